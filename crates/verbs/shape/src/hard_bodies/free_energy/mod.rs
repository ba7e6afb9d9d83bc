//! The free energy of a crystal of hard bodies, in its directory.
//!
//! ```text
//! DIR/  run.toml  run.json  log.csv  points.csv  crystal.gsd  checkpoint.bin
//! ```
//!
//! With even sweeps the log and the checkpoint are in a folder for each strength (module `apart`).

mod apart;
mod result;
mod settings;

pub use result::{FreeEnergyResult, PointResult};
pub use settings::{FreeEnergySettings, Share};

use super::result::{mean_and_error, tilt_factors};
use super::start::{BodyShape, cell_text, unit_cell};
use super::trajectory::{frame, open_trajectory};
use anyhow::{Context, Error, Result, bail};
use protomer_common::output_file::write_once;
use protomer_hpmc::body::HardBody;
use protomer_hpmc::crystal::Crystal;
use protomer_hpmc::frenkel_ladd::{
    Estimate, Measurement, Plan, Point, STRENGTHS, Walker, WalkerState, share,
};
use protomer_kernel::statistics::summarize;
use protomer_results::checkpoint::require_lengths;
use protomer_results::settings::identity;
use protomer_results::{
    CHECKPOINT, End, Execution, Layout, Log, LogMark, ResultKind, ResultsDirectory, Run, Shard,
    Turn, Work, drive, log,
};
use rayon::prelude::*;
use result::{FEW_SAMPLES, table_of};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;

const LOG: &str = log::FILE;
/// Name of the table of strengths.
pub(super) const POINTS: &str = "points.csv";
/// Name of the file with the crystal.
pub(super) const CRYSTAL: &str = "crystal.gsd";
/// Sweeps that a row of the log is the mean of.
const SWEEPS_PER_ROW: u64 = 50;
/// Rows that a point of the integral is given at once.
const ROWS_AT_ONCE: u64 = 4;
/// Parts of so many rows in a round.
const PARTS_PER_ROUND: usize = 2 * STRENGTHS;
/// Equilibration sweeps between two looks at the clock.
const EQUILIBRATION_AT_ONCE: u64 = 500;

/// The directory of a free energy.
const LAYOUT: Layout = Layout {
    kind: ResultKind::FreeEnergy,
    settings: "run.toml",
    results: &["run.json", LOG, POINTS, CRYSTAL, CHECKPOINT, "report.html"],
    is_result: apart::is_strength,
};

protomer_results::log_row! {
    /// One row of the log: a mean over some sweeps at a point of the integral.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ExtentRow {
        /// Number of the point, from the weakest springs.
        pub point: usize,
        /// Sweeps done at this point.
        pub sweep: u64,
        /// f, the energy of the springs per body over their strength, squared length.
        pub extent: f64,
    }
}

/// Computes or continues the free energy of a crystal in a directory.
///
/// # Errors
/// For invalid settings or bodies that overlap in the crystal, a directory that holds other work, and
/// a file that cannot be written.
///
/// ```
/// use protomer_shape_verbs::hard_bodies::free_energy::{FreeEnergySettings, run_free_energy};
/// use protomer_results::Execution;
/// let settings = FreeEnergySettings {
///     shape: "rod:1".into(),
///     crystal: "row".into(),
///     bodies: 8,
///     packing_fraction: 0.5,
///     equilibration: 100,
///     sweeps: 800,
///     ..FreeEnergySettings::default()
/// };
/// # let folder = tempfile::tempdir()?;
/// let directory = folder.path().join("rods");
/// let end = run_free_energy(&settings, &directory, &Execution::default())?;
/// let result = end.finished().unwrap();
/// assert!((result.free_energy_per_body_kt + 0.84051).abs() < 0.1);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn run_free_energy(
    settings: &FreeEnergySettings,
    path: &Path,
    execution: &Execution,
) -> Result<End<FreeEnergyResult>> {
    settings.check()?;
    prepared(settings, &|run| run.carry_out(path, execution))
}

/// Runs or continues some strengths of the springs, while other processes do others in the same directory; returns
/// their number. [`run_free_energy`] finds them done and computes the free energy.
///
/// # Errors
/// As [`run_free_energy`], and for settings in which the sweeps of one strength depend on the others.
pub fn run_shard(
    settings: &FreeEnergySettings,
    path: &Path,
    shard: Shard,
    execution: &Execution,
) -> Result<End<usize>> {
    settings.check()?;
    if settings.share != Share::Even {
        bail!(
            "the sweeps of each strength depend on the errors of the others, so they cannot be shared; add --share even"
        );
    }
    prepared(settings, &|run| run.carry_out_part(path, shard, execution))
}

