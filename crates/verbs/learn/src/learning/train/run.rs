//! One training in its directory: start or continue, save regularly, write the results.

use super::figure::{learning_curve, predicted_numbers};
use super::history::HISTORY;
use super::metrics::{Metrics, Predictions};
use super::prepared::{Numbers, Prepared};
use super::settings::{Source, TrainSettings};
use super::trained_on::{TRAINED_ON, TrainedOn};
use super::weights::{Start, WeightSource};
use crate::learning::labels::{self, LABELS};
use anyhow::{Context, Error, Result, bail};
use protomer_common::range;
use protomer_io::atomic::write_bytes;
use protomer_io::csv::{Cell, Table};
use protomer_learn::Device;
use protomer_learn::logistic::prior;
use protomer_learn::network::NetworkSettings;
use protomer_learn::normal::NormalHead;
use protomer_learn::sample::SampleSource;
use protomer_learn::scores::Scores;
use protomer_learn::split::{Split, family_weights};
use protomer_learn::training::{
    EpochRecord, Loss, Model, NumberTargets, Observer, Outcome, PredictionSettings, StepReport,
    Trained, Training, TrainingSettings, epochs_done,
};
use protomer_results::{
    CHECKPOINT, Checkpoint, End, Execution, Layout, Record, ResultKind, ResultsDirectory, Run,
    Turn, Work, drive, settings,
};
use serde_json::Value;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// The trained network, with its scaling and its classes.
pub const MODEL: &str = "model.safetensors";
/// The settings of the training.
pub const SETTINGS: &str = "settings.toml";
const PREDICTIONS: &str = "predictions.csv";
const CURVE: &str = "learning_curve.svg";
/// Predicted against true numbers, if it is a number that is predicted.
pub const PREDICTED_NUMBERS: &str = "predicted_numbers.svg";
/// The directory of a training and its ablation.
const LAYOUT: Layout = Layout {
    kind: ResultKind::Training,
    settings: SETTINGS,
    results: &[
        "run.json",
        super::metrics::FILE_NAME,
        MODEL,
        HISTORY,
        PREDICTIONS,
        CURVE,
        PREDICTED_NUMBERS,
        CHECKPOINT,
        TRAINED_ON,
        LABELS,
        "ablation.csv",
        "ablation",
        "report.html",
    ],
    is_result: |_| false,
};

/// Checks that a training with these settings can begin.
///
/// # Errors
/// Says which settings are inconsistent.
pub fn check(settings: &TrainSettings, prepared: &Prepared) -> Result<()> {
    for (key, value) in [
        ("epochs", settings.training.epochs),
        ("batch", settings.training.batch),
        ("permutations", settings.permutations),
        ("least_samples", settings.least_samples),
    ] {
        range::OBJECTS.require(key, value as u64)?;
    }
    if settings.training.loss == Loss::Normal && prepared.numbers.is_none() {
        bail!("--loss normal predicts a number with its spread; add --target number, or omit it");
    }
    if settings.training.epochs == 0 {
        bail!("epochs is 0; give 1 or more");
    }
    let network = settings.network(prepared.classes.names.len());
    Ok(training(prepared, &network, &settings.training, None, Device::Cpu).check()?)
}

fn training<'a>(
    prepared: &'a Prepared,
    network: &'a NetworkSettings,
    settings: &'a TrainingSettings,
    start_from: Option<&'a Model>,
    device: Device,
) -> Training<'a> {
    let Prepared {
        view,
        classes,
        split,
        ..
    } = prepared;
    Training {
        source: view,
        classes,
        split,
        network,
        settings,
        numbers: prepared.numbers.as_ref().map(|numbers| NumberTargets {
            of_samples: &numbers.of_samples,
            classes: &numbers.classes,
        }),
        start_from,
        device,
    }
}

/// A training on a set, up to its last epoch.
pub struct TrainingRun<'a> {
    settings: &'a TrainSettings,
    prepared: &'a Prepared<'a>,
    network: NetworkSettings,
    training: TrainingSettings,
    device: Device,
    identity: String,
    /// The network that the weights start from.
    start: Option<Start>,
}

