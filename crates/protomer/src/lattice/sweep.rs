//! A sweep of lattices: every r0 with every κ, once per seed, on all threads, resumable; tables and
//! figures at the end.
//!
//! ```text
//! DIR/run.toml  run.json  lattice.csv  runs.csv  crossings.csv  lattice.json  *.svg  *.png
//! DIR/r0_0.2_kappa_0/seed_1/   a run directory each, with lyapunov.json if that is measured
//! ```

use super::directory::{enter, identity, record};
use super::exponent::{self, Exponent};
use super::log::{LogRow, read_log};
use super::run::{LatticeEnd, LatticeResult, run_lattice};
use super::settings::{LatticeSettings, SweepAxes};
use super::start::network;
use super::sweep_figures;
use super::sweep_table::{ConditionRow, RunRow, conditions_to_csv, crossings_to_csv, runs_to_csv};
use super::trajectory::read_states;
use crate::run::{Execution, LATTICE_SWEEP, read_record};
use anyhow::{Context, Result, bail};
use protomer_crystal::analysis::crossings::{Crossing, crossings};
use protomer_crystal::analysis::lyapunov::LyapunovSettings;
use protomer_crystal::analysis::synchronisation::{
    Synchronisation, root_mean_square_difference, staggered,
};
use protomer_io::atomic::write_atomically;
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::FRAC_PI_4;
use std::path::{Path, PathBuf};

/// A run directory with more folders than this serves nobody.
const MOST_RUNS: usize = 100_000;
/// Files of a sweep beside its settings; the folders of its runs come on top.
const RESULTS: [&str; 6] = [
    "run.json",
    "lattice.csv",
    "runs.csv",
    "crossings.csv",
    "lattice.json",
    "report.html",
];

/// What a sweep leaves behind.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LatticeSweep {
    /// Version of the program.
    pub version: String,
    /// The resolved settings.
    pub settings: LatticeSettings,
    /// One row per r0 and κ.
    pub conditions: Vec<ConditionRow>,
    /// One row per run.
    pub runs: Vec<RunRow>,
}

/// How a sweep ended.
#[derive(Debug, Clone, PartialEq)]
pub enum LatticeSweepEnd {
    /// Everything is done.
    Finished(Box<LatticeSweep>),
    /// It was asked to stop; the same command goes on.
    Stopped,
}

/// One run of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// Index of the condition.
    pub condition: usize,
    /// The settings of the run.
    pub settings: LatticeSettings,
    /// Where it is.
    pub directory: PathBuf,
}

/// What a run left behind.
#[derive(Debug, Clone, PartialEq)]
pub struct RunOutcome {
    /// Its end.
    pub result: LatticeResult,
    /// Its Lyapunov exponent, if the sweep measures it.
    pub exponent: Option<Exponent>,
}

/// The course of a run or, where several are merged, of all runs of a condition.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Time, root mean square difference of two angles, averaged over runs.
    pub phase_differences: Vec<[f64; 2]>,
    /// Strains along x and y since the last row of the log.
    pub strains: Vec<[f64; 2]>,
    /// exp i(θ_a - θ_b).
    pub synchronisation: Synchronisation,
    /// Passages of the checkerboard mode through the open state, run by run.
    pub crossings: Vec<Vec<Crossing>>,
}

/// The axes with what the settings say where they are empty.
pub fn axes(settings: &LatticeSettings) -> SweepAxes {
    let axes = settings.sweep.clone().unwrap_or_default();
    let or = |values: Vec<f64>, value: f64| {
        if values.is_empty() {
            vec![value]
        } else {
            values
        }
    };
    SweepAxes {
        r0: or(axes.r0, settings.r0),
        kappa: or(axes.kappa, settings.kappa),
        seeds: if axes.seeds.is_empty() {
            vec![settings.seed]
        } else {
            axes.seeds
        },
        lyapunov: axes.lyapunov,
    }
}

