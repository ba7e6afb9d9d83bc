//! Settings of a training, and what is known of each epoch.

use crate::scaling::ScalingMode;
use crate::{LearnError, Result, SampleSource};
use serde::{Deserialize, Serialize};

/// How a network is trained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrainingSettings {
    /// Passes over the training part, at most.
    pub epochs: usize,
    /// Samples per step.
    pub batch: usize,
    /// Learning rate after the warm-up.
    pub learning_rate: f64,
    /// Epochs over which the learning rate rises linearly from zero.
    pub warm_up: f64,
    /// Decoupled weight decay.
    pub weight_decay: f64,
    /// The norm that longer gradients are shortened to.
    pub clip: Option<f64>,
    /// Epochs without a smaller validation loss after which training ends.
    pub patience: Option<usize>,
    /// Whether every sample is turned by a random rotation of the cube in every epoch.
    pub augment: bool,
    /// τ: the loss sees logits + τ ln(share of the class), so that for τ = 1 the plain logits treat
    /// all classes as equally common (Menon et al., ICLR 2021). Predictions restore the shares
    /// unless asked not to.
    pub logit_adjustment: f64,
    /// Names of the channels the network sees, in order; empty: all.
    pub channels: Vec<String>,
    /// How channels are scaled.
    pub scaling: ScalingMode,
    /// Decides initial weights, order and rotations.
    pub seed: u64,
}

impl Default for TrainingSettings {
    fn default() -> Self {
        Self {
            epochs: 50,
            batch: 8,
            learning_rate: 1e-3,
            warm_up: 1.0,
            weight_decay: 1e-4,
            clip: Some(1.0),
            patience: Some(10),
            augment: true,
            logit_adjustment: 0.0,
            channels: Vec::new(),
            scaling: ScalingMode::Robust,
            seed: 0,
        }
    }
}

impl TrainingSettings {
    /// Whether the settings make sense.
    ///
    /// # Errors
    /// [`LearnError::Settings`] names the first that does not.
    pub fn check(&self) -> Result<()> {
        let refuse =
            |what: &str, value: String| Err(LearnError::Settings(format!("{what}, not {value}")));
        let not_negative = |value: f64| value >= 0.0 && value.is_finite();
        if self.batch == 0 {
            return refuse("batch must be 1 or more", self.batch.to_string());
        }
        if !(self.learning_rate > 0.0 && self.learning_rate.is_finite()) {
            return refuse(
                "learning_rate must be positive",
                self.learning_rate.to_string(),
            );
        }
        let others = [
            ("warm_up", self.warm_up),
            ("weight_decay", self.weight_decay),
            ("logit_adjustment", self.logit_adjustment),
        ];
        if let Some((name, value)) = others.into_iter().find(|(_, value)| !not_negative(*value)) {
            return refuse(
                &format!("{name} must be zero or positive"),
                value.to_string(),
            );
        }
        match self.clip {
            Some(clip) if clip.is_nan() || clip <= 0.0 => {
                refuse("clip must be positive", clip.to_string())
            }
            _ => Ok(()),
        }
    }

    /// The places of the chosen channels in the source.
    ///
    /// # Errors
    /// [`LearnError::Settings`] names a channel that the source lacks or that is chosen twice.
    pub fn channel_places(&self, source: &dyn SampleSource) -> Result<Vec<usize>> {
        if self.channels.is_empty() {
            return Ok((0..source.channels().len()).collect());
        }
        let mut places = Vec::new();
        for name in &self.channels {
            match source.channels().iter().position(|channel| channel == name) {
                Some(place) if !places.contains(&place) => places.push(place),
                Some(_) => {
                    return Err(LearnError::Settings(format!(
                        "the channel {name} is chosen twice; name it once"
                    )));
                }
                None => {
                    let there = source.channels().join(", ");
                    return Err(LearnError::Settings(format!(
                        "there is no channel {name}; choose among those of the set: {there}"
                    )));
                }
            }
        }
        Ok(places)
    }

    /// Whether a training under `other` may go on under these: only its end may differ.
    pub(super) fn continues(&self, other: &Self) -> bool {
        Self {
            epochs: other.epochs,
            patience: other.patience,
            ..self.clone()
        } == *other
    }

    /// The learning rate of a step, steps counted from zero: r min(1, (t + 1) / (warm-up in
    /// steps)).
    pub(super) fn rate(&self, step: usize, steps_per_epoch: usize) -> f64 {
        let warm_up = self.warm_up * steps_per_epoch as f64;
        self.learning_rate * f64::min(1.0, (step + 1) as f64 / warm_up.max(1.0))
    }
}

/// What an epoch did.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EpochRecord {
    /// Counted from 1.
    pub epoch: usize,
    /// Mean cross entropy of the training part while weights changed, nats.
    pub training_loss_nats: f64,
    /// Log-loss of the validation part, nats; none without one.
    pub validation_loss_nats: Option<f64>,
    /// Balanced accuracy of the validation part.
    pub validation_balanced_accuracy: Option<f64>,
    /// Mean norm of the gradient before shortening.
    pub gradient_norm: f64,
    /// Largest norm of the gradient before shortening.
    pub largest_gradient_norm: f64,
    /// Learning rate of the last step.
    pub learning_rate: f64,
    /// Steps left out because the gradient was not finite.
    pub skipped_steps: usize,
}

/// How a training ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// All epochs were done.
    Completed,
    /// The validation loss no longer fell.
    Stopped,
    /// The observer ended it; the last epoch that was completed counts.
    Interrupted,
}
