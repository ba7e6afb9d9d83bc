//! `protomer free-energy`: the free energy of a crystal of hard bodies.

use crate::flags::execution::ExecutionArgs;
use crate::flags::hard_body::HardBodyArgs;
use crate::flags::scheduler::PartArgs;
use crate::flags::settings::choice;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_shape_verbs::hard_bodies::free_energy::{
    FreeEnergySettings, Share, run_free_energy, run_shard,
};
use protomer_shape_verbs::hard_bodies::start::names_of_crystals;
use std::path::PathBuf;

/// Compute the free energy of a crystal of hard bodies. The same command continues the run; more sweeps
/// extend it.
///
/// Springs hold the bodies and their orientations to the sites. With the strongest springs the free
/// energy is exact; the difference to none is integrated over 21 strengths, and sweeps go to those whose
/// errors count most (Frenkel and Ladd).
///
/// The free energy is A/(N kT) at this number of bodies, for a thermal wavelength of one in the unit of
/// the shape and an integral of one over all orientations. The excess is what it is more than that of an
/// ideal gas of the same density, ln ρ - 1.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "free-energy --shape cube --crystal simple-cubic --bodies 64 --packing-fraction 0.6 -o cubes",
    "free-energy --shape rod:1 --crystal row --bodies 32 --packing-fraction 0.5 -o rods"
))]
pub struct FreeEnergyArgs {
    #[command(flatten)]
    body: HardBodyArgs,
    #[arg(long, help = format!("Name of the crystal ({}), or the file of its unit cell", names_of_crystals(&[3, 2, 1])))]
    crystal: String,
    /// Turn every body first: degrees in a plane, a quaternion W,X,Y,Z in space.
    #[arg(long, value_delimiter = ',')]
    turn: Vec<f64>,
    /// Number of bodies.
    #[arg(long, default_value_t = 216)]
    bodies: usize,
    /// The part of the box that the bodies fill.
    #[arg(long)]
    packing_fraction: f64,
    /// Sweeps at each strength in which steps are tuned and nothing is measured.
    #[arg(long, default_value_t = 2000, value_name = "SWEEPS")]
    equilibration: u64,
    /// Sweeps after the equilibration, per strength on average.
    #[arg(long, default_value_t = 20_000)]
    sweeps: u64,
    /// Division of the sweeps among the strengths of the springs; --shard needs `even`.
    #[arg(long, value_parser = choice::<Share>(), default_value = "errors")]
    share: Share,
    #[command(flatten)]
    part: PartArgs,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Directory of the results.
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    execution: ExecutionArgs,
}

impl FreeEnergyArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        self.part.check()?;
        let settings = FreeEnergySettings {
            shape: self.body.shape.clone(),
            rounding_radius: self.body.rounding.rounding,
            crystal: self.crystal.clone(),
            turn: self.turn.clone(),
            bodies: self.bodies,
            packing_fraction: self.packing_fraction,
            equilibration: self.equilibration,
            sweeps: self.sweeps,
            share: self.share,
            seed: self.seed,
        };
        let execution = self.execution.execution(front)?;
        if let Some(shard) = self.part.shard() {
            let end = run_shard(&settings, &self.output, shard, &execution)?;
            return Ok(Reply::of_part(end, shard, ["strength", "strengths"]));
        }
        let end = run_free_energy(&settings, &self.output, &execution)?;
        Ok(Reply::of_end(end, || {
            format!(
                "stopped; the same command continues {}",
                self.output.display()
            )
        }))
    }
}
