//! The whole way from the text of a structure file to a body.

use crate::body::{Body, Provenance, Site};
use crate::chemistry::{
    ChargedSites, Mutation, SiteSettings, build_sites, mutate, sites_of_points,
};
use crate::structure::{Selection, SelectionReport, SelectionSettings, Structure};
use crate::surface::{MeshSettings, Surface, solvent_excluded_surface};
use crate::{BodyError, Result};
use protomer_io::points::PointRecord;
use protomer_kernel::Vec3;
use std::collections::BTreeMap;

/// Everything that shapes a body.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BodySettings {
    /// Which atoms.
    pub selection: SelectionSettings,
    /// Which charges.
    pub sites: SiteSettings,
    /// Residues exchanged in place.
    pub mutations: Vec<Mutation>,
    /// Which surface.
    pub surface: SurfaceSettings,
}

/// What kind of surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceSettings {
    /// Radius of the probe, Å.
    pub probe_radius_angstrom: f64,
    /// Mesh vertices per Å².
    pub density_per_angstrom2: f64,
    /// Keep the walls of cavities as part of the surface.
    pub keep_cavities: bool,
    /// The surface is moved inward by this much, Å.
    pub inward_offset_angstrom: f64,
}

impl Default for SurfaceSettings {
    fn default() -> Self {
        Self {
            probe_radius_angstrom: 1.4,
            density_per_angstrom2: 1.0,
            keep_cavities: false,
            inward_offset_angstrom: 0.0,
        }
    }
}

/// A body with the account of how it was made.
#[derive(Debug, Clone, PartialEq)]
pub struct BuiltBody {
    /// The body.
    pub body: Body,
    /// What of the structure was selected; `None` for bare points.
    pub selection: Option<SelectionReport>,
    /// What a careful user should know.
    pub warnings: Vec<String>,
}

/// Where the text of a body comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Source<'a> {
    /// The file as the user named it.
    pub file: &'a str,
    /// SHA-256 of the file, in hexadecimal.
    pub sha256: &'a str,
}

/// A body from the text of a PDB or mmCIF file.
///
/// # Errors
/// [`BodyError::Parse`] for text that is not a structure, [`BodyError::Invalid`] for settings that
/// do not fit it; both say where and what to do.
pub fn build_body(
    name: &str,
    source: Source<'_>,
    bytes: &[u8],
    settings: &BodySettings,
) -> Result<BuiltBody> {
    let structure = Structure::read(source.file, bytes)?;
    let selection = structure.select(&settings.selection)?;
    let mut built = build_body_of_selection(name, source, selection, settings)?;
    built.warnings.splice(0..0, reader_warnings(&structure));
    Ok(built)
}

/// What of a file and of what was selected from it deserves a line to the user.
pub fn structure_warnings(structure: &Structure, report: &SelectionReport) -> Vec<String> {
    let mut warnings = reader_warnings(structure);
    warnings.extend(selection_warnings(report));
    warnings
}

fn reader_warnings(structure: &Structure) -> Vec<String> {
    let warnings = &structure.warnings;
    let mut messages = warnings.messages.clone();
    if warnings.count > messages.len() {
        messages.push(format!(
            "and {} more of the kind",
            warnings.count - messages.len()
        ));
    }
    messages
}

/// A body from selected residues.
///
/// # Errors
/// [`BodyError::Invalid`] for a mutation that does not fit, or atoms that have no surface.
pub fn build_body_of_selection(
    name: &str,
    source: Source<'_>,
    mut selection: Selection,
    settings: &BodySettings,
) -> Result<BuiltBody> {
    mutate(&mut selection, &settings.mutations)?;
    let sites = build_sites(&selection, &settings.sites)?;
    let mut provenance = settings.surface.describe();
    provenance.extend(describe_selection(&settings.selection));
    provenance.insert("ph".into(), settings.sites.ph.to_string());
    provenance.insert("charges".into(), format!("{:?}", settings.sites.charges));
    if !settings.mutations.is_empty() {
        let mutations: Vec<String> = settings.mutations.iter().map(Mutation::to_string).collect();
        provenance.insert("mutations".into(), mutations.join(","));
    }
    let (body, mut warnings) = finish(name, source, sites, provenance, &settings.surface)?;
    warnings.splice(0..0, selection_warnings(&selection.report));
    Ok(BuiltBody {
        body,
        selection: Some(selection.report),
        warnings,
    })
}

/// A body from bare points that bring their own charges and radii. Points with a radius of zero
/// carry charge only.
///
/// # Errors
/// [`BodyError::Invalid`] without points, or without a positive radius.
pub fn build_body_of_points(
    name: &str,
    source: Source<'_>,
    points: &[PointRecord],
    surface: &SurfaceSettings,
) -> Result<BuiltBody> {
    let sites = sites_of_points(points)?;
    let mut provenance = surface.describe();
    provenance.insert("charges".into(), "from the file".into());
    let (body, warnings) = finish(name, source, sites, provenance, surface)?;
    Ok(BuiltBody {
        body,
        selection: None,
        warnings,
    })
}

