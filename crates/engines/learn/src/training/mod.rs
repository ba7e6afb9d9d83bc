//! The training loop.
//!
//! ```text
//! training part --shuffled, turned, scaled--> batches --cross entropy, gradient, Adam--> weights
//! validation part --> log-loss after each epoch --> the best epoch
//! ```
//!
//! Order and rotations come from (seed, epoch, sample), so a training does not depend on threads.
//! An interrupted training continues from the bytes of a checkpoint and ends with the same weights.
//!
//! | module | one idea |
//! |---|---|
//! | `settings` | how to train, and what is known of each epoch |
//! | `state` | everything that changes, its start, and its checkpoints |
//! | `epoch` | one pass over the training part |
//! | `loader` | batches, read while the one before is being worked on |
//! | `model` | a trained network with everything a prediction needs |
//! | `container` | tensors and a description as bytes |

mod container;
mod epoch;
mod loader;
mod model;
mod settings;
mod state;

pub use model::{Model, ModelCard, PredictionSettings, Predictions};
pub use settings::{EpochRecord, Loss, Outcome, TrainingSettings};
pub use state::epochs_done;

use crate::error::refuse;
use crate::normal::OUTPUTS;
use crate::number_classes::NumberClasses;
use crate::scaling::Quarantined;
use crate::scores::Scores;
use crate::split::{Split, family_weights};
use crate::targets::Classes;
use crate::{NetworkSettings, Result, SampleSource};
use candle_core::Device;
use state::State;
use std::ops::ControlFlow;

/// A training: samples, classes, split, network, settings and device.
///
/// ```
/// use protomer_learn::controls::{Control, Form, Variant};
/// use protomer_learn::split::{Fractions, Split};
/// use protomer_learn::targets::{Classes, Target};
/// use protomer_learn::training::{Training, TrainingSettings};
/// use protomer_learn::{Device, SampleSource};
///
/// let control = Control::Shapes;
/// let set = control.samples(Variant::Usual, 60, 16, 1);
/// let labels: Vec<&str> = set.descriptions().iter().map(|sample| &*sample.label).collect();
/// let classes = Classes::from_labels(&labels, Target::Label, 1)?;
/// let split = Split::grouped(set.descriptions(), 1, Fractions::default())?;
/// let experiment = &control.experiments()[0];
/// let training = Training {
///     source: &set,
///     classes: &classes,
///     split: &split,
///     network: &control.network(experiment, Form::Short),
///     settings: &TrainingSettings { epochs: 1, ..TrainingSettings::default() },
///     numbers: None,
///     start_from: None,
///     device: Device::Cpu,
/// };
/// let trained = training.run(None, &mut ())?;
/// assert_eq!((trained.history.len(), trained.best_epoch), (1, 1));
/// assert_eq!(trained.model.card.classes, classes.names);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
#[derive(Clone)]
pub struct Training<'a> {
    /// The samples.
    pub source: &'a dyn SampleSource,
    /// The class of each sample.
    pub classes: &'a Classes,
    /// Split of the samples. The test part is not looked at.
    pub split: &'a Split,
    /// The shape of the network.
    pub network: &'a NetworkSettings,
    /// Settings of the training.
    pub settings: &'a TrainingSettings,
    /// The numbers of the samples, for the loss of numbers.
    pub numbers: Option<NumberTargets<'a>>,
    /// The network whose weights the training starts from; fresh weights if there is none.
    pub start_from: Option<&'a Model>,
    /// Device on which to compute.
    pub device: Device,
}

/// Numbers that a network predicts with their spread.
#[derive(Debug, Clone, Copy)]
pub struct NumberTargets<'a> {
    /// The number of each sample.
    pub of_samples: &'a [f64],
    /// The classes that the numbers are cut into, for scores of classes.
    pub classes: &'a NumberClasses,
}

/// A trained network and how it came about.
#[derive(Debug, Clone)]
pub struct Trained {
    /// The network after its best epoch, with its scaling and the names of its classes.
    pub model: Model,
    /// Records of all epochs.
    pub history: Vec<EpochRecord>,
    /// The epoch with the smallest validation loss, counted from 1. Without validation samples it
    /// is the last epoch, and 0 if no epoch ended.
    pub best_epoch: usize,
    /// Samples of the training and validation part that could not be used.
    pub quarantined: Vec<Quarantined>,
    /// Outcome of the training.
    pub outcome: Outcome,
}

