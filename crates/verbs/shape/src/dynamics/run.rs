//! One run of contact dynamics in its directory.
//!
//! ```text
//! DIR/  run.toml  run.json  log.csv  trajectory.gsd  checkpoint.bin
//! ```
//!
//! The bodies begin on a lattice, are compressed and brought to the temperature by a global bath
//! (the preparation), and then move in the ensemble of the settings. What is averaged, and how well
//! the energy is kept, counts from the end of the preparation.

use super::log::LogRow;
use super::schedule::Schedule;
use super::settings::{DynamicsSettings, EnsembleName};
use super::trajectory::{frame, open_trajectory};
use anyhow::{Context, Error, Result};
use protomer_common::answer::Answer;
use protomer_common::cpu_time::ProcessClock;
use protomer_io::gsd::FrameWriter;
use protomer_kernel::statistics::block_standard_error;
use protomer_md::drift::Drift;
use protomer_md::engine::{Engine, Motion};
use protomer_results::keys::read_toml;
use protomer_results::{
    CHECKPOINT, End, Execution, Layout, Log, LogMark, Record, ResultKind, ResultsDirectory, Run,
    Turn, Work, checkpoint, drive, log, settings,
};
use serde::{Deserialize, Serialize};
use std::path::Path;

const LOG: &str = log::FILE;
/// Name of the trajectory.
pub(super) const TRAJECTORY: &str = "trajectory.gsd";
const CHECKPOINT_KIND: &str = "dynamics checkpoint";
/// Steps between two looks at energy, temperature and pressure.
const SAMPLE_EVERY: u64 = 10;

/// The directory of a run.
const LAYOUT: Layout = Layout {
    kind: ResultKind::DynamicsRun,
    settings: "run.toml",
    results: &[
        "run.json",
        LOG,
        TRAJECTORY,
        CHECKPOINT,
        "trajectory.gsd.partial",
        "report.html",
    ],
    is_result: |_| false,
};

/// The result of a run. Energies are in units of ε and per body; averages are over the run after
/// the preparation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DynamicsResult {
    /// Number of bodies.
    pub bodies: usize,
    /// Number of dimensions, 2 or 3.
    pub dimension: usize,
    /// Steps after the preparation.
    pub steps: u64,
    /// Time after the preparation.
    pub time: f64,
    /// Part of the space that bodies with a layer of σ_c/2 fill.
    pub packing_fraction: f64,
    /// Part of the space that the bodies fill.
    pub core_packing_fraction: f64,
    /// Part of the space that bodies with a layer of σ_c/2 fill, on average; at constant pressure
    /// it changes.
    pub mean_packing_fraction: f64,
    /// Part of the trials of the volume that were accepted; none at constant volume.
    pub volume_acceptance: Option<f64>,
    /// Energy at the end.
    pub energy_per_body: f64,
    /// Energy of the repulsion, on average.
    pub potential_energy_per_body: f64,
    /// The change of the energy (without the heat of a bath) over the run along a straight line
    /// through its values; none for overdamped motion.
    pub energy_drift_per_body: Option<f64>,
    /// The energy at the end minus that at the start, without the heat of a bath.
    pub energy_change_per_body: Option<f64>,
    /// Root of the mean squared deviation of the energy from the straight line of its drift.
    pub energy_noise_per_body: Option<f64>,
    /// kT of all motion.
    pub temperature_kt: f64,
    /// kT of the centres.
    pub translational_temperature_kt: f64,
    /// kT of the rotations.
    pub rotational_temperature_kt: f64,
    /// Pressure.
    pub pressure: f64,
    /// Standard error of the pressure from blocks of the log; none for a short run.
    pub pressure_error: Option<f64>,
    /// Length of the total momentum.
    pub momentum_per_body: f64,
    /// Bodies times steps per second of processor time, in this process; none before the first
    /// step.
    pub body_steps_per_cpu_second: Option<f64>,
}

