//! One structure to one sample, or the reason why not; and to a body, if there is a store for bodies.

use super::body_store::BodyStore;
use super::interface::InterfaceBodies;
use super::manifest::Entry;
use super::settings::{Spacing, VoxelizeSettings};
use anyhow::{Result, anyhow, bail};
use protomer_body::chemistry::residue_names::parent_amino_acid;
use protomer_body::chemistry::{AminoAcid, ChargedSites, SiteSettings};
use protomer_body::structure::{Ending, Format, SelectionSettings, Structure};
use protomer_body::surface::{ExactSurface, Placed};
use protomer_body::{BodyError, BodySettings, Draft, Source, SurfaceSettings, structure_warnings};
use protomer_common::input::InputFile;
use protomer_common::remedy;
use protomer_field::titration::SolvedProtonation;
use protomer_field::voxels::channels::{bounds, pose};
use protomer_field::voxels::lattice::SPACING_RANGE_ANGSTROM;
use protomer_field::voxels::orientation::principal_axes;
use protomer_field::voxels::{Channel, Lattice, VoxelAtom, Voxels, voxelise_within};
use protomer_field::{ChargedSphere, FieldError};
use protomer_io::digest::Digest;
use protomer_io::pqr::read_pqr_file;
use protomer_io::zarr::as_stored;
use protomer_kernel::plain_text::line_end_warning;
use protomer_kernel::setting::Choices;
use protomer_kernel::{Pose, Rotation, Vec3};
use protomer_results::FileRecord;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Reasons for the exclusion of a structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// The file is missing, damaged, or not a structure file.
    Unreadable,
    /// Too many residues lack heavy atoms, or the file was cut off.
    Truncated,
    /// The file contains no amino acids.
    NoProtein,
    /// The structure does not fit in the grid.
    TooLarge,
    /// The potential did not converge or is not finite.
    Potential,
    /// Another error.
    Failed,
}

/// The outcome for a structure.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// A sample.
    Sample(Box<Sample>),
    /// A structure that is left out.
    Excluded {
        /// Reason for the exclusion.
        reason: Reason,
        /// Description of the reason in words.
        detail: String,
    },
}

/// A sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Properties of the structure.
    pub properties: Properties,
    /// Voxels of the structure.
    pub voxels: Voxels,
    /// Warnings about the file, such as unknown residues or missing atoms.
    pub warnings: Vec<String>,
}

/// Properties of a structure besides its voxels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Properties {
    /// Number of residues that are one of the twenty amino acids or a modification of one.
    pub residues: usize,
    /// Radius of gyration of the atoms, equally weighted, Å.
    pub radius_of_gyration_angstrom: f64,
    /// Extents of the spheres along the principal axes, Å, largest first.
    pub extents_angstrom: [f64; 3],
    /// Net charge, e.
    pub net_charge_e: f64,
    /// Edge of a voxel, Å.
    pub spacing_angstrom: f64,
    /// The rotation R of the structure.
    pub rotation_wxyz: [f64; 4],
    /// A point p of the file is mapped to R p - middle, Å.
    pub middle_angstrom: [f64; 3],
    /// Share of each amino acid, by the one-letter codes in alphabetical order.
    pub composition: [f64; 20],
}

/// Maximum number of warnings kept per structure.
pub(super) const MOST_WARNINGS: usize = 10;

/// Results for a structure.
#[derive(Debug, Clone, PartialEq)]
pub struct Done {
    /// Sample of the structure, or the reason why there is none.
    pub outcome: Outcome,
    /// Record of the body for the tables, if there is a store for bodies.
    pub body: Option<FileRecord>,
}

/// An error that excludes a structure.
pub(super) struct Excluded(pub Reason, pub anyhow::Error);

impl From<Excluded> for Outcome {
    fn from(Excluded(reason, error): Excluded) -> Self {
        Outcome::Excluded {
            reason,
            detail: remedy::message(&error),
        }
    }
}

pub(super) type Checked<T> = std::result::Result<T, Excluded>;

