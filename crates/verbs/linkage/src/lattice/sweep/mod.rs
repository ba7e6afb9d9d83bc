//! A sweep of lattices: every r0 with every κ, once per seed, on all threads, resumable; tables and
//! figures at the end. A run that cannot be completed is a row with the reason, and the tables and
//! figures are those of the others.
//!
//! ```text
//! DIR/run.toml  run.json  lattice.csv  runs.csv  crossings.csv  correlation.csv  lattice.json  *.svg  *.png
//! DIR/r0_0.2_kappa_0/seed_1/   a run directory each, with lyapunov.json if that is measured
//! ```

mod answer;
mod figures;
mod plan;
mod series;
mod table;

pub use answer::LatticeSweep;
pub use plan::{Task, axes, tasks};
pub use series::{Outcome, RunOutcome, Series};
pub use table::{ConditionRow, Estimate, RunRow};

use super::exponent;
use super::log::LogRow;
use super::run::run_lattice;
use super::settings::LatticeSettings;
use anyhow::{Context, Error, Result};
use plan::is_condition;
use protomer_io::atomic::{write_atomically, write_bytes};
use protomer_linkage::CrystalError;
use protomer_linkage::analysis::lyapunov::LyapunovSettings;
use protomer_results::{
    Campaign, End, Execution, Layout, ResultKind, Shard, Work, carry_out, carry_out_shard, log,
    settings,
};
use std::path::{Path, PathBuf};
use table::{conditions_to_csv, correlations_to_csv, crossings_to_csv, runs_to_csv};

/// Phases are locked while all differences are below this angle, rad.
const LOCKED_WITHIN: f64 = 0.5;

/// The directory of a sweep.
const LAYOUT: Layout = Layout {
    kind: ResultKind::LatticeSweep,
    settings: super::directory::SETTINGS,
    results: &[
        "run.json",
        "lattice.csv",
        "runs.csv",
        "crossings.csv",
        "correlation.csv",
        "lattice.json",
        "report.html",
    ],
    is_result: is_condition,
};

/// Runs or continues a sweep in a directory. Runs whose squares cannot be moved, as with a step that
/// is too long, are listed in the answer, and the others are tabulated.
///
/// # Errors
/// For invalid settings, a directory that holds other work, and a file that cannot be written: the
/// other runs then stop at their next step, keep their progress, and `run.json` records the error.
pub fn run_sweep(
    settings: &LatticeSettings,
    path: &Path,
    execution: &Execution,
) -> Result<End<LatticeSweep>> {
    let sweep = Sweep::new(settings, path)?;
    carry_out(&sweep, path, &LAYOUT, settings, execution)
}

/// Runs or continues the runs of one part of a sweep, while other processes do other parts in the same directory;
/// returns their number. [`run_sweep`] finds them done and writes tables and figures.
///
/// # Errors
/// As [`run_sweep`].
pub fn run_shard(
    settings: &LatticeSettings,
    path: &Path,
    shard: Shard,
    execution: &Execution,
) -> Result<End<usize>> {
    let sweep = Sweep::new(settings, path)?;
    carry_out_shard(&sweep, path, &LAYOUT, settings, shard, execution)
}

struct Sweep<'a> {
    settings: &'a LatticeSettings,
    tasks: Vec<Task>,
    identity: String,
    path: &'a Path,
    lyapunov: Option<LyapunovSettings>,
}

impl<'a> Sweep<'a> {
    fn new(settings: &'a LatticeSettings, path: &'a Path) -> Result<Self> {
        Ok(Self {
            settings,
            lyapunov: axes(settings).lyapunov,
            tasks: tasks(settings, path)?,
            identity: settings::identity(settings, "")?,
            path,
        })
    }

    /// Does one run of the sweep, and measures its exponent if requested.
    fn run_task(
        &self,
        task: &Task,
        directory: &Path,
        execution: &Execution,
    ) -> Result<End<Outcome>> {
        let result = match run_lattice(&task.settings, directory, execution) {
            Ok(End::Finished(result)) => result,
            Ok(End::Stopped) => return Ok(End::Stopped),
            Err(error) if is_of_the_motion(&error) => {
                return Ok(End::Finished(Outcome::Failed(format!("{error:#}"))));
            }
            Err(error) => return Err(error),
        };
        let Some(lyapunov) = &self.lyapunov else {
            let exponent = None;
            return Ok(End::Finished(Outcome::done(result, exponent)));
        };
        let end = exponent::measure(
            &task.settings,
            result.shortest_step(),
            lyapunov,
            directory,
            &execution.interrupt,
        )?;
        Ok(end.map(|exponent| Outcome::done(result, Some(exponent))))
    }
}

