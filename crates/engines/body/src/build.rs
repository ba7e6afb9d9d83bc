//! From the text of a structure file to a body.
//!
//! A body is a draft before it has a mesh, as a surface is exact before it has one. So voxels and
//! bodies are made of one reading and one exact surface: `learn-verbs` hands both to a `BodyStore`,
//! which the command line makes of a folder of `protein-verbs`.

use crate::body::{Body, Provenance, Site};
use crate::chemistry::protonation::ModelValuesOnly;
use crate::chemistry::titration::BodyTitration;
use crate::chemistry::{
    ChargeModel, ChargedSites, Mutation, Protonate, Protonated, SiteSettings, StructureProtonation,
    build_protonated_sites, build_sites, mutate, sites_of_points,
};
use crate::hard_core::{HardCore, NativeCore, moved_inward};
use crate::points::sift_points;
use crate::structure::{Selection, SelectionReport, SelectionSettings, Structure};
use crate::surface::{Deviation, ExactSurface, MeshSettings, Surface};
use crate::warnings::{cavity_warnings, reader_warnings, selection_warnings};
use crate::{BodyError, Result};
use protomer_kernel::PointRecord;
use protomer_kernel::name::{first_forbidden, printable};
use protomer_kernel::setting::Choices;
use std::collections::{BTreeMap, HashMap};
use std::ops::RangeInclusive;

/// Every setting that affects a body.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BodySettings {
    /// Selection of atoms.
    pub selection: SelectionSettings,
    /// Settings of the charges.
    pub sites: SiteSettings,
    /// Mutations.
    pub mutations: Vec<Mutation>,
    /// Settings of the surface.
    pub surface: SurfaceSettings,
}

/// Lattices that find the surface of a protein: finer ones would fill the memory, and coarser ones
/// lose clefts between atoms.
const LATTICE_SPACINGS_ANGSTROM: RangeInclusive<f64> = 0.05..=1.0;

/// Settings of the surface.
///
/// ```
/// use protomer_body::SurfaceSettings;
/// let fine = SurfaceSettings { density_per_angstrom2: 4.0, ..SurfaceSettings::default() };
/// assert_eq!(fine.probe_radius_angstrom, 1.4);
/// assert!(fine.check().is_ok());
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceSettings {
    /// Radius of the probe, Å.
    pub probe_radius_angstrom: f64,
    /// Mesh vertices per Å².
    pub density_per_angstrom2: f64,
    /// Spacing of the lattice on which the surface is first found, Å: see
    /// [`MeshSettings::base_spacing_angstrom`].
    pub lattice_spacing_angstrom: f64,
    /// Keep the walls of all cavities as part of the surface.
    pub keep_cavities: bool,
    /// A cavity into which a ball of this radius fits is an enclosed interior, Å. Its wall is
    /// always kept, because other bodies may be in there.
    pub interior_radius_angstrom: f64,
    /// Part of the body that is hard; `None` for a native core where the elements of the atoms are
    /// known and the surface otherwise.
    pub core: Option<HardCore>,
    /// Distance by which the hard core is moved inward, Å: a native core, or the surface if that is
    /// what is hard. `None` for [`HardCore::NATIVE_OFFSET_ANGSTROM`] and 0.
    pub inward_offset_angstrom: Option<f64>,
}

impl SurfaceSettings {
    /// The default of [`SurfaceSettings::interior_radius_angstrom`]: a ball as large as the
    /// smallest folded proteins (crambin, 46 residues, has the volume of one of 11 Å). The cavities
    /// of single proteins are several times narrower.
    pub const INTERIOR_RADIUS_ANGSTROM: f64 = 10.0;
    /// The default of [`SurfaceSettings::lattice_spacing_angstrom`].
    pub const LATTICE_SPACING_ANGSTROM: f64 = MeshSettings::BASE_SPACING_ANGSTROM;
}

impl Default for SurfaceSettings {
    fn default() -> Self {
        Self {
            probe_radius_angstrom: 1.4,
            density_per_angstrom2: 1.0,
            lattice_spacing_angstrom: Self::LATTICE_SPACING_ANGSTROM,
            keep_cavities: false,
            interior_radius_angstrom: Self::INTERIOR_RADIUS_ANGSTROM,
            core: None,
            inward_offset_angstrom: None,
        }
    }
}