/// Every run of the sweep, the first seed of every condition first: an interrupted sweep has
/// something everywhere early.
///
/// # Errors
/// For too many runs, or settings of a run that make no sense.
pub fn tasks(settings: &LatticeSettings, directory: &Path) -> Result<Vec<Task>> {
    let axes = axes(settings);
    let conditions: Vec<(f64, f64)> = axes
        .r0
        .iter()
        .flat_map(|r0| axes.kappa.iter().map(move |kappa| (*r0, *kappa)))
        .collect();
    if conditions.len().saturating_mul(axes.seeds.len()) > MOST_RUNS {
        bail!(
            "{} conditions with {} seeds each are too many; ask for at most {MOST_RUNS} runs",
            conditions.len(),
            axes.seeds.len()
        );
    }
    let mut tasks = Vec::new();
    for seed in &axes.seeds {
        for (condition, (r0, kappa)) in conditions.iter().enumerate() {
            let settings = LatticeSettings {
                r0: *r0,
                kappa: *kappa,
                seed: *seed,
                sweep: None,
                ..settings.clone()
            };
            settings.check()?;
            let directory = directory
                .join(format!("r0_{r0}_kappa_{kappa}"))
                .join(format!("seed_{seed}"));
            if tasks.iter().any(|task: &Task| task.directory == directory) {
                bail!("r0 = {r0}, κ = {kappa}, seed {seed} is listed twice; list each once");
            }
            tasks.push(Task {
                condition,
                settings,
                directory,
            });
        }
    }
    Ok(tasks)
}

/// Runs or continues a sweep in a directory. `advanced` hears of every run that ended.
///
/// # Errors
/// For settings that make no sense, a directory that holds another sweep, and the first run that
/// fails; the others stop at their next step then, what they did is kept, and `run.json` says what
/// happened.
pub fn run_sweep(
    settings: &LatticeSettings,
    path: &Path,
    execution: &Execution,
    advanced: &(dyn Fn() + Sync),
) -> Result<LatticeSweepEnd> {
    let tasks = tasks(settings, path)?;
    let identity = identity(settings)?;
    let folders: Vec<String> = folders(settings);
    let results: Vec<&str> = RESULTS
        .iter()
        .copied()
        .chain(folders.iter().map(String::as_str))
        .collect();
    let entered = enter(
        path,
        settings,
        LATTICE_SWEEP,
        &results,
        execution.start_anew,
    )?;
    // A finished sweep stays one, whatever becomes of a second look at it.
    let was_done =
        !entered.settings_are_new() && read_record(path)?.is_some_and(|present| present.is_done());
    let end = to_the_end(settings, &tasks, path, execution, advanced);
    let record = |exit_reason: &str| {
        record(
            "lattice sweep",
            &identity,
            exit_reason,
            serde_json::Value::Null,
        )
    };
    match &end {
        Ok(LatticeSweepEnd::Finished(_)) => record("done").write(path)?,
        Ok(LatticeSweepEnd::Stopped) => record("stopped")
            .stopped_by(&execution.interrupt)
            .write(path)?,
        Err(_) if was_done => {}
        // The error is what counts; on a full disk there may be no room for the record either.
        Err(error) => drop(record(&format!("{error:#}")).write(path)),
    }
    end
}

/// Runs everything, and writes the tables and the figures.
fn to_the_end(
    settings: &LatticeSettings,
    tasks: &[Task],
    path: &Path,
    execution: &Execution,
    advanced: &(dyn Fn() + Sync),
) -> Result<LatticeSweepEnd> {
    // The folders are gone already where a new start was asked for.
    let execution = Execution {
        start_anew: false,
        ..execution.clone()
    };
    let lyapunov = axes(settings).lyapunov;
    let one = |task: &Task| -> Result<Option<RunOutcome>> {
        if execution.interrupt.is_requested() {
            return Ok(None);
        }
        let outcome = run_task(task, lyapunov.as_ref(), &execution);
        if outcome.is_err() {
            execution.interrupt.request_after_failure();
        }
        advanced();
        outcome.with_context(|| task.directory.display().to_string())
    };
    let outcomes: Vec<Result<Option<RunOutcome>>> = tasks.par_iter().map(one).collect();
    let outcomes = outcomes.into_iter().collect::<Result<Vec<_>>>()?;
    let Some(outcomes) = outcomes.into_iter().collect::<Option<Vec<RunOutcome>>>() else {
        return Ok(LatticeSweepEnd::Stopped);
    };
    let (sweep, series) = collect(settings, tasks, &outcomes)?;
    write_results(&sweep, &series, path)?;
    Ok(LatticeSweepEnd::Finished(Box::new(sweep)))
}

/// One run of the sweep, and its exponent; `None` if it was interrupted.
fn run_task(
    task: &Task,
    lyapunov: Option<&LyapunovSettings>,
    execution: &Execution,
) -> Result<Option<RunOutcome>> {
    std::fs::create_dir_all(&task.directory)
        .with_context(|| format!("cannot make the directory {}", task.directory.display()))?;
    let end = run_lattice(&task.settings, &task.directory, execution, &|_| {})?;
    let LatticeEnd::Finished(result) = end else {
        return Ok(None);
    };
    let Some(lyapunov) = lyapunov else {
        let exponent = None;
        return Ok(Some(RunOutcome { result, exponent }));
    };
    let interrupt = &execution.interrupt;
    let exponent = exponent::measure(&task.settings, lyapunov, &task.directory, interrupt)?;
    Ok(exponent.map(|exponent| RunOutcome {
        result,
        exponent: Some(exponent),
    }))
}

