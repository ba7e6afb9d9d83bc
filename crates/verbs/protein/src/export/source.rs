//! Which bodies are where.

use super::ExportSettings;
use super::run_directory::RunFiles;
use crate::assemblies::assembly_file::Assembly;
use crate::bodies::body_file;
use crate::file_kind::FileKind;
use anyhow::{Context, Result, bail};
use protomer_body::Body;
use protomer_io::gsd::TrajectoryReader;
use protomer_kernel::Pose;
use std::path::Path;
use std::sync::Arc;

/// A frame of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Frame {
    /// Number of the frame, counted from zero.
    Number(u64),
    /// The last frame.
    Last,
}

impl Frame {
    /// Reads `last` or a number.
    ///
    /// # Errors
    /// For anything else.
    ///
    /// ```
    /// use protomer_protein_verbs::export::Frame;
    /// assert_eq!((Frame::parse("last")?, Frame::parse("12")?), (Frame::Last, Frame::Number(12)));
    /// # Ok::<(), anyhow::Error>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self> {
        if text == "last" {
            return Ok(Self::Last);
        }
        let number = text.parse();
        let number = number
            .map_err(|_| anyhow::anyhow!("'{text}' is no frame; give a number from 0, or last"))?;
        Ok(Self::Number(number))
    }
}

/// The place of a state in its trajectory.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) frame: u64,
    pub(super) frames: u64,
    pub(super) sweep: u64,
}

/// Bodies and their poses.
#[derive(Debug)]
pub(super) struct Source {
    pub(super) title: String,
    pub(super) bodies: Vec<Arc<Body>>,
    pub(super) kinds: Vec<usize>,
    pub(super) poses: Vec<Pose>,
    pub(super) box_angstrom: Option<[f64; 3]>,
    pub(super) place: Option<Place>,
}

impl Source {
    /// Reads what the settings name.
    pub(super) fn read(settings: &ExportSettings) -> Result<Self> {
        let input = settings.input.as_path();
        if input.is_dir() {
            return Self::of_run(settings);
        }
        refuse_options_of_runs(settings)?;
        match ending(input).as_str() {
            "body" => Self::of_body(input),
            "json" => {
                let assembly = Assembly::read(input)?;
                Ok(Self::of_assembly(assembly, input.display().to_string()))
            }
            "gsd" => bail!(
                "{} has no atoms; name the directory of the run, whose assembly names the bodies, or an \
                 output that ends in .gsd",
                input.display()
            ),
            "pdb" | "ent" | "cif" | "mmcif" | "pqr" | "gz" => bail!(
                "{} is a structure already; 'protomer ingest' makes a body of it",
                input.display()
            ),
            _ => {
                FileKind::Assembly.require(input)?;
                bail!(
                    "cannot export {}; name an assembly file (.json), a body, or the directory of a \
                     simulation or a sweep",
                    input.display()
                )
            }
        }
    }

    fn of_body(path: &Path) -> Result<Self> {
        let (body, _) = body_file::read(path)?;
        Ok(Self {
            title: path.display().to_string(),
            bodies: vec![Arc::new(body)],
            kinds: vec![0],
            poses: vec![Pose::identity()],
            box_angstrom: None,
            place: None,
        })
    }

    fn of_assembly(assembly: Assembly, title: String) -> Self {
        Self {
            title,
            box_angstrom: assembly.box_angstrom(),
            bodies: assembly.bodies,
            kinds: assembly.kinds,
            poses: assembly.poses,
            place: None,
        }
    }

    fn of_run(settings: &ExportSettings) -> Result<Self> {
        let RunFiles {
            trajectory,
            assembly,
        } = RunFiles::find(settings)?;
        let mut reader = TrajectoryReader::open(&trajectory)?;
        let frames = reader.frames();
        let frame = match settings.frame.unwrap_or(Frame::Last) {
            Frame::Number(number) => number,
            Frame::Last => frames.saturating_sub(1),
        };
        let snapshot = reader.frame(frame)?;
        let kinds: Vec<usize> = snapshot
            .type_ids
            .iter()
            .map(|kind| *kind as usize)
            .collect();
        if kinds != assembly.kinds {
            bail!(
                "{} is a trajectory of other bodies than those of the assembly; name the right one \
                 with --assembly FILE",
                trajectory.display()
            );
        }
        let title = format!(
            "{}, frame {frame}, after {} sweeps",
            trajectory.display(),
            snapshot.step
        );
        Ok(Self {
            poses: snapshot.poses,
            place: Some(Place {
                frame,
                frames,
                sweep: snapshot.step,
            }),
            ..Self::of_assembly(assembly, title)
        })
    }
}

/// Options that only runs have would otherwise be ignored silently.
fn refuse_options_of_runs(settings: &ExportSettings) -> Result<()> {
    let options = [
        ("--frame", settings.frame.is_some()),
        ("--salt", settings.salt_molar.is_some()),
        ("--replica", settings.replica.is_some()),
        ("--assembly", settings.assembly.is_some()),
    ];
    for (name, is_given) in options {
        if is_given {
            bail!(
                "{name} applies to directories of runs, but {} is a file; leave it out",
                settings.input.display()
            );
        }
    }
    std::fs::metadata(&settings.input)
        .with_context(|| format!("cannot read {}", settings.input.display()))?;
    Ok(())
}

fn ending(path: &Path) -> String {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    ending.to_ascii_lowercase()
}