/// Voxelises a structure, and makes its body if there is a store for bodies. An error in the structure
/// is its outcome. Of an interface, both bodies are read, and kept in `interfaces` for their next pose.
///
/// # Errors
/// If the body cannot be written.
pub fn voxelize_structure(
    entry: &Entry,
    settings: &VoxelizeSettings,
    bodies: Option<&dyn BodyStore>,
    interfaces: &InterfaceBodies,
) -> Result<Done> {
    if let Some(partner) = &entry.partner {
        let sample = interfaces.sample(entry, partner, settings);
        return Ok(Done {
            outcome: sample.map_or_else(Outcome::from, |sample| Outcome::Sample(Box::new(sample))),
            body: None,
        });
    }
    let path = &entry.path;
    match sample_and_draft(entry, settings, bodies) {
        Ok(Drawn {
            outcome,
            draft,
            surface,
        }) => {
            let record = bodies.map(|bodies| bodies.keep(path, draft, surface));
            Ok(Done {
                outcome,
                body: record.transpose()?,
            })
        }
        Err(excluded) => Ok(Done {
            body: bodies.map(|bodies| bodies.failed(path, &excluded.1)),
            outcome: excluded.into(),
        }),
    }
}

/// A structure before its body is written.
struct Drawn {
    outcome: Outcome,
    draft: Draft,
    surface: ExactSurface,
}

/// The sample and the body. A structure that cannot become a sample may still become a body: then the
/// reason is the outcome, not an error.
fn sample_and_draft(
    entry: &Entry,
    settings: &VoxelizeSettings,
    bodies: Option<&dyn BodyStore>,
) -> Checked<Drawn> {
    let (content, amino_acids) = usable(entry, settings, density_of(bodies))?;
    let posed = Posed::new(entry, content.draft.sites(), settings);
    let lattice = lattice(&posed.atoms, settings);
    let mut lattice = lattice.map_err(|error| Excluded(Reason::TooLarge, error));
    if bodies.is_none() {
        // What does not fit needs no surface.
        lattice = Ok(lattice?);
    }
    let surface = content.draft.exact_surface();
    let surface = surface.map_err(|error| Excluded(Reason::Failed, error.into()))?;
    let outcome = lattice
        // A structure that does not fit is an outcome here, since its body may still be made.
        .and_then(|lattice| sample(&content, &posed, &lattice, &surface, &amino_acids, settings))
        .map_or_else(Outcome::from, |sample| Outcome::Sample(Box::new(sample)));
    Ok(Drawn {
        outcome,
        draft: content.draft,
        surface,
    })
}

/// A structure that can be used, with its amino acids.
fn usable(
    entry: &Entry,
    settings: &VoxelizeSettings,
    density_per_angstrom2: f64,
) -> Checked<(Content, Vec<AminoAcid>)> {
    let (name, path) = (&entry.name, &entry.path);
    let content = read(name, path, &[], settings, density_per_angstrom2)?;
    let amino_acids = amino_acids_of(&content, settings)?;
    Ok((content, amino_acids))
}

fn sample(
    content: &Content,
    posed: &Posed,
    lattice: &Lattice,
    surface: &ExactSurface,
    amino_acids: &[AminoAcid],
    settings: &VoxelizeSettings,
) -> Checked<Sample> {
    let sites = content.draft.sites();
    let voxel_settings = settings.voxel_settings();
    let voxel_settings = voxel_settings.map_err(|error| Excluded(Reason::Failed, error))?;
    let residues = sites.residues.iter();
    let hydropathy: Vec<Option<f64>> = residues.map(|residue| residue.hydropathy).collect();
    let Posed {
        atoms,
        positions,
        rotation,
        middle,
    } = posed;
    // The surface is about the origin of the sites.
    // A point p of the file goes to R p - middle; so does the origin.
    let position = rotation * sites.origin_angstrom - middle;
    let rotation = *rotation;
    let solid = Placed::new(surface.solid(), Pose { position, rotation });
    let voxels = voxelise_within(&solid, atoms, &hydropathy, lattice, &voxel_settings);
    let voxels = voxels.map_err(no_voxels)?;
    // In the form in which the set stores them: half precision may be infinite.
    check_values(&voxels, &settings.channels)
        .map_err(|error| Excluded(Reason::Potential, error))?;
    let properties = Properties {
        residues: amino_acids.len(),
        radius_of_gyration_angstrom: radius_of_gyration(positions),
        extents_angstrom: extents(atoms),
        net_charge_e: sites.net_charge_e(),
        spacing_angstrom: lattice.spacing_angstrom(),
        rotation_wxyz: [rotation.w, rotation.i, rotation.j, rotation.k],
        middle_angstrom: (*middle).into(),
        composition: composition(amino_acids),
    };
    Ok(Sample {
        properties,
        voxels,
        warnings: at_most(MOST_WARNINGS, content.warnings.clone()),
    })
}

