//! `protomer lattice bench`: steps per CPU-second.

use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_linkage_verbs::lattice::bench::bench;
use protomer_linkage_verbs::lattice::settings::{LatticeSettings, TimeStep};

/// Measure steps per CPU-second of a square lattice from a half-open start with random angular
/// velocities.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// Squares along an edge.
    #[arg(long, default_value_t = 10)]
    ns: usize,
    /// Length of the rods.
    #[arg(long, default_value_t = 3.0 / 22.0)]
    r0: f64,
    /// Steps.
    #[arg(long, default_value_t = 1000)]
    steps: u64,
    /// Time step: auto, or a number.
    #[arg(long = "dt", default_value = "auto", allow_hyphen_values = true)]
    time_step: TimeStep,
    /// Let squares pass through each other.
    #[arg(long)]
    no_collisions: bool,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

impl BenchArgs {
    pub fn run(&self) -> Result<Reply> {
        let settings = LatticeSettings {
            rows: self.ns,
            columns: self.ns,
            r0: self.r0,
            time_step: self.time_step,
            collisions: !self.no_collisions,
            seed: self.seed,
            ..LatticeSettings::default()
        };
        Ok(Reply::data(bench(&settings, self.steps)?))
    }
}
