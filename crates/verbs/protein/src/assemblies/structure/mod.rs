//! Assemblies from structures: chains, joined chains or whole files become bodies with poses.
//!
//! | module | one idea |
//! |---|---|
//! | `files` | the files of a structure, and what in them becomes a body |
//! | `shapes` | the bodies, and which copies share one |
//! | `checks` | chains that belong together, bodies that touch nothing, gaps in interfaces |
//! | `answer` | what was made |

mod answer;
mod checks;
mod files;
mod shapes;

pub use answer::{StructureAssembly, StructureBody};
pub use shapes::OwnShape;

use crate::assemblies::assemble::{refuse_another, write_assembly};
use crate::assemblies::assembly_file::Assembly;
use crate::bodies::body_file;
use crate::bodies::chain_groups::ChainNames;
use crate::bodies::ingest::BodyMeasures;
use anyhow::{Context, Result, bail};
use files::{File, NamedUnit};
use protomer_body::assembly::native_contacts::centroid;
use protomer_body::assembly::point_group::point_group;
use protomer_body::assembly::{
    CoreAtoms, PointGroup, ResidueContacts, Separation, Unit, body_types_of_units, separate,
};
use protomer_body::chemistry::radii::{core_radius_angstrom, radius_angstrom};
use protomer_body::structure::SelectionReport;
use protomer_body::{Body, BodyError, BodySettings, HardCore};
use protomer_io::atomic::sha256_hex;
use protomer_kernel::{Boundary, Pose, Vec3};
use protomer_results::ResultKind;
use shapes::Placed;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Copies in equivalent places are nearer than this to where a rotation maps each other, Å.
const SAME_PLACE_ANGSTROM: f64 = 3.0;

protomer_kernel::choices! {
    /// Shapes of the copies of a unit.
    pub enum CopyShapes, default Fitting {
        /// Shape of the reference, but the copy's own where it would overlap another body otherwise or
        /// lose contacts of the structure.
        Fitting = "fitting",
        /// Shape of the reference.
        Shared = "shared",
    }
}

/// Settings for the decomposition of a structure into bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct StructureSettings {
    /// Settings with which bodies are made.
    pub body: BodySettings,
    /// Chains that make up one body; the others are a body each.
    pub joined: Vec<ChainNames>,
    /// Whether copies share a shape.
    pub shapes: CopyShapes,
    /// Whether to remove overlaps by the least displacements.
    pub relax: bool,
    /// Periodic box, Å.
    pub box_angstrom: Option<[f64; 3]>,
    /// Whether to overwrite existing files.
    pub force: bool,
}