impl Answer for DynamicsResult {
    fn text(&self) -> String {
        let number = |value: Option<f64>| match value {
            Some(value) => format!("{value:.1e}"),
            None => "-".into(),
        };
        let pressure_error = match self.pressure_error {
            Some(error) => format!("± {error:.4}"),
            None => "(too short a run for an error)".into(),
        };
        format!(
            "t = {}: {} bodies at a packing fraction of {:.4}\n\
             kT {:.4} (centres {:.4}, rotations {:.4}), pressure {:.4} {pressure_error}\n\
             energy per body {:.6}, drift {}, noise {}\n\
             {} body-steps per CPU-second",
            self.time,
            self.bodies,
            self.packing_fraction,
            self.temperature_kt,
            self.translational_temperature_kt,
            self.rotational_temperature_kt,
            self.pressure,
            self.energy_per_body,
            number(self.energy_drift_per_body),
            number(self.energy_noise_per_body),
            number(self.body_steps_per_cpu_second),
        )
    }
}

/// Runs or continues contact dynamics in a directory.
///
/// # Errors
/// For invalid settings or an impossible start, a directory that holds other work, a file that
/// cannot be written, and bodies that overlap in motion.
///
/// ```
/// use protomer_shape_verbs::dynamics::{run::run_dynamics, settings::DynamicsSettings};
/// use protomer_results::Execution;
/// let settings = DynamicsSettings {
///     bodies: 36,
///     packing_fraction: 0.4,
///     steps: 200,
///     compress_steps: 100,
///     equilibrate_steps: 100,
///     ..DynamicsSettings::default()
/// };
/// # let folder = tempfile::tempdir()?;
/// let end = run_dynamics(&settings, &folder.path().join("run"), &Execution::default())?;
/// let result = end.finished().unwrap();
/// assert!(result.energy_noise_per_body.unwrap() < 1e-3);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn run_dynamics(
    settings: &DynamicsSettings,
    path: &Path,
    execution: &Execution,
) -> Result<End<DynamicsResult>> {
    // Checked before the directory is touched: an impossible start leaves nothing behind.
    let run = DynamicsRun::new(settings)?;
    run.schedule.engine(None)?;
    let _ours = ResultsDirectory::enter(path, &LAYOUT, settings, &run.identity, execution)?;
    execution.progress.begin(run.length(), "steps");
    drive(&run, path, execution)
}

/// Settings and last motion of the run in a directory, whatever its progress.
///
/// # Errors
/// If the directory holds no such run, or one without a checkpoint.
pub(super) fn saved_motion(directory: &Path) -> Result<(DynamicsSettings, Motion)> {
    ResultKind::DynamicsRun.expect_in(directory)?;
    let settings: DynamicsSettings = read_toml(&directory.join(LAYOUT.settings))?;
    let identity = Record::read(directory)?.map(|record| record.identity);
    let path = directory.join(CHECKPOINT);
    let saved: Option<Saved> =
        checkpoint::read(&path, CHECKPOINT_KIND, &identity.unwrap_or_default())?;
    let saved = saved.with_context(|| {
        format!(
            "{} has no checkpoint yet; give a run that has begun, or a GSD file",
            directory.display()
        )
    })?;
    Ok((settings, saved.motion))
}

/// A run whose settings have been checked.
struct DynamicsRun<'a> {
    settings: &'a DynamicsSettings,
    identity: String,
    schedule: Schedule,
}

/// A run with its open files.
struct Open {
    engine: Engine,
    averages: Averages,
    log: Log,
    trajectory: Option<FrameWriter>,
    speed: Speed,
}

/// Steps of this process after the preparation, and their processor time.
#[derive(Debug, Clone, Copy, Default)]
struct Speed {
    steps: u64,
    cpu_seconds: f64,
}

/// Sums over the run after the preparation.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Averages {
    count: u64,
    potential_energy: f64,
    temperatures: [f64; 3],
    pressure: f64,
    /// Bodies per area or volume.
    density: f64,
    drift: Drift,
}