/// A body, the report of what it was made from, and warnings.
#[derive(Debug, Clone, PartialEq)]
pub struct BuiltBody {
    /// The body.
    pub body: Body,
    /// Report of the selection from the structure; `None` for bare points.
    pub selection: Option<SelectionReport>,
    /// Deviation of the body's mesh from the exact surface.
    pub deviation: Deviation,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

/// Source of the text of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Source<'a> {
    /// The file as the user named it.
    pub file: &'a str,
    /// SHA-256 of the file, in hexadecimal.
    pub sha256: &'a str,
}

/// Makes a body from the text of a PDB or mmCIF file.
///
/// ```
/// use protomer_body::{BodySettings, Source, build_body};
/// let text = "\
/// ATOM      1  N   LYS A   1      11.104   6.134  -6.504  1.00 10.00           N
/// ATOM      2  CA  LYS A   1      11.639   6.071  -5.147  1.00 10.00           C";
/// let source = Source { file: "lysine.pdb", sha256: "" };
/// let built = build_body("lysine", source, text.as_bytes(), &BodySettings::default())?;
/// assert_eq!(built.body.sites.len(), 2);
/// assert!(built.body.mesh.volume_angstrom3() > 20.0);
/// assert_eq!(built.warnings, ["LYS A:1 lacks C, O, CB, CG, CD, CE, NZ"]);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
///
/// # Errors
/// [`BodyError::Parse`] for text that is not a structure, [`BodyError::Invalid`] for an empty name
/// and for settings that do not fit the structure; both say where and what to do.
pub fn build_body(
    name: &str,
    source: Source<'_>,
    bytes: &[u8],
    settings: &BodySettings,
) -> Result<BuiltBody> {
    check_name(name)?;
    let structure = Structure::read(source.file, bytes)?;
    let selection = structure.select(&settings.selection)?;
    let draft = Draft::of_selection(name, source, selection, settings)?;
    draft.with_warnings_of(&structure).build()
}

/// Makes a body from selected residues.
///
/// # Errors
/// As [`Draft::of_selection`] and [`Draft::build`].
pub fn build_body_of_selection(
    name: &str,
    source: Source<'_>,
    selection: Selection,
    settings: &BodySettings,
) -> Result<BuiltBody> {
    Draft::of_selection(name, source, selection, settings)?.build()
}

/// Makes a body from bare points that have their own charges and radii. Points with a radius of
/// zero carry charge only.
///
/// ```
/// use protomer_body::{Source, SurfaceSettings, build_body_of_points};
/// use protomer_kernel::PointRecord;
/// let ion = PointRecord { charge_e: 1.0, radius_angstrom: 2.0, ..PointRecord::default() };
/// let source = Source { file: "ion.xyzr", sha256: "" };
/// let body = build_body_of_points("ion", source, &[ion], &SurfaceSettings::default())?.body;
/// assert!((body.mesh.volume_angstrom3() - 33.5).abs() < 0.1);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
///
/// # Errors
/// [`BodyError::Invalid`] for an empty name, without points, or without a positive radius.
pub fn build_body_of_points(
    name: &str,
    source: Source<'_>,
    points: &[PointRecord],
    surface: &SurfaceSettings,
) -> Result<BuiltBody> {
    Draft::of_points(name, source, points, surface)?.build()
}

/// A body before its surface: its sites, and what they were made from.
///
/// ```
/// use protomer_body::surface::ImplicitSolid;
/// use protomer_body::{Draft, Source, SurfaceSettings};
/// use protomer_kernel::PointRecord;
/// let ion = PointRecord { charge_e: 1.0, radius_angstrom: 2.0, ..PointRecord::default() };
/// let source = Source { file: "ion.xyzr", sha256: "" };
/// let draft = Draft::of_points("ion", source, &[ion], &SurfaceSettings::default())?;
/// // The exact surface serves others before it becomes a mesh.
/// let surface = draft.exact_surface()?;
/// assert!(surface.solid().signed_distance(&draft.sites().sites[0].position) < 0.0);
/// assert_eq!(draft.finish(surface)?.body.sites.len(), 1);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Draft {
    name: String,
    file: String,
    sha256: String,
    sites: ChargedSites,
    /// All settings by name.
    described: BTreeMap<String, String>,
    surface: SurfaceSettings,
    /// Radii and offset of a native core; `None` where the surface is hard.
    core: Option<NativeCore>,
    selection: Option<SelectionReport>,
    titration: Option<BodyTitration>,
    /// Warnings of the reader.
    warnings: Vec<String>,
}

