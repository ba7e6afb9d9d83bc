//! A trained network with everything a prediction needs.

use super::container::{pack, unpack};
use super::loader::{Item, Loader};
use crate::augmentation::CubeRotation;
use crate::calibration::{at_temperature, softmax, temperature};
use crate::error::refuse;
use crate::normal::{NormalHead, OUTPUTS, PredictedNumber, spread_temperature};
use crate::number_classes::NumberClasses;
use crate::scaling::{ChannelScaling, Quarantined, screen};
use crate::{LearnError, Network, NetworkSettings, Result, SampleSource};
use candle_core::Device;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// A network, how its input is scaled, and what its output means.
///
/// ```
/// use protomer_learn::controls::{Control, Form, Variant};
/// use protomer_learn::split::{Fractions, Split};
/// use protomer_learn::targets::{Classes, Target};
/// use protomer_learn::training::{Model, PredictionSettings, TrainingSettings, train};
///
/// let control = Control::Charge;
/// let set = control.samples(Variant::Usual, 40, 16, 1);
/// let labels: Vec<&str> = set.descriptions.iter().map(|sample| &*sample.label).collect();
/// let classes = Classes::from_labels(&labels, Target::Label, 1)?;
/// let split = Split::grouped(&set.descriptions, 1, Fractions::default())?;
/// let network = control.network(&control.experiments()[1], Form::Short);
/// let settings = TrainingSettings {
///     channels: vec!["shape".into()],
///     epochs: 1,
///     ..TrainingSettings::default()
/// };
/// let trained = train(&set, &classes, &split, &network, &settings, &mut ())?;
///
/// let copy = Model::from_bytes(&trained.model.to_bytes()?)?;
/// let predictions = copy.predict(&set, &split.test, PredictionSettings::default())?;
/// assert_eq!(predictions.samples, split.test);
/// assert_eq!(predictions.probabilities.len(), 2 * split.test.len());
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Model {
    /// The network.
    pub network: Network,
    /// Card of the model: everything but the weights.
    pub card: ModelCard,
}

/// Data that belong to a network's weights.
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
    /// The classes as parts of the range of a number, if it is a number that is predicted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub number_classes: Option<NumberClasses>,
    /// Meaning of the outputs, if they are a number and its spread instead of classes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<NormalHead>,
    /// Natural logarithm of the share of each class in the training part.
    pub log_prior: Vec<f64>,
    /// The strength τ of the logit adjustment it was trained with.
    pub logit_adjustment: f64,
    /// Temperature of its probabilities, 1 if never calibrated; of a number, the factor on its spread.
    pub temperature: f64,
    /// The settings that the voxels it was trained on were made with, where they are known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub made_with: Option<serde_json::Value>,
}

/// Settings of a prediction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PredictionSettings {
    /// Number of grids per batch.
    pub batch: usize,
    /// Averages the probabilities over the 24 rotations of the cube. They are then the same for all
    /// 24 orientations of a grid.
    pub rotations: bool,
    /// Predicts as if all classes were equally common, for a network trained with a logit
    /// adjustment of 1.
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

impl PredictionSettings {
    /// Orientations in which each grid is seen.
    fn turns(self) -> usize {
        if self.rotations {
            CubeRotation::COUNT
        } else {
            1
        }
    }
}

/// Probabilities of classes, and numbers if the network predicts them.
pub(super) struct Outputs {
    /// Probabilities, sample after sample.
    pub probabilities: Vec<f64>,
    /// A number for each sample, or none.
    pub numbers: Vec<PredictedNumber>,
}

/// Probabilities of classes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Predictions {
    /// Samples that could be read, in the requested order.
    pub samples: Vec<usize>,
    /// Probabilities, sample after sample, one number per class.
    pub probabilities: Vec<f64>,
    /// Number and spread of each sample, if the network predicts them; otherwise empty.
    pub numbers: Vec<PredictedNumber>,
    /// Samples that could not be read.
    pub quarantined: Vec<Quarantined>,
}

impl Model {
    /// Predicts the classes of samples.
    ///
    /// # Errors
    /// [`LearnError::Settings`] if the source has other channels or another size than the model,
    /// [`LearnError::Diverged`] if a probability is not finite.
    pub fn predict(
        &self,
        source: &dyn SampleSource,
        samples: &[usize],
        how: PredictionSettings,
    ) -> Result<Predictions> {
        let (samples, quarantined) = screen(source, samples);
        let outputs = self.outputs(source, &samples, how)?;
        Ok(Predictions {
            samples,
            probabilities: outputs.probabilities,
            numbers: outputs.numbers,
            quarantined,
        })
    }

