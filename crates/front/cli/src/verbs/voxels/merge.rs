//! `protomer merge`: merges several sets of voxel grids.

use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, anyhow};
use clap::Args;
use protomer_learn_verbs::voxels::merge::merge;
use protomer_learn_verbs::voxels::origin::Missing;
use std::path::PathBuf;

/// Merge sets of voxel grids with the same settings; the parts of one manifest give the same set
/// as a single run.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "merge part1.zarr part2.zarr -o set.zarr",
    "merge a.zarr b.zarr -o both.zarr --force"
))]
pub struct MergeArgs {
    /// Sets to merge.
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// The set to write.
    #[arg(short, long)]
    output: PathBuf,
}

impl MergeArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let report = merge(&self.inputs, &self.output, front.force())?;
        let missing = report.missing.iter().map(Missing::line);
        let lines = missing.chain(report.manifest_warnings.iter().cloned());
        let warnings: Vec<String> = lines.map(|line| format!("warning: {line}")).collect();
        let failure = (report.samples == 0).then(|| {
            anyhow!(
                "{} has no samples: {} structures were left out; its attribute 'excluded' says why",
                report.set.display(),
                report.excluded
            )
        });
        let is_incomplete = !report.missing.is_empty();
        Ok(Reply::from_answer(report)
            .with_notes(warnings)
            .partial_if(is_incomplete)
            .failing(failure))
    }
}
