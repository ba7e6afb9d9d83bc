//! `protomer lattice replay` and `respond`: states from a file.

use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_linkage_verbs::lattice::replay::{LatticeFile, replay, respond};
use std::path::PathBuf;

/// Integrate the state of a file (JSON: ns, r0, kappa, s0, v0, times): without collisions to
/// the listed times, and up to the first contact and through it.
#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// The file.
    file: PathBuf,
    /// Time step; reduced slightly to match the listed times.
    #[arg(long = "dt", default_value_t = 1e-3)]
    time_step: f64,
    /// Time limit of the search for a contact.
    #[arg(long, default_value_t = 20.0)]
    longest: f64,
}

impl ReplayArgs {
    pub fn run(&self) -> Result<Reply> {
        let file = LatticeFile::read(&self.file)?;
        Ok(Reply::data(replay(&file, self.time_step, self.longest)?))
    }
}

/// The elastic impact at the contact state of a file (JSON: ns, r0, first_collision with s and v).
#[derive(Debug, Args)]
pub struct RespondArgs {
    /// The file.
    file: PathBuf,
}

impl RespondArgs {
    pub fn run(&self) -> Result<Reply> {
        Ok(Reply::data(respond(&LatticeFile::read(&self.file)?)?))
    }
}
