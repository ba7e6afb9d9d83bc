//! One run of hard bodies in its directory.
//!
//! ```text
//! DIR/  run.toml  run.json  log.csv  trajectory.gsd  profile.csv  checkpoint.bin
//! ```

use super::log::LogRow;
use super::settings::{Freedom, HardBodySettings};
use super::start::{BodyShape, FLUID, cell_text, unit_cell};
use super::trajectory::Trajectory;
use anyhow::{Context, Error, Result};
use protomer_common::answer::Answer;
use protomer_common::cpu_time::Stopwatch;
use protomer_common::output_file::write_once;
use protomer_hpmc::body::HardBody;
use protomer_hpmc::crystal::Crystal;
use protomer_hpmc::heights::Walls;
use protomer_hpmc::simulation::{self, Simulation, State};
use protomer_hpmc::start::Start;
use protomer_kernel::periodic_box::PeriodicBox;
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
const PROFILE: &str = "profile.csv";
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
        PROFILE,
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
    /// The part of the box that they fill; at constant pressure its mean.
    pub packing_fraction: f64,
    /// At constant pressure, its standard error.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub packing_fraction_error: Option<f64>,
    /// First edge of the box at the end.
    pub box_edge: f64,
    /// Lengths of the box at the end: Lx, Ly, Lz. With right angles they are its edges.
    #[serde(default)]
    pub box_edges: Vec<f64>,
    /// Tilt factors of the box at the end, xy, xz and yz; in a plane xy; none where its angles are right.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub box_tilt_factors: Vec<f64>,
    /// Where more than the volume of the box changes, its means.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub mean_box: Option<MeanBox>,
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
    /// The constant pressure βP, kT per volume.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub pressure_kt_per_volume: Option<f64>,
    /// The accepted part of the changes of the box.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub box_acceptance: Option<f64>,
    /// What the walls bear.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub walls: Option<WallsResult>,
    /// Each depletant.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub depletants: Vec<DepletantResult>,
}

/// The box on average. Tilt factors that belong to the same images count as different.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeanBox {
    /// Lx, Ly, Lz.
    pub lengths: Vec<f64>,
    /// Their standard errors.
    pub length_errors: Vec<Option<f64>>,
    /// xy, xz and yz; in a plane xy.
    pub tilt_factors: Vec<f64>,
    /// Their standard errors.
    pub tilt_factor_errors: Vec<Option<f64>>,
}

impl MeanBox {
    /// Of the measurements; `None` where the box keeps its shape.
    fn of(rows: &[LogRow]) -> Option<Self> {
        let series = |of: fn(&LogRow) -> &Vec<f64>| -> Vec<(f64, Option<f64>)> {
            let count = rows.first().map_or(0, |row| of(row).len());
            let number = |number: usize| {
                let numbers = rows.iter().filter_map(|row| of(row).get(number).copied());
                mean_and_error(&numbers.collect::<Vec<f64>>())
            };
            (0..count).map(number).collect()
        };
        let (lengths, length_errors) = series(|row| &row.box_lengths).into_iter().unzip();
        let (tilt_factors, tilt_factor_errors) =
            series(|row| &row.box_tilt_factors).into_iter().unzip();
        let found = Self {
            lengths,
            length_errors,
            tilt_factors,
            tilt_factor_errors,
        };
        (!found.lengths.is_empty()).then_some(found)
    }

    fn text(&self) -> String {
        let several = |values: &[f64], errors: &[Option<f64>]| {
            let numbers = values.iter().zip(errors);
            let words: Vec<String> = numbers.map(|(x, error)| with_error(*x, *error)).collect();
            words.join(", ")
        };
        let lengths = several(&self.lengths, &self.length_errors);
        if self.tilt_factors.is_empty() {
            return format!("box {lengths}");
        }
        let tilts = several(&self.tilt_factors, &self.tilt_factor_errors);
        format!("box {lengths}; tilt factors {tilts}")
    }
}

/// The tilt factors of a box; none where its angles are right.
pub(super) fn tilt_factors<const D: usize>(space: &PeriodicBox<D>) -> Vec<f64> {
    match space.is_rectangular() {
        true => Vec::new(),
        false => space.tilt_factors(),
    }
}

