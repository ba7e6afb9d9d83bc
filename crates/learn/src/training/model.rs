//! A trained network with everything a prediction needs.

use super::container::{pack, unpack};
use super::loader::{Item, Loader};
use crate::augmentation::CubeRotation;
use crate::calibration::{at_temperature, softmax, temperature};
use crate::scaling::{ChannelScaling, Quarantined, screen};
use crate::{LearnError, Network, NetworkSettings, Result, SampleSource};
use candle_core::Device;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// A network, how its input is scaled, and what its output means.
#[derive(Debug, Clone)]
pub struct Model {
    /// The network.
    pub network: Network,
    /// Everything else.
    pub card: ModelCard,
}

/// What belongs to a network's weights.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelCard {
    /// The shape of the network.
    pub network: NetworkSettings,
    /// Voxels along each edge of the grids it was trained on.
    pub size: usize,
    /// Names of the channels it sees, in order.
    pub channels: Vec<String>,
    /// Scaling of all channels of the set.
    pub scaling: ChannelScaling,
    /// Names of the classes.
    pub classes: Vec<String>,
    /// Natural logarithm of the share of each class in the training part.
    pub log_prior: Vec<f64>,
    /// The strength τ of the logit adjustment it was trained with.
    pub logit_adjustment: f64,
    /// Temperature of its probabilities, 1 if never calibrated.
    pub temperature: f64,
    /// How the voxels it was trained on were made, where that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub made_with: Option<serde_json::Value>,
}

/// How to predict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PredictionSettings {
    /// Grids at a time.
    pub batch: usize,
    /// Average the probabilities over the 24 rotations of the cube: then they do not depend on
    /// which of them a grid is in.
    pub rotations: bool,
    /// As if all classes were equally common, for a network trained with a logit adjustment of 1.
    pub balanced: bool,
}

impl Default for PredictionSettings {
    fn default() -> Self {
        Self {
            batch: 8,
            rotations: false,
            balanced: false,
        }
    }
}

/// Probabilities of classes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Predictions {
    /// Samples that could be read, in the order asked for.
    pub samples: Vec<usize>,
    /// Sample after sample, one number per class.
    pub probabilities: Vec<f64>,
    /// Samples that could not be read.
    pub quarantined: Vec<Quarantined>,
}

impl Model {
    /// Predicts the classes of samples.
    ///
    /// # Errors
    /// [`LearnError::Settings`] if the source has other channels or another size than the model, or
    /// a probability is not finite.
    pub fn predict(
        &self,
        source: &dyn SampleSource,
        samples: &[usize],
        how: PredictionSettings,
    ) -> Result<Predictions> {
        let (samples, quarantined) = screen(source, samples);
        let probabilities = self.probabilities(source, &samples, how)?;
        Ok(Predictions {
            samples,
            probabilities,
            quarantined,
        })
    }

    /// The same on samples known to be good.
    pub(super) fn probabilities(
        &self,
        source: &dyn SampleSource,
        samples: &[usize],
        how: PredictionSettings,
    ) -> Result<Vec<f64>> {
        let channels = self.places(source)?;
        let device = self
            .network
            .parameters()
            .first()
            .map_or(&Device::Cpu, |(_, weight)| weight.device());
        let turns = if how.rotations {
            CubeRotation::COUNT
        } else {
            1
        };
        let items: Vec<Item> = samples
            .iter()
            .flat_map(|sample| {
                (0..turns).map(move |turn| Item {
                    sample: *sample,
                    turn,
                })
            })
            .collect();
        let batches: Vec<&[Item]> = items.chunks(how.batch.max(1)).collect();
        let loader = Loader {
            source,
            scaling: &self.card.scaling,
            channels: &channels,
            device,
        };
        let classes = self.card.classes.len();
        let strength = if how.balanced {
            0.0
        } else {
            self.card.logit_adjustment
        };
        let mut sums = vec![0.0; samples.len() * classes];
        loader.each(&batches, |number, batch| {
            let logits: Vec<Vec<f32>> = self.network.predict(&batch)?.to_vec2()?;
            for (place, row) in logits.iter().enumerate() {
                let adjust =
                    |(logit, log_prior): (&f32, &f64)| f64::from(*logit) + strength * log_prior;
                let mut p: Vec<f64> = row.iter().zip(&self.card.log_prior).map(adjust).collect();
                softmax(&mut p);
                let sample = (number * how.batch.max(1) + place) / turns;
                for (sum, p) in sums[sample * classes..(sample + 1) * classes]
                    .iter_mut()
                    .zip(p)
                {
                    *sum += p / turns as f64;
                }
            }
            Ok(ControlFlow::Continue(()))
        })?;
        if sums.iter().any(|p| !p.is_finite()) {
            return Err(LearnError::Diverged(
                "the network gives probabilities that are not finite".into(),
            ));
        }
        let calibrated = self.card.temperature != 1.0;
        Ok(if calibrated {
            at_temperature(&sums, classes, self.card.temperature)
        } else {
            sums
        })
    }

