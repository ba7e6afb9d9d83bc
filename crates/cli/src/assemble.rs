//! `protomer assemble`: assemblies from a structure's own copies, from a ring or stack recipe, or
//! as a fluid.

use super::ingest::{ChargeArgs, SelectionArgs, SurfaceFlags, body_settings};
use super::{Global, Outcome, output};
use anyhow::{Result, bail};
use clap::{Args, Subcommand};
use protomer::assemblies::assemble::{
    BodyFiles, StructureAssembly, StructureSettings, assemble_structure, write_assembly,
};
use protomer::assemblies::fluid::fluid;
use protomer_body::assembly::{Recipe, RecipeSite};
use std::path::PathBuf;

/// Put bodies together: from a structure's own copies, as a ring or a stack of two rings, or at
/// random.
#[derive(Debug, Args)]
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

/// Take a structure apart: identical chains become one body, each copy a pose.
#[derive(Debug, Args)]
pub struct StructureArgs {
    /// Structure file.
    input: PathBuf,
    /// Folder for the bodies and assembly.json.
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    selection: SelectionArgs,
    #[command(flatten)]
    charges: ChargeArgs,
    #[command(flatten)]
    surface: SurfaceFlags,
    /// Remove overlaps of the hard surfaces by the smallest uniform expansion.
    #[arg(long)]
    relax: bool,
    #[command(flatten)]
    space: SpaceArgs,
}

/// A ring of bodies, or a stack of two rings, closed to contact. Bodies alternate around the ring.
#[derive(Debug, Args)]
pub struct RingArgs {
    /// Body files, in the order in which they alternate.
    #[arg(required = true)]
    bodies: Vec<PathBuf>,
    /// Bodies per ring.
    #[arg(long)]
    members: usize,
    /// Rings: one, or two stacked with dihedral symmetry.
    #[arg(long, default_value_t = 1)]
    stack: usize,
    /// Direction of each body of the pattern: u for up, d for down, such as ud; all up if left out.
    #[arg(long)]
    directions: Option<String>,
    /// Lean of each body's axis about the outward direction, degrees, such as 0,40; upright if left
    /// out.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    tilt: Vec<f64>,
    /// Turn of each body about its own axis, degrees.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    spin: Vec<f64>,
    /// How much further apart than at contact neighbours around the ring, and the rings, are
    /// placed, Å.
    #[arg(long, default_value_t = 0.5, allow_negative_numbers = true)]
    gap: f64,
    #[command(flatten)]
    space: SpaceArgs,
    /// Assembly file to write.
    #[arg(short, long)]
    output: PathBuf,
}

/// Bodies at random places and in random orientations in a periodic box, none overlapping another.
#[derive(Debug, Args)]
pub struct FluidArgs {
    /// Body files.
    #[arg(required = true)]
    bodies: Vec<PathBuf>,
    /// How many of each body, in the order of the files, such as 8,8.
    #[arg(long, required = true, value_delimiter = ',')]
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

/// The space around the assembly.
#[derive(Debug, Clone, Args)]
pub struct SpaceArgs {
    /// Edge of a cubic periodic box, or three edges, Å; open space if left out.
    #[arg(long = "box", value_delimiter = ',')]
    box_angstrom: Vec<f64>,
}

impl SpaceArgs {
    /// The box these flags describe.
    pub fn box_angstrom(&self) -> Result<Option<[f64; 3]>> {
        let lengths = match self.box_angstrom.as_slice() {
            [] => return Ok(None),
            [edge] => [*edge; 3],
            [x, y, z] => [*x, *y, *z],
            other => bail!(
                "--box takes one or three lengths, and {} are given",
                other.len()
            ),
        };
        match lengths
            .iter()
            .find(|length| !(length.is_finite() && **length > 0.0))
        {
            Some(length) => bail!("--box has a length of {length} Å; lengths are positive"),
            None => Ok(Some(lengths)),
        }
    }
}

impl AssembleArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        match &self.from {
            From::Structure(args) => args.run(global),
            From::Ring(args) => args.run(global),
            From::Fluid(args) => args.run(global),
        }
    }
}

