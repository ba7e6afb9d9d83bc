//! `protomer md run`: one run in its directory.

use crate::flags::choices::{CentralTerm, ContactPotential, DynamicsEnsemble};
use crate::flags::execution::ExecutionArgs;
use crate::flags::override_with;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_convex::dynamics::run::run_dynamics;
use protomer_convex::dynamics::settings::DynamicsSettings;
use protomer_convex::dynamics::start::begin;
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
    /// File or name of the shape, as for `shape`; also disk, ball, ellipse:A,B or ellipsoid:A,B,C;
    /// convex parts of a concave body joined by +. Several times for a mixture [default: polygon:4].
    #[arg(long)]
    shape: Vec<String>,
    /// How many bodies of each shape there are, in proportion: once for each --shape [default: equal
    /// numbers].
    #[arg(long, allow_negative_numbers = true)]
    share: Vec<f64>,
    /// Radius by which the shapes are rounded, in the unit of their points, before they are scaled
    /// [default: 0].
    #[arg(long, allow_negative_numbers = true)]
    rounding: Option<f64>,
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
    /// Strength of the attraction: 0 for the repulsion alone, 1 for Lennard-Jones [default: 0].
    #[arg(long, allow_negative_numbers = true)]
    attraction: Option<f64>,
    /// Where the attraction ends, in units of sigma_c (of sigma for the central term); it is switched
    /// off smoothly from 0.8 of that on [default: 2.5].
    #[arg(long, allow_negative_numbers = true)]
    attraction_cut_off: Option<f64>,
    /// The energy between the centroids [default: none].
    #[arg(long, value_enum)]
    central: Option<CentralTerm>,
    /// Time step [default: 1e-4].
    #[arg(long, allow_negative_numbers = true)]
    time_step: Option<f64>,
    /// Run to this many steps after the preparation [default: 10000].
    #[arg(long)]
    steps: Option<u64>,
    /// What keeps the temperature, and the pressure [default: nve].
    #[arg(long, value_enum)]
    ensemble: Option<DynamicsEnsemble>,
    /// kT at the start and of the bath, in units of epsilon [default: 1].
    #[arg(long, allow_negative_numbers = true)]
    temperature: Option<f64>,
    /// Pressure of npt, in units of epsilon per area or volume.
    #[arg(long, allow_negative_numbers = true)]
    pressure: Option<f64>,
    /// Relaxation time of the bath of nvt and npt [default: 0.5].
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
        if !flags.shape.is_empty() {
            settings.shape.clone_from(&flags.shape);
        }
        if !flags.share.is_empty() {
            settings.share.clone_from(&flags.share);
        }
        override_with(&mut settings.rounding, flags.rounding);
        override_with(&mut settings.attraction, flags.attraction);
        override_with(&mut settings.attraction_cut_off, flags.attraction_cut_off);
        override_with(&mut settings.central, flags.central.map(Into::into));
        settings.pressure = flags.pressure.or(settings.pressure);
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