impl Draft {
    /// The sites of selected residues.
    ///
    /// # Errors
    /// [`BodyError::Invalid`] for an empty name and a mutation that does not fit;
    /// [`BodyError::Trace`] for a trace of Cα atoms.
    pub fn of_selection(
        name: &str,
        source: Source<'_>,
        selection: Selection,
        settings: &BodySettings,
    ) -> Result<Self> {
        Self::of_protonated_selection(name, source, selection, settings, &ModelValuesOnly)
    }

    /// Variant of [`of_selection`](Self::of_selection) that can compute the protonation from the
    /// structure, where the settings ask for it.
    ///
    /// # Errors
    /// As [`of_selection`](Self::of_selection), and what `protonate` cannot do.
    pub fn of_protonated_selection(
        name: &str,
        source: Source<'_>,
        mut selection: Selection,
        settings: &BodySettings,
        protonate: &dyn Protonate,
    ) -> Result<Self> {
        check_name(name)?;
        mutate(&mut selection, &settings.mutations)?;
        let (sites, titration) = match &settings.sites.structure {
            None => (build_sites(&selection, &settings.sites)?, None),
            Some(conditions) => {
                let ph = settings.sites.ph;
                let Protonated {
                    residues,
                    mut titration,
                    formal_changes_e,
                } = protonate.protonate(&selection, ph, conditions)?;
                let sites = build_protonated_sites(&selection, &residues, &settings.sites)?;
                if settings.sites.charges == ChargeModel::Formal {
                    for (group, change_e) in titration.groups.iter_mut().zip(formal_changes_e) {
                        group.change_e = change_e;
                    }
                }
                (sites, settings.sites.titratable.then_some(titration))
            }
        };
        let (surface, core) = settings.surface.with_core(&sites)?;
        let mut report = selection.report;
        if settings.sites.charges != ChargeModel::None {
            list_charges(&mut report, &sites);
        }
        Ok(Self {
            name: name.into(),
            file: source.file.into(),
            sha256: source.sha256.into(),
            sites,
            described: describe_settings(settings, &surface, core.as_ref()),
            surface,
            core,
            selection: Some(report),
            titration,
            warnings: Vec::new(),
        })
    }

    /// Bare points that have their own charges and radii. Atoms without a position and repeated
    /// atoms are left out, with a warning.
    ///
    /// # Errors
    /// [`BodyError::Invalid`] for an empty name and without points, [`BodyError::Parse`] for atoms in
    /// another unit than Å.
    pub fn of_points(
        name: &str,
        source: Source<'_>,
        points: &[PointRecord],
        surface: &SurfaceSettings,
    ) -> Result<Self> {
        check_name(name)?;
        let sifted = sift_points(source.file, points)?;
        let sites = sites_of_points(&sifted.points)?;
        let (surface, core) = surface.with_core(&sites)?;
        let mut described = surface.describe(core.as_ref());
        described.insert("charges".into(), "from the file".into());
        Ok(Self {
            name: name.into(),
            file: source.file.into(),
            sha256: source.sha256.into(),
            sites,
            described,
            surface,
            core,
            selection: None,
            titration: None,
            warnings: sifted.warnings,
        })
    }

    /// Adds a warning.
    pub fn with_warning(mut self, warning: String) -> Self {
        self.warnings.push(warning);
        self
    }

    /// Adds the warnings about the structure that the selection is from.
    pub fn with_warnings_of(self, structure: &Structure) -> Self {
        Self {
            warnings: reader_warnings(structure),
            ..self
        }
    }

    /// Warnings about the file and the points that it holds.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The name of the body.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The sites, about their own origin.
    pub fn sites(&self) -> &ChargedSites {
        &self.sites
    }

