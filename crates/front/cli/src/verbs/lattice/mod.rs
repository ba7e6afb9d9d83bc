//! `protomer lattice`: rigid squares joined by rods.

mod animate;
mod bench;
mod divergence;
mod elastic;
mod joint;
mod replay;
mod run;
mod square;
mod sweep;

use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, bail};
use clap::{Args, Subcommand};
use protomer_linkage_verbs::lattice::square_of_body::{Axis, Size};
use std::path::PathBuf;

/// Two-dimensional crystals of rigid squares whose corners are joined by rigid rods.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, arg_required_else_help = true)]
#[command(after_long_help = examples!(
    "lattice run --ns 10 --r0 0.05 --time 3 -o coherent",
    "lattice --from bodies/square.body"
))]
pub struct LatticeArgs {
    /// The square that stands for this body, as `square` prints it.
    #[arg(long, value_name = "BODY")]
    from: Option<PathBuf>,
    #[command(subcommand)]
    verb: Option<LatticeVerb>,
}

#[derive(Debug, Subcommand)]
enum LatticeVerb {
    Run(run::RunArgs),
    Sweep(sweep::SweepArgs),
    Elastic(elastic::ElasticArgs),
    Divergence(divergence::DivergenceArgs),
    Animate(animate::AnimateArgs),
    Square(square::SquareArgs),
    Joint(joint::JointArgs),
    Replay(replay::ReplayArgs),
    Respond(replay::RespondArgs),
    Bench(bench::BenchArgs),
}

impl LatticeArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        match (&self.verb, &self.from) {
            (Some(LatticeVerb::Run(args)), _) => args.run(front),
            (Some(LatticeVerb::Sweep(args)), _) => args.run(front),
            (Some(LatticeVerb::Elastic(args)), _) => args.run(),
            (Some(LatticeVerb::Divergence(args)), _) => args.run(),
            (Some(LatticeVerb::Animate(args)), _) => args.run(front),
            (Some(LatticeVerb::Square(args)), _) => args.run(front),
            (Some(LatticeVerb::Joint(args)), _) => args.run(front),
            (Some(LatticeVerb::Replay(args)), _) => args.run(),
            (Some(LatticeVerb::Respond(args)), _) => args.run(),
            (Some(LatticeVerb::Bench(args)), _) => args.run(),
            (None, Some(body)) => square::square(body, Axis::Auto, Size::Corners, None, front),
            (None, None) => bail!(
                "give a subcommand: lattice run, sweep, elastic, divergence, animate, square, joint, replay, respond or bench"
            ),
        }
    }
}