/// Work on a free energy whose settings have been checked, in any number of dimensions.
trait Prepared {
    /// Does all of it.
    fn carry_out(&self, path: &Path, execution: &Execution) -> Result<End<FreeEnergyResult>>;

    /// Does some strengths, alongside other processes; returns their number.
    fn carry_out_part(
        &self,
        path: &Path,
        shard: Shard,
        execution: &Execution,
    ) -> Result<End<usize>>;
}

/// Function that does a part of prepared work.
type Carrying<'a, T> = &'a dyn Fn(&dyn Prepared) -> Result<End<T>>;

/// Reads the shape and the crystal and works on their free energy.
fn prepared<T>(settings: &FreeEnergySettings, carrying: Carrying<'_, T>) -> Result<End<T>> {
    let shape = BodyShape::read(&settings.shape)?;
    match shape.dimension() {
        1 => in_dimension::<1, T>(settings, &shape, carrying),
        2 => in_dimension::<2, T>(settings, &shape, carrying),
        _ => in_dimension::<3, T>(settings, &shape, carrying),
    }
}

fn in_dimension<const D: usize, T>(
    settings: &FreeEnergySettings,
    shape: &BodyShape,
    carrying: Carrying<'_, T>,
) -> Result<End<T>> {
    let body = shape
        .body::<D>(settings.rounding_radius)
        .with_context(|| settings.shape.clone())?;
    let text = cell_text(&settings.crystal)?;
    let cell = unit_cell::<D>(&settings.crystal, text.as_deref(), &settings.turn)?;
    let crystal = Crystal::new(&cell, &body, settings.bodies, settings.packing_fraction)?;
    let input_sha256 = shape.sha256(text.as_deref());
    let run = FreeEnergyRun {
        settings,
        identity: identity(settings, &input_sha256)?,
        input_sha256,
        measurement: Measurement::new(&body, &crystal, settings.seed)?,
        body: &body,
        crystal: &crystal,
    };
    // Only now: what was checked above refuses without a directory being made.
    carrying(&run)
}

/// A free energy whose settings have been checked.
struct FreeEnergyRun<'a, const D: usize> {
    settings: &'a FreeEnergySettings,
    identity: String,
    input_sha256: String,
    measurement: Measurement<'a, D>,
    body: &'a HardBody<D>,
    crystal: &'a Crystal<D>,
}

impl<const D: usize> Prepared for FreeEnergyRun<'_, D> {
    fn carry_out(&self, path: &Path, execution: &Execution) -> Result<End<FreeEnergyResult>> {
        if self.settings.share == Share::Even {
            return apart::carry_out_apart(self, path, execution);
        }
        let (settings, identity) = (self.settings, &self.identity);
        let _ours = ResultsDirectory::enter(path, &LAYOUT, settings, identity, execution)?;
        execution.progress.begin(self.length(), "sweeps");
        drive(self, path, execution)
    }

    fn carry_out_part(
        &self,
        path: &Path,
        shard: Shard,
        execution: &Execution,
    ) -> Result<End<usize>> {
        apart::carry_out_part(self, path, shard, execution)
    }
}

/// Bodies on springs at each point, with the open log.
struct Open<const D: usize> {
    plan: Plan,
    walkers: Vec<Walker<D>>,
    /// The extents at each point.
    series: Vec<Vec<f64>>,
    log: Log,
}

/// A state from which a run continues bit for bit.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    /// The part of the log that belongs to this state.
    log: LogMark,
    plan: Plan,
    walkers: Vec<WalkerState>,
}

/// Means of the extents at each point, with their errors.
fn estimates(series: &[Vec<f64>]) -> Vec<Estimate> {
    let estimate = |series: &Vec<f64>| {
        let (mean, error) = mean_and_error(series);
        // Too few rows for an error: the value itself as error sends work to this point first.
        let error = error.unwrap_or(mean);
        Estimate { mean, error }
    };
    series.iter().map(estimate).collect()
}

/// Does a part of the equilibration, in which steps are tuned.
fn equilibrate<const D: usize>(walker: &mut Walker<D>, remaining_sweeps: u64) {
    // What makes sweeps fast is made again here, so that a run goes on from a checkpoint as it would have.
    walker.refresh();
    // Tuned now, since steps may not change while something is measured.
    walker.run(remaining_sweeps.min(EQUILIBRATION_AT_ONCE), true);
}

