//! A search for settings: many trials with settings drawn at random, and early stopping of the losers.
//!
//! Successive halving (Jamieson and Talwalkar, AISTATS 2016): all trials train for a few epochs, the better third goes on
//! to three times as many, and so on. Trials are compared by their smallest validation loss; the test part is only looked
//! at for the one that wins.
//!
//! ```text
//! DIR/settings.toml  trials.csv  best.toml  trials/0007.bin   a checkpoint each
//! ```

use crate::run::{Execution, Layout, ResultsDirectory};
use crate::train::{Prepared, TrainSettings, advance, blocks};
use anyhow::{Context, Result, bail};
use protomer_io::atomic::write_atomically;
use protomer_io::csv::{Cell, Table};
use protomer_kernel::random::CounterRng;
use protomer_learn::sample::SampleSource;
use protomer_learn::training::EpochRecord;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Of so many trials one goes on.
const KEPT_ONE_OF: usize = 3;
/// Purpose of the random numbers that draw settings.
const DRAW: u8 = 90;
/// Files and folders of a search.
const LAYOUT: Layout = Layout {
    settings: "settings.toml",
    holds: "a search",
    results: &["trials.csv", "best.toml", "trials"],
    is_result: |_| false,
};

/// What is searched.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TuneSettings {
    /// Trials.
    pub trials: usize,
    /// Epochs of a trial that is never stopped.
    pub epochs: usize,
    /// Seed of the draws.
    pub seed: u64,
    /// Whether subsets of the channels are tried as well.
    pub vary_channels: bool,
    /// What all trials share; what is drawn replaces it.
    pub base: TrainSettings,
}

/// One trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Its number.
    pub number: usize,
    /// Its settings.
    pub settings: TrainSettings,
    /// Epochs done.
    pub epochs: usize,
    /// Smallest validation loss so far, nats.
    pub validation_loss_nats: f64,
    /// Balanced accuracy on the validation part in that epoch.
    pub validation_balanced_accuracy: f64,
}

/// How a search ended.
#[derive(Debug, Clone, PartialEq)]
pub enum TuneEnd {
    /// All trials, best first.
    Finished(Vec<Trial>),
    /// It was asked to stop; the same command goes on.
    Stopped,
}

impl TuneSettings {
    /// The settings of a trial: 2 to 4 blocks that double in width from 4, 8, 16 or 32; kernels 3 or 5 in the first block,
    /// 3 elsewhere; learning rate from 3·10⁻⁴ to 10⁻² on a logarithmic scale; with or without normalisation. Always the
    /// same for the same seed and number.
    ///
    /// # Errors
    /// Never for settings that make sense.
    pub fn trial(&self, number: usize, size: usize) -> Result<TrainSettings> {
        let random = &mut CounterRng::for_purpose(self.seed, 0, number as u64, DRAW);
        let mut pick = |choices: &[usize]| choices.get(random.index(choices.len())).copied().unwrap_or_default();
        // Each block halves the grid, which must not vanish.
        let deepest = (size.max(4).ilog2() as usize).min(4);
        let depths: Vec<usize> = (2..=deepest.max(2)).collect();
        let (depth, first, kernel, groups) = (pick(&depths), pick(&[4, 8, 16, 32]), pick(&[3, 3, 5]), pick(&[0, 4]));
        let widths: Vec<usize> = (0..depth).map(|block| first << block).collect();
        let kernels: Vec<usize> = (0..depth).map(|block| if block == 0 { kernel } else { 3 }).collect();
        let mask = pick(&(1..1 << self.base.training.channels.len().min(16)).collect::<Vec<_>>());
        let mut settings = self.base.clone();
        settings.blocks = blocks(&widths, &kernels, groups)?;
        settings.training.learning_rate = 3e-4 * (1e-2f64 / 3e-4).powf(random.uniform());
        settings.training.epochs = self.epochs;
        if self.vary_channels {
            let channels = self.base.training.channels.iter().enumerate();
            let kept = channels.filter(|(i, _)| mask >> i & 1 == 1).map(|(_, name)| name.clone());
            settings.training.channels = kept.collect();
        }
        Ok(settings)
    }

    /// Epochs at which losers stop, ascending; the last is that of trials that are never stopped.
    pub fn rungs(&self) -> Vec<usize> {
        let mut rungs = vec![self.epochs.max(1)];
        let mut left = self.trials;
        while left > 1 && rungs[0] > 1 {
            left = left.div_ceil(KEPT_ONE_OF);
            rungs.insert(0, (rungs[0] / KEPT_ONE_OF).max(1));
        }
        rungs.dedup();
        rungs
    }

    /// Epochs of all trials together, at most.
    pub fn total_epochs(&self) -> u64 {
        let (mut left, mut before, mut total) = (self.trials, 0, 0);
        for rung in self.rungs() {
            total += left * (rung - before);
            (left, before) = (left.div_ceil(KEPT_ONE_OF), rung);
        }
        total as u64
    }
}

