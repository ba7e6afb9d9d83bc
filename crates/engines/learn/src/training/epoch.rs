//! One pass over the training part.

use super::loader::{Item, Loader};
use super::state::State;
use super::{EpochRecord, Observer, Parts, StepReport, Training};
use crate::augmentation::CubeRotation;
use crate::loss::adjust_logits;
use crate::normal::{NormalHead, normal_loss};
use crate::split::shuffle;
use crate::{Adam, LearnError, Network, Result, cross_entropy};
use candle_core::Tensor;
use protomer_kernel::random::{CounterRng, Purpose};
use std::ops::ControlFlow;

/// Trains one epoch; `None` if the observer ended it. Validation scores are not yet in the record.
pub(super) fn run(
    training: &Training,
    state: &mut State,
    parts: &Parts,
    observer: &mut dyn Observer,
) -> Result<Option<EpochRecord>> {
    // Epochs count from 1, the number of the one in progress.
    let epoch = state.progress.history.len() + 1;
    let items = items(training, &parts.training, epoch);
    let batches: Vec<&[Item]> = items.chunks(training.settings.batch).collect();
    let card = &state.progress.card;
    let mut pass = Pass {
        training,
        weights: &parts.weights,
        mean_weight: mean_weight(parts),
        log_prior: card.log_prior.iter().map(|value| *value as f32).collect(),
        normal: card.normal,
        epoch,
        steps: batches.len(),
        network: &state.network,
        adam: &mut state.adam,
        observer,
        sums: Sums::default(),
    };
    let loader = Loader {
        source: training.source,
        scaling: &card.scaling,
        channels: &parts.channels,
        device: &training.device,
    };
    let completed = loader.each(&batches, |number, batch| {
        pass.step(number, batches[number], &batch)
    })?;
    if completed {
        pass.record().map(Some)
    } else {
        Ok(None)
    }
}

fn mean_weight(parts: &Parts) -> f64 {
    let sum: f64 = parts
        .training
        .iter()
        .map(|sample| parts.weights[*sample])
        .sum();
    sum / parts.training.len() as f64
}

/// The training samples of an epoch in a random order, each with its rotation.
fn items(training: &Training, samples: &[usize], epoch: usize) -> Vec<Item> {
    let (seed, step) = (training.settings.seed, epoch as u64);
    let mut items = Vec::with_capacity(samples.len());
    for sample in samples {
        // The rotation hangs on seed, sample and epoch alone: a
        // training that was interrupted goes on as if it had not been.
        let mut random =
            CounterRng::for_purpose(seed, *sample as u32, step, Purpose::TrainingRotation);
        let turn = if training.settings.augment {
            random.index(CubeRotation::COUNT)
        } else {
            0
        };
        items.push(Item {
            sample: *sample,
            turn,
        });
    }
    // Rotations are drawn before the order, so the order of samples does not change them.
    shuffle(
        &mut items,
        &mut CounterRng::for_purpose(seed, 0, step, Purpose::TrainingOrder),
    );
    items
}

/// An epoch in progress.
struct Pass<'a> {
    training: &'a Training<'a>,
    weights: &'a [f64],
    mean_weight: f64,
    log_prior: Vec<f32>,
    normal: Option<NormalHead>,
    epoch: usize,
    steps: usize,
    network: &'a Network,
    adam: &'a mut Adam,
    observer: &'a mut dyn Observer,
    sums: Sums,
}

/// Sums over the steps of an epoch whose gradients were finite.
#[derive(Default)]
struct Sums {
    loss: f64,
    weight: f64,
    norm: f64,
    largest_norm: f64,
    skipped: usize,
    last_rate: f64,
}

impl Pass<'_> {
    /// One step: forward, backward, Adam.
    fn step(&mut self, number: usize, items: &[Item], batch: &Tensor) -> Result<ControlFlow<()>> {
        let settings = self.training.settings;
        let (mut labels, mut weights) = (Vec::new(), Vec::new());
        for item in items {
            labels.push(self.training.classes.labels[item.sample] as u32);
            weights.push(self.weights[item.sample] as f32);
        }
        let weight: f64 = items.iter().map(|item| self.weights[item.sample]).sum();
        let logits = self.network.forward(batch)?;
        let loss = match (&self.training.numbers, &self.normal) {
            (Some(numbers), Some(head)) => {
                let target =
                    |item: &Item| head.standardised(numbers.of_samples[item.sample]) as f32;
                let targets: Vec<f32> = items.iter().map(target).collect();
                normal_loss(&logits, &targets, &weights)?
            }
            _ => {
                let logits = adjust_logits(&logits, &self.log_prior, settings.logit_adjustment)?;
                cross_entropy(&logits, &labels, &weights)?
            }
        };
        let loss_nats = f64::from(loss.to_scalar::<f32>()?);
        // `cross_entropy` is a mean over the batch's weights. Times this, all steps of an
        // epoch together weigh each sample as its weight says, also in a short last batch.
        let scale = weight / (labels.len() as f64 * self.mean_weight);
        let gradients = (loss * scale)?.backward()?;
        // Steps count over all epochs, skipped ones too: the schedule is a function of progress.
        let rate = settings.rate((self.epoch - 1) * self.steps + number, self.steps);
        let norm = self.adam.step(&gradients, rate, settings.clip)?;
        self.sums.add(loss_nats, weight, norm, rate);
        Ok(self.observer.step(StepReport {
            epoch: self.epoch,
            step: number + 1,
            steps: self.steps,
            loss_nats,
        }))
    }

    fn record(self) -> Result<EpochRecord> {
        let (epoch, sums) = (self.epoch, self.sums);
        // No finite step in a whole epoch: the network will not
        // recover, and the means below would divide by zero.
        if sums.skipped == self.steps {
            return Err(LearnError::Diverged(format!(
                "no step of epoch {epoch} had a finite gradient"
            )));
        }
        Ok(EpochRecord {
            epoch,
            training_loss_nats: sums.loss / sums.weight,
            validation_loss_nats: None,
            validation_balanced_accuracy: None,
            gradient_norm: sums.norm / (self.steps - sums.skipped) as f64,
            largest_gradient_norm: sums.largest_norm,
            learning_rate: sums.last_rate,
            skipped_steps: sums.skipped,
        })
    }
}

impl Sums {
    fn add(&mut self, loss_nats: f64, weight: f64, norm: f64, rate: f64) {
        self.last_rate = rate;
        // The rate above is recorded all the same: it belongs to the schedule.
        if !loss_nats.is_finite() || !norm.is_finite() {
            self.skipped += 1;
            return;
        }
        self.loss += weight * loss_nats;
        self.weight += weight;
        self.norm += norm;
        self.largest_norm = self.largest_norm.max(norm);
    }
}