/// The solvent-excluded surface of the sites that have a radius.
///
/// Moving the surface inward by δ is the surface of atoms smaller by δ rolled on by a probe larger
/// by δ: the probe's centre goes where it went before.
///
/// # Errors
/// [`BodyError::Invalid`] if no site has a radius, or the offset is larger than the smallest one.
pub fn surface_of_sites(sites: &[Site], settings: &SurfaceSettings) -> Result<Surface> {
    let solid = || sites.iter().filter(|site| site.radius_angstrom > 0.0);
    let smallest = solid()
        .map(|site| site.radius_angstrom)
        .fold(f64::INFINITY, f64::min);
    let offset = settings.inward_offset_angstrom;
    if !(offset.is_finite() && offset < smallest) {
        return Err(BodyError::Invalid {
            cause: format!(
                "an inward offset of {offset} Å, and the smallest atom has a radius of {smallest} Å"
            ),
            remedy: "give a smaller offset".into(),
        });
    }
    let centres: Vec<Vec3> = solid().map(|site| site.position).collect();
    let radii: Vec<f64> = solid().map(|site| site.radius_angstrom - offset).collect();
    let mesh = MeshSettings {
        density_per_angstrom2: settings.density_per_angstrom2,
        ..MeshSettings::default()
    };
    solvent_excluded_surface(
        &centres,
        &radii,
        settings.probe_radius_angstrom + offset,
        &mesh,
    )
}

fn finish(
    name: &str,
    source: Source<'_>,
    sites: ChargedSites,
    settings: BTreeMap<String, String>,
    surface: &SurfaceSettings,
) -> Result<(Body, Vec<String>)> {
    let whole = surface_of_sites(&sites.sites, surface)?;
    let cavities = whole.topology.cavities;
    let chosen = if surface.keep_cavities || cavities == 0 {
        whole
    } else {
        whole.without_cavities()?
    };
    let mut warnings = Vec::new();
    if !surface.keep_cavities && cavities > 0 {
        warnings.push(format!(
            "{cavities} internal cavities filled; keep them with --cavities keep"
        ));
    }
    let pieces = chosen.topology.components - chosen.topology.cavities;
    if pieces > 1 {
        warnings.push(format!(
            "the surface has {pieces} separate pieces; they move as one rigid body"
        ));
    }
    let mesh = chosen.mesh;
    let provenance = Provenance {
        source: source.file.into(),
        source_sha256: source.sha256.into(),
        origin_angstrom: sites.origin_angstrom,
        settings,
    };
    let mass_properties = mesh.mass_properties()?;
    let body = Body {
        name: name.into(),
        mesh,
        sites: sites.sites,
        residues: sites.residues,
        mass_properties,
        provenance,
    };
    Ok((body, warnings))
}

impl SurfaceSettings {
    fn describe(&self) -> BTreeMap<String, String> {
        let setting = |name: &str, value: String| (name.to_owned(), value);
        BTreeMap::from([
            setting(
                "probe_radius_angstrom",
                self.probe_radius_angstrom.to_string(),
            ),
            setting(
                "density_per_angstrom2",
                self.density_per_angstrom2.to_string(),
            ),
            setting(
                "inward_offset_angstrom",
                self.inward_offset_angstrom.to_string(),
            ),
            setting(
                "cavities",
                if self.keep_cavities { "keep" } else { "drop" }.into(),
            ),
        ])
    }
}

/// The settings of a selection by name, without those that are off.
fn describe_selection(selection: &SelectionSettings) -> BTreeMap<String, String> {
    let Ok(serde_json::Value::Object(settings)) = serde_json::to_value(selection) else {
        return BTreeMap::new();
    };
    let is_set = |value: &serde_json::Value| match value {
        serde_json::Value::Null | serde_json::Value::Bool(false) => false,
        serde_json::Value::Array(items) => !items.is_empty(),
        _ => true,
    };
    settings
        .into_iter()
        .filter(|(_, value)| is_set(value))
        .map(|(name, value)| (name, value.to_string()))
        .collect()
}

/// What of the selection deserves a line to the user.
fn selection_warnings(report: &SelectionReport) -> Vec<String> {
    let mut warnings = Vec::new();
    for listed in report
        .unknown
        .iter()
        .chain(&report.modified)
        .chain(&report.microheterogeneous)
    {
        warnings.push(format!(
            "{} {}: {}",
            listed.name, listed.residue, listed.note
        ));
    }
    for residue in &report.incomplete {
        warnings.push(format!(
            "{} {} lacks {}",
            residue.name,
            residue.residue,
            residue.missing_atoms.join(", ")
        ));
    }
    for gap in &report.chain_breaks {
        warnings.push(format!(
            "chain break between {} and {}",
            gap.before, gap.after
        ));
    }
    if report.unobserved > 0 {
        warnings.push(format!(
            "{} residues are listed as not observed",
            report.unobserved
        ));
    }
    warnings
}
