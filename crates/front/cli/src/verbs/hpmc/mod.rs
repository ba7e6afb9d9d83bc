//! `protomer hpmc`: Monte Carlo of many hard convex bodies.

mod free_volume;
mod run;
mod sweep;
mod system;

use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::{Args, Subcommand};

/// Hard convex bodies in a periodic box, with penetrable depletants.
#[derive(Debug, Args)]
#[command(arg_required_else_help = true)]
#[command(after_long_help = examples!(
    "hpmc run --shape cube --packing-fraction 0.3 -o cubes",
    "hpmc run --shape cube --packing-fraction 0.3 --depletants 0.1:20 -o depleted"
))]
pub struct HpmcArgs {
    #[command(subcommand)]
    verb: HpmcVerb,
}

#[derive(Debug, Subcommand)]
enum HpmcVerb {
    Run(Box<run::RunArgs>),
    Sweep(Box<sweep::SweepArgs>),
    FreeVolume(free_volume::FreeVolumeArgs),
}

impl HpmcArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        match &self.verb {
            HpmcVerb::Run(args) => args.run(front),
            HpmcVerb::Sweep(args) => args.run(front),
            HpmcVerb::FreeVolume(args) => args.run(),
        }
    }
}