/// Progress of a training within an epoch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepReport {
    /// The epoch, counted from 1.
    pub epoch: usize,
    /// Steps done in the epoch.
    pub step: usize,
    /// Steps of an epoch.
    pub steps: usize,
    /// Cross entropy of the step's samples, nats.
    pub loss_nats: f64,
}

/// Watches a training, keeps its checkpoints, and may end it. `()` watches nothing.
///
/// ```
/// use protomer_learn::Result;
/// use protomer_learn::training::{EpochRecord, Observer};
/// use std::ops::ControlFlow;
///
/// /// Ends a training as soon as its validation loss is below a level.
/// struct UntilGood {
///     loss_nats: f64,
/// }
///
/// impl Observer for UntilGood {
///     fn epoch(
///         &mut self,
///         record: &EpochRecord,
///         _checkpoint: &dyn Fn() -> Result<Vec<u8>>,
///     ) -> Result<ControlFlow<()>> {
///         let is_good = record.validation_loss_nats.is_some_and(|loss| loss < self.loss_nats);
///         Ok(if is_good { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
///     }
/// }
/// ```
pub trait Observer: Send {
    /// Called before the first step with the samples that will not be used.
    fn started(&mut self, _quarantined: &[Quarantined]) {}

    /// Called after each step. `Break` drops the unfinished epoch and ends the training.
    fn step(&mut self, _report: StepReport) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// Called after each epoch. `checkpoint` writes down the state from which [`Training::run`]
    /// continues; `Break` ends the training.
    ///
    /// # Errors
    /// An error ends the training.
    fn epoch(
        &mut self,
        _record: &EpochRecord,
        _checkpoint: &dyn Fn() -> Result<Vec<u8>>,
    ) -> Result<ControlFlow<()>> {
        Ok(ControlFlow::Continue(()))
    }
}

impl Observer for () {}

/// Trains on the processor from the beginning. [`Training::run`] offers more.
///
/// # Errors
/// As for [`Training::run`].
pub fn train(
    source: &dyn SampleSource,
    classes: &Classes,
    split: &Split,
    network: &NetworkSettings,
    settings: &TrainingSettings,
    observer: &mut dyn Observer,
) -> Result<Trained> {
    let training = Training {
        source,
        classes,
        split,
        network,
        settings,
        numbers: None,
        start_from: None,
        device: Device::Cpu,
    };
    training.run(None, observer)
}

/// The samples that can be used, and what each step needs to know of them.
struct Parts {
    training: Vec<usize>,
    validation: Vec<usize>,
    /// Places of the chosen channels in the source.
    channels: Vec<usize>,
    /// Weight of every sample of the source.
    weights: Vec<f64>,
}