fn folders(settings: &LatticeSettings) -> Vec<String> {
    let axes = axes(settings);
    let of = |r0: f64| {
        axes.kappa
            .iter()
            .map(move |kappa| format!("r0_{r0}_kappa_{kappa}"))
    };
    axes.r0
        .iter()
        .flat_map(|r0| of(*r0).collect::<Vec<_>>())
        .collect()
}

/// Reads what the runs wrote.
fn collect(
    settings: &LatticeSettings,
    tasks: &[Task],
    outcomes: &[RunOutcome],
) -> Result<(LatticeSweep, Vec<Series>)> {
    let mut runs = Vec::with_capacity(tasks.len());
    let mut by_condition: Vec<Condition> = Vec::new();
    for (task, outcome) in tasks.iter().zip(outcomes) {
        let rows = read_log(&task.directory.join("log.csv"))?;
        let series = Series::of_run(task, &rows)?;
        let row = RunRow::new(task, outcome, &rows, &series)?;
        // The first seed of every condition comes first, in the order of the conditions.
        match by_condition.get_mut(task.condition) {
            Some(condition) => condition.add(row.clone(), series)?,
            None => by_condition.push(Condition::new(row.clone(), series)),
        }
        runs.push(row);
    }
    let mut conditions = Vec::with_capacity(by_condition.len());
    let mut series = Vec::with_capacity(by_condition.len());
    for condition in by_condition {
        conditions.push(ConditionRow::new(&condition.runs, &condition.series)?);
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
    runs: Vec<RunRow>,
    series: Series,
}

impl Condition {
    fn new(run: RunRow, series: Series) -> Self {
        Self {
            runs: vec![run],
            series,
        }
    }

    fn add(&mut self, run: RunRow, series: Series) -> Result<()> {
        self.series.merge(series, self.runs.len())?;
        self.runs.push(run);
        Ok(())
    }
}

impl Series {
    /// From the log and the trajectory of a run.
    fn of_run(task: &Task, rows: &[LogRow]) -> Result<Self> {
        let network = network(&task.settings)?;
        let mut synchronisation = Synchronisation::new(network.squares.len());
        let mut phase_differences = Vec::new();
        if task.settings.trajectory_every > 0 {
            for (time, positions) in read_states(&task.directory.join("trajectory.gsd"))? {
                let angles = staggered(&network, &positions);
                synchronisation.push(&angles)?;
                phase_differences.push([time, root_mean_square_difference(&angles)]);
            }
        }
        let amplitudes: Vec<[f64; 2]> = rows
            .iter()
            .map(|row| [row.time, row.checkerboard])
            .collect();
        let strains = rows.iter().skip(1);
        Ok(Self {
            phase_differences,
            strains: strains
                .map(|row| [row.step_strain_xx, row.step_strain_yy])
                .collect(),
            synchronisation,
            crossings: vec![crossings(&amplitudes, FRAC_PI_4)],
        })
    }

    /// Adds a run to so many others. Phase differences are a running mean; frames of equal number
    /// are compared, as time steps may differ a little.
    fn merge(&mut self, other: Self, earlier_runs: usize) -> Result<()> {
        let runs = earlier_runs as f64 + 1.0;
        let frames = self.phase_differences.iter_mut();
        for (mean, [_, new]) in frames.zip(&other.phase_differences) {
            mean[1] += (new - mean[1]) / runs;
        }
        self.strains.extend(other.strains);
        self.synchronisation.merge(&other.synchronisation)?;
        self.crossings.extend(other.crossings);
        Ok(())
    }
}

fn write_results(sweep: &LatticeSweep, series: &[Series], directory: &Path) -> Result<()> {
    let json = serde_json::to_string_pretty(sweep).context("the result cannot be written down")?;
    let tables = [
        ("lattice.csv", conditions_to_csv(&sweep.conditions)?),
        ("runs.csv", runs_to_csv(&sweep.runs)?),
        (
            "crossings.csv",
            crossings_to_csv(&sweep.conditions, series)?,
        ),
    ];
    for (name, text) in tables {
        write_atomically(&directory.join(name), |file| {
            file.write_all(text.as_bytes())
        })?;
    }
    write_atomically(&directory.join("lattice.json"), |file| {
        writeln!(file, "{json}")
    })?;
    sweep_figures::write(sweep, series, directory)
}