    /// The surface of the sites.
    ///
    /// # Errors
    /// As [`surface_of_sites`].
    pub fn exact_surface(&self) -> Result<ExactSurface> {
        exact_surface_of_sites(&self.sites.sites, &self.surface)
    }

    /// Makes the surface, and the body.
    ///
    /// # Errors
    /// As [`surface_of_sites`].
    pub fn build(self) -> Result<BuiltBody> {
        let surface = self.exact_surface()?;
        self.finish(surface)
    }

    /// Makes the mesh of the surface that [`Self::exact_surface`] returned, and the body.
    ///
    /// # Errors
    /// [`BodyError::Invalid`] for a surface too large to be meshed.
    pub fn finish(self, surface: ExactSurface) -> Result<BuiltBody> {
        let surface = self.surface.mesh_of(surface)?;
        let core = match &self.core {
            Some(core) => Some(core.mesh(&self.sites.sites, &self.surface)?),
            None => None,
        };
        let (sites, mut settings) = (self.sites, self.described);
        let cavities = surface.cavities;
        let mut warnings = self.warnings;
        warnings.extend(self.selection.iter().flat_map(selection_warnings));
        let interior_radius = self.surface.interior_radius_angstrom;
        warnings.extend(cavity_warnings(&cavities, interior_radius));
        if cavities.kept > 0 {
            let count = cavities.kept.to_string();
            settings.insert("enclosed_interiors".into(), count);
        }
        let pieces = surface.topology.components - surface.topology.cavities;
        if pieces > 1 {
            warnings.push(format!(
                "the surface has {pieces} separate pieces; they move as one rigid body"
            ));
        }
        let deviation = surface.deviation();
        let mass_properties = surface.mesh.mass_properties()?;
        let body = Body {
            name: self.name,
            mesh: surface.mesh,
            core,
            sites: sites.sites,
            capacitances_e2: sites.capacitances_e2,
            titration: self.titration,
            residues: sites.residues,
            mass_properties,
            provenance: Provenance {
                source: self.file,
                source_sha256: self.sha256,
                origin_angstrom: sites.origin_angstrom,
                settings,
            },
        };
        Ok(BuiltBody {
            body,
            selection: self.selection,
            deviation,
            warnings,
        })
    }
}

/// Refuses an empty name of a body.
///
/// # Errors
/// [`BodyError::Invalid`] for a name without a visible character, and for one with a control
/// character or another that a name may not hold ([`protomer_kernel::name`]).
///
/// ```
/// assert!(protomer_body::check_name("lysozyme").is_ok());
/// assert!(protomer_body::check_name(" ").is_err());
/// assert!(protomer_body::check_name("a\nopen x").is_err());
/// ```
pub fn check_name(name: &str) -> Result<()> {
    if name.trim().is_empty() {
        return Err(BodyError::Invalid {
            cause: "the name of the body is empty".into(),
            remedy: "give it a name, by which assemblies and tables refer to it".into(),
        });
    }
    if let Some(character) = first_forbidden(name) {
        return Err(BodyError::Invalid {
            cause: format!(
                "the name '{}' of the body holds the character U+{:04X}",
                printable(name),
                u32::from(character)
            ),
            remedy: "give it a name of visible characters".into(),
        });
    }
    Ok(())
}

/// The solvent-excluded surface of the sites that have a radius, with the cavities that the settings
/// keep.
///
/// The settings may move it inward; they say nothing of a native core here.
///
/// ```
/// use protomer_body::{Site, SurfaceSettings, surface_of_sites};
/// use protomer_kernel::Vec3;
/// let carbon = Site {
///     position: Vec3::zeros(),
///     charge_e: 0.0,
///     radius_angstrom: 1.7,
///     atom_name: "C".into(),
///     residue: None,
/// };
/// let surface = surface_of_sites(&[carbon], &SurfaceSettings::default())?;
/// assert!((surface.exact.ses_area_angstrom2() - 36.317).abs() < 1e-3);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
///
/// # Errors
/// [`BodyError::Invalid`] for a probe, density or offset out of range, without a site that has a
/// radius, and for an offset larger than the smallest radius.
pub fn surface_of_sites(sites: &[Site], settings: &SurfaceSettings) -> Result<Surface> {
    settings.mesh_of(exact_surface_of_sites(sites, settings)?)
}

