//! A search for settings: many trials with settings drawn at random, and early stopping of the
//! losers.
//!
//! Successive halving (Jamieson and Talwalkar, AISTATS 2016): all trials train for a few epochs,
//! the better third goes on to three times as many, and so on. Trials are compared by their
//! smallest validation loss; the test part is only looked at for the one that wins.
//!
//! ```text
//! DIR/settings.toml  trials.csv  trials.svg  best.toml
//! DIR/trials/0007.bin  trials/0007-3.toml   a checkpoint each, and what it had reached at each rung
//! ```

use crate::run::{Execution, Hold, Layout, ResultsDirectory};
use crate::shard::Shard;
use crate::train::{Prepared, TrainSettings, advance, blocks, check};
use crate::tune_figure;
use crate::tune_records::{Records, Standing};
use crate::tune_table::write_table;
use anyhow::{Context, Result, bail};
use protomer_io::atomic::write_atomically;
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_learn::LearnError;
use protomer_learn::sample::SampleSource;
use protomer_learn::training::EpochRecord;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::Path;

/// Of so many trials one goes on.
const KEPT_ONE_OF: usize = 3;
/// More would not end, and their settings would fill the memory.
const MOST_TRIALS: usize = 100_000;
/// The figure of a search.
const FIGURE: &str = "trials.svg";
/// How many of so many trials go on.
pub(crate) fn kept(trials: usize) -> usize {
    trials.div_ceil(KEPT_ONE_OF)
}

/// Files and folders of a search.
const LAYOUT: Layout = Layout {
    settings: "settings.toml",
    holds: "a search",
    results: &["trials.csv", FIGURE, "best.toml", "trials", "report.html"],
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
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trial {
    /// Its number.
    pub number: usize,
    /// Epochs done.
    pub epochs: usize,
    /// Smallest validation loss so far, nats; none if it diverged.
    pub validation_loss_nats: Option<f64>,
    /// Balanced accuracy on the validation part in that epoch.
    pub validation_balanced_accuracy: Option<f64>,
    /// Its settings.
    pub settings: TrainSettings,
}

/// How a search ended.
#[derive(Debug, Clone, PartialEq)]
pub enum TuneEnd {
    /// All trials, best first.
    Finished(Vec<Trial>),
    /// It was asked to stop; the same command goes on.
    Stopped,
}

/// How a part of a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShardEnd {
    /// No trial of the search is left to be trained.
    Finished,
    /// Other parts have to train theirs before it is known who goes on.
    Waiting,
    /// It was asked to stop; the same command goes on.
    Stopped,
}

impl TuneSettings {
    /// All trials before the first epoch.
    fn draw(&self, size: usize) -> Result<Vec<Trial>> {
        if self.trials == 0 || self.epochs == 0 {
            bail!(
                "{} trials of {} epochs; give at least one of each",
                self.trials,
                self.epochs
            );
        }
        if self.trials > MOST_TRIALS {
            bail!("{} trials; give at most {MOST_TRIALS}", self.trials);
        }
        let trial = |number| {
            let settings = self.trial(number, size)?;
            Ok(Trial {
                number,
                epochs: 0,
                validation_loss_nats: None,
                validation_balanced_accuracy: None,
                settings,
            })
        };
        (0..self.trials).map(trial).collect()
    }