impl Averages {
    fn push(&mut self, time: f64, engine: &Engine) {
        self.count += 1;
        self.potential_energy += engine.motion().potential_energy;
        for (sum, temperature) in self.temperatures.iter_mut().zip(engine.temperatures()) {
            *sum += temperature;
        }
        self.pressure += engine.pressure();
        let bodies = engine.bodies();
        self.density += bodies.count() as f64 / engine.motion().state.volume(bodies.dimension());
        self.drift.push(time, engine.kept_energy());
    }
}

/// A state from which a run continues bit for bit.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    /// The part of the log that belongs to this state.
    log: LogMark,
    /// Frames of the trajectory that belong to this state.
    frames: u64,
    averages: Averages,
    motion: Motion,
}

impl<'a> DynamicsRun<'a> {
    fn new(settings: &'a DynamicsSettings) -> Result<Self> {
        let schedule = Schedule::new(settings.clone())?;
        Ok(Self {
            settings,
            identity: settings::identity(settings, &schedule.begun.input_sha256)?,
            schedule,
        })
    }

    /// Makes a step, and does what is due after it.
    fn step(&self, open: &mut Open) -> Result<()> {
        self.schedule.step(&mut open.engine)?;
        self.write_outputs(open)
    }

    fn write_outputs(&self, open: &mut Open) -> Result<()> {
        let (step, time) = self.schedule.place(&open.engine);
        if step >= 0 && step.unsigned_abs().is_multiple_of(SAMPLE_EVERY) {
            open.averages.push(time, &open.engine);
        }
        if step.unsigned_abs().is_multiple_of(self.settings.log_every) {
            let row = LogRow::new(
                step,
                time,
                &open.engine,
                self.schedule.begun.volume_with_layer,
            );
            open.log.append(&row)?;
        }
        if let Some(trajectory) = &mut open.trajectory
            && step >= 0
            && step
                .unsigned_abs()
                .is_multiple_of(self.settings.trajectory_every)
        {
            trajectory.append(frame(step.unsigned_abs(), time, &open.engine))?;
        }
        Ok(())
    }
}