impl Training<'_> {
    /// Trains, from the beginning or from a checkpoint of the same training. With a checkpoint,
    /// `epochs` and `patience` may be new.
    ///
    /// With `start_from`, blocks start from the weights of that network, and its scaling is kept. So does
    /// the head, if it tells the same classes apart. Otherwise the head's bias starts at (1 - τ) ln(share
    /// of the class). The loss is Σ w l / (B w̄) over
    /// the B samples of a batch, with w one over the size of a sample's family and w̄ its mean over
    /// the training part. Samples that cannot be read are left out.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) if settings, classes, split, network
    /// and source do not fit together, a class loses all its training samples, or the checkpoint is
    /// that of another training. [`LearnError::Diverged`](crate::LearnError::Diverged) if training
    /// diverges.
    pub fn run(&self, checkpoint: Option<&[u8]>, observer: &mut dyn Observer) -> Result<Trained> {
        self.check()?;
        let weights = family_weights(self.source.descriptions());
        let mut state = match checkpoint {
            Some(bytes) => State::resume(self, bytes)?,
            None => State::start(self, &weights)?,
        };
        observer.started(&state.progress.quarantined);
        let parts = Parts {
            training: state.usable(&self.split.training),
            validation: state.usable(&self.split.validation),
            channels: self.settings.channel_places(self.source)?,
            weights,
        };
        let outcome = self.run_epochs(&mut state, &parts, observer)?;
        state.finish(outcome)
    }

    /// The epochs that are left.
    fn run_epochs(
        &self,
        state: &mut State,
        parts: &Parts,
        observer: &mut dyn Observer,
    ) -> Result<Outcome> {
        while state.progress.history.len() < self.settings.epochs {
            if state.is_out_of_patience(self.settings) {
                return Ok(Outcome::Stopped);
            }
            let Some(mut record) = epoch::run(self, state, parts, observer)? else {
                return Ok(Outcome::Interrupted);
            };
            if !parts.validation.is_empty() {
                let scores = self.validate(state, parts)?;
                record.validation_loss_nats = Some(scores.log_loss_nats);
                record.validation_balanced_accuracy = Some(scores.balanced_accuracy);
            }
            state.note(record.clone())?;
            if observer.epoch(&record, &|| state.checkpoint())?.is_break() {
                return Ok(Outcome::Interrupted);
            }
        }
        Ok(Outcome::Completed)
    }

    fn validate(&self, state: &State, parts: &Parts) -> Result<Scores> {
        let model = state.model();
        let how = PredictionSettings {
            batch: self.settings.batch,
            ..PredictionSettings::default()
        };
        let outputs = model.outputs(self.source, &parts.validation, how)?;
        let probabilities = outputs.probabilities;
        let (mut labels, mut weights) = (Vec::new(), Vec::new());
        for sample in &parts.validation {
            labels.push(self.classes.labels[*sample]);
            weights.push(parts.weights[*sample]);
        }
        let classes = self.classes.names.len();
        let mut scores =
            Scores::from_probabilities(&probabilities, &labels, classes, Some(&weights))?;
        if let (Some(numbers), Some(head)) = (&self.numbers, &state.progress.card.normal) {
            let pairs = parts.validation.iter().zip(&outputs.numbers).zip(&weights);
            let losses = pairs.map(|((sample, predicted), weight)| {
                weight * predicted.loss_nats(numbers.of_samples[*sample], head)
            });
            scores.log_loss_nats = losses.sum::<f64>() / weights.iter().sum::<f64>();
        }
        Ok(scores)
    }

    /// Refuses a network to start from that sees something else, or consists of other blocks.
    fn require_start(&self, model: &Model) -> Result<()> {
        let theirs = &model.card;
        let has_same_blocks = theirs.network.blocks == self.network.blocks
            && theirs.network.pooling == self.network.pooling;
        if !has_same_blocks {
            return refuse(
                "the weights are those of a network of other blocks or another pooling; omit the flags of \
                 the network",
            );
        }
        let all = self.source.channels();
        let places = self.settings.channel_places(self.source)?;
        let channels: Vec<String> = places.iter().map(|place| all[*place].clone()).collect();
        if theirs.channels != channels || theirs.scaling.channels != all {
            return refuse(format!(
                "the weights are those of a network that sees {} of a set with {}; here it is {} of {}",
                theirs.channels.join(", "),
                theirs.scaling.channels.join(", "),
                channels.join(", "),
                all.join(", ")
            ));
        }
        Ok(())
    }

    /// Checks that settings, classes, split, network and source fit together. [`Training::run`]
    /// does so first.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) says what does not fit.
    pub fn check(&self) -> Result<()> {
        self.settings.check()?;
        self.network.check()?;
        let samples = self.source.descriptions().len();
        self.split.check(samples)?;
        let (names, labels) = (self.classes.names.len(), &self.classes.labels);
        if labels.len() != samples || labels.iter().any(|label| *label >= names) {
            let count = labels.len();
            return refuse(format!(
                "{count} labels of {names} classes for {samples} samples"
            ));
        }
        if self.split.training.is_empty() {
            return refuse("the training part is empty");
        }
        let channels = self.settings.channel_places(self.source)?.len();
        let NetworkSettings {
            channels: seen,
            classes: told_apart,
            ..
        } = *self.network;
        let outputs = match (self.settings.loss, &self.numbers) {
            (Loss::CrossEntropy, _) => names,
            (Loss::Normal, Some(numbers)) if numbers.of_samples.len() == samples => OUTPUTS,
            (Loss::Normal, _) => {
                return refuse("the loss 'normal' needs a number for each sample");
            }
        };
        if seen != channels || told_apart != outputs {
            return refuse(format!(
                "the network is for {seen} channels and has {told_apart} outputs, the data have \
                 {channels} channels and need {outputs} outputs"
            ));
        }
        if let Some(model) = self.start_from {
            self.require_start(model)?;
        }
        let (size, smallest) = (self.source.size(), self.network.smallest_edge());
        if size < smallest {
            return refuse(format!(
                "grids of {size}³ voxels: this network needs {smallest}³; take fewer blocks or a \
                 finer grid"
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
