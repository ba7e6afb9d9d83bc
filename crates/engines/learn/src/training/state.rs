//! Everything that changes during a training: its start, its checkpoints, its end.

use super::container::{pack, unpack};
use super::settings::{Loss, TrainingSettings};
use super::{EpochRecord, Model, ModelCard, Outcome, Trained, Training};
use crate::error::refuse;
use crate::logistic::prior;
use crate::normal::NormalHead;
use crate::scaling::{ChannelScaling, Quarantined, screen};
use crate::{Adam, AdamSettings, Network, Result};
use candle_core::{Device, Tensor};
use serde::{Deserialize, Serialize};

/// Number of epochs that the training of a checkpoint has done.
///
/// # Errors
/// [`crate::LearnError::Settings`] if the bytes are not a checkpoint.
pub fn epochs_done(checkpoint: &[u8]) -> Result<usize> {
    let (_, progress): (_, Progress) = unpack(checkpoint, "checkpoint", &Device::Cpu)?;
    Ok(progress.history.len())
}

/// The part of a checkpoint that is not a tensor.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Progress {
    /// Fingerprint of samples, labels and split, to refuse others.
    fingerprint: u64,
    settings: TrainingSettings,
    pub card: ModelCard,
    pub quarantined: Vec<Quarantined>,
    pub history: Vec<EpochRecord>,
    best_epoch: usize,
}

/// Advice for a damaged checkpoint.
const RESTORE: &str = "restore it, or start again with --force";

/// Tensors with their names.
type Named = Vec<(String, Tensor)>;

/// State of a training: everything that changes.
pub(super) struct State {
    pub progress: Progress,
    pub network: Network,
    pub adam: Adam,
    /// Weights after the best epoch.
    best: Named,
}

impl State {
    /// The state before the first epoch.
    pub fn start(training: &Training, weights: &[f64]) -> Result<Self> {
        let (usable, mut quarantined) = screen(training.source, &training.split.training);
        quarantined.extend(screen(training.source, &training.split.validation).1);
        check_classes(training, &usable, &quarantined)?;
        let mut card = card(training, &usable, weights)?;
        let network = Network::new(training.network, training.settings.seed, &training.device)?;
        let has_head = match training.start_from {
            Some(model) => adopt(model, &network, &mut card)?,
            None => false,
        };
        if !has_head && card.normal.is_none() {
            let mut bias = Vec::with_capacity(card.log_prior.len());
            for log_prior in &card.log_prior {
                bias.push(((1.0 - training.settings.logit_adjustment) * log_prior) as f32);
            }
            network.set_head_bias(&bias)?;
        }
        let progress = Progress {
            fingerprint: fingerprint(training),
            settings: training.settings.clone(),
            card,
            quarantined,
            history: Vec::new(),
            best_epoch: 0,
        };
        Ok(Self {
            best: copies(&network)?,
            adam: adam(training, &network)?,
            network,
            progress,
        })
    }

    /// The state that [`State::checkpoint`] wrote down.
    pub fn resume(training: &Training, bytes: &[u8]) -> Result<Self> {
        let (tensors, mut progress): (Named, Progress) =
            unpack(bytes, "checkpoint", &training.device)?;
        if let Some(difference) = progress.difference_to(training) {
            return refuse(format!(
                "the checkpoint is that of another training: {difference}; start again with \
                 --force, or use what it was for"
            ));
        }
        progress.require_fit(training)?;
        progress.settings = training.settings.clone();
        let network = Network::new(training.network, training.settings.seed, &training.device)?;
        let (weights, best) = (
            with_prefix(&tensors, "network."),
            with_prefix(&tensors, "best."),
        );
        let parameters = network.parameters().len();
        require_length("tensors of weights", weights.len(), parameters)?;
        require_length("tensors of the best weights", best.len(), parameters)?;
        // The best weights first: setting them shows that names and shapes are right.
        for (name, tensor) in best.iter().chain(&weights) {
            network.set_parameter(name, tensor)?;
        }
        let mut adam = adam(training, &network)?;
        adam.load_state(&with_prefix(&tensors, "optimiser."))?;
        let state = Self {
            progress,
            network,
            adam,
            best,
        };
        state.require_steps(training)?;
        Ok(state)
    }

    /// Refuses a state whose optimiser has not taken one step per batch of the epochs done. It takes
    /// none where the gradient is not finite; such a step is among those that the history calls
    /// skipped, with those whose loss alone is not finite.
    fn require_steps(&self, training: &Training) -> Result<()> {
        let samples = self.usable(&training.split.training).len();
        let batches = samples.div_ceil(training.settings.batch);
        let history = &self.progress.history;
        let most = batches * history.len();
        let skipped = history
            .iter()
            .map(|record| record.skipped_steps.min(batches));
        let least = most - skipped.sum::<usize>();
        let steps = self.adam.steps() as usize;
        if (least..=most).contains(&steps) {
            return Ok(());
        }
        refuse(format!(
            "the checkpoint has {steps} steps of the optimiser where its epochs have {least} to {most}; \
             {RESTORE}"
        ))
    }

