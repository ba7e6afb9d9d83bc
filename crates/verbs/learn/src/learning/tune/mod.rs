//! A search for settings in its directory: many trials with random settings, and early
//! stopping of the worst by successive halving ([`protomer_learn::halving`]).
//!
//! Trials are compared by their smallest validation loss. No trial looks at the test part.
//!
//! ```text
//! DIR/settings.toml  trials.csv  trials.svg  best.toml
//! DIR/trials/0007.bin     the checkpoint of trial 7
//! DIR/trials/0007-3.toml  its result at the rung of 3 epochs
//! ```

pub mod figure;
pub mod page;
mod records;
mod table;

use crate::learning::train::{Epochs, Prepared, TrainSettings, TrainingRun, check};
use anyhow::{Context, Result, bail};
use protomer_common::answer::{Answer, columns, heading};
use protomer_io::atomic::write_atomically;
use protomer_learn::halving::{Halving, Reached};
use protomer_learn::sample::SampleSource;
use protomer_learn::training::EpochRecord;
use protomer_learn::trial::TrialSettings;
use protomer_learn::{Device, LearnError};
use protomer_plot::Figure;
use protomer_results::{
    End, Execution, Hold, Layout, ResultKind, ResultsDirectory, Run, Settings, Shard, Work,
    checkpoint, each, keys::to_toml, proceed, recorded, settings,
};
use records::{Records, Standing};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::{Path, PathBuf};
use table::write_table;

/// The settings of the best trial.
const BEST: &str = "best.toml";
/// The figure of a search.
const FIGURE: &str = "trials.svg";

/// The files and folders of a search.
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

/// The settings of a search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TuneSettings {
    /// Number of trials.
    pub trials: usize,
    /// Epochs of a trial that is not stopped early.
    pub epochs: usize,
    /// Seed of the random settings.
    pub seed: u64,
    /// Whether subsets of the channels are tried too.
    pub vary_channels: bool,
    /// The settings shared by all trials, apart from those drawn at random.
    pub base: TrainSettings,
}

/// One trial.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trial {
    /// Number of the trial.
    pub number: usize,
    /// Progress of the trial.
    #[serde(flatten)]
    pub reached: Reached,
    /// Settings of the trial.
    pub settings: TrainSettings,
}

/// A finished search.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TuneReport {
    /// The settings of the best trial.
    pub best: PathBuf,
    /// All trials, best first.
    pub trials: Vec<Trial>,
    /// The set as named by the user, for the suggested command.
    #[serde(skip)]
    pub set: PathBuf,
    #[serde(skip)]
    channels: Vec<String>,
}

/// Number of trials shown in the text.
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
            "the best trial was chosen on the validation part, so its scores there are biased; for \
             scores on the test part:\nprotomer train {} --config {} -o DIRECTORY",
            self.set.display(),
            self.best.display()
        ));
        lines.join("\n")
    }

    fn figure(&self) -> Option<Figure> {
        Some(figure::figure(&self.trials, &self.channels))
    }
}

/// The progress of one part of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct TunePart {
    /// The number of the part, counted from 1.
    pub shard: usize,
    /// The number of parts.
    pub of: usize,
    /// Whether all trials of the search are done. Otherwise the other parts must reach the rung
    /// before the survivors are known.
    pub finished: bool,
}

impl Answer for TunePart {
    fn text(&self) -> String {
        let state = match self.finished {
            true => "all trials are done; run without --shard for the table",
            false => "waiting for the other parts; run the same command again after them",
        };
        format!("part {} of {}: {state}", self.shard, self.of)
    }
}

