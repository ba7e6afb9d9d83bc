//! A search for settings in its directory: many trials with settings drawn at random, and early
//! stopping of the losers by successive halving ([`protomer_learn::halving`]).
//!
//! Trials are compared by their smallest validation loss. No trial looks at the test part.
//!
//! ```text
//! DIR/settings.toml  trials.csv  trials.svg  best.toml
//! DIR/trials/0007.bin     the checkpoint of trial 7
//! DIR/trials/0007-3.toml  what it had reached at the rung of 3 epochs
//! ```

use crate::run::{Execution, Hold, Layout, ResultsDirectory};
use crate::shard::Shard;
use crate::train::{Prepared, TrainSettings, advance, check};
use crate::tune_figure;
use crate::tune_records::{Records, Standing};
use crate::tune_table::write_table;
use anyhow::{Context, Result, bail};
use protomer_io::atomic::write_atomically;
use protomer_learn::LearnError;
use protomer_learn::halving::{Halving, Reached};
use protomer_learn::sample::SampleSource;
use protomer_learn::trial::TrialSettings;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::Path;

/// The figure of a search.
const FIGURE: &str = "trials.svg";

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
    /// How far it came.
    #[serde(flatten)]
    pub reached: Reached,
    /// Its settings.
    pub settings: TrainSettings,
}

/// How a search ended.
#[derive(Debug, Clone, PartialEq)]
pub enum TuneEnd {
    /// All trials, best first.
    Finished(Vec<Trial>),
    /// It was asked to stop; the same command continues it.
    Stopped,
}

/// How a part of a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShardEnd {
    /// No trial of the search is left to be trained.
    Finished,
    /// Other parts have to train theirs before it is known who goes on.
    Waiting,
    /// It was asked to stop; the same command continues it.
    Stopped,
}

impl TuneSettings {
    /// Who trains for how long.
    pub(crate) fn halving(&self) -> Result<Halving> {
        Ok(Halving::new(self.trials, self.epochs)?)
    }

    /// All trials before the first epoch.
    fn draw(&self, size: usize) -> Result<Vec<Trial>> {
        self.halving()?;
        let mut trials = Vec::with_capacity(self.trials);
        for number in 0..self.trials {
            trials.push(Trial {
                number,
                reached: Reached::default(),
                settings: self.trial(number, size)?,
            });
        }
        Ok(trials)
    }

    /// The settings of a trial, the same for the same seed and number.
    fn trial(&self, number: usize, size: usize) -> Result<TrainSettings> {
        let channels = &self.base.training.channels;
        let drawn = TrialSettings::draw(self.seed, number, size, channels)?;
        let mut settings = self.base.clone();
        settings.blocks = drawn.blocks;
        settings.training.learning_rate = drawn.learning_rate;
        settings.training.epochs = self.epochs;
        if self.vary_channels {
            settings.training.channels = drawn.channels;
        }
        Ok(settings)
    }

    /// Epochs of all trials together, at most.
    ///
    /// # Errors
    /// For no trials, no epochs, or too many trials.
    pub fn total_epochs(&self) -> Result<u64> {
        Ok(self.halving()?.total_epochs())
    }
}

/// Searches or continues in a directory. `advanced` is called with the number of epochs done.
///
/// # Errors
/// For settings that make no sense, a directory that holds something else, and a full disk.
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
        .filter(|best| best.reached.validation_loss_nats.is_some())
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
/// directory. It returns when other parts must finish before it is known who goes on. Call it for
/// all parts until all are finished; then [`tune_in`] has nothing left to train.
///
/// # Errors
/// As for [`tune_in`].
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
    // Preparing a set reads all of it: not if there is nothing to train.
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

/// The set as all trials see it, after a check that each can begin.
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

    /// Trains the trials of a part rung after rung, until other parts must reach one. `tell` is
    /// called after each rung.
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
        // Where the search is shared, a process that counts as lost may still be at work.
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
            Ok(Some(trained)) => Reached::at(&trained.history, rung),
            Ok(None) => return Ok(false),
            // Settings under which training diverges have lost; the search goes on.
            Err(error) if matches!(error.downcast_ref(), Some(LearnError::Diverged(_))) => {
                Reached {
                    epochs: trial.reached.epochs,
                    ..Reached::default()
                }
            }
            Err(error) => return Err(error),
        };
        self.records.keep(trial, &reached, rung)?;
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::Source;

    fn settings(vary_channels: bool) -> TuneSettings {
        let channels = ["shape", "potential"].map(String::from).to_vec();
        let source = Source::Set {
            path: "set.zarr".into(),
            digest: String::new(),
        };
        TuneSettings {
            trials: 40,
            epochs: 9,
            seed: 1,
            vary_channels,
            base: TrainSettings::of_set(source, channels).unwrap(),
        }
    }

    #[test]
    fn what_is_drawn_replaces_the_base() {
        for trial in settings(false).draw(16).unwrap() {
            let drawn = &trial.settings;
            assert_eq!(drawn.training.channels.len(), 2);
            assert_eq!((drawn.training.epochs, drawn.least_samples), (9, 10));
            assert_ne!(drawn.training.learning_rate, 1e-3);
        }
        let varied = settings(true).draw(16).unwrap();
        let is_alone = |trial: &Trial| trial.settings.training.channels == ["potential"];
        assert!(varied.iter().any(is_alone));
        assert!(
            TuneSettings {
                trials: 0,
                ..settings(true)
            }
            .draw(16)
            .is_err()
        );
    }
}
