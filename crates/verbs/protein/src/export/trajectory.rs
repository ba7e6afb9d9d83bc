//! The trajectory of a run, or of another program, in another version of its schema.

use super::run_directory::trajectory_of_run;
use super::{ExportSettings, Frame};
use anyhow::{Context, Result, bail};
use protomer_common::answer::{Answer, counted};
use protomer_common::output_file::require_writable;
use protomer_io::gsd::{GsdFile, SchemaVersion, copy_trajectory};
use protomer_kernel::setting::Choices;
use serde::Serialize;
use std::path::{Path, PathBuf};

protomer_kernel::choices! {
    /// Version of the HOOMD schema of a trajectory.
    pub enum Schema, default V2_0 {
        /// The version that HOOMD-blue 7 writes; gsd 5 or newer reads it.
        V2_0 = "2.0",
        /// The version that every reader opens, in single precision.
        V1_4 = "1.4",
    }
}

impl From<Schema> for SchemaVersion {
    fn from(schema: Schema) -> Self {
        match schema {
            Schema::V2_0 => Self::V2_0,
            Schema::V1_4 => Self::V1_4,
        }
    }
}

/// Report on the export of a trajectory.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrajectoryReport {
    /// The trajectory written.
    pub file: PathBuf,
    /// The trajectory read.
    pub source: PathBuf,
    /// Version of the schema of the trajectory written.
    pub schema: &'static str,
    /// Number of frames written.
    pub frames: u64,
    /// Number of bodies in the first frame written.
    pub bodies: u64,
}

impl Answer for TrajectoryReport {
    fn text(&self) -> String {
        format!(
            "{}: {} of {}, HOOMD schema {}",
            self.file.display(),
            counted(self.frames as usize, "frame", "frames"),
            counted(self.bodies as usize, "body", "bodies"),
            self.schema
        )
    }
}

/// Whether the name of an output asks for a trajectory, not for atoms.
pub fn is_trajectory(output: &Path) -> bool {
    output
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("gsd"))
}

/// Writes a trajectory again: all frames, or the one that the settings name.
///
/// # Errors
/// For an input without a trajectory, a frame that does not exist, settings that belong to
/// structure files, and a file that exists or cannot be written.
pub fn export_trajectory(settings: &ExportSettings) -> Result<TrajectoryReport> {
    refuse_options_of_structures(settings)?;
    require_writable(&settings.output, settings.force)?;
    let source = source_of(settings)?;
    let frame = match settings.frame {
        None => None,
        Some(Frame::Number(number)) => Some(number),
        Some(Frame::Last) => Some(GsdFile::open(&source)?.frames().saturating_sub(1)),
    };
    let schema = settings.schema.unwrap_or_default();
    let copied = copy_trajectory(&source, &settings.output, schema.into(), frame)?;
    Ok(TrajectoryReport {
        file: settings.output.clone(),
        source,
        schema: schema.name(),
        frames: copied.frames,
        bodies: copied.particles,
    })
}

fn source_of(settings: &ExportSettings) -> Result<PathBuf> {
    let input = settings.input.as_path();
    if input.is_dir() {
        return trajectory_of_run(settings);
    }
    std::fs::metadata(input).with_context(|| format!("cannot read {}", input.display()))?;
    if settings.salt_molar.is_some() || settings.replica.is_some() {
        bail!(
            "--salt and --replica apply to directories of runs, but {} is a file; leave them out",
            input.display()
        );
    }
    if !is_trajectory(input) {
        bail!(
            "{} is no trajectory; name a .gsd file, or the directory of a run that wrote one",
            input.display()
        );
    }
    Ok(input.to_owned())
}

/// Options that only files of atoms have would otherwise be ignored silently.
fn refuse_options_of_structures(settings: &ExportSettings) -> Result<()> {
    let options = [
        ("--assembly", settings.assembly.is_some()),
        ("--values", settings.values.is_some()),
        ("--gather", settings.gather),
        ("--script", settings.script.is_some()),
    ];
    for (name, is_given) in options {
        if is_given {
            bail!(
                "{name} applies to structure files, but {} is a trajectory; leave it out, or name \
                 the output .pdb or .cif",
                settings.output.display()
            );
        }
    }
    Ok(())
}