/// Decomposes a structure into bodies and writes them with the assembly into a folder. Each chain of one
/// file is a body, and each of several files in one frame, unless the settings join chains.
///
/// # Errors
/// Without `relax`, bodies that overlap are an error that lists the pairs; so are bodies in one place.
///
/// ```no_run
/// use protomer_common::answer::Answer;
/// use protomer_protein_verbs::assemblies::structure::{CopyShapes, StructureSettings, assemble_structure};
/// use protomer_body::BodySettings;
/// use std::path::{Path, PathBuf};
/// let settings = StructureSettings {
///     body: BodySettings::default(),
///     joined: vec!["H,L".parse()?],
///     shapes: CopyShapes::Fitting,
///     relax: true,
///     box_angstrom: Some([300.0; 3]),
///     force: false,
/// };
/// let files = [PathBuf::from("1fsk.cif.gz")];
/// let assembly = assemble_structure(&files, Path::new("1fsk"), &settings)?;
/// println!("{}", assembly.text());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn assemble_structure(
    inputs: &[PathBuf],
    folder: &Path,
    settings: &StructureSettings,
) -> Result<StructureAssembly> {
    ResultKind::VoxelSet.refuse_in(folder)?;
    let decomposition = Decomposition::new(inputs, folder, settings)?;
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot create the folder {}", folder.display()))?;
    let Decomposition {
        files,
        named,
        units,
        placed,
        names,
        proposals,
        apart,
    } = decomposition;
    let native = ResidueContacts::native(&units);
    let now = ResidueContacts::of_placements(&units, &placed.types, &apart.placements);
    let edges = settings.box_angstrom;
    placed.files.require_room(&apart.placements, edges)?;
    let path = folder.join("assembly.json");
    let provenance = provenance(&files, &names, &apart);
    let assembly = placed
        .files
        .assembly_file(&path, &apart.placements, edges, provenance)?;
    let point_group = point_group_of(&units)?;
    let force = settings.force;
    refuse_another(&path, &assembly, force)?;
    for (path, body) in placed.files.paths.iter().zip(&placed.files.bodies) {
        body_file::refuse_another(path, body, force)?;
    }
    for (path, body) in placed.files.paths.iter().zip(&placed.files.bodies) {
        body_file::write_once(path, body, force)?;
    }
    write_assembly(&path, &assembly, force)?;
    Ok(StructureAssembly {
        assembly: path,
        proposed_box_angstrom: proposed_box_angstrom(&placed, &apart),
        point_group,
        placed: names,
        native_contacts: native.len(),
        native_contacts_kept: native.share_in(&now),
        structure_warnings: warnings(&files, &named, &units, &native),
        proposals,
        skipped: skipped(&files),
        bodies: described(&placed),
        overlaps: placed.overlaps,
        own_shapes: placed.own_shapes,
        moved_angstrom: apart.moved_angstrom,
        selection: files[0].selection.report.clone(),
        further_selections: reports_of(&files[1..]),
        has_box: edges.is_some(),
    })
}

/// A structure decomposed into bodies, which nothing was written of.
pub struct StructureInMemory {
    /// The bodies at their places, in open space.
    pub assembly: Assembly,
    /// Names of the placed bodies: those of their chains.
    pub names: Vec<String>,
    /// Warnings about the files and the interfaces.
    pub warnings: Vec<String>,
}

/// Decomposes a structure into bodies without writing them.
///
/// # Errors
/// As [`assemble_structure`].
pub fn structure_in_memory(
    inputs: &[PathBuf],
    settings: &StructureSettings,
) -> Result<StructureInMemory> {
    let found = Decomposition::new(inputs, Path::new(""), settings)?;
    let native = ResidueContacts::native(&found.units);
    let bodies: Vec<Arc<Body>> = found
        .placed
        .files
        .bodies
        .iter()
        .cloned()
        .map(Arc::new)
        .collect();
    let (kinds, poses): (Vec<usize>, Vec<Pose>) = found.apart.placements.iter().copied().unzip();
    // What the bodies are made of, and where they are: the identity of work on them.
    let made = bodies.iter().map(|body| &body.provenance);
    let identity = format!("{:?}{kinds:?}{poses:?}", made.collect::<Vec<_>>());
    Ok(StructureInMemory {
        warnings: warnings(&found.files, &found.named, &found.units, &native),
        names: found.names,
        assembly: Assembly {
            bodies,
            kinds,
            poses,
            boundary: Boundary::Open,
            sha256: sha256_hex(identity.as_bytes()),
            path: None,
        },
    })
}

/// Bodies of a structure and their places.
struct Decomposition {
    files: Vec<File>,
    named: Vec<NamedUnit>,
    units: Vec<Unit>,
    placed: Placed,
    /// Names of the placed bodies.
    names: Vec<String>,
    /// Chains that would better be one body.
    proposals: Vec<String>,
    /// Places without overlap.
    apart: Separation,
}

impl Decomposition {
    /// Reads the files and makes bodies, whose files are to lie in a folder.
    fn new(inputs: &[PathBuf], folder: &Path, settings: &StructureSettings) -> Result<Self> {
        let files = files::read(inputs, &settings.body.selection)?;
        let named = files::units(&files, &settings.joined)?;
        let units: Vec<Unit> = named
            .iter()
            .map(|named_unit| named_unit.unit.clone())
            .collect();
        checks::require_one_frame(&units)?;
        let placed = shapes::place(&files, &named, &units, folder, settings)?;
        let names = names_of_copies(&placed);
        let proposals = checks::joined(&units, files.len() == 1);
        let apart = moved_apart(&placed, &units, &names, &proposals, settings)?;
        Ok(Self {
            files,
            named,
            units,
            placed,
            names,
            proposals,
            apart,
        })
    }
}