    /// The settings of a trial: 2 to 4 blocks that double in width from 4, 8, 16 or 32; kernels 3
    /// or 5 in the first block, 3 elsewhere; learning rate from 3·10⁻⁴ to 10⁻² on a logarithmic
    /// scale; with or without normalisation. Always the same for the same seed and number.
    ///
    /// # Errors
    /// Never for settings that make sense.
    pub fn trial(&self, number: usize, size: usize) -> Result<TrainSettings> {
        let random =
            &mut CounterRng::for_purpose(self.seed, 0, number as u64, Purpose::TuningTrial);
        let mut pick = |choices: &[usize]| {
            choices
                .get(random.index(choices.len()))
                .copied()
                .unwrap_or_default()
        };
        // Each block halves the grid, which must not vanish.
        let deepest = (size.max(4).ilog2() as usize).min(4);
        let depths: Vec<usize> = (2..=deepest.max(2)).collect();
        let (depth, first, kernel, groups) = (
            pick(&depths),
            pick(&[4, 8, 16, 32]),
            pick(&[3, 3, 5]),
            pick(&[0, 4]),
        );
        let widths: Vec<usize> = (0..depth).map(|block| first << block).collect();
        let kernels: Vec<usize> = (0..depth)
            .map(|block| if block == 0 { kernel } else { 3 })
            .collect();
        // The bits of a mask are channels; without names there is nothing to leave out.
        let masks: Vec<usize> = (1..1 << self.base.training.channels.len().clamp(1, 16)).collect();
        let mask = pick(&masks);
        let mut settings = self.base.clone();
        settings.blocks = blocks(&widths, &kernels, groups)?;
        settings.training.learning_rate = 3e-4 * (1e-2f64 / 3e-4).powf(random.uniform());
        settings.training.epochs = self.epochs;
        if self.vary_channels {
            let channels = self.base.training.channels.iter().enumerate();
            let kept = channels
                .filter(|(i, _)| mask >> i & 1 == 1)
                .map(|(_, name)| name.clone());
            settings.training.channels = kept.collect();
        }
        Ok(settings)
    }

    /// Epochs at which losers stop, ascending; the last is that of trials that are never stopped.
    pub fn rungs(&self) -> Vec<usize> {
        let mut rungs = vec![self.epochs.max(1)];
        let mut left = self.trials;
        while left > 1 && rungs[0] > 1 {
            left = kept(left);
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
            (left, before) = (kept(left), rung);
        }
        total as u64
    }
}

/// Searches or continues in a directory. `advanced` hears of epochs done.
///
/// # Errors
/// For settings that make no sense, a directory that holds something else, and a disk that takes no
/// more.
pub fn tune_in(
    settings: &TuneSettings,
    set: &dyn SampleSource,
    path: &Path,
    execution: &Execution,
    advanced: &(dyn Fn(u64) + Sync),
) -> Result<TuneEnd> {
    let trials = settings.draw(set.size())?;
    let prepared = prepare(settings, &trials, set)?;
    let same = |present: &TuneSettings| Ok(present == settings);
    let _mine = ResultsDirectory::enter(path, LAYOUT, settings, execution.start_anew, same)?;
    let search = Search {
        settings,
        trials,
        records: Records::open(path)?,
        execution,
        advanced,
    };
    search.records.tidy()?;
    let tell =
        |standing: &Standing| write_table(standing.running.iter().chain(&standing.ended), path);
    if search.train(&prepared, Shard::WHOLE, Hold::Alone, &tell)? == ShardEnd::Stopped {
        return Ok(TuneEnd::Stopped);
    }
    let mut standing = search.standing()?;
    tell(&standing)?;
    let mut trials = standing.running;
    trials.append(&mut standing.ended);
    let Some(best) = trials
        .first()
        .filter(|best| best.validation_loss_nats.is_some())
    else {
        bail!("every trial diverged; choose other --channels or another --scaling");
    };
    tune_figure::figure(&trials, &settings.base.training.channels).write_svg(&path.join(FIGURE))?;
    let text = toml::to_string_pretty(&best.settings).context("best.toml")?;
    write_atomically(&path.join("best.toml"), |out| {
        out.write_all(text.as_bytes())
    })?;
    Ok(TuneEnd::Finished(trials))
}

/// Trains the trials of one part, while other processes train those of other parts in the same
/// directory, for as long as it is known who goes on. Called again and again for all parts until
/// all are finished, it leaves [`tune_in`] nothing to train.
///
/// # Errors
/// As [`tune_in`].
pub fn tune_shard(
    settings: &TuneSettings,
    set: &dyn SampleSource,
    path: &Path,
    shard: Shard,
    execution: &Execution,
    advanced: &(dyn Fn(u64) + Sync),
) -> Result<ShardEnd> {
    let trials = settings.draw(set.size())?;
    let same = |present: &TuneSettings| Ok(present == settings);
    let _ours = ResultsDirectory::share(path, LAYOUT, settings, execution.start_anew, same)?;
    let search = Search {
        settings,
        trials,
        records: Records::open(path)?,
        execution,
        advanced,
    };
    let standing = search.standing()?;
    if standing.rung.is_none() {
        return Ok(ShardEnd::Finished);
    }
    // To prepare a set is to read all of it.
    if !standing.behind.iter().any(|place| shard.has(*place)) {
        return Ok(ShardEnd::Waiting);
    }
    search.train(
        &prepare(settings, &search.trials, set)?,
        shard,
        Hold::Shared,
        &|_| Ok(()),
    )
}