/// The state of a training.
#[derive(Debug, Default)]
pub struct Epochs {
    /// The state after the last epoch.
    checkpoint: Option<EngineCheckpoint>,
    done: u64,
    /// Whether the validation loss has stopped falling before the last epoch.
    has_ended_early: bool,
}

/// A checkpoint of the engine, in the engine's own format, which identifies its training.
#[derive(Debug, Clone)]
pub struct EngineCheckpoint {
    bytes: Vec<u8>,
    /// The file it was read from, for error messages.
    origin: Option<PathBuf>,
}

impl Checkpoint for EngineCheckpoint {
    fn to_bytes(&self, _kind: &str, _identity: &str) -> protomer_results::Result<Vec<u8>> {
        // The engine's own format names its training; kind and identity are in there.
        Ok(self.bytes.clone())
    }

    fn from_bytes(
        path: &Path,
        _kind: &str,
        _identity: &str,
        bytes: &[u8],
    ) -> protomer_results::Result<Self> {
        Ok(Self {
            bytes: bytes.to_vec(),
            origin: Some(path.to_owned()),
        })
    }
}

impl<'a> TrainingRun<'a> {
    /// A training up to the epoch of the settings.
    ///
    /// # Errors
    /// If the settings cannot be serialised.
    pub fn new(
        settings: &'a TrainSettings,
        prepared: &'a Prepared<'a>,
        device: Device,
    ) -> Result<Self> {
        Ok(Self {
            settings,
            prepared,
            network: settings.network(prepared.classes.names.len()),
            training: settings.training.clone(),
            device,
            // The digest of the set is among the settings.
            identity: settings::identity(settings, "")?,
            start: settings
                .weights_from
                .as_ref()
                .map(WeightSource::read)
                .transpose()?,
        })
    }

    /// The same training, up to another epoch.
    pub fn until_epoch(mut self, epoch: usize) -> Self {
        self.training.epochs = epoch;
        self
    }

    /// Whether a training with these metrics has come to the end of the settings: all epochs, or as many
    /// without a smaller validation loss as the patience allows.
    fn ends_with(&self, metrics: &Metrics) -> bool {
        let since_best = metrics.epochs - metrics.best_epoch.min(metrics.epochs);
        let patience = self.training.patience.map(|patience| patience.max(1));
        metrics.epochs >= self.training.epochs || patience.is_some_and(|most| since_best >= most)
    }

    fn engine(&self) -> Training<'_> {
        let device = self.device.clone();
        let start_from = self.start.as_ref().map(|start| &start.model);
        training(
            self.prepared,
            &self.network,
            &self.training,
            start_from,
            device,
        )
    }

    /// The network after the best epoch so far, with the history of its training.
    ///
    /// # Errors
    /// If the checkpoint belongs to another training.
    pub fn trained(&self, epochs: &Epochs) -> Result<Trained> {
        self.train(epochs, &mut ())
    }

    fn train(&self, epochs: &Epochs, observer: &mut dyn Observer) -> Result<Trained> {
        let engine = self.engine();
        let Some(checkpoint) = &epochs.checkpoint else {
            return Ok(engine.run(None, observer)?);
        };
        let trained = engine.run(Some(&checkpoint.bytes), observer);
        match &checkpoint.origin {
            Some(origin) => {
                trained.with_context(|| format!("continuing from {}", origin.display()))
            }
            None => Ok(trained?),
        }
    }
}