/// The point group of the units as they are in the structure; `None` for a single one.
fn point_group_of(units: &[Unit]) -> Result<Option<PointGroup>> {
    // Copies may keep their own shape, and are copies nevertheless.
    let types = body_types_of_units(units, &SelectionReport::default(), &BTreeSet::new())?;
    let (mut placements, mut radii_angstrom) = (Vec::new(), Vec::new());
    for (kind, of_type) in types.iter().enumerate() {
        placements.extend(of_type.copies.iter().map(|copy| (kind, copy.pose)));
        radii_angstrom.push(radius_of_gyration_angstrom(&units[of_type.unit]));
    }
    Ok(match placements.len() {
        0 | 1 => None,
        _ => point_group(&placements, &radii_angstrom, SAME_PLACE_ANGSTROM),
    })
}

/// The radius of gyration of the atoms of a unit, Å.
fn radius_of_gyration_angstrom(unit: &Unit) -> f64 {
    let centre = centroid(unit);
    let atoms = unit.residues.iter().flat_map(|residue| &residue.atoms);
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for atom in atoms {
        sum += (atom.position - centre).norm_squared();
        count += 1.0;
    }
    (sum / count.max(1.0)).sqrt()
}

/// Names of the placed bodies in the order of their placements.
fn names_of_copies(placed: &Placed) -> Vec<String> {
    let copies = placed.types.iter().flat_map(|of_type| &of_type.copies);
    copies.map(|copy| copy.chain.clone()).collect()
}

fn described(placed: &Placed) -> Vec<StructureBody> {
    let mut described = Vec::with_capacity(placed.types.len());
    let bodies = placed.types.iter().zip(&placed.built);
    for ((of_type, built), file) in bodies.zip(&placed.files.paths) {
        let copies = || of_type.copies.iter();
        described.push(StructureBody {
            file: file.clone(),
            reference: of_type.reference.clone(),
            chains: copies().map(|copy| copy.chain.clone()).collect(),
            rmsd_angstrom: copies().map(|copy| copy.rmsd_angstrom).collect(),
            measures: BodyMeasures::from_body(&built.body),
            warnings: built.warnings.clone(),
        });
    }
    described
}

fn provenance(files: &[File], names: &[String], apart: &Separation) -> serde_json::Value {
    let sources: Vec<&str> = files.iter().map(|file| &*file.name).collect();
    let hashes: Vec<&str> = files.iter().map(|file| &*file.sha256).collect();
    let displacements = &apart.moved_angstrom;
    match (&sources[..], &hashes[..]) {
        ([source], [sha256]) => serde_json::json!({
            "source": source, "source_sha256": sha256, "chains": names, "moved_angstrom": displacements,
        }),
        _ => serde_json::json!({
            "sources": sources, "sources_sha256": hashes, "chains": names, "moved_angstrom": displacements,
        }),
    }
}

fn warnings(
    files: &[File],
    named: &[NamedUnit],
    units: &[Unit],
    native: &ResidueContacts,
) -> Vec<String> {
    let mut warnings = Vec::new();
    for file in files {
        for warning in &file.warnings {
            warnings.push(match files.len() {
                1 => warning.clone(),
                _ => format!("{}: {warning}", file.name),
            });
        }
    }
    warnings.extend(checks::gaps_in_interfaces(files, named));
    warnings.extend(checks::apart(units, native));
    warnings
}

fn skipped(files: &[File]) -> BTreeMap<&'static str, usize> {
    let mut skipped = BTreeMap::new();
    for file in files {
        for (reason, count) in &file.selection.report.skipped {
            *skipped.entry(*reason).or_default() += count;
        }
    }
    skipped
}

fn reports_of(files: &[File]) -> Vec<protomer_body::structure::SelectionReport> {
    let reports = files.iter().map(|file| file.selection.report.clone());
    reports.collect()
}

