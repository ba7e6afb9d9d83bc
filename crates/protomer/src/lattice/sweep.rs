//! A sweep of lattices: every r0 with every κ, once per seed, on all threads, resumable; tables and
//! figures at the end.
//!
//! ```text
//! DIR/run.toml  run.json  lattice.csv  runs.csv  crossings.csv  lattice.json  *.svg  *.png
//! DIR/r0_0.2_kappa_0/seed_1/   a run directory each, with lyapunov.json if that is measured
//! ```

use super::exponent::{self, Exponent};
use super::log::LogRow;
use super::run::{LatticeResult, run_lattice};
use super::settings::{LatticeSettings, SweepAxes};
use super::start::network;
use super::sweep_figures;
use super::sweep_table::{
    ConditionRow, Estimate, RunRow, conditions_to_csv, crossings_to_csv, runs_to_csv,
};
use super::trajectory::read_states;
use crate::answer::{Answer, columns};
use anyhow::{Context, Error, Result, bail};
use protomer_crystal::analysis::crossings::{Crossing, crossings};
use protomer_crystal::analysis::lyapunov::LyapunovSettings;
use protomer_crystal::analysis::synchronisation::{
    Synchronisation, root_mean_square_difference, staggered,
};
use protomer_io::atomic::write_atomically;
use protomer_results::{
    Campaign, End, Execution, Layout, ResultKind, ResultsDirectory, Work, conduct, log, settings,
};
use serde::Serialize;
use std::f64::consts::FRAC_PI_4;
use std::path::{Path, PathBuf};

/// Upper limit for the number of runs, each of which has a folder.
const MOST_RUNS: usize = 100_000;
/// The directory of a sweep.
const LAYOUT: Layout = Layout {
    kind: ResultKind::LatticeSweep,
    settings: super::directory::SETTINGS,
    results: &[
        "run.json",
        "lattice.csv",
        "runs.csv",
        "crossings.csv",
        "lattice.json",
        "report.html",
    ],
    is_result: is_condition,
};

/// The result of a sweep.
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

impl Answer for LatticeSweep {
    fn text(&self) -> String {
        let mut heading = vec![
            "r0",
            "κ",
            "runs",
            "Poisson's ratio",
            "r²",
            "σ_max",
            "σ of checkerboard",
            "synchronisation",
        ];
        let has_exponents = axes(&self.settings).lyapunov.is_some();
        if has_exponents {
            heading.push("λ_max");
        }
        let mut rows: Vec<Vec<String>> = vec![heading.into_iter().map(str::to_owned).collect()];
        for row in &self.conditions {
            let mut cells = vec![
                format!("{:.4}", row.r0),
                row.kappa.to_string(),
                row.runs.to_string(),
                shown(row.poisson_ratio),
                shown(row.r_squared),
                shown(row.largest_spread),
                shown(row.checkerboard_deviation),
                shown(row.synchronisation),
            ];
            if has_exponents {
                cells.push(shown(row.lyapunov_exponent));
            }
            rows.push(cells);
        }
        columns(&rows)
    }
}

fn shown(Estimate { mean, error }: Estimate) -> String {
    match (mean.is_finite(), error.is_finite()) {
        (false, _) => "-".to_owned(),
        (true, false) => format!("{mean:.3}"),
        (true, true) => format!("{mean:.3} ± {error:.3}"),
    }
}

/// One run of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// Index of the condition.
    pub condition: usize,
    /// The settings of the run.
    pub settings: LatticeSettings,
    /// Its directory.
    pub directory: PathBuf,
}

/// The result of one run of the sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct RunOutcome {
    /// Its result.
    pub result: LatticeResult,
    /// Its Lyapunov exponent, if measured.
    pub exponent: Option<Exponent>,
}

/// The time series of a run or, once merged, of all runs of a condition.
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

/// The axes, with empty ones replaced by the value of the settings.
pub fn axes(settings: &LatticeSettings) -> SweepAxes {
    let axes = settings.sweep.clone().unwrap_or_default();
    SweepAxes {
        r0: values_or(axes.r0, settings.r0),
        kappa: values_or(axes.kappa, settings.kappa),
        seeds: values_or(axes.seeds, settings.seed),
        lyapunov: axes.lyapunov,
    }
}

fn values_or<T>(values: Vec<T>, default: T) -> Vec<T> {
    match values.is_empty() {
        true => vec![default],
        false => values,
    }
}

