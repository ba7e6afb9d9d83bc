//! `protomer candidates`: the up/down arrangements of a ring or stack that are different under its
//! symmetry.

use crate::flags::settings::choice;
use crate::flags::space::SpaceArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_body::assembly::Symmetry;
use protomer_common::range;
use protomer_protein_verbs::assemblies::candidates::{CandidatesSettings, candidates};
use std::path::PathBuf;

/// Enumerate the distinct up/down arrangements of bodies in a ring or a stack of two
/// rings, up to the symmetry of the stack, and write each as an assembly closed to contact.
#[derive(Debug, Args)]
pub struct CandidatesArgs {
    /// Body files, in the order in which they alternate.
    #[arg(required = true)]
    bodies: Vec<PathBuf>,
    /// Bodies per ring.
    #[arg(long, value_parser = range::MEMBERS.number::<usize>())]
    ring: usize,
    /// Number of rings: one or two.
    #[arg(long, default_value_t = 1)]
    stack: usize,
    /// Symmetry required of an arrangement.
    #[arg(long, value_parser = choice::<Symmetry>(), default_value = "dihedral")]
    symmetry: Symmetry,
    /// Gap between neighbours in the ring, and between the rings, beyond contact, Å.
    #[arg(long, default_value_t = 0.5, value_parser = range::GAP.number())]
    gap: f64,
    #[command(flatten)]
    space: SpaceArgs,
    /// Folder for the assemblies; if omitted, they are only counted.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

impl CandidatesArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let settings = CandidatesSettings {
            bodies: self.bodies.clone(),
            ring: self.ring,
            stack: self.stack,
            symmetry: self.symmetry,
            gap_angstrom: self.gap,
            box_angstrom: self.space.box_angstrom()?,
            output: self.output.clone(),
            force: front.force(),
        };
        Ok(Reply::data(candidates(&settings)?))
    }
}