impl StructureArgs {
    fn run(&self, global: &Global) -> Result<Outcome> {
        let settings = StructureSettings {
            body: body_settings(&self.selection, &self.charges, &self.surface)?,
            relax: self.relax,
            box_angstrom: self.space.box_angstrom()?,
        };
        let made = assemble_structure(&self.input, &self.output, &settings)?;
        if global.json {
            output::json(&made)?
        } else {
            output::text(&describe(&made))?
        }
        Ok(Outcome::Done)
    }
}

fn describe(made: &StructureAssembly) -> String {
    let mut rows = vec![
        ["body", "copies", "largest RMSD (Å)"]
            .map(str::to_owned)
            .to_vec(),
    ];
    for body in &made.bodies {
        let largest = body.rmsd_angstrom.iter().copied().fold(0.0, f64::max);
        rows.push(vec![
            body.file.display().to_string(),
            body.chains.join(" "),
            format!("{largest:.3}"),
        ]);
    }
    format!(
        "{}\n{} pairs of chains overlapped; expanded by a factor {:.6} (at most {:.3} Å)\n{}",
        output::table(&rows),
        made.overlaps.len(),
        made.expansion_factor,
        made.largest_displacement_angstrom,
        made.assembly.display()
    )
}

impl RingArgs {
    fn run(&self, global: &Global) -> Result<Outcome> {
        let files = BodyFiles::read(&self.bodies)?;
        let pattern = self.pattern()?;
        if !(self.gap.is_finite() && self.gap >= 0.0) {
            bail!("--gap is {} Å; give zero or more", self.gap);
        }
        let recipe = match self.stack {
            1 => Recipe::ring(self.members, &pattern),
            2 => Recipe::dihedral(self.members, &pattern),
            other => bail!("--stack is {other}; one ring or a stack of two can be closed"),
        };
        if !self.members.is_multiple_of(pattern.len()) {
            bail!(
                "{} bodies do not alternate evenly in a ring of {}; choose --members that the number of bodies divides",
                pattern.len(),
                self.members
            );
        }
        let closed = files.close(&recipe, self.gap)?;
        let provenance = serde_json::json!({
            "recipe": recipe, "gap_angstrom": self.gap,
            "radius_angstrom": closed.radius_angstrom, "ring_distance_angstrom": closed.ring_distance_angstrom,
        });
        let file = files.assembly_file(
            &self.output,
            &closed.placements,
            self.space.box_angstrom()?,
            provenance,
        )?;
        write_assembly(&self.output, &file)?;
        if global.json {
            output::json(&serde_json::json!({
                "assembly": self.output, "bodies": file.placements.len(),
                "radius_angstrom": closed.radius_angstrom, "ring_distance_angstrom": closed.ring_distance_angstrom,
            }))?;
        } else {
            global.say(&format!(
                "{}: {} bodies, ring radius {:.2} Å, ring distance {:.2} Å",
                self.output.display(),
                file.placements.len(),
                closed.radius_angstrom,
                closed.ring_distance_angstrom
            ));
        }
        Ok(Outcome::Done)
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
    fn run(&self, global: &Global) -> Result<Outcome> {
        let Some(box_angstrom) = self.space.box_angstrom()? else {
            bail!("a fluid needs a periodic box; state its edge with --box, such as --box 500");
        };
        let files = BodyFiles::read(&self.bodies)?;
        let placements = fluid(&files, &self.counts, box_angstrom, self.seed)?;
        let provenance =
            serde_json::json!({ "fluid": { "counts": self.counts, "seed": self.seed } });
        let file =
            files.assembly_file(&self.output, &placements, Some(box_angstrom), provenance)?;
        write_assembly(&self.output, &file)?;
        let millimolar = 1e3 * placements.len() as f64
            / box_angstrom.iter().product::<f64>()
            / protomer_kernel::units::NUMBER_DENSITY_PER_MOLAR;
        if global.json {
            output::json(&serde_json::json!({
                "assembly": self.output, "bodies": placements.len(), "concentration_millimolar": millimolar,
            }))?;
        } else {
            global.say(&format!(
                "{}: {} bodies at random places, {millimolar:.3} mM",
                self.output.display(),
                placements.len()
            ));
        }
        Ok(Outcome::Done)
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