/// All runs of the sweep, ordered by seed first, so that an interrupted sweep covers all
/// conditions early.
///
/// # Errors
/// For too many runs, or invalid settings of a run.
pub fn tasks(settings: &LatticeSettings, directory: &Path) -> Result<Vec<Task>> {
    let axes = axes(settings);
    let mut conditions = Vec::new();
    for r0 in &axes.r0 {
        for kappa in &axes.kappa {
            conditions.push((*r0, *kappa));
        }
    }
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

/// Whether this is the folder of the runs of one condition: `r0_0.2_kappa_0`.
fn is_condition(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let Some(axes) = name.strip_prefix("r0_") else {
        return false;
    };
    let Some((r0, kappa)) = axes.split_once("_kappa_") else {
        return false;
    };
    path.is_dir() && r0.parse::<f64>().is_ok() && kappa.parse::<f64>().is_ok()
}

/// Runs or continues a sweep in a directory.
///
/// # Errors
/// For invalid settings, a directory that holds other work, or a run that fails: the others
/// then stop at their next step, keep their progress, and `run.json` records the error.
pub fn run_sweep(
    settings: &LatticeSettings,
    path: &Path,
    execution: &Execution,
) -> Result<End<LatticeSweep>> {
    let sweep = Sweep {
        settings,
        lyapunov: axes(settings).lyapunov,
        tasks: tasks(settings, path)?,
        identity: settings::identity(settings, "")?,
        path,
    };
    let entered = ResultsDirectory::enter(path, &LAYOUT, settings, &sweep.identity, execution)?;
    execution.progress.begin(sweep.tasks.len() as u64, "runs");
    conduct(&sweep, &entered, execution)
}

struct Sweep<'a> {
    settings: &'a LatticeSettings,
    tasks: Vec<Task>,
    identity: String,
    path: &'a Path,
    lyapunov: Option<LyapunovSettings>,
}

impl Sweep<'_> {
    /// Does one run of the sweep, and measures its exponent if requested.
    fn run_task(
        &self,
        task: &Task,
        directory: &Path,
        execution: &Execution,
    ) -> Result<End<RunOutcome>> {
        let End::Finished(result) = run_lattice(&task.settings, directory, execution)? else {
            return Ok(End::Stopped);
        };
        let Some(lyapunov) = &self.lyapunov else {
            let exponent = None;
            return Ok(End::Finished(RunOutcome { result, exponent }));
        };
        let end = exponent::measure(&task.settings, lyapunov, directory, &execution.interrupt)?;
        Ok(end.map(|exponent| RunOutcome {
            result,
            exponent: Some(exponent),
        }))
    }
}

impl Campaign for Sweep<'_> {
    type Task = Task;
    type Part = RunOutcome;
    type Answer = LatticeSweep;
    type Error = Error;

    fn work(&self) -> Work {
        Work {
            kind: ResultKind::LatticeSweep,
            verb: "lattice sweep",
            identity: self.identity.clone(),
            input_sha256: String::new(),
        }
    }

    fn tasks(&self) -> &[Task] {
        &self.tasks
    }

    fn directory(&self, task: &Task) -> PathBuf {
        task.directory.clone()
    }

    fn run(&self, task: &Task, directory: &Path, execution: &Execution) -> Result<End<RunOutcome>> {
        let end = self.run_task(task, directory, &execution.of_part());
        execution.progress.advance(1);
        end.with_context(|| directory.display().to_string())
    }

    /// Makes the tables and the figures.
    fn collect(&self, outcomes: Vec<RunOutcome>) -> Result<LatticeSweep> {
        let (sweep, series) = collect(self.settings, &self.tasks, &outcomes)?;
        write_results(&sweep, &series, self.path)?;
        Ok(sweep)
    }
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
        let rows: Vec<LogRow> = log::read(&task.directory.join("log.csv"))?;
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
    /// Reads the log and the trajectory of a run.
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
        let (mut amplitudes, mut strains) = (Vec::new(), Vec::new());
        for (number, row) in rows.iter().enumerate() {
            amplitudes.push([row.time, row.checkerboard]);
            if number > 0 {
                strains.push([row.step_strain_xx, row.step_strain_yy]);
            }
        }
        Ok(Self {
            phase_differences,
            strains,
            synchronisation,
            crossings: vec![crossings(&amplitudes, FRAC_PI_4)],
        })
    }

    /// Merges a run into the mean over `runs` others. Phase differences are a running mean over
    /// frames of equal index, because time steps may differ slightly.
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
    let json = serde_json::to_string_pretty(sweep).context("the result cannot be serialised")?;
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