/// Atoms as they lie in the grid.
struct Posed {
    atoms: Vec<VoxelAtom>,
    /// Positions of the atoms in the file.
    positions: Vec<Vec3>,
    rotation: Rotation,
    middle: Vec3,
}

impl Posed {
    fn new(entry: &Entry, sites: &ChargedSites, settings: &VoxelizeSettings) -> Self {
        let mut atoms = atoms_of(sites);
        let positions: Vec<Vec3> = atoms.iter().map(|atom| atom.sphere.centre).collect();
        // By name, not by place in the manifest: the same
        // structure has the same orientation in any set.
        let key = key_of(&entry.name);
        let rotation = settings
            .orientation
            .rotation(&positions, settings.seed, key);
        let middle = pose(&mut atoms, &rotation);
        Self {
            atoms,
            positions,
            rotation,
            middle,
        }
    }
}

/// The largest extent of a structure along an axis of the grid, Å; `None` if it cannot be used for
/// another reason than its size.
pub(super) fn extent_angstrom(entry: &Entry, settings: &VoxelizeSettings) -> Option<f64> {
    if entry.partner.is_some() {
        // An interface is cropped to the grid.
        return None;
    }
    let (content, _) = usable(entry, settings, density_of(None)).ok()?;
    let (low, high) = bounds(&Posed::new(entry, content.draft.sites(), settings).atoms);
    Some((high - low).max())
}

/// Voxels along an edge that hold an extent, both in Å.
pub(super) fn voxels_needed(extent: f64, spacing: f64) -> usize {
    (extent / spacing).ceil() as usize + 1
}

/// The amino acids of a structure, if it has any and enough of them are complete.
pub(super) fn amino_acids_of(
    content: &Content,
    settings: &VoxelizeSettings,
) -> Checked<Vec<AminoAcid>> {
    let residues = &content.draft.sites().residues;
    let mut amino_acids = Vec::with_capacity(residues.len());
    for residue in residues {
        amino_acids.extend(parent_amino_acid(&residue.name));
    }
    if amino_acids.is_empty() {
        let error = anyhow!("none of the {} residues is an amino acid", residues.len());
        return Err(Excluded(Reason::NoProtein, error));
    }
    let (incomplete, count) = (content.incomplete, amino_acids.len());
    // A trace lacks nearly all; single incomplete residues are usual in crystals.
    if incomplete as f64 > settings.most_incomplete * count as f64 {
        let error =
            anyhow!("{incomplete} of {count} residues lack heavy atoms, as in a trace of Cα atoms");
        return Err(Excluded(Reason::Truncated, error));
    }
    Ok(amino_acids)
}

/// The atoms in the coordinates of the file.
fn atoms_of(sites: &ChargedSites) -> Vec<VoxelAtom> {
    let mut atoms = Vec::with_capacity(sites.sites.len());
    for site in &sites.sites {
        let sphere = ChargedSphere {
            centre: site.position + sites.origin_angstrom,
            radius_angstrom: site.radius_angstrom,
            charge_e: site.charge_e,
        };
        atoms.push(VoxelAtom {
            sphere,
            residue: site.residue,
        });
    }
    atoms
}

pub(super) fn no_voxels(error: FieldError) -> Excluded {
    let reason = match error {
        FieldError::NotConverged { .. } | FieldError::ChargeOutside { .. } => Reason::Potential,
        _ => Reason::Failed,
    };
    Excluded(reason, error.into())
}