    /// Probabilities and numbers of samples known to be good.
    pub(super) fn outputs(
        &self,
        source: &dyn SampleSource,
        samples: &[usize],
        how: PredictionSettings,
    ) -> Result<Outputs> {
        let mut items = Vec::with_capacity(samples.len() * how.turns());
        // All orientations of a sample stand one after another, over the borders of batches.
        for sample in samples {
            items.extend((0..how.turns()).map(|turn| Item {
                sample: *sample,
                turn,
            }));
        }
        let batches: Vec<&[Item]> = items.chunks(how.batch.max(1)).collect();
        let loader = Loader {
            source,
            scaling: &self.card.scaling,
            channels: &self.places(source)?,
            device: self.network.device(),
        };
        let mut averages = Averages::new(samples.len(), self.card.classes.len(), how.turns());
        let mut of_grids = Vec::new();
        loader.each(&batches, |_, batch| {
            let logits: Vec<Vec<f32>> = self.network.predict(&batch)?.to_vec2()?;
            for row in logits {
                match (self.number(&row), &self.card.number_classes) {
                    (Some(number), Some(classes)) => {
                        of_grids.push(number);
                        averages.add(&number.probabilities(classes));
                    }
                    _ => averages.add(&self.probabilities_of(&row, how)),
                }
            }
            Ok(ControlFlow::Continue(()))
        })?;
        let numbers = of_grids.chunks(how.turns()).map(PredictedNumber::mixed);
        let numbers = numbers.collect();
        let probabilities = averages.sums;
        // A diverged network gives NaN; a class must not be named on such numbers.
        if probabilities.iter().any(|p| !p.is_finite()) {
            return Err(LearnError::Diverged(
                "the network gives probabilities that are not finite".into(),
            ));
        }
        // The spread of a number has been multiplied by it already.
        let probabilities = match self.card.normal.is_some() || self.card.temperature == 1.0 {
            true => probabilities,
            false => at_temperature(
                &probabilities,
                self.card.classes.len(),
                self.card.temperature,
            ),
        };
        Ok(Outputs {
            probabilities,
            numbers,
        })
    }

    /// The number that the outputs for one grid predict, if the network predicts numbers.
    fn number(&self, outputs: &[f32]) -> Option<PredictedNumber> {
        let head = self.card.normal.as_ref()?;
        let [mean, width] = outputs else {
            return None;
        };
        Some(head.predicted([*mean, *width], self.card.temperature))
    }

    /// The probabilities of one grid.
    fn probabilities_of(&self, logits: &[f32], how: PredictionSettings) -> Vec<f64> {
        // The network learnt logits z with z + τ ln prior as the true odds. Left off, the
        // classes count as equally common; put back, they have the shares of the training part.
        let strength = if how.balanced {
            0.0
        } else {
            self.card.logit_adjustment
        };
        let mut p = Vec::with_capacity(logits.len());
        for (logit, log_prior) in logits.iter().zip(&self.card.log_prior) {
            p.push(f64::from(*logit) + strength * log_prior);
        }
        softmax(&mut p);
        p
    }

    /// Sets the factor on spreads to the best one for samples with these numbers, and returns it: the
    /// counterpart of [`Model::calibrate`] for a network that predicts numbers.
    ///
    /// `numbers` and `weights` hold one for every sample of the source.
    ///
    /// # Errors
    /// As for [`Model::predict`].
    pub fn calibrate_spread(
        &mut self,
        source: &dyn SampleSource,
        samples: &[usize],
        numbers: &[f64],
        weights: &[f64],
        how: PredictionSettings,
    ) -> Result<f64> {
        self.card.temperature = 1.0;
        let predictions = self.predict(source, samples, how)?;
        let (truth, weights) = (
            pick(numbers, &predictions.samples)?,
            pick(weights, &predictions.samples)?,
        );
        let distances = predictions.numbers.iter().zip(truth).zip(weights);
        self.card.temperature =
            spread_temperature(distances.map(|((predicted, number), weight)| {
                ((number - predicted.mean) / predicted.spread, weight)
            }));
        Ok(self.card.temperature)
    }