impl Run for DynamicsRun<'_> {
    type State = Open;
    type Checkpoint = Saved;
    type Answer = DynamicsResult;
    type Error = Error;

    const CHECKPOINT_KIND: &'static str = CHECKPOINT_KIND;

    fn work(&self) -> Work {
        Work::new(
            ResultKind::DynamicsRun,
            "md run",
            &self.identity,
            &self.schedule.begun.input_sha256,
        )
    }

    fn length(&self) -> u64 {
        self.settings.preparation_steps() + self.settings.steps
    }

    fn open(&self, directory: &Path, saved: Option<Saved>) -> Result<Open> {
        let is_new = saved.is_none();
        let (mark, frames, averages, motion) = match saved {
            Some(saved) => (saved.log, saved.frames, saved.averages, Some(saved.motion)),
            None => (LogMark::default(), 0, Averages::default(), None),
        };
        let engine = self.schedule.engine(motion)?;
        let left_out = LogRow::left_out(self.settings);
        let log = Log::open_without::<LogRow>(&directory.join(LOG), &mark, &left_out)?;
        let trajectory = match self.settings.trajectory_every {
            0 => None,
            _ => {
                let path = directory.join(TRAJECTORY);
                Some(open_trajectory(&path, &self.schedule.begun.bodies, frames)?)
            }
        };
        let mut open = Open {
            engine,
            averages,
            log,
            trajectory,
            speed: Speed::default(),
        };
        if is_new {
            self.write_outputs(&mut open)?;
        }
        Ok(open)
    }

    fn done(&self, open: &Open) -> u64 {
        open.engine.motion().steps
    }

    fn advance(&self, open: &mut Open, turn: &Turn<'_>) -> Result<()> {
        let begin = open.engine.motion().steps;
        let prepared = self.settings.preparation_steps();
        let mut end = self.length().min(begin + SAMPLE_EVERY);
        if begin < prepared {
            end = end.min(prepared);
        }
        let clock = ProcessClock::start();
        while open.engine.motion().steps < end && !turn.is_over()
            || open.engine.motion().steps == begin
        {
            self.step(open)?;
        }
        if begin >= prepared {
            open.speed.steps += open.engine.motion().steps - begin;
            open.speed.cpu_seconds += clock.seconds();
        }
        Ok(())
    }

    fn save(&self, open: &mut Open) -> Result<Saved> {
        let frames = match &mut open.trajectory {
            Some(trajectory) => trajectory.sync()?,
            None => 0,
        };
        Ok(Saved {
            log: open.log.sync()?,
            frames,
            averages: open.averages,
            motion: open.engine.motion().clone(),
        })
    }

    fn answer(&self, open: &mut Open, directory: &Path) -> Result<DynamicsResult> {
        let engine = &open.engine;
        let (step, time) = self.schedule.place(engine);
        let averages = match open.averages.count {
            0 => {
                let mut now = Averages::default();
                now.push(0.0, engine);
                now
            }
            _ => open.averages,
        };
        let (bodies, state) = (engine.bodies(), &engine.motion().state);
        let count = bodies.count() as f64;
        let samples = averages.count as f64;
        let density = count / state.volume(bodies.dimension());
        let [all, centres, rotations] = averages.temperatures.map(|sum| sum / samples);
        let has_energy = self.settings.ensemble != EnsembleName::Brownian;
        let of_energy = |value: f64| has_energy.then_some(value / count);
        let drift = averages.drift;
        let masses = bodies.kind_of.iter().map(|kind| bodies.kinds[*kind].mass);
        let mean_mass = masses.sum::<f64>() / count;
        let seconds = open.speed.cpu_seconds;
        let speed = open.speed.steps as f64 * count / seconds;
        Ok(DynamicsResult {
            bodies: bodies.count(),
            dimension: bodies.dimension(),
            steps: step.max(0).unsigned_abs(),
            time: time.max(0.0),
            packing_fraction: density * self.schedule.begun.volume_with_layer,
            core_packing_fraction: density * mean_mass,
            mean_packing_fraction: averages.density / samples
                * self.schedule.begun.volume_with_layer,
            volume_acceptance: acceptance(engine.motion().volume_trials),
            energy_per_body: engine.energy() / count,
            potential_energy_per_body: averages.potential_energy / samples / count,
            energy_drift_per_body: of_energy(drift.along_the_line()),
            energy_change_per_body: of_energy(drift.change()),
            energy_noise_per_body: of_energy(drift.noise()),
            temperature_kt: all,
            translational_temperature_kt: centres,
            rotational_temperature_kt: rotations,
            pressure: averages.pressure / samples,
            pressure_error: pressure_error(directory)?,
            momentum_per_body: state.momentum(bodies).norm() / count,
            body_steps_per_cpu_second: (seconds > 0.0).then_some(speed),
        })
    }

    fn check(&self, directory: &Path, saved: &Saved) -> Result<()> {
        Ok(log::check(&directory.join(LOG), &saved.log)?)
    }
}

/// Accepted part of the trials, from the numbers of refused and accepted ones.
fn acceptance([refused, accepted]: [u64; 2]) -> Option<f64> {
    let trials = refused + accepted;
    (trials > 0).then(|| accepted as f64 / trials as f64)
}

/// Standard error of the pressure from the log after the preparation.
fn pressure_error(directory: &Path) -> Result<Option<f64>> {
    let rows: Vec<LogRow> = log::read_so_far(&directory.join(LOG))?;
    let series: Vec<f64> = rows
        .iter()
        .filter(|row| row.step >= 0)
        .map(|row| row.pressure)
        .collect();
    Ok(block_standard_error(&series))
}
