//! `protomer lattice sweep`: rod lengths, κ and seeds.

use super::super::{Global, Outcome, output};
use super::run::{DirectoryArgs, SettingsArgs};
use anyhow::{Result, bail};
use clap::Args;
use protomer::lattice::sweep::{LatticeSweep, axes, run_sweep, tasks};
use protomer::lattice::sweep_table::Estimate;
use protomer_results::End;

/// Run lattices of several rod lengths and κ, once per seed, on all threads: tables with error bars
/// and figures. The same command continues a sweep that was stopped.
#[derive(Debug, Args)]
pub struct SweepArgs {
    #[command(flatten)]
    directory: DirectoryArgs,
    /// Rod lengths, separated by commas [default: the [sweep] of the configuration].
    #[arg(long, value_delimiter = ',', allow_negative_numbers = true)]
    r0_list: Vec<f64>,
    /// κ, separated by commas.
    #[arg(long, value_delimiter = ',', allow_negative_numbers = true)]
    kappa_list: Vec<f64>,
    /// Runs per rod length and κ: seeds 1, 2, ...
    #[arg(long)]
    seeds: Option<u64>,
    #[command(flatten)]
    settings: SettingsArgs,
}

/// As many as anyone needs.
const MOST_SEEDS: u64 = 10_000;

impl SweepArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
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
        settings.sweep = Some(sweep);
        let runs = tasks(&settings, &self.directory.output)?.len();
        let conditions = axes(&settings);
        global.say(&format!(
            "{} × {} squares; rod lengths: {}, κ: {}, seeds: {}, runs: {runs}",
            settings.rows,
            settings.columns,
            conditions.r0.len(),
            conditions.kappa.len(),
            conditions.seeds.len()
        ));
        let execution = self.directory.execution(global)?;
        let end = run_sweep(&settings, &self.directory.output, &execution)?;
        drop(execution);
        match end {
            End::Stopped => {
                global.say(&format!(
                    "stopped; the same command continues {}",
                    self.directory.output.display()
                ));
                Ok(Outcome::Stopped)
            }
            End::Finished(sweep) => {
                self.report(&sweep, global)?;
                Ok(Outcome::Done)
            }
        }
    }

    fn report(&self, sweep: &LatticeSweep, global: &Global) -> Result<()> {
        if global.json {
            return output::json(sweep);
        }
        if global.quiet {
            return Ok(());
        }
        let heading = [
            "r0",
            "κ",
            "runs",
            "Poisson's ratio",
            "r²",
            "σ_max",
            "σ of checkerboard",
            "synchronisation",
        ];
        let mut table = vec![heading.map(str::to_owned).to_vec()];
        let show = |Estimate { mean, error }: Estimate| match (mean.is_finite(), error.is_finite())
        {
            (false, _) => "-".to_owned(),
            (true, false) => format!("{mean:.3}"),
            (true, true) => format!("{mean:.3} ± {error:.3}"),
        };
        for row in &sweep.conditions {
            table.push(vec![
                format!("{:.4}", row.r0),
                row.kappa.to_string(),
                row.runs.to_string(),
                show(row.poisson_ratio),
                show(row.r_squared),
                show(row.largest_spread),
                show(row.checkerboard_deviation),
                show(row.synchronisation),
            ]);
        }
        output::text(&output::table(&table))?;
        global.say(&format!(
            "tables and figures: {}",
            self.directory.output.display()
        ));
        Ok(())
    }
}
