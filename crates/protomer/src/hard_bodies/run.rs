//! One run of hard bodies in its directory.
//!
//! ```text
//! DIR/  run.toml  run.json  log.csv  trajectory.gsd  checkpoint.bin
//! ```

use super::log::LogRow;
use super::settings::HardBodySettings;
use super::trajectory::Trajectory;
use crate::shapes::read_shape;
use anyhow::{Context, Error, Result, bail};
use protomer_common::answer::Answer;
use protomer_common::cpu_time::Stopwatch;
use protomer_hpmc::body::HardBody;
use protomer_hpmc::simulation::{self, Simulation, State};
use protomer_io::atomic::sha256_hex;
use protomer_kernel::shape::Shape;
use protomer_kernel::statistics::{block_standard_error, summarize};
use protomer_results::{
    CHECKPOINT, End, Execution, Layout, Log, LogMark, ResultKind, ResultsDirectory, Run, Turn,
    Work, drive, log, settings,
};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;

const LOG: &str = "log.csv";
const TRAJECTORY: &str = "trajectory.gsd";
/// Measurements between two looks at the clock. What makes a run fast is forgotten there, so that a run
/// goes on from a checkpoint as it would have.
const SAMPLES_AT_ONCE: u64 = 10;

/// The directory of a run.
const LAYOUT: Layout = Layout {
    kind: ResultKind::HardBodies,
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

/// The result of a run. Lengths are in the unit of the shape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HardBodyResult {
    /// The file or the name.
    pub shape: String,
    /// 2 or 3.
    pub dimension: usize,
    /// Radius that rounds the shape.
    pub rounding_radius: f64,
    /// Bodies.
    pub bodies: usize,
    /// The part of the box that they fill.
    pub packing_fraction: f64,
    /// Edge of the box.
    pub box_edge: f64,
    /// Sweeps after the equilibration.
    pub sweeps: u64,
    /// Z = βP/ρ of the bodies by trial compressions. It does not hold what depletants add.
    pub compressibility_factor: f64,
    /// Its standard error.
    pub compressibility_factor_error: Option<f64>,
    /// βP times the volume of a body.
    pub reduced_pressure: f64,
    /// The accepted part of the trial moves.
    pub acceptance: f64,
    /// Largest step of a coordinate.
    pub translation_step: f64,
    /// Largest component of a rotation step.
    pub rotation_step: f64,
    /// Trial moves per second of processor time in this process; `None` if it made none.
    pub trial_moves_per_cpu_second: Option<f64>,
    /// The part of inserted bodies that overlap none.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub insertion_probability: Option<f64>,
    /// Its standard error.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub insertion_probability_error: Option<f64>,
    /// Excess chemical potential, kT.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub excess_chemical_potential_kt: Option<f64>,
    /// Its standard error, kT.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub excess_chemical_potential_error_kt: Option<f64>,
    /// Free volume of the first depletant, as a part of the box.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub free_volume_fraction: Option<f64>,
    /// Its standard error.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub free_volume_fraction_error: Option<f64>,
    /// Each depletant.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub depletants: Vec<DepletantResult>,
}

/// What was measured of a depletant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DepletantResult {
    /// Radius.
    pub radius: f64,
    /// Number density in the reservoir.
    pub fugacity: f64,
    /// The part of the reservoir that the depletants would fill if they did not overlap.
    pub reservoir_packing_fraction: f64,
    /// The part of the box that is open to their centres.
    pub free_volume_fraction: f64,
    /// Its standard error.
    pub free_volume_fraction_error: Option<f64>,
}

impl Answer for HardBodyResult {
    fn text(&self) -> String {
        let mut lines = vec![
            format!(
                "{} bodies ({}), packing fraction {}, {} sweeps",
                self.bodies, self.shape, self.packing_fraction, self.sweeps
            ),
            format!(
                "compressibility factor {}",
                with_error(
                    self.compressibility_factor,
                    self.compressibility_factor_error
                )
            ),
        ];
        if let Some(potential) = self.excess_chemical_potential_kt {
            lines.push(format!(
                "excess chemical potential {} kT",
                with_error(potential, self.excess_chemical_potential_error_kt)
            ));
        }
        for kind in &self.depletants {
            lines.push(format!(
                "depletants of radius {}: free volume fraction {}",
                kind.radius,
                with_error(kind.free_volume_fraction, kind.free_volume_fraction_error)
            ));
        }
        lines.push(format!(
            "{:.1} % of the moves accepted",
            100.0 * self.acceptance
        ));
        lines.join("\n")
    }
}