impl Run for TrainingRun<'_> {
    type State = Epochs;
    type Checkpoint = EngineCheckpoint;
    type Answer = Metrics;
    type Error = Error;

    fn work(&self) -> Work {
        Work::new(
            ResultKind::Training,
            "train",
            &self.identity,
            self.settings.source.digest(),
        )
    }

    fn length(&self) -> u64 {
        self.training.epochs as u64
    }

    fn open(&self, _directory: &Path, saved: Option<EngineCheckpoint>) -> Result<Epochs> {
        let done = match &saved {
            Some(saved) => epochs_done(&saved.bytes).with_context(|| {
                let origin = saved.origin.as_deref().unwrap_or(Path::new(CHECKPOINT));
                format!("continuing from {}", origin.display())
            })?,
            None => 0,
        };
        Ok(Epochs {
            checkpoint: saved,
            done: done as u64,
            has_ended_early: false,
        })
    }

    fn done(&self, epochs: &Epochs) -> u64 {
        if epochs.has_ended_early {
            // Ended early counts as whole, or the run would never be done.
            self.length()
        } else {
            epochs.done
        }
    }

    /// Trains one epoch. The engine resumes from its checkpoint every time, at negligible
    /// cost compared with an epoch.
    fn advance(&self, epochs: &mut Epochs, turn: &Turn<'_>) -> Result<()> {
        let mut one = OneEpoch {
            turn,
            checkpoint: None,
        };
        // Up to one epoch: the observer breaks off after it.
        let trained = self.train(epochs, &mut one)?;
        epochs.done = trained.history.len() as u64;
        epochs.has_ended_early = trained.outcome == Outcome::Stopped;
        // Broken off within an epoch: the checkpoint before it stays.
        if let Some(bytes) = one.checkpoint {
            epochs.checkpoint = Some(EngineCheckpoint {
                bytes,
                origin: None,
            });
        }
        Ok(())
    }

    fn save(&self, epochs: &mut Epochs) -> Result<EngineCheckpoint> {
        epochs
            .checkpoint
            .clone()
            .context("no epoch has been trained")
    }

    fn answer(&self, epochs: &mut Epochs, directory: &Path) -> Result<Metrics> {
        let trained = self.trained(epochs)?;
        let earlier = self.start.as_ref().map(|start| &start.trained_on);
        write_results(self.settings, self.prepared, trained, earlier, directory)
    }

    fn details(&self, _epochs: &mut Epochs, _directory: &Path) -> Result<Value> {
        Ok(Value::Null)
    }

    /// Reads the metrics. They are written last: their presence marks a training that was finished,
    /// whatever the record states. It may be asked to go on since.
    fn finished(&self, directory: &Path, _record: Option<&Record>) -> Result<Option<Metrics>> {
        let metrics = Metrics::read(directory)?;
        Ok(metrics.filter(|metrics| self.ends_with(metrics)))
    }

    /// Keeps the progress even if training failed.
    fn rescue(&self, epochs: &mut Epochs) -> Option<EngineCheckpoint> {
        epochs.checkpoint.clone()
    }
}

/// Ends a training after one epoch, or on request in the middle of it.
struct OneEpoch<'a> {
    turn: &'a Turn<'a>,
    checkpoint: Option<Vec<u8>>,
}

impl Observer for OneEpoch<'_> {
    fn step(&mut self, _report: StepReport) -> ControlFlow<()> {
        if self.turn.must_stop() {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }

    fn epoch(
        &mut self,
        _record: &EpochRecord,
        checkpoint: &dyn Fn() -> protomer_learn::Result<Vec<u8>>,
    ) -> protomer_learn::Result<ControlFlow<()>> {
        // Only whole epochs can be continued bit for bit.
        self.checkpoint = Some(checkpoint()?);
        Ok(ControlFlow::Break(()))
    }
}

/// Trains or continues in a directory and scores the result.
///
/// # Errors
/// For invalid settings, a directory that holds something else, or a file that cannot be written.
pub fn train_in(
    settings: &TrainSettings,
    set: &dyn SampleSource,
    path: &Path,
    device: &Device,
    execution: &Execution,
) -> Result<End<Metrics>> {
    let (end, _held) = train_holding(settings, set, path, device, execution)?;
    Ok(end)
}

