//! Back to atoms: assemblies, frames of trajectories and bound poses as PDB and mmCIF files, with
//! scripts for viewers; and trajectories in another version of their schema.
//!
//! | module | one idea |
//! |---|---|
//! | `source` | which bodies are where: an assembly file, a body, or a frame of a run |
//! | `run_directory` | the trajectory and the assembly of a run |
//! | `gather` | a cluster across the border of the box in one piece |
//! | `structure_file` | the format by the name of the file |
//! | `values` | a number per residue, to colour by |
//! | `script` | scripts for ChimeraX and PyMOL |
//! | `trajectory` | a trajectory in another version of its schema |

mod gather;
mod run_directory;
mod script;
mod source;
mod structure_file;
mod trajectory;
mod values;

pub use gather::gather;
pub use run_directory::assembly_of;
pub use script::Viewer;
pub use source::Frame;
pub use structure_file::StructureFormat;
pub use trajectory::{Schema, TrajectoryReport, export_trajectory, is_trajectory};
pub use values::ResidueValues;

use anyhow::{Result, bail};
use protomer_body::structure::write::{PlacedBodies, PlacedBody, WrittenChain};
use protomer_common::answer::{Answer, counted};
use protomer_common::output_file::{refuse_to_replace, require_folder, write_once};
use protomer_io::atomic::write_bytes;
use serde::Serialize;
use source::Source;
use std::path::{Path, PathBuf};

/// Settings of an export.
///
/// ```no_run
/// use protomer_protein_verbs::export::{ExportSettings, Frame, Viewer, export};
/// let settings = ExportSettings {
///     input: "stability".into(),
///     output: "end.cif".into(),
///     frame: Some(Frame::Last),
///     script: Some(Viewer::Chimerax),
///     ..ExportSettings::default()
/// };
/// println!("{} atoms", export(&settings)?.atoms);
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct ExportSettings {
    /// An assembly file, a body file, or the directory of a simulation or a sweep.
    pub input: PathBuf,
    /// The structure file: `.pdb`, `.ent`, `.cif` or `.mmcif`.
    pub output: PathBuf,
    /// The frame of a run; the last if `None`.
    pub frame: Option<Frame>,
    /// The salt concentration of a run of several, mol/L.
    pub salt_molar: Option<f64>,
    /// The replica of a run; the first if `None`.
    pub replica: Option<u32>,
    /// The assembly of a run, if it is no longer where the run was begun with it.
    pub assembly: Option<PathBuf>,
    /// Values for the B factors of residues; zero if `None`.
    pub values: Option<ResidueValues>,
    /// Whether copies are shifted by box lengths, so that a cluster is in one piece.
    pub gather: bool,
    /// The viewer that a script is written for.
    pub script: Option<Viewer>,
    /// Version of the schema of a trajectory; the newest if `None`.
    pub schema: Option<Schema>,
    /// Whether existing files are replaced.
    pub force: bool,
}

/// Report on an export.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExportReport {
    /// The structure file.
    pub file: PathBuf,
    /// The script next to the structure file.
    pub script: Option<PathBuf>,
    /// Number of copies of bodies.
    pub copies: usize,
    /// Number of atoms.
    pub atoms: usize,
    /// The frame, counted from zero; null for an assembly.
    pub frame: Option<u64>,
    /// Frames of the trajectory; null for an assembly.
    pub frames: Option<u64>,
    /// Sweeps done at this frame; null for an assembly.
    pub sweep: Option<u64>,
    /// The chains of the file, with the copy and the chain that each was.
    pub chains: Vec<WrittenChain>,
}

