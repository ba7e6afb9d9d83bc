//! `protomer md`: contact dynamics of convex bodies.

mod run;

use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::{Args, Subcommand};

/// Contact dynamics: convex bodies in motion, in two and three dimensions.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "md run --shape polygon:4 --packing-fraction 0.6 -o squares",
    "md run --shape octahedron --bodies 500 --potential smooth --ensemble nvt -o fluid"
))]
pub struct MdArgs {
    #[command(subcommand)]
    verb: MdVerb,
}

#[derive(Debug, Subcommand)]
enum MdVerb {
    Run(Box<run::RunArgs>),
}

impl MdArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        match &self.verb {
            MdVerb::Run(args) => args.run(front),
        }
    }
}
