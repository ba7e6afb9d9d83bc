//! Settings of a training, and what is known of each epoch.

use crate::error::refuse;
use crate::scaling::ScalingMode;
use crate::{Result, SampleSource};
use serde::{Deserialize, Serialize};

protomer_kernel::choices! {
    /// Quantity that a training minimises.
    pub enum Loss, default CrossEntropy {
        /// The cross entropy of classes; numbers are cut into classes.
        CrossEntropy = "cross-entropy",
        /// The negative logarithm of a normal density: a number by its mean and its spread.
        Normal = "normal",
    }
}

/// For serde: whether a loss is left out.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_default(loss: &Loss) -> bool {
    *loss == Loss::default()
}

/// Settings of a training.
///
/// ```
/// use protomer_learn::training::TrainingSettings;
///
/// let settings = TrainingSettings {
///     epochs: 20,
///     channels: vec!["shape".into(), "potential".into()],
///     ..TrainingSettings::default()
/// };
/// assert!(settings.check().is_ok());
/// assert!(TrainingSettings { batch: 0, ..settings }.check().is_err());
/// ```
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
    /// Largest norm of a gradient; longer gradients are shortened to it.
    pub clip: Option<f64>,
    /// Number of epochs without a smaller validation loss after which training ends.
    pub patience: Option<usize>,
    /// Whether every sample is turned by a random rotation of the cube in every epoch.
    pub augment: bool,
    /// τ of the logit adjustment (Menon et al., ICLR 2021). The loss sees logits + τ ln(share of
    /// the class), so for τ = 1 the plain logits treat all classes as equally common. Predictions
    /// add the shares again unless asked not to.
    pub logit_adjustment: f64,
    /// Loss that is minimised.
    #[serde(skip_serializing_if = "is_default")]
    pub loss: Loss,
    /// Names of the channels the network sees, in order; empty: all.
    pub channels: Vec<String>,
    /// Scaling of the channels.
    pub scaling: ScalingMode,
    /// Seed of initial weights, order and rotations.
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
            loss: Loss::CrossEntropy,
            channels: Vec::new(),
            scaling: ScalingMode::Robust,
            seed: 0,
        }
    }
}

impl TrainingSettings {
    /// Checks that the settings make sense.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) names the first that does not.
    pub fn check(&self) -> Result<()> {
        if self.batch == 0 {
            return refuse("batch must be 1 or more, not 0");
        }
        let rate = self.learning_rate;
        if !(rate > 0.0 && rate.is_finite()) {
            return refuse(format!("learning_rate must be positive, not {rate}"));
        }
        let others = [
            ("warm_up", self.warm_up),
            ("weight_decay", self.weight_decay),
            ("logit_adjustment", self.logit_adjustment),
        ];
        for (name, value) in others {
            if !(value >= 0.0 && value.is_finite()) {
                return refuse(format!("{name} must be zero or positive, not {value}"));
            }
        }
        match self.clip {
            Some(clip) if clip.is_nan() || clip <= 0.0 => {
                refuse(format!("clip must be positive, not {clip}"))
            }
            _ => Ok(()),
        }
    }

    /// The places of the chosen channels in the source.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) names a channel that the source lacks
    /// or that is chosen twice.
    pub(super) fn channel_places(&self, source: &dyn SampleSource) -> Result<Vec<usize>> {
        let all = source.channels();
        if self.channels.is_empty() {
            return Ok((0..all.len()).collect());
        }
        let mut places = Vec::with_capacity(self.channels.len());
        for name in &self.channels {
            let Some(place) = all.iter().position(|channel| channel == name) else {
                return refuse(format!(
                    "there is no channel {name}; choose among those of the set: {}",
                    all.join(", ")
                ));
            };
            if places.contains(&place) {
                return refuse(format!("the channel {name} is chosen twice; name it once"));
            }
            places.push(place);
        }
        Ok(places)
    }

    /// Whether a training under `other` may continue under these settings: only its end may differ.
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

/// Record of an epoch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EpochRecord {
    /// Number of the epoch, counted from 1.
    pub epoch: usize,
    /// Mean cross entropy of the training part while weights changed, nats.
    pub training_loss_nats: f64,
    /// Log-loss of the validation part, nats; `None` without one.
    pub validation_loss_nats: Option<f64>,
    /// Balanced accuracy of the validation part.
    pub validation_balanced_accuracy: Option<f64>,
    /// Mean norm of the gradient before shortening.
    pub gradient_norm: f64,
    /// Largest norm of the gradient before shortening.
    pub largest_gradient_norm: f64,
    /// Learning rate of the last step.
    pub learning_rate: f64,
    /// Steps left out because loss or gradient was not finite.
    pub skipped_steps: usize,
}

/// Outcome of a training.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// All epochs were done.
    Completed,
    /// The validation loss no longer fell.
    Stopped,
    /// The observer ended it. Complete epochs count.
    Interrupted,
}