impl Answer for ExportReport {
    fn text(&self) -> String {
        let mut text = format!(
            "{}: {} in {}, {} in all",
            self.file.display(),
            counted(self.copies, "body", "bodies"),
            counted(self.chains.len(), "chain", "chains"),
            counted(self.atoms, "atom", "atoms")
        );
        if let (Some(frame), Some(frames), Some(sweep)) = (self.frame, self.frames, self.sweep) {
            let last = frames.saturating_sub(1);
            text += &format!("\nframe {frame} (of 0 to {last}), after {sweep} sweeps");
        }
        if let Some(script) = &self.script {
            text += &format!("\nscript: {}", script.display());
        }
        text
    }
}

/// Writes bodies as atoms.
///
/// # Errors
/// For an input that holds no bodies, a frame that does not exist, bodies without atoms, what does
/// not fit the format, and files that exist or cannot be written.
pub fn export(settings: &ExportSettings) -> Result<ExportReport> {
    let format = StructureFormat::of_path(&settings.output)?;
    if settings.schema.is_some() {
        bail!(
            "--schema applies to trajectories, but {} is a structure file; leave it out, or name the \
             output .gsd",
            settings.output.display()
        );
    }
    let script = settings
        .script
        .map(|viewer| (viewer, viewer.path_beside(&settings.output)));
    require_folder(&settings.output)?;
    let mut source = Source::read(settings)?;
    if settings.gather {
        gather_in_box(&mut source)?;
    }
    let placed = placed(&source, settings.values);
    let (text, chains) = rendered(format, &placed)?;
    let mut files = vec![(&settings.output, text)];
    if let Some((viewer, path)) = &script {
        let limit = settings.values.map(ResidueValues::limit);
        let text = viewer.script(&settings.output, &placed, &chains, limit)?;
        files.push((path, text));
    }
    for (path, text) in &files {
        refuse_to_replace(path, text.as_bytes(), settings.force)?;
    }
    for (path, text) in &files {
        write_once(path, text, settings.force)?;
    }
    Ok(ExportReport {
        file: settings.output.clone(),
        script: script.map(|(_, path)| path),
        copies: placed.copies.len(),
        atoms: placed.atoms(),
        frame: source.place.map(|place| place.frame),
        frames: source.place.map(|place| place.frames),
        sweep: source.place.map(|place| place.sweep),
        chains,
    })
}

fn gather_in_box(source: &mut Source) -> Result<()> {
    let Some(lengths) = source.box_angstrom else {
        bail!("there is no periodic box, so nothing to gather; leave out --gather");
    };
    let positions = source.poses.iter_mut().map(|pose| &mut pose.position);
    gather(&mut positions.collect::<Vec<_>>(), lengths);
    Ok(())
}

fn placed<'a>(source: &'a Source, values: Option<ResidueValues>) -> PlacedBodies<'a> {
    let mut copies = Vec::with_capacity(source.poses.len());
    for (kind, pose) in source.kinds.iter().zip(&source.poses) {
        let body = &source.bodies[*kind];
        copies.push(PlacedBody {
            residue_values: values.map_or(Vec::new(), |values| values.evaluate(body)),
            ..PlacedBody::new(body, *pose)
        });
    }
    PlacedBodies {
        title: source.title.clone(),
        copies,
        box_angstrom: source.box_angstrom,
    }
}

/// Writes a structure file and returns its chains.
///
/// # Errors
/// For bodies without atoms, what does not fit the format, and a file that cannot be written.
pub fn write_structure(
    path: &Path,
    format: StructureFormat,
    placed: &PlacedBodies,
) -> Result<Vec<WrittenChain>> {
    let (text, chains) = rendered(format, placed)?;
    write_bytes(path, text.as_bytes())?;
    Ok(chains)
}

/// The text of a structure file, and its chains.
fn rendered(format: StructureFormat, placed: &PlacedBodies) -> Result<(String, Vec<WrittenChain>)> {
    Ok(match format {
        StructureFormat::Pdb => (placed.to_pdb()?, placed.chains_of_pdb()?),
        StructureFormat::Mmcif => (placed.to_mmcif()?, placed.chains_of_mmcif()),
    })
}