fn with_error(value: f64, error: Option<f64>) -> String {
    match error {
        Some(error) => format!("{value:.5} ± {error:.5}"),
        None => format!("{value:.5}"),
    }
}

/// Runs or continues hard bodies in a directory.
///
/// # Errors
/// For invalid settings or a packing fraction that cannot be reached, a directory that holds other
/// work, and a file that cannot be written.
///
/// ```
/// use protomer::hard_bodies::{run::run_hard_bodies, settings::HardBodySettings};
/// use protomer_results::Execution;
/// let settings = HardBodySettings {
///     shape: "cube".into(),
///     bodies: 64,
///     packing_fraction: 0.1,
///     equilibration: 100,
///     sweeps: 200,
///     ..HardBodySettings::default()
/// };
/// # let folder = tempfile::tempdir()?;
/// let directory = folder.path().join("run");
/// let end = run_hard_bodies(&settings, &directory, &Execution::default())?;
/// assert!(end.finished().is_some_and(|result| result.compressibility_factor > 1.2));
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn run_hard_bodies(
    settings: &HardBodySettings,
    path: &Path,
    execution: &Execution,
) -> Result<End<HardBodyResult>> {
    settings.check()?;
    let shape = read_shape(&settings.shape)?;
    match shape.dimension() {
        2 => HardBodyRun::<2>::new(settings, &shape)?.drive(path, execution),
        3 => HardBodyRun::<3>::new(settings, &shape)?.drive(path, execution),
        other => bail!(
            "{} has {other} dimensions; give two or three",
            settings.shape
        ),
    }
}

/// A run whose settings have been checked.
struct HardBodyRun<'a, const D: usize> {
    settings: &'a HardBodySettings,
    identity: String,
    input_sha256: String,
    body: HardBody<D>,
    engine: simulation::Settings,
}

/// A run with its open files.
struct Open<const D: usize> {
    simulation: Simulation<D>,
    rows: Vec<LogRow>,
    log: Log,
    trajectory: Option<Trajectory>,
    /// Processor time of the moves, and how many, in this process.
    watch: Stopwatch,
    trials: u64,
}

/// A state from which a run continues bit for bit.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    /// The part of the log that belongs to this state.
    log: LogMark,
    /// Frames of the trajectory that belong to this state.
    frames: u64,
    state: State,
}

impl<'a, const D: usize> HardBodyRun<'a, D> {
    fn new(settings: &'a HardBodySettings, shape: &Shape) -> Result<Self> {
        let body = HardBody::new(shape, settings.rounding_radius)
            .with_context(|| settings.shape.clone())?;
        let input_sha256 = sha256_hex(format!("{shape:?}").as_bytes());
        Ok(Self {
            settings,
            identity: settings::identity(settings, &input_sha256)?,
            input_sha256,
            body,
            engine: simulation::Settings {
                seed: settings.seed,
                equilibration_sweeps: settings.equilibration,
                insertions: settings.insertions,
                points: settings.resolved_points(),
            },
        })
    }

    fn drive(&self, path: &Path, execution: &Execution) -> Result<End<HardBodyResult>> {
        let _ours =
            ResultsDirectory::enter(path, &LAYOUT, self.settings, &self.identity, execution)?;
        execution.progress.begin(self.length(), "sweeps");
        drive(self, path, execution)
    }

    /// Sweeps at which the next block of a run ends.
    fn next_stop(&self, sweeps: u64) -> u64 {
        let after = |period: u64| (sweeps / period + 1) * period;
        let (start, block) = (
            self.settings.equilibration,
            SAMPLES_AT_ONCE * self.settings.sample_every,
        );
        let mut stop = match sweeps < start {
            true => after(block).min(start),
            false => start + ((sweeps - start) / block + 1) * block,
        };
        if self.settings.trajectory_every > 0 {
            stop = stop.min(after(self.settings.trajectory_every));
        }
        stop.min(self.length())
    }

    fn write_frame(&self, open: &mut Open<D>) -> Result<()> {
        let sweeps = open.simulation.sweeps();
        if let Some(trajectory) = &mut open.trajectory
            && sweeps.is_multiple_of(self.settings.trajectory_every)
        {
            trajectory.append(sweeps, open.simulation.system())?;
        }
        Ok(())
    }
}

