//! `protomer lattice elastic`: Poisson's ratio and compliances of runs in a heat bath.

use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_linkage_verbs::lattice::elastic::{ElasticSettings, elastic};
use std::path::PathBuf;

/// Compliances and Poisson's ratio of runs in a heat bath: from the fluctuations of the strain in each
/// run, and from the response of runs that differ in their stress.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "lattice elastic pulled pushed",
    "lattice elastic warm --discard 0.2 --blocks 10"
))]
pub struct ElasticArgs {
    /// Directories of runs.
    #[arg(required = true)]
    directories: Vec<PathBuf>,
    /// Share of every log that is left out at its start.
    #[arg(long, default_value_t = 0.1)]
    discard: f64,
    /// Blocks of every log for the errors; each must be longer than the strains remember.
    #[arg(long, default_value_t = 20)]
    blocks: usize,
}

impl ElasticArgs {
    pub fn run(&self) -> Result<Reply> {
        let settings = ElasticSettings {
            discard: self.discard,
            blocks: self.blocks,
        };
        Ok(Reply::data(elastic(&self.directories, &settings)?))
    }
}
