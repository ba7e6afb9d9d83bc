//! The training loop.
//!
//! ```text
//! training part --shuffled, turned, scaled--> batches --cross entropy, gradient, Adam--> weights
//! validation part ------------------------------------------------------------------> log-loss: the best epoch
//! ```
//!
//! Order and rotations come from (seed, epoch, sample), so a training does not depend on threads,
//! and one that was interrupted goes on from the bytes of a checkpoint as if nothing had happened.

mod container;
mod loader;
mod model;
mod settings;

pub use model::{Model, ModelCard, PredictionSettings, Predictions};
pub use settings::{EpochRecord, Outcome, TrainingSettings};

use crate::augmentation::CubeRotation;
use crate::logistic::prior;
use crate::loss::adjust_logits;
use crate::scaling::{ChannelScaling, Quarantined, screen};
use crate::scores::Scores;
use crate::split::{Split, family_weights, shuffle};
use crate::targets::Classes;
use crate::{
    Adam, AdamSettings, LearnError, Network, NetworkSettings, Result, SampleSource, cross_entropy,
};
use candle_core::{Device, Tensor};
use container::{pack, unpack};
use loader::{Item, Loader};
use protomer_kernel::random::CounterRng;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// Purposes of the random numbers here.
const ORDER: u8 = 63;
const ROTATION: u8 = 64;

/// What is to be trained on what.
#[derive(Clone)]
pub struct Training<'a> {
    /// The samples.
    pub source: &'a dyn SampleSource,
    /// The class of each.
    pub classes: &'a Classes,
    /// Which of them train and which validate; those of the test part are not looked at.
    pub split: &'a Split,
    /// The shape of the network.
    pub network: &'a NetworkSettings,
    /// How to train.
    pub settings: &'a TrainingSettings,
    /// Where to compute.
    pub device: Device,
}

/// A trained network and how it came about.
#[derive(Debug, Clone)]
pub struct Trained {
    /// The network after its best epoch, with its scaling and the names of its classes.
    pub model: Model,
    /// All epochs.
    pub history: Vec<EpochRecord>,
    /// The epoch with the smallest validation loss, counted from 1; without validation samples the
    /// last; 0 if none ended.
    pub best_epoch: usize,
    /// Samples of the training and validation part that could not be used.
    pub quarantined: Vec<Quarantined>,
    /// How it ended.
    pub outcome: Outcome,
}

/// Where a training stands within an epoch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepReport {
    /// The epoch, counted from 1.
    pub epoch: usize,
    /// Steps done in it.
    pub step: usize,
    /// Steps of an epoch.
    pub steps: usize,
    /// Cross entropy of the step's samples, nats.
    pub loss_nats: f64,
}

/// Watches a training, keeps its checkpoints, and may end it.
pub trait Observer: Send {
    /// Before the first step: samples that will not be used.
    fn started(&mut self, _quarantined: &[Quarantined]) {}

    /// After a step; on `Break` the unfinished epoch is given up.
    fn step(&mut self, _report: StepReport) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// After an epoch; `checkpoint` writes down the state, from which [`Training::run`] goes on.
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

/// Watches nothing.
impl Observer for () {}

/// Trains on the processor from the beginning; [`Training::run`] offers more.
///
/// # Errors
/// As [`Training::run`].
pub fn train(
    source: &dyn SampleSource,
    classes: &Classes,
    split: &Split,
    network: &NetworkSettings,
    settings: &TrainingSettings,
    observer: &mut dyn Observer,
) -> Result<Trained> {
    Training {
        source,
        classes,
        split,
        network,
        settings,
        device: Device::Cpu,
    }
    .run(None, observer)
}

/// How many epochs the training of a checkpoint has done.
///
/// # Errors
/// [`LearnError::Settings`] if the bytes are not a checkpoint.
pub fn epochs_done(checkpoint: &[u8]) -> Result<usize> {
    let (_, progress): (_, Progress) = unpack(checkpoint, "checkpoint", &Device::Cpu)?;
    Ok(progress.history.len())
}

/// The part of a checkpoint that is no tensor.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Progress {
    /// Samples, labels and split, to refuse others.
    fingerprint: u64,
    settings: TrainingSettings,
    card: ModelCard,
    quarantined: Vec<Quarantined>,
    history: Vec<EpochRecord>,
    best_epoch: usize,
}

