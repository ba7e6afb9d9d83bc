//! The runs of a sweep, and where they are.

use crate::lattice::settings::{LatticeSettings, SweepAxes};
use anyhow::{Result, bail};
use std::path::{Path, PathBuf};

/// Upper limit for the number of runs, each of which has a folder.
const MOST_RUNS: usize = 100_000;

/// One run of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// Index of the condition.
    pub condition: usize,
    /// The settings of the run.
    pub settings: LatticeSettings,
    /// Directory of the run.
    pub directory: PathBuf,
}

/// The axes, with empty ones replaced by the value of the settings.
pub fn axes(settings: &LatticeSettings) -> SweepAxes {
    let axes = settings.sweep.clone().unwrap_or_default();
    SweepAxes {
        r0: values_or(axes.r0, settings.r0),
        kappa: values_or(axes.kappa, settings.kappa),
        seeds: values_or(axes.seeds, settings.seed),
        lyapunov: axes.lyapunov,
        locked_within: axes.locked_within,
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
pub(super) fn is_condition(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let Some(axes) = name.strip_prefix("r0_") else {
        return false;
    };
    let Some((r0, kappa)) = axes.split_once("_kappa_") else {
        return false;
    };
    path.is_dir() && r0.parse::<f64>().is_ok() && kappa.parse::<f64>().is_ok()
}