/// The progress of the trials of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ShardState {
    /// All trials of the search are done.
    Complete,
    /// Other parts must reach the rung before the survivors are known.
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
    /// Schedule of the search: which trials train for how many epochs.
    ///
    /// # Errors
    /// For no trials, no epochs, or too many trials.
    pub fn halving(&self) -> Result<Halving> {
        Ok(Halving::new(self.trials, self.epochs)?)
    }

    /// All trials, before the first epoch.
    fn draw(&self, size: usize) -> Result<Vec<Trial>> {
        self.halving()?;
        let mut trials = Vec::with_capacity(self.trials);
        for number in 0..self.trials {
            // Drawn by number: every process draws the same trials without talking to others.
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

    /// Upper limit for the epochs of all trials together.
    ///
    /// # Errors
    /// For no trials, no epochs, or too many trials.
    pub fn total_epochs(&self) -> Result<u64> {
        Ok(self.halving()?.total_epochs())
    }
}

/// Runs or continues a search in a directory.
///
/// # Errors
/// For invalid settings, a directory that holds other work, or a file that cannot be written.
///
/// ```no_run
/// use protomer_learn_verbs::learning::train::{TrainSettings, channels_of, open_set};
/// use protomer_learn_verbs::learning::tune::{TuneSettings, tune_in};
/// use protomer_learn::device::DeviceChoice;
/// use protomer_results::Execution;
/// use std::path::Path;
/// let (source, set) = open_set(Path::new("set.zarr"))?;
/// let settings = TuneSettings {
///     trials: 27,
///     epochs: 27,
///     seed: 1,
///     vary_channels: false,
///     base: TrainSettings::of_set(source, channels_of(&set))?,
/// };
/// let device = DeviceChoice::Cpu.open()?;
/// tune_in(&settings, &set, Path::new("search"), &device, &Execution::default())?;
/// # Ok::<(), anyhow::Error>(())
/// ```
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
    // Alone in the directory: checkpoints of trials that are out may go.
    search.records.tidy()?;
    execution.progress.begin(settings.total_epochs()?, "epochs");
    recorded(&work, &entered, &execution.interrupt, || {
        search.to_the_end(&prepared, path)
    })
}

/// Trains the trials of one part, while other processes train those of other parts in the same
/// directory. Returns when the other parts must catch up before the survivors of a rung are known.
/// Call it for all parts until all are finished; then [`tune_in`] has nothing left to train.
///
/// # Errors
/// As for [`tune_in`].
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
    // Preparing a set reads all of it, so skip it if there is nothing to train.
    if !standing.behind.iter().any(|place| shard.has(*place)) {
        return Ok(End::Finished(part(ShardState::Waiting)));
    }
    let prepared = prepare(settings, &search.trials, set)?;
    execution.progress.begin(settings.total_epochs()?, "epochs");
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

/// Prepares the set for all trials and checks that each of them can begin.
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
        // Diverged trials come last, so the best one diverged only if all did.
        let Some(best) = best.filter(|best| best.reached.validation_loss_nats.is_some()) else {
            bail!("every trial diverged; choose other --channels or another --scaling");
        };
        let text = to_toml("the settings of the best trial", &best.settings)?;
        if let Some(figure) = report.figure() {
            figure.write_svg(&path.join(FIGURE))?;
        }
        write_atomically(&report.best, |out| out.write_all(text.as_bytes()))?;
        Ok(End::Finished(report))
    }

    /// Trains the trials of a part rung by rung, until it has to wait for other parts.
    /// Calls `after_rung` after each rung.
    fn train(
        &self,
        prepared: &Prepared,
        shard: Shard,
        hold: Hold,
        after_rung: &dyn Fn(&Standing) -> Result<()>,
    ) -> Result<End<ShardState>> {
        let mut standing = self.standing()?;
        // Epochs of earlier runs count as progress.
        self.execution.progress.advance(standing.epochs);
        while let Some(epochs) = standing.rung {
            // By place in the ranking, which all processes compute alike from the records.
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
            // Anew from the records: others may have finished more meanwhile.
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
        // In a shared search, a process presumed lost may still be at work.
        let _alone = match hold {
            Hold::Shared => Some(self.records.hold(trial)?),
            Hold::Alone => None,
        };
        let rung = epochs.end;
        // Another process may have trained it while we waited for its lock.
        if self.records.reached(trial, rung)?.is_some() {
            return Ok(End::Finished(()));
        }
        let reached = match self.train_to(trial, prepared, epochs) {
            Ok(End::Finished(history)) => Reached::from_history(&history, rung),
            Ok(End::Stopped) => return Ok(End::Stopped),
            // Settings for which training diverges are out; the search continues.
            Err(error) if matches!(error.downcast_ref(), Some(LearnError::Diverged(_))) => {
                Reached {
                    epochs: trial.reached.epochs,
                    ..Reached::default()
                }
            }
            Err(error) => return Err(error),
        };
        self.records.keep(trial, &reached, rung)?;
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
        let loss = self.reached.validation_loss_nats;
        let accuracy = self.reached.validation_balanced_accuracy;
        vec![
            self.number.to_string(),
            self.reached.epochs.to_string(),
            loss.map_or_else(|| "diverged".into(), |loss| format!("{loss:.4}")),
            accuracy.map_or_else(String::new, |value| format!("{value:.3}")),
            widths.join("-"),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learning::train::Source;

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
