//! `protomer assemble`: assemblies from a structure, from a ring or stack recipe, or as a fluid.

use crate::flags::body::{
    ChainGroupArgs, ChargeArgs, CoreArgs, SelectionArgs, SurfaceFlags, body_settings,
};
use crate::flags::settings::choice;
use crate::flags::space::SpaceArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, bail};
use clap::{Args, Subcommand};
use protomer_body::assembly::RecipeSite;
use protomer_common::range;
use protomer_protein_verbs::assemblies::fluid::assemble_fluid;
use protomer_protein_verbs::assemblies::ring::{RingSettings, assemble_ring};
use protomer_protein_verbs::assemblies::structure::{
    CopyShapes, StructureSettings, assemble_structure,
};
use std::path::PathBuf;

/// Build assemblies: from the chains of a structure, as a ring or a stack of two rings, or at
/// random.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "assemble structure 1brs.cif.gz --chain A,D --relax -o complex",
    "assemble ring a.body b.body --members 4 --box 320 -o ring.json"
))]
pub struct AssembleArgs {
    #[command(subcommand)]
    from: From,
}

#[derive(Debug, Subcommand)]
enum From {
    Structure(Box<StructureArgs>),
    Ring(RingArgs),
    Fluid(FluidArgs),
}

/// Decompose a structure: each chain becomes a body, or each of several files in one frame; identical
/// ones become one body, and each copy a pose.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "assemble structure receptor.pdb ligand.pdb --box 300 -o complex",
    "assemble structure 6mdr.cif.gz --assembly 1 --box 400 -o stack"
))]
pub struct StructureArgs {
    /// Structure file, or several in one frame, such as a receptor and its ligand.
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Folder for the bodies and assembly.json.
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    selection: SelectionArgs,
    #[command(flatten)]
    charges: ChargeArgs,
    #[command(flatten)]
    surface: SurfaceFlags,
    #[command(flatten)]
    core: CoreArgs,
    #[command(flatten)]
    bodies: ChainGroupArgs,
    /// The shapes of copies.
    #[arg(long, value_parser = choice::<CopyShapes>(), default_value = "fitting", help_heading = "Bodies")]
    shapes: CopyShapes,
    /// Remove overlaps by the least displacements and rotations of the bodies.
    #[arg(long)]
    relax: bool,
    #[command(flatten)]
    space: SpaceArgs,
}

/// A ring of bodies, or a stack of two rings, closed to contact. Bodies alternate around the ring.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "assemble ring a.body b.body --members 4 --box 320 -o ring.json",
    "assemble ring a.body b.body --members 8 --stack 2 --directions ud -o stack.json"
))]
pub struct RingArgs {
    /// Body files, in the order in which they alternate.
    #[arg(required = true)]
    bodies: Vec<PathBuf>,
    /// Bodies per ring.
    #[arg(long, value_parser = range::MEMBERS.number::<usize>())]
    members: usize,
    /// Number of rings: one, or two stacked with dihedral symmetry.
    #[arg(long, default_value_t = 1)]
    stack: usize,
    /// Direction of each body of the pattern: u for up, d for down, such as ud; all up if omitted.
    #[arg(long)]
    directions: Option<String>,
    /// Tilt of each body's axis about the outward direction, degrees, such as 0,40; upright if
    /// omitted.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true, value_parser = range::ANGLE.number())]
    tilt: Vec<f64>,
    /// Rotation of each body about its own axis, degrees.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true, value_parser = range::ANGLE.number())]
    spin: Vec<f64>,
    /// Gap between neighbours in the ring, and between the rings, beyond contact, Å.
    #[arg(long, default_value_t = 0.5, value_parser = range::GAP.number())]
    gap: f64,
    #[command(flatten)]
    space: SpaceArgs,
    /// Assembly file to write.
    #[arg(short, long)]
    output: PathBuf,
}