/// Everything that changes.
struct State {
    progress: Progress,
    network: Network,
    adam: Adam,
    /// Weights after the best epoch.
    best: Vec<(String, Tensor)>,
}

impl Training<'_> {
    /// Trains, from the beginning or from a checkpoint of the same training; with a checkpoint,
    /// `epochs` and `patience` may be new.
    ///
    /// The head's bias starts at (1 - τ) ln(share of the class). The loss is Σ w l / (B w̄) over
    /// the B samples of a batch, with w one over the size of a sample's family and w̄ its mean over
    /// the training part. Samples that cannot be read are left out.
    ///
    /// # Errors
    /// [`LearnError::Settings`] if settings, classes, split, network and source do not fit
    /// together, a class loses all its training samples, or the checkpoint is that of another
    /// training; [`LearnError::Diverged`] if training diverges.
    pub fn run(&self, checkpoint: Option<&[u8]>, observer: &mut dyn Observer) -> Result<Trained> {
        self.check()?;
        let places = self.settings.channel_places(self.source)?;
        let weights = family_weights(self.source.descriptions());
        let mut state = match checkpoint {
            Some(bytes) => self.resume(bytes)?,
            None => self.start(&weights)?,
        };
        observer.started(&state.progress.quarantined);
        let good = |part: &[usize]| {
            let bad = &state.progress.quarantined;
            part.iter()
                .copied()
                .filter(|sample| bad.iter().all(|bad| bad.sample != *sample))
                .collect::<Vec<_>>()
        };
        let (training, validation) = (good(&self.split.training), good(&self.split.validation));
        let mut outcome = Outcome::Completed;
        while state.progress.history.len() < self.settings.epochs {
            let epoch = state.progress.history.len() + 1;
            if self
                .settings
                .patience
                .is_some_and(|patience| epoch > state.progress.best_epoch + patience.max(1))
            {
                outcome = Outcome::Stopped;
                break;
            }
            let Some(mut record) =
                self.epoch(&mut state, epoch, &training, &places, &weights, observer)?
            else {
                outcome = Outcome::Interrupted;
                break;
            };
            if !validation.is_empty() {
                let scores = self.validate(&state, &validation, &weights)?;
                record.validation_loss_nats = Some(scores.log_loss_nats);
                record.validation_balanced_accuracy = Some(scores.balanced_accuracy);
            }
            let loss_of = |record: &EpochRecord| record.validation_loss_nats;
            let before = state
                .progress
                .best_epoch
                .checked_sub(1)
                .and_then(|best| state.progress.history.get(best));
            let better = match (loss_of(&record), before.and_then(loss_of)) {
                (Some(now), Some(before)) => now < before,
                _ => true,
            };
            if better {
                state.progress.best_epoch = epoch;
                state.best = copies(&state.network)?;
            }
            state.progress.history.push(record.clone());
            if observer.epoch(&record, &|| state.checkpoint())?.is_break() {
                outcome = Outcome::Interrupted;
                break;
            }
        }
        state.finish(outcome)
    }

    /// Whether settings, classes, split, network and source fit together; [`Training::run`] asks
    /// this first.
    ///
    /// # Errors
    /// [`LearnError::Settings`] says what does not fit.
    pub fn check(&self) -> Result<()> {
        self.settings.check()?;
        self.network.check()?;
        let samples = self.source.descriptions().len();
        self.split.check(samples)?;
        let refuse = |reason: String| Err(LearnError::Settings(reason));
        let (names, labels) = (self.classes.names.len(), &self.classes.labels);
        if labels.len() != samples || labels.iter().any(|label| *label >= names) {
            return refuse(format!(
                "{} labels of {names} classes for {samples} samples",
                labels.len()
            ));
        }
        if self.split.training.is_empty() {
            return refuse("the training part is empty".into());
        }
        let channels = self.settings.channel_places(self.source)?.len();
        if self.network.channels != channels || self.network.classes != names {
            let (seen, told_apart) = (self.network.channels, self.network.classes);
            let network = format!("the network is for {seen} channels and {told_apart} classes");
            return refuse(format!(
                "{network}, the data have {channels} channels and {names} classes"
            ));
        }
        if self.source.size() < self.network.smallest_edge() {
            let (size, smallest) = (self.source.size(), self.network.smallest_edge());
            return refuse(format!(
                "grids of {size}³ voxels: this network needs {smallest}³; take fewer blocks or a finer grid"
            ));
        }
        Ok(())
    }

    fn start(&self, weights: &[f64]) -> Result<State> {
        let (training, mut quarantined) = screen(self.source, &self.split.training);
        quarantined.extend(screen(self.source, &self.split.validation).1);
        let labels = &self.classes.labels;
        for sample in &self.split.training {
            let class = labels[*sample];
            if !training.iter().any(|kept| labels[*kept] == class) {
                let name = &self.classes.names[class];
                let why = quarantined
                    .iter()
                    .find(|bad| bad.sample == *sample)
                    .map_or("", |bad| &bad.reason);
                let reason = format!(
                    "no training sample of the class {name} can be read, for instance: {why}"
                );
                return Err(LearnError::Settings(reason));
            }
        }
        let scaling = ChannelScaling::fit(self.source, &training, self.settings.scaling)?;
        let shares = prior(&training, labels, Some(weights), self.classes.names.len());
        let log_prior: Vec<f64> = shares.into_iter().map(f64::ln).collect();
        let network = Network::new(self.network, self.settings.seed, &self.device)?;
        let bias = |log_prior: &f64| ((1.0 - self.settings.logit_adjustment) * log_prior) as f32;
        network.set_head_bias(&log_prior.iter().map(bias).collect::<Vec<_>>())?;
        let places = self.settings.channel_places(self.source)?;
        let card = ModelCard {
            network: self.network.clone(),
            size: self.source.size(),
            channels: places
                .iter()
                .map(|place| self.source.channels()[*place].clone())
                .collect(),
            scaling,
            classes: self.classes.names.clone(),
            log_prior,
            logit_adjustment: self.settings.logit_adjustment,
            temperature: 1.0,
            made_with: self.source.made_with().cloned(),
        };
        let progress = Progress {
            fingerprint: self.fingerprint(),
            settings: self.settings.clone(),
            card,
            quarantined,
            history: Vec::new(),
            best_epoch: 0,
        };
        Ok(State {
            best: copies(&network)?,
            adam: self.adam(&network)?,
            network,
            progress,
        })
    }

    fn adam(&self, network: &Network) -> Result<Adam> {
        let TrainingSettings {
            learning_rate,
            weight_decay,
            ..
        } = *self.settings;
        Adam::new(
            network.parameters(),
            AdamSettings {
                learning_rate,
                weight_decay,
                ..AdamSettings::default()
            },
        )
    }

    fn resume(&self, bytes: &[u8]) -> Result<State> {
        let (tensors, mut progress): (Vec<(String, Tensor)>, Progress) =
            unpack(bytes, "checkpoint", &self.device)?;
        let refuse = |what: &str| {
            let reason = format!(
                "the checkpoint is that of another training: {what}; start anew or use what it was for"
            );
            Err(LearnError::Settings(reason))
        };
        if progress.fingerprint != self.fingerprint() {
            return refuse("samples, classes or split differ");
        }
        if progress.card.network != *self.network {
            return refuse("the network differs");
        }
        if !self.settings.continues(&progress.settings) {
            return refuse("the settings differ in more than epochs and patience");
        }
        progress.settings = self.settings.clone();
        let part = |prefix: &str| {
            let strip = |(name, tensor): &(String, Tensor)| {
                Some((name.strip_prefix(prefix)?.to_string(), tensor.clone()))
            };
            tensors.iter().filter_map(strip).collect::<Vec<_>>()
        };
        let network = Network::new(self.network, self.settings.seed, &self.device)?;
        let (weights, best) = (part("network."), part("best."));
        if weights.len() != network.parameters().len() || best.len() != weights.len() {
            return Err(LearnError::Settings(
                "the checkpoint lacks weights: it is damaged".into(),
            ));
        }
        for (name, tensor) in &weights {
            network.set_parameter(name, tensor)?;
        }
        let mut adam = self.adam(&network)?;
        adam.load_state(&part("optimiser."))?;
        Ok(State {
            progress,
            network,
            adam,
            best,
        })
    }

    /// One pass over the training part; none if the observer ends it.
    fn epoch(
        &self,
        state: &mut State,
        epoch: usize,
        training: &[usize],
        places: &[usize],
        weights: &[f64],
        observer: &mut dyn Observer,
    ) -> Result<Option<EpochRecord>> {
        let settings = self.settings;
        let items = self.items(training, epoch);
        let batches: Vec<&[Item]> = items.chunks(settings.batch).collect();
        let mean_weight =
            training.iter().map(|sample| weights[*sample]).sum::<f64>() / training.len() as f64;
        let log_prior: Vec<f32> = state
            .progress
            .card
            .log_prior
            .iter()
            .map(|value| *value as f32)
            .collect();
        let State {
            network,
            adam,
            progress,
            ..
        } = state;
        let loader = Loader {
            source: self.source,
            scaling: &progress.card.scaling,
            channels: places,
            device: &self.device,
        };
        let (mut loss_sum, mut weight_sum) = (0.0, 0.0);
        let (mut norm_sum, mut largest_norm, mut skipped, mut rate) = (0.0, 0.0_f64, 0, 0.0);
        let completed = loader.each(&batches, |step, batch| {
            let labels: Vec<u32> = batches[step]
                .iter()
                .map(|item| self.classes.labels[item.sample] as u32)
                .collect();
            let of_batch: Vec<f32> = batches[step]
                .iter()
                .map(|item| weights[item.sample] as f32)
                .collect();
            let weight: f64 = batches[step].iter().map(|item| weights[item.sample]).sum();
            let logits = network.forward(&batch)?;
            let logits = adjust_logits(&logits, &log_prior, settings.logit_adjustment)?;
            let loss = cross_entropy(&logits, &labels, &of_batch)?;
            let value = f64::from(loss.to_scalar::<f32>()?);
            let gradients = (loss * (weight / (labels.len() as f64 * mean_weight)))?.backward()?;
            rate = settings.rate((epoch - 1) * batches.len() + step, batches.len());
            let norm = adam.step(&gradients, rate, settings.clip)?;
            if value.is_finite() && norm.is_finite() {
                loss_sum += weight * value;
                weight_sum += weight;
                norm_sum += norm;
                largest_norm = largest_norm.max(norm);
            } else {
                skipped += 1;
            }
            Ok(observer.step(StepReport {
                epoch,
                step: step + 1,
                steps: batches.len(),
                loss_nats: value,
            }))
        })?;
        if !completed {
            return Ok(None);
        }
        if skipped == batches.len() {
            return Err(LearnError::Diverged(format!(
                "no step of epoch {epoch} had a finite gradient"
            )));
        }
        Ok(Some(EpochRecord {
            epoch,
            training_loss_nats: loss_sum / weight_sum,
            validation_loss_nats: None,
            validation_balanced_accuracy: None,
            gradient_norm: norm_sum / (batches.len() - skipped) as f64,
            largest_gradient_norm: largest_norm,
            learning_rate: rate,
            skipped_steps: skipped,
        }))
    }

    /// The training samples of an epoch in a random order, each with its rotation.
    fn items(&self, training: &[usize], epoch: usize) -> Vec<Item> {
        let (seed, step) = (self.settings.seed, epoch as u64);
        let turn = |sample: usize| {
            let mut rng = CounterRng::for_purpose(seed, sample as u32, step, ROTATION);
            if self.settings.augment {
                rng.index(CubeRotation::COUNT)
            } else {
                0
            }
        };
        let mut items: Vec<Item> = training
            .iter()
            .map(|sample| Item {
                sample: *sample,
                turn: turn(*sample),
            })
            .collect();
        shuffle(
            &mut items,
            &mut CounterRng::for_purpose(seed, 0, step, ORDER),
        );
        items
    }

    fn validate(&self, state: &State, validation: &[usize], weights: &[f64]) -> Result<Scores> {
        let model = Model {
            network: state.network.clone(),
            card: state.progress.card.clone(),
        };
        let how = PredictionSettings {
            batch: self.settings.batch,
            ..PredictionSettings::default()
        };
        let p = model.probabilities(self.source, validation, how)?;
        let labels: Vec<usize> = validation
            .iter()
            .map(|sample| self.classes.labels[*sample])
            .collect();
        let weights: Vec<f64> = validation.iter().map(|sample| weights[*sample]).collect();
        Scores::of(&p, &labels, self.classes.names.len(), Some(&weights))
    }

    /// The hash of Fowler, Noll and Vo (FNV-1a, 64 bits) over everything that decides which sample
    /// is what.
    fn fingerprint(&self) -> u64 {
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut add = |bytes: &[u8]| {
            for byte in (bytes.len() as u64).to_le_bytes().iter().chain(bytes) {
                hash = (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
            }
        };
        add(&(self.source.size() as u64).to_le_bytes());
        self.source
            .channels()
            .iter()
            .chain(&self.classes.names)
            .for_each(|name| add(name.as_bytes()));
        for (description, label) in self.source.descriptions().iter().zip(&self.classes.labels) {
            add(description.name.as_bytes());
            add(description.family.as_bytes());
            add(&(*label as u64).to_le_bytes());
        }
        for part in [&self.split.training, &self.split.validation] {
            let bytes: Vec<u8> = part
                .iter()
                .flat_map(|sample| (*sample as u64).to_le_bytes())
                .collect();
            add(&bytes);
        }
        hash
    }
}

