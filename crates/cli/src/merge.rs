//! `protomer merge`: several sets of voxel grids to one.

use super::{Global, Outcome, output};
use anyhow::{Result, bail};
use clap::Args;
use protomer::voxels::merge::merge;
use protomer::voxels::origin::Missing;
use std::path::PathBuf;

/// Join sets of voxel grids of the same settings; the parts of one manifest become the set that one
/// run would have made.
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Sets to join.
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// The set to write.
    #[arg(short, long)]
    output: PathBuf,
}

impl MergeArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        let report = merge(&self.inputs, &self.output, global.force)?;
        for line in report
            .missing
            .iter()
            .map(Missing::line)
            .chain(report.manifest_warnings.iter().cloned())
        {
            global.say(&format!("warning: {line}"));
        }
        if global.json {
            output::json(&report)?;
        } else if !global.quiet {
            let end = if report.nothing_to_do {
                ", nothing to do"
            } else {
                ""
            };
            let (set, samples, excluded) = (report.set.display(), report.samples, report.excluded);
            output::text(&format!(
                "{set}: {samples} samples of {} sets, {excluded} left out{end}",
                report.sets
            ))?;
        }
        if report.samples == 0 {
            bail!(
                "{} has no samples: {} structures were left out; its attribute 'excluded' says why",
                report.set.display(),
                report.excluded
            );
        }
        Ok(if report.missing.is_empty() {
            Outcome::Done
        } else {
            Outcome::Partial
        })
    }
}