impl<const D: usize> Open<D> {
    /// Rows that each point is given in the next round.
    fn rows(&self) -> Vec<u64> {
        let points = self.walkers.len();
        let parts = match self.series.iter().any(Vec::is_empty) {
            // First the same for all: without a series there is no error to share by.
            true => vec![PARTS_PER_ROUND / points; points],
            false => {
                let mut measured = Vec::new();
                for (series, estimate) in self.series.iter().zip(estimates(&self.series)) {
                    measured.push((series.len() as u64, estimate.error));
                }
                // Then where the error of the integral falls most for its cost.
                share(&self.plan, &measured, PARTS_PER_ROUND)
            }
        };
        let rows = |parts: &usize| *parts as u64 * ROWS_AT_ONCE;
        parts.iter().map(rows).collect()
    }
}

impl<const D: usize> FreeEnergyRun<'_, D> {
    /// Bodies on the springs of one strength, as they begin or as they were saved.
    fn walker(&self, number: usize, plan: &Plan, saved: Option<&WalkerState>) -> Result<Walker<D>> {
        let point = plan
            .points
            .get(number)
            .context("the checkpoint has other strengths; start again with --force")?;
        let (stream, strength, turning) = (number as u32, point.strength, plan.turning);
        Ok(match saved {
            Some(state) => self.measurement.resume(stream, strength, turning, state)?,
            None => self.measurement.start(stream, strength, turning)?,
        })
    }

    fn point(point: &Point, series: &[f64], estimate: &Estimate) -> PointResult {
        let summary = summarize(series);
        PointResult {
            strength_kt_per_area: point.strength,
            weight: point.weight,
            extent: estimate.mean,
            extent_error: estimate.error,
            contribution_kt: point.weight * estimate.mean,
            contribution_kt_error: point.weight * estimate.error,
            sweeps: series.len() as u64 * SWEEPS_PER_ROW,
            correlation_time_sweeps: summary.autocorrelation_time * SWEEPS_PER_ROW as f64,
            independent_samples: summary.effective_samples,
        }
    }

    /// Writes the crystal, and its bodies on the weakest springs.
    fn write_crystal(&self, weakest: Option<&Walker<D>>, path: &Path) -> Result<()> {
        let system = self.crystal.system(self.body, &[])?;
        let mut trajectory = open_trajectory(path, &system, None, 0)?;
        trajectory.append(frame(0, &system))?;
        if let Some(weakest) = weakest {
            trajectory.append(frame(weakest.sweeps(), weakest.system()))?;
        }
        trajectory.sync()?;
        Ok(())
    }

    /// Computes the free energy from the extents at each point, and writes the table of points.
    fn result(
        &self,
        plan: &Plan,
        series: &[Vec<f64>],
        directory: &Path,
    ) -> Result<FreeEnergyResult> {
        let estimates = estimates(series);
        let terms = self.measurement.free_energy(plan, &estimates);
        let (mut points, mut slow_points) = (Vec::new(), Vec::new());
        for (number, estimate) in estimates.iter().enumerate() {
            let point = Self::point(&plan.points[number], &series[number], estimate);
            if point.independent_samples < FEW_SAMPLES {
                slow_points.push(number);
            }
            points.push(point);
        }
        let table = table_of(&points)?;
        // Overwritten: the points of a shorter run are no longer true.
        write_once(&directory.join(POINTS), table.as_bytes(), true)?;
        let density = self.settings.packing_fraction / self.body.volume;
        Ok(FreeEnergyResult {
            shape: self.settings.shape.clone(),
            crystal: self.settings.crystal.clone(),
            dimension: D,
            bodies: self.settings.bodies,
            packing_fraction: self.settings.packing_fraction,
            number_density: density,
            box_edges: self.crystal.space.lengths().to_vec(),
            box_tilt_factors: tilt_factors(&self.crystal.space),
            symmetry_order: self.measurement.symmetry().rotations().len(),
            free_energy_per_body_kt: terms.total_kt,
            free_energy_per_body_kt_error: terms.total_kt_error,
            // The ideal gas of this density has A/(N kT) = ln ρ - 1.
            excess_free_energy_per_body_kt: terms.total_kt - (density.ln() - 1.0),
            excess_free_energy_per_body_kt_error: terms.total_kt_error,
            terms,
            points,
            slow_points,
        })
    }
}