/// Bodies under gravity between walls. The pressures differ by the weight over the area, whatever the
/// bodies are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WallsResult {
    /// βP at the lower wall, kT per volume, from the bodies near it.
    pub lower_pressure: f64,
    /// Its standard error.
    pub lower_pressure_error: Option<f64>,
    /// βP at the upper wall.
    pub upper_pressure: f64,
    /// Its standard error.
    pub upper_pressure_error: Option<f64>,
    /// The weight of all bodies over the area of a wall, kT per volume.
    pub weight_per_area: f64,
    /// Mean height of the centres over the lower wall.
    pub mean_height: f64,
    /// Its standard error.
    pub mean_height_error: Option<f64>,
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
                self.bodies,
                self.shape,
                match self.pressure_kt_per_volume {
                    None => self.packing_fraction.to_string(),
                    Some(_) => with_error(self.packing_fraction, self.packing_fraction_error),
                },
                self.sweeps
            ),
            format!(
                "compressibility factor {}",
                with_error(
                    self.compressibility_factor,
                    self.compressibility_factor_error
                )
            ),
        ];
        lines.extend(self.mean_box.as_ref().map(MeanBox::text));
        if let Some(walls) = &self.walls {
            lines.push(format!(
                "pressure at the lower wall {}, at the upper {}; weight per area {:.5}",
                with_error(walls.lower_pressure, walls.lower_pressure_error),
                with_error(walls.upper_pressure, walls.upper_pressure_error),
                walls.weight_per_area
            ));
            lines.push(format!(
                "mean height {}",
                with_error(walls.mean_height, walls.mean_height_error)
            ));
        }
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
    let shape = BodyShape::read(&settings.shape)?;
    match shape.dimension() {
        1 => HardBodyRun::<1>::new(settings, &shape)?.drive(path, execution),
        2 => HardBodyRun::<2>::new(settings, &shape)?.drive(path, execution),
        _ => HardBodyRun::<3>::new(settings, &shape)?.drive(path, execution),
    }
}

