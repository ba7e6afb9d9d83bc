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

pub mod figure;
mod records;
mod table;

use crate::answer::{Answer, columns, heading};
use crate::learning::train::{Epochs, Prepared, TrainSettings, TrainingRun, blocks, check};
use crate::plot::Figure;
use anyhow::{Context, Result, bail};
use protomer_io::atomic::write_atomically;
use protomer_kernel::random::CounterRng;
use protomer_learn::sample::SampleSource;
use protomer_learn::training::EpochRecord;
use protomer_learn::{Device, LearnError};
use protomer_results::{
    End, Execution, Hold, Layout, ResultKind, ResultsDirectory, Run, Settings, Shard, Work,
    checkpoint, each, keys::to_toml, proceed, recorded, settings,
};
use records::{Records, Standing};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::{Path, PathBuf};
use table::write_table;

/// Of so many trials one goes on.
const KEPT_ONE_OF: usize = 3;
/// More would not end, and their settings would fill the memory.
const MOST_TRIALS: usize = 100_000;
/// Purpose of the random numbers that draw settings.
const DRAW: u8 = 90;
/// The settings of the best trial.
const BEST: &str = "best.toml";
/// The figure of a search.
const FIGURE: &str = "trials.svg";
/// How many of so many trials go on.
pub(crate) fn kept(trials: usize) -> usize {
    trials.div_ceil(KEPT_ONE_OF)
}

/// Files and folders of a search.
const LAYOUT: Layout = Layout {
    kind: ResultKind::Search,
    settings: "settings.toml",
    results: &[
        "run.json",
        "trials.csv",
        FIGURE,
        BEST,
        "trials",
        "report.html",
    ],
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

/// A finished search.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TuneReport {
    /// The settings of the best trial.
    pub best: PathBuf,
    /// All trials, best first.
    pub trials: Vec<Trial>,
    /// The set as the user named it, for the command that follows.
    #[serde(skip)]
    pub set: PathBuf,
    #[serde(skip)]
    channels: Vec<String>,
}

/// Trials shown to a reader.
const SHOWN: usize = 10;

impl Answer for TuneReport {
    fn text(&self) -> String {
        let mut rows = vec![heading([
            "trial",
            "epochs",
            "validation loss (nats)",
            "balanced accuracy",
            "widths",
        ])];
        rows.extend(self.trials.iter().take(SHOWN).map(Trial::cells));
        let mut lines = vec![columns(&rows)];
        if self.trials.len() > SHOWN {
            lines.push(format!(
                "the best {SHOWN} of {}; all in {}",
                self.trials.len(),
                self.best.with_file_name("trials.csv").display()
            ));
        }
        lines.push(format!(
            "the validation part chose the best, so its scores there are too good; for scores on the \
             test part:\nprotomer train {} --config {} -o DIRECTORY",
            self.set.display(),
            self.best.display()
        ));
        lines.join("\n")
    }

    fn figure(&self) -> Option<Figure> {
        Some(figure::figure(&self.trials, &self.channels))
    }
}

/// How far the trials of a part of a search came.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct TunePart {
    /// Which part, from one.
    pub shard: usize,
    /// Of how many.
    pub of: usize,
    /// Whether no trial of the search is left to be trained. Otherwise other parts have to train
    /// theirs before it is known who goes on.
    pub finished: bool,
}

impl Answer for TunePart {
    fn text(&self) -> String {
        let state = match self.finished {
            true => "all trials are done; without --shard: the table",
            false => "waits for the others; then the same command continues it",
        };
        format!("part {} of {}: {state}", self.shard, self.of)
    }
}

/// How far the trials of a part came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ShardState {
    /// No trial of the search is left to be trained.
    Complete,
    /// Other parts have to train theirs before it is known who goes on.
    Waiting,
}