impl State {
    fn checkpoint(&self) -> Result<Vec<u8>> {
        let named = |prefix: &'static str| {
            move |(name, tensor): (String, Tensor)| (format!("{prefix}.{name}"), tensor)
        };
        let tensors = copies(&self.network)?.into_iter().map(named("network"));
        let tensors = tensors.chain(self.best.iter().cloned().map(named("best")));
        let tensors: Vec<_> = tensors
            .chain(self.adam.state().into_iter().map(named("optimiser")))
            .collect();
        pack(&tensors, &self.progress)
    }

    fn finish(self, outcome: Outcome) -> Result<Trained> {
        for (name, tensor) in &self.best {
            self.network.set_parameter(name, tensor)?;
        }
        let Progress {
            card,
            quarantined,
            history,
            best_epoch,
            ..
        } = self.progress;
        Ok(Trained {
            model: Model {
                network: self.network,
                card,
            },
            history,
            best_epoch,
            quarantined,
            outcome,
        })
    }
}

/// The weights as they are now; the parameters themselves change in place.
fn copies(network: &Network) -> Result<Vec<(String, Tensor)>> {
    network
        .parameters()
        .iter()
        .map(|(name, var)| Ok((name.clone(), var.as_detached_tensor().copy()?)))
        .collect()
}

#[cfg(test)]
mod tests;