/// Whether a set can keep the values.
pub(super) fn check_values(voxels: &Voxels, channels: &[Channel]) -> Result<()> {
    for (channel, values) in channels.iter().zip(&voxels.values) {
        if let Some(value) = values.iter().find(|value| !as_stored(**value).is_finite()) {
            bail!(
                "the channel {} holds {value}; a set keeps finite values up to ± 65504",
                channel.name()
            );
        }
    }
    Ok(())
}

/// The content of a structure file.
pub(super) struct Content {
    pub draft: Draft,
    /// Residues that lack heavy atoms.
    pub incomplete: usize,
    pub warnings: Vec<String>,
}

/// Vertices of a mesh per Å²; without a store there is no mesh.
pub(super) fn density_of(bodies: Option<&dyn BodyStore>) -> f64 {
    let default = SurfaceSettings::default().density_per_angstrom2;
    bodies.map_or(default, BodyStore::density_per_angstrom2)
}

pub(super) fn read(
    name: &str,
    path: &Path,
    chains: &[String],
    settings: &VoxelizeSettings,
    density_per_angstrom2: f64,
) -> Checked<Content> {
    let file = InputFile::read(path).map_err(unreadable)?;
    let source = Source {
        file: &file.name,
        sha256: &file.sha256,
    };
    let surface = SurfaceSettings {
        probe_radius_angstrom: settings.probe_angstrom,
        density_per_angstrom2,
        ..SurfaceSettings::default()
    };
    if Format::of_file(&file.name, &file.bytes).map_err(unreadable)? == Format::Pqr {
        let pqr = read_pqr_file(&file.name, &file.bytes).map_err(unreadable)?;
        let draft = Draft::of_points(name, source, &pqr.atoms, &surface);
        let draft = draft.map_err(unreadable)?;
        let mut warnings = of_ending(&Ending::of_pqr(&String::from_utf8_lossy(&file.bytes)))?;
        warnings.extend(Format::Pqr.contradiction(&file.name));
        warnings.extend(line_end_warning(&file.bytes));
        warnings.extend(pqr.models_warning());
        warnings.extend(draft.warnings().iter().cloned());
        warnings.extend(ph_warning(settings.ph));
        return Ok(Content {
            draft,
            incomplete: 0,
            warnings,
        });
    }
    let structure = Structure::read(&file.name, &file.bytes).map_err(unreadable)?;
    let mut warnings = of_ending(&structure.ending)?;
    // With these settings the selection fails only if nothing remains without nucleic acids,
    // ligands and water.
    let selection = structure.select(&SelectionSettings {
        chains: chains.to_vec(),
        ..SelectionSettings::default()
    });
    let selection = selection.map_err(|error| Excluded(Reason::NoProtein, error.into()))?;
    let incomplete = selection.report.incomplete.len();
    warnings.extend(structure_warnings(&structure, &selection.report));
    let body_settings = BodySettings {
        sites: SiteSettings {
            ph: settings.ph,
            structure: settings.titration.map(|titration| {
                titration.conditions(settings.salt_molar, settings.temperature_kelvin)
            }),
            ..SiteSettings::default()
        },
        surface,
        ..BodySettings::default()
    };
    let solved = &SolvedProtonation;
    let draft = Draft::of_protonated_selection(name, source, selection, &body_settings, solved);
    let draft = draft.map_err(|error| match error {
        BodyError::Trace { .. } => Excluded(Reason::Truncated, error.into()),
        _ => Excluded(Reason::Failed, error.into()),
    })?;
    Ok(Content {
        draft: draft.with_warnings_of(&structure),
        incomplete,
        warnings,
    })
}

/// Warning that a pH which the user chose does nothing to a PQR file, whose charges are its own.
fn ph_warning(ph: f64) -> Option<String> {
    let default = VoxelizeSettings::default().ph;
    (ph != default).then(|| {
        format!("a PQR file has its own charges, which are not changed to those at pH {ph}")
    })
}

