//! `protomer tune`: a random search for the shape of the network, with early stopping of the
//! losers.

use super::device::DeviceArgs;
use super::execution::ExecutionArgs;
use super::scheduler::SchedulerArgs;
use super::train::TaskArgs;
use super::{Global, Outcome, output};
use anyhow::Result;
use clap::Args;
use protomer::learning::train::{TrainSettings, channels_of, open_set};
use protomer::learning::tune::{ShardState, Trial, TuneSettings, tune_in, tune_shard};
use protomer_results::{End, Shard};
use std::path::{Path, PathBuf};

/// Search for the network that predicts best: blocks, kernels, channels, learning rate. The same
/// command continues it.
#[derive(Debug, Args)]
pub struct TuneArgs {
    /// Set of voxels (zarr), as 'protomer voxelize' makes it.
    set: PathBuf,
    /// Networks to try.
    #[arg(long, default_value_t = 27)]
    trials: usize,
    /// Passes over the training part for those that are never stopped.
    #[arg(long, default_value_t = 27)]
    epochs: usize,
    /// Seed of draws, split, weights, order and rotations.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Try subsets of the channels as well.
    #[arg(long)]
    vary_channels: bool,
    /// Directory of the results.
    #[arg(short, long)]
    output: PathBuf,
    /// Only a part of the trials, such as 2/8, beside other processes in the same directory, until
    /// other parts have to come as far; the command without it collects them.
    #[arg(long, value_parser = Shard::parse, default_value = "1/1")]
    shard: Shard,
    #[command(flatten)]
    scheduler: SchedulerArgs,
    #[command(flatten)]
    task: TaskArgs,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    execution: ExecutionArgs,
}

impl TuneArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        self.scheduler.check()?;
        let device = self.device.open()?;
        let execution = self.execution.execution(global)?;
        let (source, set) = open_set(&self.set)?;
        let mut base = TrainSettings::of_set(source, channels_of(&set))?;
        self.task.override_in(&mut base)?;
        base.training.seed = self.seed;
        base.split_seed = base.split_seed.or(Some(self.seed));
        let settings = TuneSettings {
            trials: self.trials,
            epochs: self.epochs,
            seed: self.seed,
            vary_channels: self.vary_channels,
            base,
        };
        if !self.shard.is_whole() {
            let end = tune_shard(
                &settings,
                &set,
                &self.output,
                self.shard,
                &device,
                &execution,
            )?;
            drop(execution);
            return self.report_shard(end, global);
        }
        let end = tune_in(&settings, &set, &self.output, &device, &execution)?;
        drop(execution);
        let End::Finished(trials) = end else {
            global.say(&format!(
                "stopped; the same command continues {}",
                self.output.display()
            ));
            return Ok(Outcome::Stopped);
        };
        report(global, &trials, &self.set, &self.output)?;
        Ok(Outcome::Done)
    }

    fn report_shard(&self, end: End<ShardState>, global: &Global) -> Result<Outcome> {
        let Shard { index, of } = self.shard;
        let state = match end {
            End::Stopped => {
                global.say(&format!(
                    "stopped; the same command continues part {index} of {of}"
                ));
                return Ok(Outcome::Stopped);
            }
            End::Finished(ShardState::Waiting) => {
                "waits for the others; then the same command goes on"
            }
            End::Finished(ShardState::Complete) => {
                "all trials are done; without --shard: the table"
            }
        };
        if global.json {
            let finished = end == End::Finished(ShardState::Complete);
            output::json(&serde_json::json!({ "shard": index, "of": of, "finished": finished }))?;
        } else {
            global.say(&format!("part {index} of {of}: {state}"));
        }
        Ok(Outcome::Done)
    }
}

/// Rows shown on the terminal.
const SHOWN: usize = 10;

fn report(global: &Global, trials: &[Trial], set: &Path, directory: &Path) -> Result<()> {
    let best = directory.join("best.toml");
    if global.json {
        return output::json(&serde_json::json!({ "best": best, "trials": trials }));
    }
    if global.quiet {
        return Ok(());
    }
    let mut rows = vec![
        [
            "trial",
            "epochs",
            "validation loss (nats)",
            "balanced accuracy",
            "widths",
        ]
        .map(String::from)
        .to_vec(),
    ];
    for trial in trials.iter().take(SHOWN) {
        let widths: Vec<String> = trial
            .settings
            .blocks
            .iter()
            .map(|block| block.width.to_string())
            .collect();
        let loss = trial
            .validation_loss_nats
            .map_or_else(|| "diverged".into(), |loss| format!("{loss:.4}"));
        let accuracy = trial
            .validation_balanced_accuracy
            .map_or_else(String::new, |value| format!("{value:.3}"));
        rows.push(vec![
            trial.number.to_string(),
            trial.epochs.to_string(),
            loss,
            accuracy,
            widths.join("-"),
        ]);
    }
    output::text(&output::table(&rows))?;
    if trials.len() > SHOWN {
        output::text(&format!(
            "the best {SHOWN} of {}; all in {}/trials.csv",
            trials.len(),
            directory.display()
        ))?;
    }
    output::text(&format!(
        "the validation part chose the best, so its scores there are too good; for scores on the test part:\n\
         protomer train {} --config {} -o DIRECTORY",
        set.display(),
        best.display()
    ))
}
