//! `protomer hpmc sweep`: an equation of state in its directory.

use super::system::{BoxArgs, SystemArgs, freedom};
use crate::flags::execution::ExecutionArgs;
use crate::flags::scheduler::PartArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, bail};
use clap::Args;
use protomer_results::End;
use protomer_shape_verbs::hard_bodies::settings::HardBodySettings;
use protomer_shape_verbs::hard_bodies::sweep::{HardBodySweepSettings, run_shard, run_sweep};
use std::path::PathBuf;

/// Upper limit for the number of seeds.
const MOST_SEEDS: u64 = 10_000;

/// Run hard bodies at several packing fractions or pressures, once per seed, on all threads: the equation
/// of state as a table and a figure.
///
/// The same command continues a sweep; more sweeps, packing fractions, pressures and seeds extend it. Over
/// packing fractions of a fluid, the excess free energy is integrated from no bodies.
#[derive(Debug, Args)]
#[group(id = "HardBodySweepResult")]
pub struct SweepArgs {
    #[command(flatten)]
    system: SystemArgs,
    /// Packing fractions, with commas between them.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "FRACTION,…",
        required_unless_present = "pressures",
        conflicts_with = "pressures"
    )]
    packing_fractions: Vec<f64>,
    /// Constant pressures, kT per volume, with commas between them.
    #[arg(long, value_delimiter = ',', value_name = "P_KT_PER_VOLUME,…")]
    pressures: Vec<f64>,
    /// With --pressures, the packing fraction of the start.
    #[arg(long, requires = "pressures", value_name = "FRACTION")]
    packing_fraction: Option<f64>,
    /// With --pressures, change each edge of the box on its own; for crystals.
    #[arg(long, requires = "pressures")]
    anisotropic: bool,
    /// With --pressures, change the lengths and the angles of the box; for crystals.
    #[arg(long, requires = "pressures", conflicts_with = "anisotropic")]
    triclinic: bool,
    #[command(flatten)]
    box_changes: BoxArgs,
    /// Runs at each condition: seeds 1, 2, ...
    #[arg(long, default_value_t = 1)]
    seeds: u64,
    #[command(flatten)]
    part: PartArgs,
    /// Directory of the results.
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    execution: ExecutionArgs,
}

impl SweepArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        self.part.check()?;
        let settings = self.settings()?;
        let execution = self.execution.execution(front)?;
        if let Some(shard) = self.part.shard() {
            let end = run_shard(&settings, &self.output, shard, &execution)?;
            return Ok(Reply::of_part(end, shard, ["run", "runs"]));
        }
        let directory = self.output.display();
        Ok(match run_sweep(&settings, &self.output, &execution)? {
            End::Finished(equation) => {
                let warnings = equation.warnings();
                let notes = warnings
                    .into_iter()
                    .map(|words| format!("warning: {words}"));
                Reply::from_answer(equation)
                    .with_notes(notes)
                    .with_note(format!("table and figure: {directory}"))
            }
            End::Stopped => {
                Reply::stopped(format!("stopped; the same command continues {directory}"))
            }
        })
    }

    fn settings(&self) -> Result<HardBodySweepSettings> {
        if !(1..=MOST_SEEDS).contains(&self.seeds) {
            bail!("--seeds is {}; give 1 to {MOST_SEEDS}", self.seeds);
        }
        self.box_changes.check(!self.pressures.is_empty())?;
        if self.system.starts_from_state() && self.pressures.is_empty() {
            bail!("a state has one packing fraction; give --pressures, or another --start");
        }
        let of_a_run = self.system.settings(self.packing_fraction)?;
        Ok(HardBodySweepSettings {
            packing_fractions: self.packing_fractions.clone(),
            pressures_kt_per_volume: self.pressures.clone(),
            seeds: (1..=self.seeds).collect(),
            run: HardBodySettings {
                pressure: self.pressures.first().map(|kt_per_volume| {
                    let freedom = freedom(self.anisotropic, self.triclinic);
                    self.box_changes.pressure(*kt_per_volume, freedom)
                }),
                ..of_a_run
            },
        })
    }
}
