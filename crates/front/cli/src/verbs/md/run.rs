//! `protomer md run`: one run in its directory.

use crate::flags::execution::ExecutionArgs;
use crate::flags::settings::SettingsArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_shape_verbs::dynamics::placed::with_state;
use protomer_shape_verbs::dynamics::run::run_dynamics;
use protomer_shape_verbs::dynamics::settings::DynamicsSettings;
use protomer_shape_verbs::dynamics::start::{begin, dimension};
use protomer_shape_verbs::potential_file::{read_smooth_field, read_smooth_potential};
use std::path::PathBuf;

/// Follow convex bodies in motion, from a wide lattice through a slow compression. The same command
/// continues a run.
///
/// Bodies repel each other between the points that --potential names (energy epsilon at the distance
/// sigma_c = 0.15 sigma; sigma is the mean diameter of the balls about the centroids that fit in).
/// Units: epsilon, the length that gives a body area or volume one, density one. The packing fraction
/// counts bodies with a layer of sigma_c/2.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "md run --shape polygon:4 --packing-fraction 0.6 -o squares",
    "md run --shape octahedron --bodies 500 --potential smooth --ensemble nvt -o fluid"
))]
pub struct RunArgs {
    /// Configuration (TOML), such as the run.toml of another run; flags override it.
    config: Option<PathBuf>,
    /// Directory of the results.
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten, next_help_heading = "Dynamics")]
    settings: SettingsArgs<DynamicsSettings>,
    /// Energy of pairs of bodies in addition to their contacts, as for `hpmc run --potential`: terms in a .toml file (radial,
    /// charges), or a table with the columns distance and energy_kt. kT is that of --temperature.
    #[arg(long, value_name = "FILE", help_heading = "Dynamics")]
    pair_potential: Option<PathBuf>,
    /// Energy of each body by its last coordinate, from the lower end of the box: a table with the columns height and
    /// energy_kt, whose first and last energies are equal.
    #[arg(long, value_name = "FILE", help_heading = "Dynamics")]
    field: Option<PathBuf>,
    #[command(flatten)]
    execution: ExecutionArgs,
}

impl RunArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let mut settings = self.settings.settings(self.config.as_deref())?;
        if let Some(path) = &self.pair_potential {
            settings.pair_potential = read_smooth_potential(path, dimension(&settings)?)?;
        }
        if let Some(path) = &self.field {
            settings.field = Some(read_smooth_field(path)?);
        }
        let settings = with_state(settings)?;
        let begun = begin(&settings)?;
        front.say(&format!(
            "{} bodies from a packing fraction of {:.4} to {}, then {} steps of {}",
            settings.bodies,
            begun.first_packing_fraction,
            settings.packing_fraction,
            settings.steps,
            settings.time_step
        ));
        let execution = self.execution.execution(front)?;
        let end = run_dynamics(&settings, &self.output, &execution)?;
        Ok(Reply::of_end(end, || {
            format!(
                "stopped; the same command continues {}",
                self.output.display()
            )
        }))
    }
}
