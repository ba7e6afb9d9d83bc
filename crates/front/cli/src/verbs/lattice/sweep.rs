//! `protomer lattice sweep`: rod lengths, κ and seeds.

use super::run::{DirectoryArgs, LatticeFlags};
use crate::flags::override_with;
use crate::flags::scheduler::PartArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, bail};
use clap::Args;
use protomer_linkage_verbs::lattice::settings::LatticeSettings;
use protomer_linkage_verbs::lattice::sweep::{axes, run_shard, run_sweep, tasks};
use protomer_results::End;

/// Run lattices of several rod lengths and κ, once per seed, on all threads, with tables and
/// figures. The same command continues a sweep that was stopped.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "lattice sweep --ns 4 --r0-list 0.05,0.5,1 --kappa-list 0,10 --seeds 3 -o sweep",
    "lattice sweep --ns 2 --r0-list 0.25,0.5 --seeds 2 --lyapunov -o chaos"
))]
#[group(id = "LatticeSweepResult")]
pub struct SweepArgs {
    #[command(flatten)]
    directory: DirectoryArgs,
    /// Rod lengths, separated by commas [default: the [sweep] of the configuration].
    #[arg(long, value_delimiter = ',')]
    r0_list: Vec<f64>,
    /// κ, separated by commas.
    #[arg(long, value_delimiter = ',')]
    kappa_list: Vec<f64>,
    /// Runs per rod length and κ: seeds 1, 2, ...
    #[arg(long)]
    seeds: Option<u64>,
    /// Measure the maximal Lyapunov exponent of every run.
    #[arg(long)]
    lyapunov: bool,
    /// Intervals over which the exponent is averaged [default: 200].
    #[arg(long, requires = "lyapunov")]
    lyapunov_intervals: Option<usize>,
    #[command(flatten)]
    part: PartArgs,
    /// Phases are locked while all their differences are below this angle, rad [default: 0.5].
    #[arg(long)]
    locked_within: Option<f64>,
    #[command(flatten)]
    settings: LatticeFlags,
}

/// Upper limit for the number of seeds.
const MOST_SEEDS: u64 = 10_000;

impl SweepArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        self.part.check()?;
        let settings = self.settings()?;
        let directory = &self.directory.output;
        let conditions = axes(&settings);
        front.say(&format!(
            "{} × {} squares; rod lengths: {}, κ: {}, seeds: {}, runs: {}",
            settings.rows,
            settings.columns,
            conditions.r0.len(),
            conditions.kappa.len(),
            conditions.seeds.len(),
            tasks(&settings, directory)?.len()
        ));
        let execution = self.directory.execution(front)?;
        if let Some(shard) = self.part.shard() {
            let end = run_shard(&settings, directory, shard, &execution)?;
            return Ok(Reply::of_part(end, shard, ["run", "runs"]));
        }
        let end = run_sweep(&settings, directory, &execution)?;
        let directory = directory.display();
        Ok(match end {
            End::Finished(sweep) => {
                let failed = sweep.failed_runs();
                let some_failed = !failed.is_empty();
                let warning = sweep.energy_warning();
                Reply::from_answer(sweep)
                    .with_note(format!("tables and figures: {directory}"))
                    .with_notes(warning.map(|warning| format!("warning: {warning}")))
                    .with_errors(failed)
                    .partial_if(some_failed)
            }
            End::Stopped => {
                Reply::stopped(format!("stopped; the same command continues {directory}"))
            }
        })
    }

    /// The settings of the configuration and the flags, with the varied parameters.
    fn settings(&self) -> Result<LatticeSettings> {
        let mut settings = self.settings.settings(&self.directory)?;
        let mut sweep = settings.sweep.clone().unwrap_or_default();
        if !self.r0_list.is_empty() {
            sweep.r0.clone_from(&self.r0_list);
        }
        if !self.kappa_list.is_empty() {
            sweep.kappa.clone_from(&self.kappa_list);
        }
        match self.seeds {
            Some(0) => bail!("--seeds is 0; give at least 1"),
            Some(seeds) if seeds > MOST_SEEDS => {
                bail!("--seeds is {seeds}; give at most {MOST_SEEDS}")
            }
            Some(seeds) => sweep.seeds = (1..=seeds).collect(),
            None => {}
        }
        if self.locked_within.is_some() {
            sweep.locked_within = self.locked_within;
        }
        if self.lyapunov {
            let lyapunov = sweep.lyapunov.get_or_insert_default();
            override_with(&mut lyapunov.intervals, self.lyapunov_intervals);
        }
        settings.sweep = Some(sweep);
        settings.check()?;
        Ok(settings)
    }
}