impl<const D: usize> Run for HardBodyRun<'_, D> {
    type State = Open<D>;
    type Checkpoint = Saved;
    type Answer = HardBodyResult;
    type Error = Error;

    const CHECKPOINT_KIND: &'static str = "hard bodies checkpoint";

    fn work(&self) -> Work {
        Work {
            kind: ResultKind::HardBodies,
            verb: "hpmc run",
            identity: self.identity.clone(),
            input_sha256: self.input_sha256.clone(),
        }
    }

    fn length(&self) -> u64 {
        self.settings.equilibration + self.settings.sweeps
    }

    fn open(&self, directory: &Path, saved: Option<Saved>) -> Result<Open<D>> {
        let (settings, depletants) = (self.settings, &self.settings.depletants);
        let is_new = saved.is_none();
        let (mark, frames, simulation) = match saved {
            Some(saved) => (
                saved.log,
                saved.frames,
                Simulation::resume(&self.engine, &self.body, depletants, &saved.state)?,
            ),
            None => {
                let (bodies, packing) = (settings.bodies, settings.packing_fraction);
                let new = Simulation::new(&self.engine, &self.body, depletants, bodies, packing)?;
                (LogMark::default(), 0, new)
            }
        };
        let path = directory.join(LOG);
        let mut log = Log::open::<LogRow>(&path, &mark)?;
        log.sync()?;
        let trajectory = match settings.trajectory_every {
            0 => None,
            _ => {
                let path = directory.join(TRAJECTORY);
                Some(Trajectory::open(&path, simulation.system(), frames)?)
            }
        };
        let mut open = Open {
            simulation,
            rows: log::read(&path)?,
            log,
            trajectory,
            watch: Stopwatch::default(),
            trials: 0,
        };
        if is_new {
            self.write_frame(&mut open)?;
        }
        Ok(open)
    }

    fn done(&self, open: &Open<D>) -> u64 {
        open.simulation.sweeps()
    }

    fn advance(&self, open: &mut Open<D>, _turn: &Turn<'_>) -> Result<()> {
        let stop = self.next_stop(open.simulation.sweeps());
        open.simulation.refresh();
        while open.simulation.sweeps() < stop {
            let done = open.simulation.sweeps();
            let period = self.settings.sample_every;
            let start = self.settings.equilibration;
            let next = match done < start {
                true => stop.min(start),
                false => stop.min(start + ((done - start) / period + 1) * period),
            };
            open.watch.time(|| open.simulation.run(next - done));
            open.trials += (next - done) * self.settings.bodies as u64;
            if next > start && (next - start).is_multiple_of(period) {
                let sample = open.simulation.sample();
                let row = LogRow {
                    sweep: next,
                    compressibility_factor: sample.compressibility_factor,
                    insertion_probability: sample.insertion_probability,
                    free_volume: sample.free_volume,
                };
                open.log.append(&row)?;
                open.rows.push(row);
            }
        }
        self.write_frame(open)
    }

    fn save(&self, open: &mut Open<D>) -> Result<Saved> {
        let frames = match &mut open.trajectory {
            Some(trajectory) => trajectory.sync()?,
            None => 0,
        };
        Ok(Saved {
            log: open.log.sync()?,
            frames,
            state: open.simulation.state(),
        })
    }

    fn answer(&self, open: &mut Open<D>, _directory: &Path) -> Result<HardBodyResult> {
        let rows = &open.rows;
        let factors: Vec<f64> = rows.iter().map(|row| row.compressibility_factor).collect();
        let (factor, factor_error) = mean_and_error(&factors);
        let insertions: Option<Vec<f64>> =
            rows.iter().map(|row| row.insertion_probability).collect();
        let insertion = insertions
            .filter(|series| !series.is_empty())
            .map(|series| mean_and_error(&series));
        let mut depletants = Vec::new();
        for (number, kind) in self.settings.depletants.iter().enumerate() {
            let series: Vec<f64> = rows.iter().map(|row| row.free_volume[number]).collect();
            let (fraction, error) = mean_and_error(&series);
            depletants.push(DepletantResult {
                radius: kind.radius,
                fugacity: kind.fugacity,
                reservoir_packing_fraction: kind.fugacity * ball_volume::<D>(kind.radius),
                free_volume_fraction: fraction,
                free_volume_fraction_error: error,
            });
        }
        let system = open.simulation.system();
        let first = depletants.first();
        let seconds = open.watch.seconds();
        Ok(HardBodyResult {
            shape: self.settings.shape.clone(),
            dimension: D,
            rounding_radius: self.settings.rounding_radius,
            bodies: system.len(),
            packing_fraction: self.settings.packing_fraction,
            box_edge: system.edge(),
            sweeps: open
                .simulation
                .sweeps()
                .saturating_sub(self.settings.equilibration),
            compressibility_factor: factor,
            compressibility_factor_error: factor_error,
            reduced_pressure: factor * system.packing_fraction(),
            acceptance: open.simulation.counts().total().acceptance(),
            translation_step: open.simulation.steps().translation,
            rotation_step: open.simulation.steps().rotation,
            trial_moves_per_cpu_second: (seconds > 0.0).then(|| open.trials as f64 / seconds),
            insertion_probability: insertion.map(|(mean, _)| mean),
            insertion_probability_error: insertion.and_then(|(_, error)| error),
            excess_chemical_potential_kt: insertion
                .filter(|(mean, _)| *mean > 0.0)
                .map(|(mean, _)| -mean.ln()),
            excess_chemical_potential_error_kt: insertion
                .filter(|(mean, _)| *mean > 0.0)
                .and_then(|(mean, error)| Some(error? / mean)),
            free_volume_fraction: first.map(|kind| kind.free_volume_fraction),
            free_volume_fraction_error: first.and_then(|kind| kind.free_volume_fraction_error),
            depletants,
        })
    }

    fn details(&self, open: &mut Open<D>, directory: &Path) -> Result<Value> {
        if open.rows.is_empty() {
            return Ok(Value::Null);
        }
        Ok(serde_json::to_value(self.answer(open, directory)?)?)
    }

    fn check(&self, directory: &Path, saved: &Saved) -> Result<()> {
        Ok(log::check(&directory.join(LOG), &saved.log)?)
    }
}