/// Variant of [`train_in`] that also returns the directory, held for further work in it.
pub(super) fn train_holding(
    settings: &TrainSettings,
    set: &dyn SampleSource,
    path: &Path,
    device: &Device,
    execution: &Execution,
) -> Result<(End<Metrics>, ResultsDirectory)> {
    let prepared = Prepared::new(settings, set)?;
    check(settings, &prepared)?;
    let run = TrainingRun::new(settings, &prepared, device.clone())?;
    // Again, with the network to start from: nothing is written if it does not fit.
    run.engine().check()?;
    let held = ResultsDirectory::enter(path, &LAYOUT, settings, &run.identity, execution)?;
    if settings.labels.is_some() && !path.join(LABELS).exists() {
        // The labels stay with the training: the table may be lost, and predict scores by them.
        labels::write(set, path)?;
    }
    let end = drive(&run, path, execution)?;
    // Earlier versions did not write this file.
    if matches!(end, End::Finished(_)) && TrainedOn::read(path)?.is_none() {
        let earlier = run.start.as_ref().map(|start| &start.trained_on);
        note_samples(settings, &prepared, earlier, path)?;
    }
    Ok((end, held))
}

/// Records the structures that the network has seen. A control has none.
fn note_samples(
    settings: &TrainSettings,
    prepared: &Prepared,
    earlier: Option<&TrainedOn>,
    path: &Path,
) -> Result<()> {
    let earlier = earlier.map_or_else(Vec::new, |earlier| earlier.samples().cloned().collect());
    match settings.source {
        Source::Set { .. } => TrainedOn {
            earlier,
            ..TrainedOn::from_prepared(prepared)
        }
        .write(path),
        Source::Control { .. } => Ok(()),
    }
}

/// Calibrates, predicts the test part, and writes the results. The metrics come last: they mark a
/// finished training.
fn write_results(
    settings: &TrainSettings,
    prepared: &Prepared,
    trained: Trained,
    earlier: Option<&TrainedOn>,
    path: &Path,
) -> Result<Metrics> {
    let Prepared {
        view,
        descriptions,
        classes,
        numbers,
        split,
        ..
    } = prepared;
    let Trained {
        mut model,
        history,
        best_epoch,
        ..
    } = trained;
    let how = PredictionSettings {
        rotations: settings.rotations,
        ..PredictionSettings::default()
    };
    let weights = family_weights(descriptions);
    // On the validation part: neither fitted to nor scored on.
    let temperature = match (numbers, settings.training.loss) {
        (Some(numbers), Loss::Normal) => {
            let numbers = &numbers.of_samples;
            model.calibrate_spread(view, &split.validation, numbers, &weights, how)?
        }
        _ => model.calibrate(
            view,
            &split.validation,
            &classes.labels,
            Some(&weights),
            how,
        )?,
    };
    model.card.number_classes = numbers.as_ref().map(|numbers| numbers.classes.clone());
    let predicted = model.predict(view, &split.test, how)?;
    let predictions = Predictions {
        descriptions,
        labels: &classes.labels,
        numbers: numbers.as_ref(),
        classes: &classes.names,
        channels: &settings.training.channels,
        split,
        probabilities: &predicted.probabilities,
        predicted_numbers: &predicted.numbers,
        temperature,
        quarantined: &prepared.quarantined,
        other_labels: &prepared.other_labels,
        single_cluster_classes: &prepared.single_cluster_classes,
        epochs: history.len(),
        best_epoch,
        parameters: model.network.parameter_count(),
        permutations: settings.permutations,
        seed: settings.training.seed,
    };
    let mut metrics = predictions.metrics()?;
    metrics.seen_before = earlier.map_or(0, |earlier| {
        let structures = earlier.seen();
        let is_familiar = |sample: &&usize| {
            let cluster = &descriptions[**sample].cluster;
            structures
                .familiar(view.file_sha256(**sample), cluster)
                .is_some()
        };
        split.test.iter().filter(is_familiar).count()
    });
    predictions.write_csv(&path.join(PREDICTIONS))?;
    // The metrics are written below, last of all.
    let bytes = model.to_bytes()?;
    write_bytes(&path.join(MODEL), &bytes)?;
    let history_csv = history_table(&history)?.to_csv()?;
    write_bytes(&path.join(HISTORY), history_csv.as_bytes())?;
    if !history.is_empty() {
        write_curve(settings, prepared, &history, best_epoch, path)?;
    }
    if let Some(numbers) = numbers {
        let of_test = predictions.numbers_of_test(numbers);
        write_numbers(settings, numbers, split, of_test, path)?;
    }
    note_samples(settings, prepared, earlier, path)?;
    metrics.write(path)?;
    Ok(metrics)
}

