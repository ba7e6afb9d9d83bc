//! `protomer hpmc run`: one run in its directory.

use super::system::{BoxArgs, SystemArgs, freedom};
use crate::flags::execution::ExecutionArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, bail};
use clap::Args;
use protomer_results::End;
use protomer_shape_verbs::hard_bodies::run::run_hard_bodies;
use protomer_shape_verbs::hard_bodies::settings::HardBodySettings;
use std::path::PathBuf;

/// Run hard bodies in a periodic box. The same command continues the run; more sweeps extend it.
///
/// Bodies are placed at random and compressed to the packing fraction, or stand on the sites of a crystal. In the equilibration the steps
/// are tuned; then the pressure is measured by trial compressions, the free volume of the depletants by
/// random points, and the chemical potential by insertion.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "hpmc run --shape cube --packing-fraction 0.3 -o cubes",
    "hpmc run --shape cube --packing-fraction 0.3 --depletants 0.1:20 -o depleted"
))]
pub struct RunArgs {
    #[command(flatten)]
    system: SystemArgs,
    /// The part of the box that the bodies fill; a state has its own.
    #[arg(long)]
    packing_fraction: Option<f64>,
    /// Constant pressure, kT per volume, at which the box changes; the packing fraction is that of the
    /// start.
    #[arg(long, value_name = "P_KT_PER_VOLUME")]
    pressure: Option<f64>,
    /// At constant pressure, change each edge of the box on its own; for crystals.
    #[arg(long, requires = "pressure")]
    anisotropic: bool,
    /// At constant pressure, change the lengths and the angles of the box; for crystals.
    #[arg(long, requires = "pressure", conflicts_with = "anisotropic")]
    triclinic: bool,
    #[command(flatten)]
    box_changes: BoxArgs,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Directory of the results.
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    execution: ExecutionArgs,
}

impl RunArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        self.box_changes.check(self.pressure.is_some())?;
        if self.packing_fraction.is_none() && !self.system.starts_from_state() {
            bail!("there is no --packing-fraction; give one, or a state to --start");
        }
        let settings = HardBodySettings {
            seed: self.seed,
            pressure: self.pressure.map(|kt_per_volume| {
                let freedom = freedom(self.anisotropic, self.triclinic);
                self.box_changes.pressure(kt_per_volume, freedom)
            }),
            ..self.system.settings(self.packing_fraction)?
        };
        let execution = self.execution.execution(front)?;
        let end = run_hard_bodies(&settings, &self.output, &execution)?;
        // The answer says why.
        let warning = match &end {
            End::Finished(result) => result.warning(),
            End::Stopped => None,
        };
        let warning = warning.map(|_| {
            "warning: equilibrium is not reached or not shown, so these may not be the numbers of this pressure or weight"
        });
        let reply = Reply::of_end(end, || {
            format!(
                "stopped; the same command continues {}",
                self.output.display()
            )
        });
        Ok(reply.with_notes(warning.map(str::to_owned)))
    }
}