/// The edge of a cube that holds the assembly and, on each side of it, its largest body; tens of Å.
fn proposed_box_angstrom(placed: &Placed, apart: &Separation) -> f64 {
    let mut centre = Vec3::zeros();
    for (_, pose) in &apart.placements {
        centre += pose.position / apart.placements.len() as f64;
    }
    let (mut reach, mut largest) = (0.0_f64, 0.0_f64);
    for (kind, pose) in &apart.placements {
        let radius = placed.files.bodies[*kind].mesh_radius_angstrom();
        reach = reach.max((pose.position - centre).norm() + radius);
        largest = largest.max(radius);
    }
    10.0 * ((2.0 * reach + 4.0 * largest) / 10.0).ceil()
}

/// The placements without overlaps: as they are, or moved apart if `relax` is set.
fn moved_apart(
    placed: &Placed,
    units: &[Unit],
    names: &[String],
    proposals: &[String],
    settings: &StructureSettings,
) -> Result<Separation> {
    if placed.overlaps.is_empty() {
        return Ok(Separation {
            placements: placed.placements.clone(),
            moved_angstrom: vec![0.0; placed.placements.len()],
        });
    }
    if !settings.relax {
        bail!(overlap_message(placed, names, proposals, settings));
    }
    let types = placed.types.iter();
    let cores: Vec<CoreAtoms> = types
        .map(|of_type| core_atoms(&units[of_type.unit], &settings.body))
        .collect();
    let hard = &placed.files.hard;
    let apart = separate(&cores, &placed.placements, |a, b| {
        hard.overlap_in_open_space(a, b)
    });
    match apart {
        Err(BodyError::Interlocked { first, second }) => bail!(
            "{} and {} interlock: no displacement of a few Å frees them; make them one body with --body \
             {},{}",
            names[first],
            names[second],
            names[first],
            names[second]
        ),
        apart => Ok(apart?),
    }
}

fn overlap_message(
    placed: &Placed,
    names: &[String],
    proposals: &[String],
    settings: &StructureSettings,
) -> String {
    const MOST_LISTED: usize = 20;
    let pairs = placed.overlaps.iter();
    let mut pairs: Vec<String> = pairs
        .map(|(i, j)| format!("{}-{}", names[*i], names[*j]))
        .collect();
    let count = pairs.len();
    if count > MOST_LISTED {
        pairs.truncate(MOST_LISTED);
        pairs.push(format!("and {} more", count - MOST_LISTED));
    }
    let mut remedies = Vec::new();
    if settings.body.surface.core == Some(HardCore::Surface) {
        remedies.push("leave out --core surface".to_owned());
    }
    if settings.shapes == CopyShapes::Shared {
        remedies.push("leave out --shapes shared".to_owned());
    }
    remedies.push("move them apart with --relax".to_owned());
    let mut message = format!(
        "{count} pairs of bodies overlap: {}; {}",
        pairs.join(", "),
        remedies.join(", or ")
    );
    for proposal in proposals {
        message += "; ";
        message += proposal;
    }
    message
}

/// Atoms of the hard core of a unit, in the frame of its body.
fn core_atoms(unit: &Unit, settings: &BodySettings) -> CoreAtoms {
    let origin = centroid(unit);
    let surface = &settings.surface;
    let is_native = surface.core != Some(HardCore::Surface);
    let default = if is_native {
        HardCore::NATIVE_OFFSET_ANGSTROM
    } else {
        0.0
    };
    let offset = surface.inward_offset_angstrom.unwrap_or(default);
    let (mut positions, mut radii_angstrom) = (Vec::new(), Vec::new());
    for atom in unit.residues.iter().flat_map(|residue| &residue.atoms) {
        let radius = match is_native {
            true => core_radius_angstrom(&atom.element),
            false => radius_angstrom(&atom.element),
        };
        positions.push(atom.position - origin);
        radii_angstrom.push(radius - offset);
    }
    CoreAtoms {
        positions,
        radii_angstrom,
    }
}

#[cfg(test)]
mod tests;