/// The surface of [`surface_of_sites`] before it is meshed.
fn exact_surface_of_sites(sites: &[Site], settings: &SurfaceSettings) -> Result<ExactSurface> {
    settings.check()?;
    let atoms = sites.iter();
    let atoms = atoms.map(|site| (site.position, site.radius_angstrom));
    let offset_angstrom = settings.inward_offset_angstrom.unwrap_or(0.0);
    moved_inward(atoms, offset_angstrom, settings.probe_radius_angstrom)
}

/// Adds the charges of the residues listed in the report, now that the pH is known.
fn list_charges(report: &mut SelectionReport, sites: &ChargedSites) {
    let mut charges: HashMap<(&str, i32, &str), f64> = HashMap::new();
    for residue in &sites.residues {
        let key = (
            residue.chain.as_str(),
            residue.number,
            residue.insertion_code.as_str(),
        );
        charges.insert(key, residue.charge_e);
    }
    for list in [
        &mut report.modified,
        &mut report.unknown,
        &mut report.ligands,
    ] {
        for listed in list {
            let key = &listed.residue;
            let key = (&*key.chain, key.number, &*key.insertion_code);
            listed.charge_e = charges.get(&key).copied();
        }
    }
}

/// The settings of a body by name.
fn describe_settings(
    settings: &BodySettings,
    surface: &SurfaceSettings,
    core: Option<&NativeCore>,
) -> BTreeMap<String, String> {
    let mut described = surface.describe(core);
    described.extend(describe_selection(&settings.selection));
    described.insert("ph".into(), settings.sites.ph.to_string());
    described.insert("charges".into(), format!("{:?}", settings.sites.charges));
    if let Some(conditions) = &settings.sites.structure {
        described.insert("protonation".into(), describe_protonation(conditions));
        let constant = conditions.anion_binding_per_molar.to_string();
        described.insert(ANION_BINDING_SETTING.into(), constant);
    }
    if !settings.mutations.is_empty() {
        let mutations: Vec<String> = settings.mutations.iter().map(Mutation::to_string).collect();
        described.insert("mutations".into(), mutations.join(","));
    }
    described
}

/// Name of the binding constant of anions (L/mol) among the settings of a body whose structure was titrated.
pub const ANION_BINDING_SETTING: &str = "anion_binding_per_M";

/// The conditions of a protonation in words.
fn describe_protonation(conditions: &StructureProtonation) -> String {
    let StructureProtonation {
        salt_molar,
        temperature_kelvin,
        anion_binding_per_molar,
    } = conditions;
    let bound = match *anion_binding_per_molar > 0.0 {
        true => format!(", anions bound with {anion_binding_per_molar} /M"),
        false => String::new(),
    };
    format!("of the structure in {salt_molar} M salt at {temperature_kelvin} K{bound}")
}

impl SurfaceSettings {
    /// Checks what does not depend on the atoms.
    ///
    /// ```
    /// use protomer_body::SurfaceSettings;
    /// let coarse = SurfaceSettings { lattice_spacing_angstrom: 2.0, ..SurfaceSettings::default() };
    /// let message = coarse.check().map_err(|error| error.to_string());
    /// assert!(message.is_err_and(|message| message.contains("give 0.05 to 1 Å")));
    /// ```
    ///
    /// # Errors
    /// [`BodyError::Invalid`] names the setting and its range.
    pub fn check(&self) -> Result<()> {
        let radius = self.interior_radius_angstrom;
        if radius.is_nan() || radius <= 0.0 {
            return Err(BodyError::Invalid {
                cause: format!("a radius of {radius} Å for enclosed interiors"),
                remedy: "give a positive radius, larger than that of any cavity to fill".into(),
            });
        }
        let spacing = self.lattice_spacing_angstrom;
        if !LATTICE_SPACINGS_ANGSTROM.contains(&spacing) {
            return Err(BodyError::Invalid {
                cause: format!("a lattice with a spacing of {spacing} Å"),
                remedy: "give 0.05 to 1 Å, such as 0.3".into(),
            });
        }
        self.mesh().check()
    }