fn unreadable(error: impl Into<anyhow::Error>) -> Excluded {
    Excluded(Reason::Unreadable, error.into())
}

/// Refuses a file that was cut off, because half a protein is not a valid sample. Warns if the file
/// does not show whether it is complete.
fn of_ending(ending: &Ending) -> Checked<Vec<String>> {
    match ending {
        Ending::Whole => Ok(Vec::new()),
        Ending::Unknown => Ok(vec![Ending::UNKNOWN.to_owned()]),
        Ending::CutOff(message) => Err(Excluded(Reason::Truncated, anyhow!("{message}"))),
    }
}

/// The first warnings, and the number of the others.
pub(super) fn at_most(most: usize, mut warnings: Vec<String>) -> Vec<String> {
    // `checked_sub` is none if there are fewer, zero if just as many.
    if let Some(more @ 1..) = warnings.len().checked_sub(most) {
        warnings.truncate(most);
        warnings.push(format!("and {more} more"));
    }
    warnings
}

/// A number derived from the name.
pub(super) fn key_of(name: &str) -> u64 {
    Digest::hash(name.as_bytes()).short()
}

fn lattice(atoms: &[VoxelAtom], settings: &VoxelizeSettings) -> Result<Lattice> {
    let (low, high) = bounds(atoms);
    let extent = (high - low).max();
    let intervals = settings.size as f64 - 1.0;
    let spacing = match settings.spacing {
        Spacing::Angstrom(spacing) => spacing,
        // A margin, so that rounding does not push an atom off the lattice.
        Spacing::Fit(_) => (extent / intervals * (1.0 + 1e-9)).max(SPACING_RANGE_ANGSTROM.0),
    };
    // One voxel more than intervals.
    let needed = voxels_needed(extent, spacing);
    if needed > settings.size {
        return Err(anyhow!(
            "{extent:.1} Å need {needed} voxels of {spacing} Å, the grid has {}",
            settings.size
        ));
    }
    if spacing > SPACING_RANGE_ANGSTROM.1 {
        return Err(anyhow!(
            "{extent:.1} Å need voxels of {spacing:.2} Å, the largest are {} Å",
            SPACING_RANGE_ANGSTROM.1
        ));
    }
    Ok(Lattice::new(settings.size, spacing)?)
}

pub(super) fn radius_of_gyration(positions: &[Vec3]) -> f64 {
    let count = positions.len().max(1) as f64;
    let middle = positions.iter().sum::<Vec3>() / count;
    let mut squares = 0.0;
    for position in positions {
        squares += (position - middle).norm_squared();
    }
    (squares / count).sqrt()
}

pub(super) fn extents(atoms: &[VoxelAtom]) -> [f64; 3] {
    // About the principal axes: extents do not depend on the rotation of the sample.
    let positions: Vec<Vec3> = atoms.iter().map(|atom| atom.sphere.centre).collect();
    let (rotation, _) = principal_axes(&positions);
    let mut rotated_atoms = atoms.to_vec();
    for atom in &mut rotated_atoms {
        atom.sphere.centre = rotation * atom.sphere.centre;
    }
    let (low, high) = bounds(&rotated_atoms);
    let mut extents: [f64; 3] = (high - low).into();
    extents.sort_by(|a, b| b.total_cmp(a));
    extents
}

pub(super) fn composition(amino_acids: &[AminoAcid]) -> [f64; 20] {
    let letters = letters();
    let mut shares = [0.0; 20];
    for amino_acid in amino_acids {
        // The letters are sorted, as `letters` says.
        if let Ok(place) = letters.binary_search(&amino_acid.letter()) {
            shares[place] += 1.0 / amino_acids.len() as f64;
        }
    }
    shares
}

/// One-letter codes in alphabetical order.
///
/// ```
/// let letters: String = protomer_learn_verbs::voxels::structure::letters().into_iter().collect();
/// assert_eq!(letters, "ACDEFGHIKLMNPQRSTVWY");
/// ```
pub fn letters() -> Vec<char> {
    let mut letters: Vec<char> = AminoAcid::all().map(AminoAcid::letter).collect();
    letters.sort_unstable();
    letters
}
