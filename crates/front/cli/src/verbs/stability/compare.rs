//! `protomer compare`: several sweeps in one figure.

use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_protein_verbs::stability::compare::compare;
use std::path::PathBuf;

/// Draw several finished sweeps in one figure; the legend names the directories.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "compare spin_0 spin_90 -o spins.svg",
    "compare stability --title Ring -o ring.png"
))]
#[group(id = "CompareResult")]
pub struct CompareArgs {
    /// Sweep directories.
    #[arg(required = true)]
    sweeps: Vec<PathBuf>,
    /// Figure to write: .png or .svg.
    #[arg(short, long)]
    output: PathBuf,
    /// Title of the figure.
    #[arg(long, default_value = "Stability against salt")]
    title: String,
}

impl CompareArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let report = compare(&self.sweeps, &self.title, &self.output, front.force())?;
        Ok(Reply::from_answer(report))
    }
}
