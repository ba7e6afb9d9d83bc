//! `protomer lattice`: rigid squares joined by rods.

mod bench;
mod replay;
mod run;

use super::{Global, Outcome};
use anyhow::Result;
use clap::{Args, Subcommand};

/// Two-dimensional crystals of rigid squares whose corners are joined by rigid rods: run, sweep, animate.
#[derive(Debug, Args)]
pub struct LatticeArgs {
    #[command(subcommand)]
    verb: LatticeVerb,
}

#[derive(Debug, Subcommand)]
enum LatticeVerb {
    Run(run::RunArgs),
    Replay(replay::ReplayArgs),
    Respond(replay::RespondArgs),
    Bench(bench::BenchArgs),
}

impl LatticeArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        match &self.verb {
            LatticeVerb::Run(args) => args.run(global),
            LatticeVerb::Replay(args) => args.run(global),
            LatticeVerb::Respond(args) => args.run(global),
            LatticeVerb::Bench(args) => args.run(global),
        }
    }
}
