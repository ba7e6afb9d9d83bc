//! `protomer md run`: one run in its directory.

use crate::flags::choices::{ContactPotential, DynamicsEnsemble};
use crate::flags::execution::ExecutionArgs;
use crate::flags::override_with;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer::dynamics::run::run_dynamics;
use protomer::dynamics::settings::DynamicsSettings;
use protomer::dynamics::start::begin;
use protomer_results::keys::read_toml;
use std::path::PathBuf;

/// Follow convex bodies in motion, from a wide lattice through a slow compression. The same command
/// continues a run.
///
/// Bodies repel each other between the points that --potential names (energy epsilon at the distance
/// sigma_c = 0.15 sigma; sigma is the mean diameter of the balls about the centroids that fit in).
/// Units: epsilon, the length that gives a body area or volume one, density one. The packing fraction
/// counts bodies with a layer of sigma_c/2.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// Configuration (TOML), such as the run.toml of another run; flags override it.
    config: Option<PathBuf>,
    /// Directory of the results.
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    settings: SettingsArgs,
    #[command(flatten)]
    execution: ExecutionArgs,
}

/// Settings. Omitted settings come from the configuration file, or else from the defaults.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Dynamics")]
struct SettingsArgs {
    /// File or name of the shape, as for `shape`; also disk or ball [default: polygon:4].
    #[arg(long)]
    shape: Option<String>,
    /// Keep the size of the shape instead of scaling it to area or volume one.
    #[arg(long)]
    keep_size: bool,
    /// Number of bodies [default: 1000].
    #[arg(long)]
    bodies: Option<usize>,
    /// Part of the space that bodies with their layer fill [default: 0.5].
    #[arg(long, allow_negative_numbers = true)]
    packing_fraction: Option<f64>,
    /// Which points of the bodies repel each other [default: smooth].
    #[arg(long, value_enum)]
    potential: Option<ContactPotential>,
    /// Time step [default: 1e-4].
    #[arg(long, allow_negative_numbers = true)]
    time_step: Option<f64>,
    /// Run to this many steps after the preparation [default: 10000].
    #[arg(long)]
    steps: Option<u64>,
    /// What keeps the temperature [default: nve].
    #[arg(long, value_enum)]
    ensemble: Option<DynamicsEnsemble>,
    /// kT at the start and of the bath, in units of epsilon [default: 1].
    #[arg(long, allow_negative_numbers = true)]
    temperature: Option<f64>,
    /// Relaxation time of the bath of nvt [default: 0.5].
    #[arg(long, allow_negative_numbers = true)]
    relaxation_time: Option<f64>,
    /// Friction of langevin and brownian, an inverse time [default: 1].
    #[arg(long, allow_negative_numbers = true)]
    friction: Option<f64>,
    /// Seed of the random numbers [default: 1].
    #[arg(long)]
    seed: Option<u64>,
    /// Packing fraction of the lattice at the start [default: the densest without forces].
    #[arg(long, allow_negative_numbers = true)]
    compress_from: Option<f64>,
    /// Steps of the compression [default: 10000].
    #[arg(long)]
    compress_steps: Option<u64>,
    /// Steps with a bath after the compression [default: 8000].
    #[arg(long)]
    equilibrate_steps: Option<u64>,
    /// Time step of compression and equilibration [default: 5e-4].
    #[arg(long, allow_negative_numbers = true)]
    preparation_time_step: Option<f64>,
    /// Steps between rows of the log [default: 100].
    #[arg(long)]
    log_every: Option<u64>,
    /// Steps between frames of the trajectory; 0 for none [default: 1000].
    #[arg(long)]
    trajectory_every: Option<u64>,
}

impl RunArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let settings = self.settings()?;
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

    fn settings(&self) -> Result<DynamicsSettings> {
        let mut settings = match &self.config {
            None => DynamicsSettings::default(),
            Some(path) => read_toml(path)?,
        };
        let flags = &self.settings;
        if let Some(shape) = &flags.shape {
            settings.shape.clone_from(shape);
        }
        override_with(&mut settings.bodies, flags.bodies);
        override_with(&mut settings.packing_fraction, flags.packing_fraction);
        override_with(&mut settings.potential, flags.potential.map(Into::into));
        override_with(&mut settings.time_step, flags.time_step);
        override_with(&mut settings.steps, flags.steps);
        override_with(&mut settings.ensemble, flags.ensemble.map(Into::into));
        override_with(&mut settings.temperature, flags.temperature);
        override_with(&mut settings.relaxation_time, flags.relaxation_time);
        override_with(&mut settings.friction, flags.friction);
        override_with(&mut settings.seed, flags.seed);
        override_with(&mut settings.compress_steps, flags.compress_steps);
        override_with(&mut settings.equilibrate_steps, flags.equilibrate_steps);
        override_with(
            &mut settings.preparation_time_step,
            flags.preparation_time_step,
        );
        override_with(&mut settings.log_every, flags.log_every);
        override_with(&mut settings.trajectory_every, flags.trajectory_every);
        settings.compress_from = flags.compress_from.or(settings.compress_from);
        settings.keep_size |= flags.keep_size;
        settings.check()?;
        Ok(settings)
    }
}
