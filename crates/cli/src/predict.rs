//! `protomer predict`: a trained network applied to a set.

use super::device::DeviceArgs;
use super::{Global, Outcome, output};
use anyhow::{Result, bail};
use clap::Args;
use protomer::frameworks::directory::{refuse_to_overwrite, write_one};
use protomer::learning::predict::{PredictReport, predict};
use protomer_results::{End, Execution};
use std::path::{Path, PathBuf};

/// Apply a network that 'protomer train' has made to every sample of a set of voxels: class and
/// probabilities, and scores where the labels are known.
#[derive(Debug, Args)]
pub struct PredictArgs {
    /// Directory of a finished training.
    run: PathBuf,
    /// Set of voxels (zarr), made by 'protomer voxelize' like the one of the training.
    set: PathBuf,
    /// Table to write (CSV); left out, it goes to the standard output.
    #[arg(short, long)]
    output: Option<PathBuf>,
    #[command(flatten)]
    device: DeviceArgs,
}

impl PredictArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        if let Some(path) = &self.output {
            check_output(path, global.force)?;
        }
        let execution = Execution {
            interrupt: global.host.interrupt.clone().unwrap_or_default(),
            progress: global.progress(),
            ..Execution::default()
        };
        let end = predict(&self.run, &self.set, &self.device.open()?, &execution)?;
        drop(execution);
        let End::Finished(report) = end else {
            return Ok(Outcome::Stopped);
        };
        if let Some(path) = &self.output {
            write_one(path, &report.table()?.to_csv(), global.force)?;
        }
        self.tell(global, &report)?;
        Ok(if report.left_out.is_empty() {
            Outcome::Done
        } else {
            Outcome::Partial
        })
    }

    fn tell(&self, global: &Global, report: &PredictReport) -> Result<()> {
        for sample in &report.left_out {
            global.say(&format!("left out: {}: {}", sample.name, sample.reason));
        }
        for difference in &report.differences {
            global.say(&format!(
                "warning: the voxels were made otherwise: {}",
                difference.line()
            ));
        }
        if global.json {
            return output::json(report);
        }
        if self.output.is_none() {
            global.say(&report.summary());
            return output::text(report.table()?.to_csv().trim_end());
        }
        if global.quiet {
            Ok(())
        } else {
            output::text(&report.summary())
        }
    }
}

/// Before the work, which may be long.
fn check_output(path: &Path, force: bool) -> Result<()> {
    refuse_to_overwrite(path, force)?;
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            bail!(
                "cannot write {}: there is no folder {}; make it first",
                path.display(),
                folder.display()
            )
        }
        _ => Ok(()),
    }
}