/// Searches or continues in a directory. `advanced` hears of epochs done.
///
/// # Errors
/// For settings that make no sense, a directory that holds something else, and a disk that takes no more.
pub fn tune_in(
    settings: &TuneSettings,
    set: &dyn SampleSource,
    path: &Path,
    execution: &Execution,
    advanced: &(dyn Fn(u64) + Sync),
) -> Result<TuneEnd> {
    if settings.trials == 0 || settings.epochs == 0 {
        bail!("{} trials of {} epochs; give at least one of each", settings.trials, settings.epochs);
    }
    let prepared = Prepared::new(&settings.base, set)?;
    let _mine =
        ResultsDirectory::enter(path, LAYOUT, settings, execution.start_anew, |present| Ok(present == settings))?;
    let folder = path.join("trials");
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot make the directory {}", folder.display()))?;
    let start = |number: usize| {
        Ok(Trial {
            number,
            settings: settings.trial(number, set.size())?,
            epochs: 0,
            validation_loss_nats: f64::INFINITY,
            validation_balanced_accuracy: 0.0,
        })
    };
    let mut running = (0..settings.trials).map(start).collect::<Result<Vec<Trial>>>()?;
    let mut ended = Vec::new();
    for rung in settings.rungs() {
        let go_on = |trial: &Trial| -> Result<Option<Trial>> {
            let file = folder.join(format!("{:04}.bin", trial.number));
            let Some(trained) = advance(&trial.settings, &prepared, &file, rung, execution, advanced)? else {
                return Ok(None);
            };
            Ok(Some(trial.after(&trained.history)))
        };
        let done = running.par_iter().map(go_on).collect::<Result<Vec<_>>>()?;
        let Some(mut trials) = done.into_iter().collect::<Option<Vec<Trial>>>() else {
            return Ok(TuneEnd::Stopped);
        };
        trials.sort_by(|a, b| a.loss().total_cmp(&b.loss()).then(a.number.cmp(&b.number)));
        let kept = if rung == settings.epochs { trials.len() } else { trials.len().div_ceil(KEPT_ONE_OF) };
        // Losers of later rounds stand before those of earlier ones.
        ended.splice(0..0, trials.split_off(kept));
        running = trials;
        write_table(&running, &ended, path)?;
    }
    running.append(&mut ended);
    if let Some(best) = running.first() {
        let text = toml::to_string_pretty(&best.settings).context("best.toml")?;
        write_atomically(&path.join("best.toml"), |out| out.write_all(text.as_bytes()))?;
    }
    Ok(TuneEnd::Finished(running))
}

impl Trial {
    fn loss(&self) -> f64 {
        if self.validation_loss_nats.is_nan() { f64::INFINITY } else { self.validation_loss_nats }
    }

    fn after(&self, history: &[EpochRecord]) -> Self {
        let loss = |record: &&EpochRecord| record.validation_loss_nats.filter(|loss| loss.is_finite());
        let best = history.iter().filter(|record| loss(record).is_some()).min_by(|a, b| {
            let of = |record: &EpochRecord| record.validation_loss_nats.unwrap_or(f64::INFINITY);
            of(a).total_cmp(&of(b))
        });
        Self {
            epochs: history.len(),
            validation_loss_nats: best.and_then(|record| record.validation_loss_nats).unwrap_or(f64::INFINITY),
            validation_balanced_accuracy: best
                .and_then(|record| record.validation_balanced_accuracy)
                .unwrap_or_default(),
            ..self.clone()
        }
    }
}

/// `trials.csv`: one row per trial, best first.
fn write_table(running: &[Trial], ended: &[Trial], path: &Path) -> Result<()> {
    let columns = [
        "trial",
        "epochs",
        "validation_loss_nats",
        "validation_balanced_accuracy",
        "widths",
        "kernels",
        "groups",
        "learning_rate",
        "channels",
    ];
    let mut table = Table::new(columns);
    for trial in running.iter().chain(ended) {
        let TrainSettings { blocks, training, .. } = &trial.settings;
        let join = |values: Vec<usize>| values.iter().map(usize::to_string).collect::<Vec<_>>().join("-");
        table.push([
            trial.number.into(),
            trial.epochs.into(),
            trial.validation_loss_nats.into(),
            trial.validation_balanced_accuracy.into(),
            Cell::from(join(blocks.iter().map(|block| block.width).collect()).as_str()),
            join(blocks.iter().map(|block| block.kernel).collect()).as_str().into(),
            blocks.first().and_then(|block| block.groups).unwrap_or(0).into(),
            training.learning_rate.into(),
            training.channels.join("+").as_str().into(),
        ])?;
    }
    write_atomically(&path.join("trials.csv"), |out| out.write_all(table.to_csv().as_bytes()))?;
    Ok(())
}