    /// The settings of the surface alone, and what a native core is made of unless the surface is
    /// hard.
    ///
    /// # Errors
    /// [`BodyError::Invalid`] for a native core of points whose elements are not known.
    fn with_core(&self, sites: &ChargedSites) -> Result<(Self, Option<NativeCore>)> {
        let radii = sites.core_radii_angstrom.as_ref();
        let radii = match (self.core, radii) {
            (Some(HardCore::Surface), _) | (None, None) => return Ok((*self, None)),
            (None | Some(HardCore::Native), Some(radii)) => radii,
            (Some(HardCore::Native), None) => {
                return Err(BodyError::Invalid {
                    cause:
                        "a native core depends on elements, which points with radii of their own \
                            do not have"
                            .into(),
                    remedy:
                        "leave out --core native and move the surface inward with --offset 0.5, \
                             or give the structure as PDB or mmCIF"
                            .into(),
                });
            }
        };
        let offset = self.inward_offset_angstrom;
        let core = NativeCore {
            radii_angstrom: radii.clone(),
            inward_offset_angstrom: offset.unwrap_or(HardCore::NATIVE_OFFSET_ANGSTROM),
        };
        let surface = Self {
            inward_offset_angstrom: None,
            ..*self
        };
        Ok((surface, Some(core)))
    }

    /// The mesh of a surface, with the cavities that are kept.
    pub(crate) fn mesh_of(&self, surface: ExactSurface) -> Result<Surface> {
        let interior_radius = (!self.keep_cavities).then_some(self.interior_radius_angstrom);
        surface.mesh(&self.mesh(), interior_radius)
    }

    fn mesh(&self) -> MeshSettings {
        MeshSettings {
            density_per_angstrom2: self.density_per_angstrom2,
            base_spacing_angstrom: self.lattice_spacing_angstrom,
            ..MeshSettings::default()
        }
    }

    /// The settings by name; the interior radius and the lattice only where they are not the default.
    fn describe(&self, core: Option<&NativeCore>) -> BTreeMap<String, String> {
        let cavities = if self.keep_cavities { "keep" } else { "drop" };
        let mut described = BTreeMap::from([("cavities".to_owned(), cavities.to_owned())]);
        let lengths = [
            ("probe_radius_angstrom", self.probe_radius_angstrom),
            ("density_per_angstrom2", self.density_per_angstrom2),
            (
                "inward_offset_angstrom",
                self.inward_offset_angstrom.unwrap_or(0.0),
            ),
        ];
        for (name, value) in lengths {
            described.insert(name.to_owned(), value.to_string());
        }
        let kind = match core {
            Some(_) => HardCore::Native,
            None => HardCore::Surface,
        };
        described.insert("core".to_owned(), kind.name().to_owned());
        if let Some(core) = core {
            let offset = core.inward_offset_angstrom.to_string();
            described.insert("core_inward_offset_angstrom".to_owned(), offset);
        }
        if self.interior_radius_angstrom != Self::INTERIOR_RADIUS_ANGSTROM {
            let radius = self.interior_radius_angstrom.to_string();
            described.insert("interior_radius_angstrom".to_owned(), radius);
        }
        if self.lattice_spacing_angstrom != Self::LATTICE_SPACING_ANGSTROM {
            let spacing = self.lattice_spacing_angstrom.to_string();
            described.insert("lattice_spacing_angstrom".to_owned(), spacing);
        }
        described
    }
}

/// The settings of a selection by name, without those switched off.
fn describe_selection(selection: &SelectionSettings) -> BTreeMap<String, String> {
    let Ok(serde_json::Value::Object(settings)) = serde_json::to_value(selection) else {
        return BTreeMap::new();
    };
    let mut described = BTreeMap::new();
    for (name, value) in settings {
        let is_set = match &value {
            serde_json::Value::Null | serde_json::Value::Bool(false) => false,
            serde_json::Value::Array(items) => !items.is_empty(),
            _ => true,
        };
        if is_set {
            described.insert(name, value.to_string());
        }
    }
    described
}