    /// The state as bytes.
    pub fn checkpoint(&self) -> Result<Vec<u8>> {
        let parts = [
            ("network", copies(&self.network)?),
            ("best", self.best.clone()),
            ("optimiser", self.adam.state()),
        ];
        let mut tensors = Named::new();
        for (prefix, part) in parts {
            for (name, tensor) in part {
                tensors.push((format!("{prefix}.{name}"), tensor));
            }
        }
        pack(&tensors, &self.progress)
    }

    /// The samples that are not quarantined.
    pub fn usable(&self, samples: &[usize]) -> Vec<usize> {
        let mut usable = samples.to_vec();
        for bad in &self.progress.quarantined {
            usable.retain(|sample| *sample != bad.sample);
        }
        usable
    }

    /// Whether the validation loss has not fallen for `patience` epochs, at least one.
    pub fn is_out_of_patience(&self, settings: &TrainingSettings) -> bool {
        let since_best = self.progress.history.len() - self.progress.best_epoch;
        let patience = settings.patience.map(|patience| patience.max(1));
        patience.is_some_and(|patience| since_best >= patience)
    }

    /// Takes note of an epoch, and of the weights if it is the best so far. Without validation
    /// samples every epoch is.
    pub fn note(&mut self, record: EpochRecord) -> Result<()> {
        let best = self.progress.best_epoch.checked_sub(1);
        let before = best.and_then(|best| self.progress.history.get(best));
        let loss_before = before.and_then(|record| record.validation_loss_nats);
        let is_better = match (record.validation_loss_nats, loss_before) {
            (Some(now), Some(before)) => now < before,
            _ => true,
        };
        if is_better {
            self.progress.best_epoch = record.epoch;
            self.best = copies(&self.network)?;
        }
        self.progress.history.push(record);
        Ok(())
    }

    /// The network as it is now.
    pub fn model(&self) -> Model {
        Model {
            network: self.network.clone(),
            card: self.progress.card.clone(),
        }
    }

    /// The network after its best epoch.
    pub fn finish(self, outcome: Outcome) -> Result<Trained> {
        for (name, tensor) in &self.best {
            self.network.set_parameter(name, tensor)?;
        }
        Ok(Trained {
            model: self.model(),
            history: self.progress.history,
            best_epoch: self.progress.best_epoch,
            quarantined: self.progress.quarantined,
            outcome,
        })
    }
}

impl Progress {
    /// Refuses lists that are not as long as the training needs them, and epochs that are not
    /// numbered from one. A checksum shows that a checkpoint is what was written, not that it fits.
    fn require_fit(&self, training: &Training) -> Result<()> {
        let (card, classes) = (&self.card, training.classes.names.len());
        let channels = training.settings.channel_places(training.source)?.len();
        let all_channels = training.source.channels().len();
        for (list, count, expected) in [
            ("classes", card.classes.len(), classes),
            ("shares of classes", card.log_prior.len(), classes),
            ("channels", card.channels.len(), channels),
            ("scaled channels", card.scaling.channels.len(), all_channels),
            ("scalings", card.scaling.transforms.len(), all_channels),
        ] {
            require_length(list, count, expected)?;
        }
        let done = self.history.len();
        let is_numbered = self
            .history
            .iter()
            .zip(1..)
            .all(|(record, epoch)| record.epoch == epoch);
        if is_numbered && (1..=done).contains(&self.best_epoch) {
            return Ok(());
        }
        refuse(format!(
            "the checkpoint lacks epochs: it has {done}, and epoch {} is its best; {RESTORE}",
            self.best_epoch
        ))
    }

    /// Difference of a training from the one that wrote the checkpoint, beyond epochs and patience.
    fn difference_to(&self, training: &Training) -> Option<&'static str> {
        if self.fingerprint != fingerprint(training) {
            Some("samples, classes or split differ")
        } else if self.card.network != *training.network {
            Some("the network differs")
        } else if !training.settings.continues(&self.settings) {
            Some("the settings differ in more than epochs and patience")
        } else {
            None
        }
    }
}

/// Refuses a part of a checkpoint that is not as long as the training needs it.
fn require_length(part: &str, count: usize, expected: usize) -> Result<()> {
    if count == expected {
        return Ok(());
    }
    refuse(format!(
        "the checkpoint has {count} {part} where the training has {expected}; {RESTORE}"
    ))
}