/// The set as all trials see it, once it is known that each can begin.
fn prepare<'a>(
    settings: &TuneSettings,
    trials: &[Trial],
    set: &'a dyn SampleSource,
) -> Result<Prepared<'a>> {
    let prepared = Prepared::new(&settings.base, set)?;
    trials
        .iter()
        .try_for_each(|trial| check(&trial.settings, &prepared))?;
    Ok(prepared)
}

/// A search in its directory.
struct Search<'a> {
    settings: &'a TuneSettings,
    trials: Vec<Trial>,
    records: Records,
    execution: &'a Execution,
    advanced: &'a (dyn Fn(u64) + Sync),
}

impl Search<'_> {
    fn standing(&self) -> Result<Standing> {
        self.records.standing(self.settings, &self.trials)
    }

    /// Trains the trials of a part rung after rung, until others have to reach one; `tell` hears
    /// after each.
    fn train(
        &self,
        prepared: &Prepared,
        shard: Shard,
        hold: Hold,
        tell: &dyn Fn(&Standing) -> Result<()>,
    ) -> Result<ShardEnd> {
        let mut standing = self.standing()?;
        (self.advanced)(standing.epochs);
        while let Some(epochs) = standing.rung {
            let mine: Vec<&Trial> = standing
                .behind
                .iter()
                .filter(|place| shard.has(**place))
                .filter_map(|place| standing.running.get(*place))
                .collect();
            if mine.is_empty() {
                return Ok(ShardEnd::Waiting);
            }
            let one = |trial: &&Trial| {
                self.train_one(trial, prepared, epochs.clone(), hold)
                    .with_context(|| format!("trial {}", trial.number))
            };
            if mine
                .par_iter()
                .map(one)
                .collect::<Result<Vec<bool>>>()?
                .contains(&false)
            {
                return Ok(ShardEnd::Stopped);
            }
            standing = self.standing()?;
            tell(&standing)?;
        }
        Ok(ShardEnd::Finished)
    }

    /// Trains a trial to the end of the epochs and records it; false if it was asked to stop.
    fn train_one(
        &self,
        trial: &Trial,
        prepared: &Prepared,
        epochs: Range<usize>,
        hold: Hold,
    ) -> Result<bool> {
        // Where the search is shared, a process that was given up for lost may still be at work.
        let _mine = if hold == Hold::Shared {
            Some(self.records.hold(trial)?)
        } else {
            None
        };
        let rung = epochs.end;
        if self.records.of(trial, rung)?.is_some() {
            return Ok(true);
        }
        let file = self.records.checkpoint(trial);
        let reached = match advance(
            &trial.settings,
            prepared,
            &file,
            epochs,
            self.execution,
            self.advanced,
        ) {
            Ok(Some(trained)) => trial.after(&trained.history, rung),
            Ok(None) => return Ok(false),
            // Settings under which training diverges have lost; the search goes on.
            Err(error) if matches!(error.downcast_ref(), Some(LearnError::Diverged(_))) => Trial {
                validation_loss_nats: None,
                validation_balanced_accuracy: None,
                ..trial.clone()
            },
            Err(error) => return Err(error),
        };
        self.records.keep(&reached, rung)?;
        Ok(true)
    }
}

impl Trial {
    /// What trials are compared by.
    pub(crate) fn loss(&self) -> f64 {
        self.validation_loss_nats.unwrap_or(f64::INFINITY)
    }