impl Settings for TuneSettings {
    fn essential(&self) -> Self {
        Self {
            base: self.base.essential(),
            ..self.clone()
        }
    }
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
        let random = &mut CounterRng::for_purpose(self.seed, 0, number as u64, DRAW);
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

/// Searches or continues in a directory.
///
/// # Errors
/// For settings that make no sense, a directory that holds other work, and a disk that refuses.
pub fn tune_in(
    settings: &TuneSettings,
    set: &dyn SampleSource,
    path: &Path,
    device: &Device,
    execution: &Execution,
) -> Result<End<TuneReport>> {
    let trials = settings.draw(set.size())?;
    let prepared = prepare(settings, &trials, set)?;
    let work = work(settings)?;
    let entered = ResultsDirectory::enter(path, &LAYOUT, settings, &work.identity, execution)?;
    let search = Search {
        settings,
        trials,
        records: Records::open(path)?,
        device,
        execution,
    };
    search.records.tidy()?;
    execution.progress.begin(settings.total_epochs(), "epochs");
    recorded(&work, &entered, &execution.interrupt, || {
        search.to_the_end(&prepared, path)
    })
}

/// Trains the trials of one part, while other processes train those of other parts in the same
/// directory, for as long as it is known who goes on. Called again and again for all parts until
/// all are complete, it leaves [`tune_in`] nothing to train.
///
/// # Errors
/// As [`tune_in`].
pub fn tune_shard(
    settings: &TuneSettings,
    set: &dyn SampleSource,
    path: &Path,
    shard: Shard,
    device: &Device,
    execution: &Execution,
) -> Result<End<TunePart>> {
    let trials = settings.draw(set.size())?;
    let identity = work(settings)?.identity;
    let _ours = ResultsDirectory::share(path, &LAYOUT, settings, &identity, execution)?;
    let search = Search {
        settings,
        trials,
        records: Records::open(path)?,
        device,
        execution,
    };
    let standing = search.standing()?;
    let part = |state| TunePart {
        shard: shard.index,
        of: shard.of,
        finished: state == ShardState::Complete,
    };
    if standing.rung.is_none() {
        return Ok(End::Finished(part(ShardState::Complete)));
    }
    // To prepare a set is to read all of it.
    if !standing.behind.iter().any(|place| shard.has(*place)) {
        return Ok(End::Finished(part(ShardState::Waiting)));
    }
    let prepared = prepare(settings, &search.trials, set)?;
    execution.progress.begin(settings.total_epochs(), "epochs");
    let end = search.train(&prepared, shard, Hold::Shared, &|_| Ok(()))?;
    Ok(end.map(part))
}

fn work(settings: &TuneSettings) -> Result<Work> {
    Ok(Work {
        kind: ResultKind::Search,
        verb: "tune",
        identity: settings::identity(settings, "")?,
        input_sha256: settings.base.source.digest().to_owned(),
    })
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
    device: &'a Device,
    execution: &'a Execution,
}

impl Search<'_> {
    fn standing(&self) -> Result<Standing> {
        self.records.standing(self.settings, &self.trials)
    }

    /// Trains all trials, and writes the table, the figure and the best settings.
    fn to_the_end(&self, prepared: &Prepared, path: &Path) -> Result<End<TuneReport>> {
        let write_standing =
            |standing: &Standing| write_table(standing.running.iter().chain(&standing.ended), path);
        let end = self.train(prepared, Shard::WHOLE, Hold::Alone, &write_standing)?;
        if end == End::Stopped {
            return Ok(End::Stopped);
        }
        let standing = self.standing()?;
        write_standing(&standing)?;
        let report = TuneReport {
            best: path.join(BEST),
            trials: [standing.running, standing.ended].concat(),
            set: self.settings.base.source.path().to_owned(),
            channels: self.settings.base.training.channels.clone(),
        };
        let best = report.trials.first();
        let Some(best) = best.filter(|best| best.validation_loss_nats.is_some()) else {
            bail!("every trial diverged; choose other --channels or another --scaling");
        };
        let text = to_toml("the settings of the best trial", &best.settings)?;
        if let Some(figure) = report.figure() {
            figure.write_svg(&path.join(FIGURE))?;
        }
        write_atomically(&report.best, |out| out.write_all(text.as_bytes()))?;
        Ok(End::Finished(report))
    }