    /// Sets the temperature to the best one for samples with these labels, usually the validation
    /// part, and returns it.
    ///
    /// `labels` holds a class for every sample of the source, `weights` a weight.
    ///
    /// # Errors
    /// As for [`Model::predict`], and if no sample can be read.
    pub fn calibrate(
        &mut self,
        source: &dyn SampleSource,
        samples: &[usize],
        labels: &[usize],
        weights: Option<&[f64]>,
        how: PredictionSettings,
    ) -> Result<f64> {
        // Reset first, or the new temperature would be fitted on top of the old one.
        self.card.temperature = 1.0;
        let predictions = self.predict(source, samples, how)?;
        // Samples that could not be read have no probabilities: labels and weights follow the rest.
        let truth = pick(labels, &predictions.samples)?;
        let weights = match weights {
            Some(weights) => Some(pick(weights, &predictions.samples)?),
            None => None,
        };
        let classes = self.card.classes.len();
        let p = &predictions.probabilities;
        self.card.temperature = temperature(p, &truth, classes, weights.as_deref())?;
        Ok(self.card.temperature)
    }

    /// The places of the model's channels in a source.
    fn places(&self, source: &dyn SampleSource) -> Result<Vec<usize>> {
        let (all, size) = (&self.card.scaling.channels, self.card.size);
        if source.channels() != all || source.size() != size {
            return refuse(format!(
                "the model is for {size}³ voxels with the channels {}, the set has {}³ with {}",
                all.join(", "),
                source.size(),
                source.channels().join(", ")
            ));
        }
        // By name: the source may have more channels, or other places for them.
        let mut places = Vec::with_capacity(self.card.channels.len());
        for name in &self.card.channels {
            match all.iter().position(|channel| channel == name) {
                Some(place) => places.push(place),
                None => return refuse(format!("the set has no channel {name}")),
            }
        }
        Ok(places)
    }

    /// The model in the format safetensors: weights under their names in PyTorch's layout, the card
    /// as JSON in the metadata.
    ///
    /// # Errors
    /// [`LearnError::Settings`] if it cannot be written.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let mut tensors = Vec::new();
        for (name, weights) in self.network.parameters() {
            tensors.push((name.clone(), weights.as_detached_tensor()));
        }
        pack(&tensors, &self.card)
    }

    /// A model from the bytes that [`Model::to_bytes`] returned.
    ///
    /// # Errors
    /// [`LearnError::Settings`] if they are damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let (tensors, card): (_, ModelCard) = unpack(bytes, "model", &Device::Cpu)?;
        let network = Network::new(&card.network, 0, &Device::Cpu)?;
        let (classes, channels) = (card.network.classes, card.network.channels);
        let told_apart = card.classes.len();
        let has_classes = |numbers: &NumberClasses| {
            numbers.count() == told_apart && numbers.means.len() == told_apart
        };
        let agree = match card.normal {
            Some(_) => classes == OUTPUTS && card.number_classes.is_some(),
            None => classes == told_apart,
        } && card.log_prior.len() == told_apart
            && card.number_classes.as_ref().is_none_or(has_classes)
            && card.channels.len() == channels
            && card.scaling.transforms.len() == card.scaling.channels.len()
            && tensors.len() == network.parameters().len();
        if !agree {
            return refuse("this is not a usable model: its weights and its card disagree");
        }
        for (name, tensor) in &tensors {
            network.set_parameter(name, tensor)?;
        }
        Ok(Self { network, card })
    }

    /// The same model on a device.
    ///
    /// # Errors
    /// [`LearnError::Tensor`] if the device has no room for it.
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
}

/// Values of some samples, picked from those of all samples.
fn pick<T: Copy>(all: &[T], samples: &[usize]) -> Result<Vec<T>> {
    let mut picked = Vec::with_capacity(samples.len());
    for sample in samples {
        match all.get(*sample) {
            Some(value) => picked.push(*value),
            None => return refuse(format!("sample {sample} has no label or no weight")),
        }
    }
    Ok(picked)
}

/// Probabilities of samples, averaged over the orientations in which each is seen.
struct Averages {
    /// Sums of probabilities, sample after sample, one number per class.
    sums: Vec<f64>,
    classes: usize,
    turns: usize,
    /// Grids added.
    grids: usize,
}

impl Averages {
    fn new(samples: usize, classes: usize, turns: usize) -> Self {
        Self {
            sums: vec![0.0; samples * classes],
            classes,
            turns,
            grids: 0,
        }
    }

    /// Adds the next grid, which belongs to the sample after `turns` grids of the one before.
    fn add(&mut self, probabilities: &[f64]) {
        let first = self.grids / self.turns * self.classes;
        for (sum, p) in self.sums[first..].iter_mut().zip(probabilities) {
            *sum += p / self.turns as f64;
        }
        self.grids += 1;
    }
}