impl<const D: usize> Run for FreeEnergyRun<'_, D> {
    type State = Open<D>;
    type Checkpoint = Saved;
    type Answer = FreeEnergyResult;
    type Error = Error;

    const CHECKPOINT_KIND: &'static str = "free energy checkpoint";

    fn work(&self) -> Work {
        Work::new(
            ResultKind::FreeEnergy,
            "free-energy",
            &self.identity,
            &self.input_sha256,
        )
    }

    /// Length of the run, with whole rounds.
    fn length(&self) -> u64 {
        let round = PARTS_PER_ROUND as u64 * ROWS_AT_ONCE * SWEEPS_PER_ROW;
        // Rounds are whole, so the last one may exceed what was asked for.
        let points = STRENGTHS as u64;
        let production = points * self.settings.sweeps;
        points * self.settings.equilibration + production.div_ceil(round) * round
    }

    fn open(&self, directory: &Path, saved: Option<Saved>) -> Result<Open<D>> {
        let (mark, plan, states) = match saved {
            Some(saved) => {
                // A checkpoint of another version may have fewer points.
                require_lengths(&[
                    ("strengths", saved.plan.points.len(), STRENGTHS),
                    ("crystals", saved.walkers.len(), STRENGTHS),
                ])?;
                (saved.log, saved.plan, saved.walkers)
            }
            None => (LogMark::default(), self.measurement.plan()?, Vec::new()),
        };
        let walker = |number| self.walker(number, &plan, states.get(number));
        let numbers = 0..plan.points.len();
        let walkers: Vec<Walker<D>> = numbers.map(walker).collect::<Result<_>>()?;
        let path = directory.join(LOG);
        let mut log = Log::open::<ExtentRow>(&path, &mark)?;
        // Truncated and synced before it is read back: rows after the checkpoint must not count.
        log.sync()?;
        let mut series = vec![Vec::new(); walkers.len()];
        for row in log::read::<ExtentRow>(&path)? {
            if let Some(series) = series.get_mut(row.point) {
                series.push(row.extent);
            }
        }
        Ok(Open {
            plan,
            walkers,
            series,
            log,
        })
    }

    fn done(&self, open: &Open<D>) -> u64 {
        open.walkers.iter().map(Walker::sweeps).sum()
    }

    /// Does a part of the equilibration, or a round of measurements, on all threads.
    fn advance(&self, open: &mut Open<D>, _turn: &Turn<'_>) -> Result<()> {
        let equilibrated = open.walkers.iter().map(Walker::sweeps).min().unwrap_or(0);
        let remaining_sweeps = self.settings.equilibration.saturating_sub(equilibrated);
        if remaining_sweeps > 0 {
            let walkers = open.walkers.par_iter_mut();
            walkers.for_each(|walker| equilibrate(walker, remaining_sweeps));
            return Ok(());
        }
        let rows = open.rows();
        let measure = |(walker, rows): (&mut Walker<D>, &u64)| {
            walker.refresh();
            let row = |_| walker.run(SWEEPS_PER_ROW, false);
            (0..*rows).map(row).collect::<Vec<f64>>()
        };
        let measured: Vec<Vec<f64>> = open
            .walkers
            .par_iter_mut()
            .zip(&rows)
            .map(measure)
            .collect();
        // In the order of the points, whichever thread was first: the log is the same each time.
        for (point, extents) in measured.into_iter().enumerate() {
            for extent in extents {
                open.series[point].push(extent);
                let done = open.series[point].len() as u64 * SWEEPS_PER_ROW;
                open.log.append(&ExtentRow {
                    point,
                    sweep: self.settings.equilibration + done,
                    extent,
                })?;
            }
        }
        Ok(())
    }

    fn save(&self, open: &mut Open<D>) -> Result<Saved> {
        Ok(Saved {
            log: open.log.sync()?,
            plan: open.plan.clone(),
            walkers: open.walkers.iter().map(Walker::state).collect(),
        })
    }

    fn answer(&self, open: &mut Open<D>, directory: &Path) -> Result<FreeEnergyResult> {
        let result = self.result(&open.plan, &open.series, directory)?;
        self.write_crystal(open.walkers.first(), &directory.join(CRYSTAL))?;
        Ok(result)
    }

    fn details(&self, open: &mut Open<D>, directory: &Path) -> Result<Value> {
        // During equilibration there is nothing to tell yet.
        if open.series.iter().any(Vec::is_empty) {
            return Ok(Value::Null);
        }
        Ok(serde_json::to_value(self.answer(open, directory)?)?)
    }

    fn check(&self, directory: &Path, saved: &Saved) -> Result<()> {
        Ok(log::check(&directory.join(LOG), &saved.log)?)
    }
}

#[cfg(test)]
mod tests;