    /// Trains the trials of a part rung after rung, until others have to reach one. Calls
    /// `after_rung` after each.
    fn train(
        &self,
        prepared: &Prepared,
        shard: Shard,
        hold: Hold,
        after_rung: &dyn Fn(&Standing) -> Result<()>,
    ) -> Result<End<ShardState>> {
        let mut standing = self.standing()?;
        self.execution.progress.advance(standing.epochs);
        while let Some(epochs) = standing.rung {
            let ours: Vec<&Trial> = standing
                .behind
                .iter()
                .filter(|place| shard.has(**place))
                .filter_map(|place| standing.running.get(*place))
                .collect();
            if ours.is_empty() {
                return Ok(End::Finished(ShardState::Waiting));
            }
            let one = |trial: &&Trial| {
                self.train_one(trial, prepared, epochs.clone(), hold)
                    .with_context(|| format!("trial {}", trial.number))
            };
            if each(&ours, &self.execution.interrupt, one)? == End::Stopped {
                return Ok(End::Stopped);
            }
            standing = self.standing()?;
            after_rung(&standing)?;
        }
        Ok(End::Finished(ShardState::Complete))
    }

    /// Trains a trial to the end of the epochs and records it.
    fn train_one(
        &self,
        trial: &Trial,
        prepared: &Prepared,
        epochs: Range<usize>,
        hold: Hold,
    ) -> Result<End<()>> {
        // Where the search is shared, a process that was given up for lost may still be at work.
        let _alone = match hold {
            Hold::Shared => Some(self.records.hold(trial)?),
            Hold::Alone => None,
        };
        let rung = epochs.end;
        if self.records.of(trial, rung)?.is_some() {
            return Ok(End::Finished(()));
        }
        let reached = match self.train_to(trial, prepared, epochs) {
            Ok(End::Finished(history)) => trial.after(&history, rung),
            Ok(End::Stopped) => return Ok(End::Stopped),
            // Settings under which training diverges have lost; the search goes on.
            Err(error) if matches!(error.downcast_ref(), Some(LearnError::Diverged(_))) => Trial {
                validation_loss_nats: None,
                validation_balanced_accuracy: None,
                ..trial.clone()
            },
            Err(error) => return Err(error),
        };
        self.records.keep(&reached, rung)?;
        Ok(End::Finished(()))
    }

    /// Trains a trial from its checkpoint to the end of the epochs, and returns its history.
    fn train_to(
        &self,
        trial: &Trial,
        prepared: &Prepared,
        epochs: Range<usize>,
    ) -> Result<End<Vec<EpochRecord>>> {
        let run = TrainingRun::new(&trial.settings, prepared, self.device.clone())?
            .until_epoch(epochs.end);
        let file = self.records.checkpoint(trial);
        let saved = checkpoint::read(&file, TrainingRun::CHECKPOINT_KIND, "")?;
        let mut state: Epochs = run.open(self.records.folder(), saved)?;
        let done = (run.done(&state) as usize).clamp(epochs.start, epochs.end);
        self.execution
            .progress
            .advance((done - epochs.start) as u64);
        match proceed(&run, &mut state, &file, self.execution)? {
            End::Finished(()) => Ok(End::Finished(run.trained(&state)?.history)),
            End::Stopped => Ok(End::Stopped),
        }
    }
}

impl Trial {
    fn cells(&self) -> Vec<String> {
        let blocks = self.settings.blocks.iter();
        let widths: Vec<String> = blocks.map(|block| block.width.to_string()).collect();
        let loss = self.validation_loss_nats;
        let accuracy = self.validation_balanced_accuracy;
        vec![
            self.number.to_string(),
            self.epochs.to_string(),
            loss.map_or_else(|| "diverged".into(), |loss| format!("{loss:.4}")),
            accuracy.map_or_else(String::new, |value| format!("{value:.3}")),
            widths.join("-"),
        ]
    }

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
    use crate::learning::train::Source;

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