/// Checks that every class of the training part keeps a sample.
fn check_classes(training: &Training, usable: &[usize], quarantined: &[Quarantined]) -> Result<()> {
    let (names, labels) = (&training.classes.names, &training.classes.labels);
    let mut has_sample = vec![false; names.len()];
    for sample in usable {
        has_sample[labels[*sample]] = true;
    }
    for sample in &training.split.training {
        let class = labels[*sample];
        if !has_sample[class] {
            let bad = quarantined.iter().find(|bad| bad.sample == *sample);
            return refuse(format!(
                "no training sample of the class {} can be read, for instance: {}",
                names[class],
                bad.map_or("", |bad| &bad.reason)
            ));
        }
    }
    Ok(())
}

/// Card of the model, fitted to the usable training samples.
fn card(training: &Training, usable: &[usize], weights: &[f64]) -> Result<ModelCard> {
    let (source, settings, classes) = (training.source, training.settings, training.classes);
    let mut channels = Vec::new();
    for place in settings.channel_places(source)? {
        channels.push(source.channels()[place].clone());
    }
    let shares = prior(usable, &classes.labels, Some(weights), classes.names.len());
    let numbers = training.numbers.filter(|_| settings.loss == Loss::Normal);
    let normal = match numbers {
        Some(numbers) => {
            let weighted = usable.iter();
            let weighted = weighted.map(|sample| (numbers.of_samples[*sample], weights[*sample]));
            Some(NormalHead::fit(&weighted.collect::<Vec<_>>())?)
        }
        None => None,
    };
    Ok(ModelCard {
        normal,
        network: training.network.clone(),
        size: source.size(),
        channels,
        scaling: ChannelScaling::fit(source, usable, settings.scaling)?,
        classes: classes.names.clone(),
        number_classes: numbers.map(|numbers| numbers.classes.clone()),
        log_prior: shares.into_iter().map(f64::ln).collect(),
        logit_adjustment: settings.logit_adjustment,
        temperature: 1.0,
        made_with: source.made_with().cloned(),
    })
}

/// Takes over the scaling of a trained network, the weights of its blocks, and those of its head if it
/// tells the same classes apart. Returns whether it does.
fn adopt(model: &Model, network: &Network, card: &mut ModelCard) -> Result<bool> {
    let theirs = &model.card;
    card.scaling = theirs.scaling.clone();
    // The outputs of a number mean what its head says.
    let has_head = theirs.classes == card.classes && theirs.normal == card.normal;
    for (name, weights) in model.network.parameters() {
        if has_head || !name.starts_with("head.") {
            network.set_parameter(name, &weights.as_detached_tensor())?;
        }
    }
    Ok(has_head)
}

fn adam(training: &Training, network: &Network) -> Result<Adam> {
    let settings = AdamSettings {
        learning_rate: training.settings.learning_rate,
        weight_decay: training.settings.weight_decay,
        ..AdamSettings::default()
    };
    Adam::new(network.parameters(), settings)
}

/// The weights as they are now; the parameters themselves change in place.
fn copies(network: &Network) -> Result<Named> {
    let mut copies = Named::new();
    for (name, parameter) in network.parameters() {
        copies.push((name.clone(), parameter.as_detached_tensor().copy()?));
    }
    Ok(copies)
}

/// The tensors whose names begin with a prefix, without it.
fn with_prefix(tensors: &[(String, Tensor)], prefix: &str) -> Named {
    let mut entries = Named::new();
    for (name, tensor) in tensors {
        if let Some(name) = name.strip_prefix(prefix) {
            entries.push((name.to_owned(), tensor.clone()));
        }
    }
    entries
}

/// A hash of everything that decides which sample is what.
fn fingerprint(training: &Training) -> u64 {
    let (source, classes, split) = (training.source, training.classes, training.split);
    let mut hash = Fnv::new();
    hash.add(&(source.size() as u64).to_le_bytes());
    for name in source.channels().iter().chain(&classes.names) {
        hash.add(name.as_bytes());
    }
    for (description, label) in source.descriptions().iter().zip(&classes.labels) {
        hash.add(description.name.as_bytes());
        hash.add(description.family.as_bytes());
        hash.add(&(*label as u64).to_le_bytes());
    }
    for part in [&split.training, &split.validation] {
        let mut bytes = Vec::with_capacity(8 * part.len());
        for sample in part {
            bytes.extend((*sample as u64).to_le_bytes());
        }
        hash.add(&bytes);
    }
    hash.0
}

/// The hash of Fowler, Noll and Vo (FNV-1a, 64 bits).
struct Fnv(u64);

impl Fnv {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    /// Adds the length, then the bytes.
    fn add(&mut self, bytes: &[u8]) {
        let length = (bytes.len() as u64).to_le_bytes();
        for byte in length.iter().chain(bytes) {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
        }
    }
}