/// Whether the squares could not be started or moved; anything else ends the sweep.
fn is_of_the_motion(error: &Error) -> bool {
    error.downcast_ref::<CrystalError>().is_some()
}

impl Campaign for Sweep<'_> {
    type Task = Task;
    type Part = Outcome;
    type Answer = LatticeSweep;
    type Error = Error;

    const ENTERS_DIRECTORIES: bool = true;

    fn work(&self) -> Work {
        Work::new(
            ResultKind::LatticeSweep,
            "lattice sweep",
            &self.identity,
            "",
        )
    }

    fn tasks(&self) -> &[Task] {
        &self.tasks
    }

    fn directory(&self, task: &Task) -> PathBuf {
        task.directory.clone()
    }

    fn run(&self, task: &Task, directory: &Path, execution: &Execution) -> Result<End<Outcome>> {
        let end = self.run_task(task, directory, &execution.of_part());
        execution.progress.advance(1);
        end.with_context(|| directory.display().to_string())
    }

    /// Makes the tables and the figures.
    fn collect(&self, outcomes: Vec<Outcome>) -> Result<LatticeSweep> {
        let (sweep, series) = collect(self.settings, &self.tasks, &outcomes)?;
        write_results(&sweep, &series, self.path)?;
        Ok(sweep)
    }
}

/// Reads the results of the runs.
fn collect(
    settings: &LatticeSettings,
    tasks: &[Task],
    outcomes: &[Outcome],
) -> Result<(LatticeSweep, Vec<Series>)> {
    let bound = axes(settings).locked_within.unwrap_or(LOCKED_WITHIN);
    let mut runs = Vec::with_capacity(tasks.len());
    let mut by_condition: Vec<Condition> = Vec::new();
    for (task, outcome) in tasks.iter().zip(outcomes) {
        // The first seed of every condition comes first, in the order of the conditions.
        if task.condition == by_condition.len() {
            by_condition.push(Condition::new(task)?);
        }
        let condition = &mut by_condition[task.condition];
        match outcome {
            Outcome::Done(outcome) => {
                let rows: Vec<LogRow> = log::read(&task.directory.join("log.csv"))?;
                let (series, coherence) = Series::of_run(task, &rows, bound)?;
                let row = RunRow::new(task, outcome, &rows, &series, coherence)?;
                condition.add(row.clone(), series)?;
                runs.push(row);
            }
            Outcome::Failed(reason) => {
                condition.failed += 1;
                runs.push(RunRow::failed(task, reason));
            }
        }
    }
    let mut conditions = Vec::with_capacity(by_condition.len());
    let mut series = Vec::with_capacity(by_condition.len());
    for condition in by_condition {
        conditions.push(ConditionRow::new(
            condition.parameters,
            &condition.runs,
            condition.failed,
            &condition.series,
        )?);
        series.push(condition.series);
    }
    let sweep = LatticeSweep {
        version: env!("CARGO_PKG_VERSION").into(),
        settings: settings.clone(),
        conditions,
        runs,
    };
    Ok((sweep, series))
}

/// The runs of one r0 and κ.
struct Condition {
    /// Values of r0 and κ.
    parameters: [f64; 2],
    /// Rows of the runs that were completed.
    runs: Vec<RunRow>,
    /// Number of runs that were not completed.
    failed: usize,
    series: Series,
}

impl Condition {
    fn new(task: &Task) -> Result<Self> {
        Ok(Self {
            parameters: [task.settings.r0, task.settings.kappa],
            runs: Vec::new(),
            failed: 0,
            series: Series::empty(task)?,
        })
    }

    fn add(&mut self, run: RunRow, series: Series) -> Result<()> {
        if self.runs.is_empty() {
            self.series = series;
        } else {
            self.series.merge(series, self.runs.len())?;
        }
        self.runs.push(run);
        Ok(())
    }
}

fn write_results(sweep: &LatticeSweep, series: &[Series], directory: &Path) -> Result<()> {
    let json = serde_json::to_string_pretty(sweep).context("the result cannot be serialised")?;
    let tables = [
        ("lattice.csv", conditions_to_csv(&sweep.conditions)?),
        ("runs.csv", runs_to_csv(&sweep.runs)?),
        (
            "crossings.csv",
            crossings_to_csv(&sweep.conditions, series)?,
        ),
        (
            "correlation.csv",
            correlations_to_csv(&sweep.conditions, series)?,
        ),
    ];
    for (name, text) in tables {
        write_bytes(&directory.join(name), text.as_bytes())?;
    }
    write_atomically(&directory.join("lattice.json"), |file| {
        writeln!(file, "{json}")
    })?;
    figures::write(sweep, series, directory)
}