/// The mean of a series and its standard error by blocks; of a short series, by its autocorrelation.
fn mean_and_error(series: &[f64]) -> (f64, Option<f64>) {
    let summary = summarize(series);
    let error = block_standard_error(series).unwrap_or(summary.standard_error);
    (summary.mean, Some(error).filter(|error| error.is_finite()))
}

fn ball_volume<const D: usize>(radius: f64) -> f64 {
    use std::f64::consts::PI;
    match D {
        2 => PI * radius * radius,
        _ => 4.0 / 3.0 * PI * radius.powi(3),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn run(settings: &HardBodySettings, path: &Path) -> HardBodyResult {
        let end = run_hard_bodies(settings, path, &Execution::default()).unwrap();
        end.finished().unwrap()
    }

    #[test]
    fn a_run_that_stops_and_goes_on_writes_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let short = HardBodySettings {
            shape: "tetrahedron".into(),
            bodies: 64,
            packing_fraction: 0.1,
            equilibration: 100,
            sweeps: 100,
            trajectory_every: 50,
            insertions: 10,
            depletants: super::super::settings::parse_depletants("0.1:5").unwrap(),
            ..HardBodySettings::default()
        };
        let long = HardBodySettings {
            sweeps: 300,
            ..short.clone()
        };
        let [parts, whole] = ["parts", "whole"].map(|name| folder.path().join(name));
        run(&short, &parts);
        let (in_parts, at_once) = (run(&long, &parts), run(&long, &whole));
        assert_eq!(in_parts.sweeps, 300);
        assert_eq!(
            in_parts.compressibility_factor,
            at_once.compressibility_factor
        );
        for file in [LOG, TRAJECTORY, CHECKPOINT] {
            let [parts, whole] =
                [&parts, &whole].map(|path| std::fs::read(path.join(file)).unwrap());
            assert!(parts == whole, "{file}");
        }
        // A finished run answers from its record.
        assert_eq!(
            run(&long, &whole).compressibility_factor,
            at_once.compressibility_factor
        );
        let other = HardBodySettings { seed: 2, ..long };
        let refused = run_hard_bodies(&other, &whole, &Execution::default());
        assert!(refused.unwrap_err().to_string().contains("seed"));
    }
}
