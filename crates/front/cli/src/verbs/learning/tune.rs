//! `protomer tune`: a random search for the shape of the network, with early stopping of
//! the worst trials.

use super::labels::LabelArgs;
use super::train::TaskArgs;
use crate::flags::device::DeviceArgs;
use crate::flags::execution::ExecutionArgs;
use crate::flags::scheduler::SchedulerArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_common::range;
use protomer_learn_verbs::learning::train::{Source, TrainSettings, channels_of, open_set};
use protomer_learn_verbs::learning::tune::{TuneReport, TuneSettings, tune_in, tune_shard};
use protomer_learn_verbs::voxels::samples::VoxelSet;
use protomer_protein_verbs::file_kind::FileKind;
use protomer_results::{ResultKind, Shard};
use std::path::PathBuf;

/// Search for the network that predicts best: blocks, kernels, channels, learning rate. The same
/// command continues it.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "tune set.zarr --target crystal-system --trials 27 -o search",
    "tune set.zarr --trials 9 --shard 1/4 -o search"
))]
#[group(id = "TuneResult")]
pub struct TuneArgs {
    /// Set of voxels (zarr), made by 'protomer voxelize'.
    set: PathBuf,
    /// Number of networks to try.
    #[arg(long, default_value_t = 27, value_parser = range::OBJECTS.number::<usize>())]
    trials: usize,
    /// Passes over the training part for networks that are not stopped early.
    #[arg(long, default_value_t = 27, value_parser = range::OBJECTS.number::<usize>())]
    epochs: usize,
    /// Seed of the drawn settings, split, weights, order and rotations.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Try subsets of the channels as well.
    #[arg(long)]
    vary_channels: bool,
    /// Directory of the results.
    #[arg(short, long)]
    output: PathBuf,
    /// Run only a part of the trials, such as 2/8, alongside other processes in the same directory,
    /// until it has to wait for other parts; the command without this flag collects the results.
    #[arg(long, value_parser = Shard::parse, default_value = "1/1")]
    shard: Shard,
    #[command(flatten)]
    scheduler: SchedulerArgs,
    #[command(flatten)]
    labels: LabelArgs,
    #[command(flatten)]
    task: TaskArgs,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    execution: ExecutionArgs,
}

impl TuneArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        self.scheduler.check()?;
        let device = self.device.open()?;
        let execution = self.execution.execution(front)?;
        FileKind::Results(ResultKind::VoxelSet).require(&self.set)?;
        let (source, set) = open_set(&self.set)?;
        let mut settings = self.settings(source, &set)?;
        let set = self.task.label(&self.labels, &mut settings.base, &set)?;
        self.task.override_in(&mut settings.base)?;
        let directory = &self.output;
        if !self.shard.is_whole() {
            let end = tune_shard(&settings, &set, directory, self.shard, &device, &execution)?;
            return Ok(Reply::of_end_in_part(end, self.shard));
        }
        let end = tune_in(&settings, &set, directory, &device, &execution)?;
        let naming_set = |mut report: TuneReport| {
            report.set.clone_from(&self.set);
            report
        };
        Ok(Reply::of_end(end.map(naming_set), || {
            format!(
                "stopped; the same command continues {}",
                directory.display()
            )
        }))
    }

    fn settings(&self, source: Source, set: &VoxelSet) -> Result<TuneSettings> {
        let mut base = TrainSettings::of_set(source, channels_of(set))?;
        base.training.seed = self.seed;
        base.split_seed = Some(self.seed);
        Ok(TuneSettings {
            trials: self.trials,
            epochs: self.epochs,
            seed: self.seed,
            vary_channels: self.vary_channels,
            base,
        })
    }
}