    /// Sets the temperature to the best one for samples with these labels, usually the validation
    /// part, and returns it.
    ///
    /// `labels` holds a class for every sample of the source.
    ///
    /// # Errors
    /// As [`Model::predict`], and if no sample can be read.
    pub fn calibrate(
        &mut self,
        source: &dyn SampleSource,
        samples: &[usize],
        labels: &[usize],
        weights: Option<&[f64]>,
        how: PredictionSettings,
    ) -> Result<f64> {
        self.card.temperature = 1.0;
        let predictions = self.predict(source, samples, how)?;
        let missing = |sample: &usize| {
            LearnError::Settings(format!("sample {sample} has no label or no weight"))
        };
        let pick = |sample: &usize| labels.get(*sample).copied().ok_or_else(|| missing(sample));
        let truth = predictions
            .samples
            .iter()
            .map(pick)
            .collect::<Result<Vec<_>>>()?;
        let pick = |weights: &[f64]| {
            let of = |sample: &usize| weights.get(*sample).copied().ok_or_else(|| missing(sample));
            predictions
                .samples
                .iter()
                .map(of)
                .collect::<Result<Vec<_>>>()
        };
        let weights = weights.map(pick).transpose()?;
        let classes = self.card.classes.len();
        self.card.temperature = temperature(
            &predictions.probabilities,
            &truth,
            classes,
            weights.as_deref(),
        )?;
        Ok(self.card.temperature)
    }

    fn places(&self, source: &dyn SampleSource) -> Result<Vec<usize>> {
        let ModelCard {
            scaling,
            size,
            channels,
            ..
        } = &self.card;
        if source.channels() != scaling.channels || source.size() != *size {
            return Err(LearnError::Settings(format!(
                "the model is for {size}³ voxels with the channels {}, the set has {}³ with {}",
                scaling.channels.join(", "),
                source.size(),
                source.channels().join(", ")
            )));
        }
        let place = |name: &String| {
            let found = source.channels().iter().position(|channel| channel == name);
            found.ok_or_else(|| LearnError::Settings(format!("the set has no channel {name}")))
        };
        channels.iter().map(place).collect()
    }

    /// The model in the format safetensors: weights under their names in PyTorch's layout, the card
    /// as JSON in the metadata.
    ///
    /// # Errors
    /// [`LearnError::Settings`] if it cannot be written.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let tensors = self
            .network
            .parameters()
            .iter()
            .map(|(name, var)| (name.clone(), var.as_detached_tensor()));
        pack(&tensors.collect::<Vec<_>>(), &self.card)
    }

    /// The same model on a device.
    ///
    /// # Errors
    /// [`LearnError::Tensor`] if the device takes no more.
    pub fn to_device(&self, device: &Device) -> Result<Self> {
        let network = Network::new(&self.card.network, 0, device)?;
        for (name, weights) in self.network.parameters() {
            network.set_parameter(name, &weights.as_detached_tensor())?;
        }
        Ok(Self {
            network,
            card: self.card.clone(),
        })
    }

    /// A model from the bytes that [`Model::to_bytes`] gave.
    ///
    /// # Errors
    /// [`LearnError::Settings`] if they are damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let (tensors, card): (_, ModelCard) = unpack(bytes, "model", &Device::Cpu)?;
        let network = Network::new(&card.network, 0, &Device::Cpu)?;
        let (classes, channels) = (card.network.classes, card.network.channels);
        let agree = card.classes.len() == classes
            && card.log_prior.len() == classes
            && card.channels.len() == channels;
        if tensors.len() != network.parameters().len() || !agree {
            return Err(LearnError::Settings(
                "this is no usable model: its weights and its card disagree".into(),
            ));
        }
        for (name, tensor) in &tensors {
            network.set_parameter(name, tensor)?;
        }
        Ok(Self { network, card })
    }
}