    /// The trial as it stood at a rung. A search that goes on finds checkpoints beyond the rung:
    /// what came later must not decide who goes on from here.
    fn after(&self, history: &[EpochRecord], rung: usize) -> Self {
        let history = history.get(..rung).unwrap_or(history);
        let finite =
            |record: &&EpochRecord| record.validation_loss_nats.is_some_and(f64::is_finite);
        let loss = |record: &EpochRecord| record.validation_loss_nats.unwrap_or(f64::INFINITY);
        let best = history
            .iter()
            .filter(finite)
            .min_by(|a, b| loss(a).total_cmp(&loss(b)));
        Self {
            epochs: history.len(),
            validation_loss_nats: best.and_then(|record| record.validation_loss_nats),
            validation_balanced_accuracy: best
                .and_then(|record| record.validation_balanced_accuracy),
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::Source;

    fn settings(trials: usize, epochs: usize, vary_channels: bool) -> TuneSettings {
        let channels = ["shape", "potential"].map(String::from).to_vec();
        let source = Source::Set {
            path: "set.zarr".into(),
            digest: String::new(),
        };
        TuneSettings {
            trials,
            epochs,
            seed: 1,
            vary_channels,
            base: TrainSettings::of_set(source, channels).unwrap(),
        }
    }

    #[test]
    fn a_third_goes_on_to_three_times_as_many_epochs() {
        let cases: [(usize, usize, &[usize], u64); 7] = [
            // 27 + 9 x 2 + 3 x 6 + 1 x 18.
            (27, 27, &[1, 3, 9, 27], 81),
            // 9 x 3 + 3 x 6 + 1 x 18.
            (9, 27, &[3, 9, 27], 63),
            // 5 + 2 x 3.
            (5, 4, &[1, 4], 11),
            (4, 9, &[1, 3, 9], 14),
            (1, 27, &[27], 27),
            (27, 1, &[1], 27),
            (3, 2, &[1, 2], 4),
        ];
        for (trials, epochs, rungs, total) in cases {
            let settings = settings(trials, epochs, false);
            assert_eq!(
                (settings.rungs().as_slice(), settings.total_epochs()),
                (rungs, total),
                "{trials}, {epochs}"
            );
        }
    }

    #[test]
    fn draws_depend_on_seed_and_number_only_and_fit_the_grid() {
        let drawn = |settings: &TuneSettings, size| -> Vec<TrainSettings> {
            (0..40)
                .map(|number| settings.trial(number, size).unwrap())
                .collect()
        };
        let some = settings(40, 9, true);
        assert_eq!(drawn(&some, 16), drawn(&some, 16));
        assert_ne!(
            drawn(&some, 16),
            drawn(
                &TuneSettings {
                    seed: 2,
                    ..some.clone()
                },
                16
            )
        );
        for trial in drawn(&some, 8) {
            assert!(
                (2..=3).contains(&trial.blocks.len()),
                "8 voxels can be halved three times"
            );
            assert!(
                (3e-4..=1e-2).contains(&trial.training.learning_rate)
                    && !trial.training.channels.is_empty()
            );
        }
        assert!(
            drawn(&some, 16)
                .iter()
                .any(|trial| trial.training.channels == ["potential"])
        );
        assert!(
            drawn(&settings(40, 9, false), 16)
                .iter()
                .all(|trial| trial.training.channels.len() == 2)
        );
    }

    #[test]
    fn a_trial_stands_where_it_stood_at_its_rung() {
        let record = |epoch: usize, loss: f64| EpochRecord {
            epoch,
            training_loss_nats: 1.0,
            validation_loss_nats: Some(loss),
            validation_balanced_accuracy: Some(epoch as f64),
            gradient_norm: 1.0,
            largest_gradient_norm: 1.0,
            learning_rate: 1e-3,
            skipped_steps: 0,
        };
        let history = [
            record(1, 0.7),
            record(2, f64::NAN),
            record(3, 0.6),
            record(4, 0.1),
        ];
        let settings = settings(2, 4, false).trial(0, 16).unwrap();
        let new = Trial {
            number: 0,
            epochs: 0,
            validation_loss_nats: None,
            validation_balanced_accuracy: None,
            settings,
        };
        let at = |rung| {
            let trial = new.after(&history, rung);
            (
                trial.epochs,
                trial.validation_loss_nats,
                trial.validation_balanced_accuracy,
            )
        };
        assert_eq!(at(1), (1, Some(0.7), Some(1.0)));
        assert_eq!(at(3), (3, Some(0.6), Some(3.0)));
        // Ended early, the history is shorter than the rung.
        assert_eq!(at(9), (4, Some(0.1), Some(4.0)));
        assert_eq!(new.after(&[record(1, f64::NAN)], 1).loss(), f64::INFINITY);
    }
}