/// Bodies at random positions and orientations in a periodic box, without overlaps.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "assemble fluid a.body b.body --counts 8,8 --box 500 -o fluid.json",
    "assemble fluid a.body --counts 20 --box 400 --seed 7 -o fluid.json"
))]
pub struct FluidArgs {
    /// Body files.
    #[arg(required = true)]
    bodies: Vec<PathBuf>,
    /// Number of copies of each body, in the order of the files, such as 8,8.
    #[arg(long, required = true, value_delimiter = ',', value_parser = range::OBJECTS.number::<usize>())]
    counts: Vec<usize>,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    space: SpaceArgs,
    /// Assembly file to write.
    #[arg(short, long)]
    output: PathBuf,
}

impl AssembleArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        match &self.from {
            From::Structure(args) => args.run(front),
            From::Ring(args) => args.run(front),
            From::Fluid(args) => args.run(front),
        }
    }
}

impl StructureArgs {
    fn run(&self, front: &Front) -> Result<Reply> {
        let settings = StructureSettings {
            body: body_settings(&self.selection, &self.charges, &self.surface, self.core)?,
            joined: self.bodies.body.clone(),
            shapes: self.shapes,
            relax: self.relax,
            box_angstrom: self.space.box_angstrom()?,
            force: front.force(),
        };
        let made = assemble_structure(&self.inputs, &self.output, &settings)?;
        let warnings = made.warnings();
        Ok(Reply::data(made).with_notes(warnings))
    }
}

impl RingArgs {
    fn run(&self, front: &Front) -> Result<Reply> {
        let settings = RingSettings {
            members: self.members,
            stack: self.stack,
            pattern: self.pattern()?,
            gap_angstrom: self.gap,
            box_angstrom: self.space.box_angstrom()?,
            force: front.force(),
        };
        Ok(Reply::from_answer(assemble_ring(
            &self.bodies,
            &settings,
            &self.output,
        )?))
    }

    /// One site per body of the pattern.
    fn pattern(&self) -> Result<Vec<RecipeSite>> {
        let count = self.bodies.len();
        let up = match &self.directions {
            None => vec![true; count],
            Some(text) => text.chars().map(direction).collect::<Result<_>>()?,
        };
        let angles = |degrees: &[f64]| match degrees {
            [] => vec![0.0; count],
            given => given.iter().map(|angle| angle.to_radians()).collect(),
        };
        let (tilt, spin) = (angles(&self.tilt), angles(&self.spin));
        for (flag, given) in [
            ("--directions", up.len()),
            ("--tilt", tilt.len()),
            ("--spin", spin.len()),
        ] {
            if given != count {
                bail!("{flag} has {given} values for {count} bodies; give one per body");
            }
        }
        for (flag, given) in [("--tilt", &tilt), ("--spin", &spin)] {
            if given.iter().any(|angle| !angle.is_finite()) {
                bail!("{flag} has an angle that is not a finite number; give degrees");
            }
        }
        let site = |body: usize| RecipeSite {
            body,
            up: up[body],
            tilt_radian: tilt[body],
            spin_radian: spin[body],
        };
        Ok((0..count).map(site).collect())
    }
}

impl FluidArgs {
    fn run(&self, front: &Front) -> Result<Reply> {
        let Some(box_angstrom) = self.space.box_angstrom()? else {
            bail!("a fluid needs a periodic box; state its edge with --box, such as --box 500");
        };
        let (counts, seed) = (&self.counts, self.seed);
        let (output, force) = (&self.output, front.force());
        let fluid = assemble_fluid(&self.bodies, counts, box_angstrom, seed, output, force)?;
        Ok(Reply::from_answer(fluid))
    }
}

fn direction(letter: char) -> Result<bool> {
    match letter {
        'u' => Ok(true),
        'd' => Ok(false),
        other => {
            bail!("--directions has '{other}'; write u for up and d for down, one letter per body")
        }
    }
}
