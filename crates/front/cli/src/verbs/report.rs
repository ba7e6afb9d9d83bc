//! `protomer report`: a directory of results as one page.

use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_report::{Request, report};
use std::path::PathBuf;

/// Make a self-contained HTML page of a directory of results: figures with their numbers,
/// rotatable bodies, animated lattices. The page loads nothing.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "report stability",
    "report coherent -o coherent.html --force"
))]
pub struct ReportArgs {
    /// Directory of a simulation, a sweep, a lattice run or sweep, a framework, a training or a
    /// search; or a set of voxels.
    directory: PathBuf,
    /// The page [default: report.html in the directory; SET.zarr.report.html next to a set
    /// of voxels].
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Assembly file of a sweep or simulation, if it has moved.
    #[arg(long)]
    assembly: Option<PathBuf>,
}

impl ReportArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let request = Request {
            output: self.output.clone(),
            assembly: self.assembly.clone(),
            force: front.force(),
        };
        Ok(Reply::from_answer(report(&self.directory, &request)?))
    }
}