/// A run whose settings have been checked.
struct HardBodyRun<'a, const D: usize> {
    settings: &'a HardBodySettings,
    identity: String,
    input_sha256: String,
    body: HardBody<D>,
    start: Start<D>,
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
    fn new(settings: &'a HardBodySettings, shape: &BodyShape) -> Result<Self> {
        let body = shape
            .body(settings.rounding_radius)
            .with_context(|| settings.shape.clone())?;
        let engine = simulation::Settings {
            seed: settings.seed,
            equilibration_sweeps: settings.equilibration,
            insertions: settings.insertions,
            points: settings.resolved_points(),
            pressure: settings.pressure,
            gravity: settings.gravity,
        };
        engine.check(&settings.depletants)?;
        let text = cell_text(&settings.start)?;
        let start = start(settings, &body, text.as_deref())?;
        let input_sha256 = shape.sha256(text.as_deref());
        Ok(Self {
            settings,
            identity: settings::identity(settings, &input_sha256)?,
            input_sha256,
            body,
            start,
            engine,
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

    /// The means of what the walls bear.
    fn walls(&self, open: &Open<D>) -> Option<WallsResult> {
        let gravity = self.settings.gravity?;
        let samples: Option<Vec<Walls>> = open.rows.iter().map(|row| row.walls).collect();
        let samples = samples?;
        let mean =
            |of: fn(&Walls) -> f64| mean_and_error(&samples.iter().map(of).collect::<Vec<f64>>());
        let (lower, lower_error) = mean(|walls| walls.pressures[0]);
        let (upper, upper_error) = mean(|walls| walls.pressures[1]);
        let (height, height_error) = mean(|walls| walls.mean_height);
        let lengths = open.simulation.system().space().lengths();
        let area: f64 = lengths.iter().take(D - 1).product();
        Some(WallsResult {
            lower_pressure: lower,
            lower_pressure_error: lower_error,
            upper_pressure: upper,
            upper_pressure_error: upper_error,
            weight_per_area: self.settings.bodies as f64 * gravity.weight_kt_per_length / area,
            mean_height: height,
            mean_height_error: height_error,
        })
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
                let new = Simulation::new(&self.engine, &self.body, depletants, &self.start)?;
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
                let space = open.simulation.system().space();
                let (lengths, tilt_factors) = match self.settings.pressure.map(|kept| kept.freedom)
                {
                    None | Some(Freedom::Volume) => (Vec::new(), Vec::new()),
                    Some(Freedom::Lengths) => (space.lengths().to_vec(), Vec::new()),
                    Some(Freedom::Shape) => (space.lengths().to_vec(), space.tilt_factors()),
                };
                let row = LogRow {
                    sweep: next,
                    compressibility_factor: sample.compressibility_factor,
                    insertion_probability: sample.insertion_probability,
                    free_volume: sample.free_volume,
                    packing_fraction: sample.packing_fraction,
                    walls: sample.walls,
                    box_lengths: lengths,
                    box_tilt_factors: tilt_factors,
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

    fn answer(&self, open: &mut Open<D>, directory: &Path) -> Result<HardBodyResult> {
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
        let walls = self.walls(open);
        if walls.is_some() {
            write_once(&directory.join(PROFILE), profile(open).as_bytes(), true)?;
        }
        let packings: Vec<f64> = rows.iter().map(|row| row.packing_fraction).collect();
        let (packing, packing_error) = match self.settings.pressure {
            Some(_) => mean_and_error(&packings),
            None => (self.settings.packing_fraction, None),
        };
        let system = open.simulation.system();
        let first = depletants.first();
        let seconds = open.watch.seconds();
        Ok(HardBodyResult {
            shape: self.settings.shape.clone(),
            dimension: D,
            rounding_radius: self.settings.rounding_radius,
            bodies: system.len(),
            packing_fraction: packing,
            packing_fraction_error: packing_error,
            box_edge: system.space().lengths()[0],
            box_edges: system.space().lengths().to_vec(),
            box_tilt_factors: tilt_factors(system.space()),
            mean_box: MeanBox::of(rows),
            sweeps: open
                .simulation
                .sweeps()
                .saturating_sub(self.settings.equilibration),
            compressibility_factor: factor,
            compressibility_factor_error: factor_error,
            reduced_pressure: factor * packing,
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
            pressure_kt_per_volume: self
                .settings
                .pressure
                .map(|pressure| pressure.kt_per_volume),
            box_acceptance: self
                .settings
                .pressure
                .map(|_| open.simulation.box_acceptance()),
            walls,
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

fn start<const D: usize>(
    settings: &HardBodySettings,
    body: &HardBody<D>,
    cell_text: Option<&str>,
) -> Result<Start<D>> {
    let (bodies, packing) = (settings.bodies, settings.packing_fraction);
    if settings.start != FLUID {
        let cell = unit_cell(&settings.start, cell_text, &settings.turn)?;
        let crystal = Crystal::new(&cell, body, bodies, packing)?;
        // What cannot be is refused before a directory is made.
        crystal.system(body, &settings.depletants)?;
        return Ok(Start::Crystal(crystal));
    }
    let edge_ratios = match settings.box_ratios.as_slice() {
        [] => [1.0; D],
        ratios => ratios.try_into().ok().with_context(|| {
            let count = ratios.len();
            format!("there are {count} ratios of edges, and the box has {D} edges; give {D}")
        })?,
    };
    Ok(Start::Fluid {
        bodies,
        packing_fraction: packing,
        edge_ratios,
        has_walls: settings.gravity.is_some(),
    })
}

/// Densities by height.
fn profile<const D: usize>(open: &Open<D>) -> String {
    let system = open.simulation.system();
    let parts = open.simulation.heights().parts();
    let height = system.space().lengths()[D - 1] / parts.len().max(1) as f64;
    let volume = system.volume() / parts.len().max(1) as f64;
    let mut table = String::from("height,number_density,packing_fraction\n");
    for (bin, part) in parts.iter().enumerate() {
        let density = part * system.len() as f64 / volume;
        let middle = (bin as f64 + 0.5) * height;
        let packing = density * system.body().volume;
        table.push_str(&format!("{middle},{density},{packing}\n"));
    }
    table
}

/// The mean of a series and its standard error by blocks; of a short series, by its autocorrelation.
pub(super) fn mean_and_error(series: &[f64]) -> (f64, Option<f64>) {
    let summary = summarize(series);
    let error = block_standard_error(series).unwrap_or(summary.standard_error);
    (summary.mean, Some(error).filter(|error| error.is_finite()))
}

fn ball_volume<const D: usize>(radius: f64) -> f64 {
    use std::f64::consts::PI;
    match D {
        1 => 2.0 * radius,
        2 => PI * radius * radius,
        _ => 4.0 / 3.0 * PI * radius.powi(3),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::hard_bodies::settings::Pressure;

    fn run(settings: &HardBodySettings, path: &Path) -> HardBodyResult {
        let end = run_hard_bodies(settings, path, &Execution::default()).unwrap();
        end.finished().unwrap()
    }

    #[test]
    fn a_run_that_stops_and_goes_on_writes_the_same_bytes() {
        let plain = HardBodySettings {
            shape: "tetrahedron".into(),
            bodies: 64,
            packing_fraction: 0.1,
            equilibration: 100,
            sweeps: 100,
            trajectory_every: 50,
            insertions: 10,
            ..HardBodySettings::default()
        };
        stops_and_goes_on(&HardBodySettings {
            depletants: super::super::settings::parse_depletants("0.1:5").unwrap(),
            ..plain.clone()
        });
        // A fluid, whose box soon is so tilted that other edges describe it.
        stops_and_goes_on(&HardBodySettings {
            pressure: Some(Pressure {
                kt_per_volume: 0.5,
                freedom: Freedom::Shape,
            }),
            ..plain
        });
    }

    fn stops_and_goes_on(short: &HardBodySettings) {
        let folder = tempfile::tempdir().unwrap();
        let long = HardBodySettings {
            sweeps: 300,
            ..short.clone()
        };
        let [parts, whole] = ["parts", "whole"].map(|name| folder.path().join(name));
        run(short, &parts);
        let (in_parts, at_once) = (run(&long, &parts), run(&long, &whole));
        assert_eq!(in_parts.sweeps, 300);
        assert_eq!(in_parts.mean_box, at_once.mean_box);
        assert_eq!(in_parts.mean_box.is_some(), short.pressure.is_some());
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