/// Writes `predicted_numbers.svg`.
fn write_numbers(
    settings: &TrainSettings,
    numbers: &Numbers,
    split: &Split,
    predicted: Vec<f64>,
    path: &Path,
) -> Result<()> {
    let of_samples = split.test.iter().map(|sample| numbers.of_samples[*sample]);
    let pairs: Vec<(f64, f64)> = of_samples.zip(predicted).collect();
    let title = format!("Numbers from {}", settings.training.channels.join(", "));
    let caption = format!(
        "{} test samples, {} training samples in {} classes, seed {}",
        pairs.len(),
        split.training.len(),
        numbers.classes.count(),
        settings.training.seed
    );
    predicted_numbers(&title, &caption, &pairs).write_svg(&path.join(PREDICTED_NUMBERS))?;
    Ok(())
}

/// Writes `learning_curve.svg`, with the loss of the prior on the validation part.
fn write_curve(
    settings: &TrainSettings,
    prepared: &Prepared,
    history: &[EpochRecord],
    best_epoch: usize,
    path: &Path,
) -> Result<()> {
    let (split, classes) = (&prepared.split, &prepared.classes);
    let count = classes.names.len();
    let weights = family_weights(&prepared.descriptions);
    let shares = prior(&split.training, &classes.labels, Some(&weights), count);
    let (mut truth, mut of_validation) = (Vec::new(), Vec::new());
    for sample in &split.validation {
        truth.push(classes.labels[*sample]);
        of_validation.push(weights[*sample]);
    }
    let prior = shares.repeat(truth.len());
    let prior = Scores::from_probabilities(&prior, &truth, count, Some(&of_validation))?;
    let title = format!(
        "{count} classes from {}",
        settings.training.channels.join(", ")
    );
    let caption = format!(
        "{} training and {} validation samples, seed {}, best epoch {best_epoch}",
        split.training.len(),
        split.validation.len(),
        settings.training.seed
    );
    let prior = match (settings.training.loss, &prepared.numbers) {
        (Loss::Normal, Some(numbers)) => normal_prior(numbers, split, &weights)?,
        _ => prior.log_loss_nats,
    };
    learning_curve(&title, &caption, history, prior, count).write_svg(&path.join(CURVE))?;
    Ok(())
}

/// Loss of the validation part for mean and spread of the training part, nats.
fn normal_prior(numbers: &Numbers, split: &Split, weights: &[f64]) -> Result<f64> {
    let weighted = |part: &[usize]| -> Vec<(f64, f64)> {
        let pairs = part.iter();
        pairs
            .map(|sample| (numbers.of_samples[*sample], weights[*sample]))
            .collect()
    };
    let head = NormalHead::fit(&weighted(&split.training))?;
    let prior = head.predicted([0.0; 2], 1.0);
    let of_validation = weighted(&split.validation);
    let total: f64 = of_validation.iter().map(|(_, weight)| weight).sum();
    let losses = of_validation.iter();
    let losses = losses.map(|(number, weight)| weight * prior.loss_nats(*number, &head));
    Ok(losses.sum::<f64>() / total)
}

/// The table of `history.csv`: one row per epoch.
fn history_table(history: &[EpochRecord]) -> Result<Table> {
    let columns = [
        "epoch",
        "training_loss_nats",
        "validation_loss_nats",
        "validation_balanced_accuracy",
        "gradient_norm",
        "largest_gradient_norm",
        "learning_rate",
        "skipped_steps",
    ];
    let mut table = Table::new(columns);
    for record in history {
        table.push([
            record.epoch.into(),
            record.training_loss_nats.into(),
            Cell::from(record.validation_loss_nats),
            Cell::from(record.validation_balanced_accuracy),
            record.gradient_norm.into(),
            record.largest_gradient_norm.into(),
            record.learning_rate.into(),
            record.skipped_steps.into(),
        ])?;
    }
    Ok(table)
}
