//! `protomer lattice run`: one run in its directory, and the flags that `sweep` shares with it.

use crate::flags::choices::{LatticeEdges, StartVelocities};
use crate::flags::execution::ExecutionArgs;
use crate::flags::override_with;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_lattices::lattice::directory::read_settings;
use protomer_lattices::lattice::run::run_lattice;
use protomer_lattices::lattice::settings::{LatticeSettings, Start, TimeStep};
use protomer_lattices::lattice::start::{begin_unless, is_stopped, time_step};
use protomer_results::{End, Execution};
use std::path::PathBuf;

/// Settings. Omitted settings come from the configuration file, or else from the defaults.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Lattice")]
pub struct SettingsArgs {
    /// Squares along an edge: rows and columns at once.
    #[arg(long, conflicts_with_all = ["rows", "columns"])]
    ns: Option<usize>,
    /// Rows of squares [default: 10].
    #[arg(long)]
    rows: Option<usize>,
    /// Columns of squares [default: 10].
    #[arg(long)]
    columns: Option<usize>,
    /// Length of the rods; the half-diagonal of a square is 1 [default: 3/22].
    #[arg(long, allow_negative_numbers = true)]
    r0: Option<f64>,
    /// κ of the potential that favours coherent motion of the squares [default: 0].
    #[arg(long, allow_negative_numbers = true)]
    kappa: Option<f64>,
    /// Boundary condition [default: open].
    #[arg(long, value_enum)]
    edges: Option<LatticeEdges>,
    /// Orientation at the start: open, closed, or an angle in radians [default: open].
    #[arg(long, allow_hyphen_values = true)]
    start: Option<Start>,
    /// Standard deviation of random angles added to the start, radians [default: 0].
    #[arg(long, allow_negative_numbers = true)]
    angle_spread: Option<f64>,
    /// Velocities at the start [default: checkerboard].
    #[arg(long, value_enum)]
    velocities: Option<StartVelocities>,
    /// Angular velocity of every square (checkerboard), or the largest drawn (random) [default: 1].
    #[arg(long, allow_negative_numbers = true)]
    speed: Option<f64>,
    /// Standard deviation of random numbers added to the angular velocities of a checkerboard start
    /// [default: 0].
    #[arg(long, allow_negative_numbers = true)]
    velocity_spread: Option<f64>,
    /// Run to this time [default: 10].
    #[arg(long, allow_negative_numbers = true)]
    time: Option<f64>,
    /// Run to this many steps instead.
    #[arg(long, conflicts_with = "time")]
    steps: Option<u64>,
    /// Time step: auto, or a number [default: auto].
    #[arg(long = "dt", allow_hyphen_values = true)]
    time_step: Option<TimeStep>,
    /// Let squares pass through each other.
    #[arg(long)]
    no_collisions: bool,
    /// Coefficient of restitution: 1 is elastic [default: 1].
    #[arg(long, allow_negative_numbers = true)]
    restitution: Option<f64>,
    /// Collide as the paper does, with one mean collision time per step.
    #[arg(long)]
    paper: bool,
    /// kT of a heat bath; needs --friction.
    #[arg(long, allow_negative_numbers = true)]
    temperature: Option<f64>,
    /// Friction, an inverse time [default: 0].
    #[arg(long, allow_negative_numbers = true)]
    friction: Option<f64>,
    /// Seed of the random numbers [default: 1].
    #[arg(long)]
    seed: Option<u64>,
    /// Steps between rows of the log [default: 10].
    #[arg(long)]
    log_every: Option<u64>,
    /// Steps between frames of the trajectory; 0 for none [default: 50].
    #[arg(long)]
    trajectory_every: Option<u64>,
}

/// Output directory and execution.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Run")]
pub struct DirectoryArgs {
    /// Configuration (TOML), such as the run.toml of another run; flags override it.
    config: Option<PathBuf>,
    /// Directory of the results.
    #[arg(short, long)]
    pub output: PathBuf,
    #[command(flatten)]
    execution: ExecutionArgs,
}

impl SettingsArgs {
    /// The settings of the configuration file, overridden by the flags.
    pub fn settings(&self, directory: &DirectoryArgs) -> Result<LatticeSettings> {
        let mut settings = match &directory.config {
            None => LatticeSettings::default(),
            Some(path) => read_settings(path)?,
        };
        override_with(&mut settings.rows, self.rows.or(self.ns));
        override_with(&mut settings.columns, self.columns.or(self.ns));
        override_with(&mut settings.r0, self.r0);
        override_with(&mut settings.kappa, self.kappa);
        override_with(&mut settings.edges, self.edges.map(Into::into));
        override_with(&mut settings.start, self.start);
        override_with(&mut settings.angle_spread, self.angle_spread);
        override_with(&mut settings.velocities, self.velocities.map(Into::into));
        override_with(&mut settings.speed, self.speed);
        override_with(&mut settings.velocity_spread, self.velocity_spread);
        if self.time.is_some() {
            settings.steps = None;
        }
        override_with(&mut settings.time, self.time);
        override_with(&mut settings.time_step, self.time_step);
        override_with(&mut settings.restitution, self.restitution);
        override_with(&mut settings.friction, self.friction);
        override_with(&mut settings.seed, self.seed);
        override_with(&mut settings.log_every, self.log_every);
        override_with(&mut settings.trajectory_every, self.trajectory_every);
        settings.steps = self.steps.or(settings.steps);
        settings.temperature = self.temperature.or(settings.temperature);
        settings.collisions &= !self.no_collisions;
        settings.paper |= self.paper;
        settings.check()?;
        Ok(settings)
    }
}

impl DirectoryArgs {
    /// The execution of the run.
    pub fn execution(&self, front: &Front) -> Result<Execution> {
        self.execution.execution(front)
    }
}

/// Run one lattice. The same command continues it.
#[derive(Debug, Args)]
pub struct RunArgs {
    #[command(flatten)]
    directory: DirectoryArgs,
    #[command(flatten)]
    settings: SettingsArgs,
}

impl RunArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let settings = self.settings.settings(&self.directory)?;
        let execution = self.directory.execution(front)?;
        let directory = &self.directory.output;
        let stopped = || {
            format!(
                "stopped; the same command continues {}",
                directory.display()
            )
        };
        let interrupt = &execution.interrupt;
        let begun = match begin_unless(&settings, &|| interrupt.is_requested()) {
            Err(error) if is_stopped(&error) => return Ok(Reply::stopped(stopped())),
            begun => begun?,
        };
        let step = time_step(&settings, &begun)?;
        front.say(&format!(
            "{} squares, {} rods, {} steps of {step}",
            begun.network.squares.len(),
            begun.network.rods.len(),
            settings.total_steps(step)
        ));
        let end = run_lattice(&settings, directory, &execution)?;
        let warning = match &end {
            End::Finished(result) => result.energy_warning(&settings),
            End::Stopped => None,
        };
        let notes = warning.map(|warning| format!("warning: {warning}"));
        Ok(Reply::of_end(end, stopped).with_notes(notes))
    }
}
