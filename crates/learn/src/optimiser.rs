//! Adam with decoupled weight decay and clipping of the gradient.

use crate::{LearnError, Result};
use candle_core::backprop::GradStore;
use candle_core::{DType, Device, Tensor, Var};
use serde::{Deserialize, Serialize};

/// Settings of [`Adam`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AdamSettings {
    /// Length of a step.
    pub learning_rate: f64,
    /// Memory of the mean of the gradient.
    pub beta1: f64,
    /// Memory of the mean of its square.
    pub beta2: f64,
    /// Added to the root of the second mean.
    pub epsilon: f64,
    /// Decoupled weight decay, of the parameters with two axes or more: biases and normalisations
    /// do not decay.
    pub weight_decay: f64,
}

impl Default for AdamSettings {
    fn default() -> Self {
        Self {
            learning_rate: 1e-3,
            beta1: 0.9,
            beta2: 0.999,
            epsilon: 1e-8,
            weight_decay: 0.0,
        }
    }
}

/// Adam (Kingma and Ba, ICLR 2015) with decoupled weight decay (Loshchilov and Hutter, ICLR 2019):
/// for the gradient g of step t,
///
/// m = β₁ m + (1 - β₁) g, v = β₂ v + (1 - β₂) g²,
/// p = p - r (m / (1 - β₁ᵗ) / (√(v / (1 - β₂ᵗ)) + ε) + decay p).
#[derive(Debug)]
pub struct Adam {
    settings: AdamSettings,
    steps: u32,
    /// The number of steps as part of the memory, a scalar.
    counter: Tensor,
    slots: Vec<Slot>,
}

#[derive(Debug)]
struct Slot {
    name: String,
    parameter: Var,
    first: Tensor,
    second: Tensor,
}

impl Adam {
    /// An optimiser of these parameters, with no memory yet.
    ///
    /// # Errors
    /// [`LearnError::Settings`] for settings that make no sense.
    pub fn new(parameters: &[(String, Var)], settings: AdamSettings) -> Result<Self> {
        let AdamSettings {
            learning_rate,
            beta1,
            beta2,
            epsilon,
            weight_decay,
        } = settings;
        let sound = learning_rate > 0.0
            && (0.0..1.0).contains(&beta1)
            && (0.0..1.0).contains(&beta2)
            && epsilon > 0.0
            && weight_decay >= 0.0;
        if !sound {
            return Err(LearnError::Settings(format!(
                "Adam with {settings:?}: the rate and epsilon must be above 0, the betas in [0, 1), the decay not negative"
            )));
        }
        let slots = parameters.iter().map(|(name, parameter)| {
            let zeros = Tensor::zeros(parameter.shape(), DType::F32, parameter.device())?;
            Ok(Slot {
                name: name.clone(),
                parameter: parameter.clone(),
                first: zeros.clone(),
                second: zeros,
            })
        });
        let counter = Tensor::new(0u32, &Device::Cpu)?;
        Ok(Self {
            settings,
            steps: 0,
            counter,
            slots: slots.collect::<Result<_>>()?,
        })
    }

    /// Steps taken.
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// One step with this learning rate; returns the norm of the gradient over all parameters. A
    /// longer gradient is shortened to `clip_norm` first. If the norm is not finite nothing
    /// changes: whoever trains sees it and decides.
    ///
    /// # Errors
    /// [`LearnError::Settings`] if a parameter has no gradient.
    pub fn step(
        &mut self,
        gradients: &GradStore,
        learning_rate: f64,
        clip_norm: Option<f64>,
    ) -> Result<f64> {
        let gradient = |slot: &Slot| match gradients.get(slot.parameter.as_tensor()) {
            Some(gradient) => Ok(gradient.detach()),
            None => Err(LearnError::Settings(format!(
                "{} has no gradient: is it part of the loss?",
                slot.name
            ))),
        };
        let found = self
            .slots
            .iter()
            .map(gradient)
            .collect::<Result<Vec<_>>>()?;
        let mut square = 0.0;
        for gradient in &found {
            square += f64::from(gradient.sqr()?.sum_all()?.to_scalar::<f32>()?);
        }
        let norm = square.sqrt();
        if !norm.is_finite() {
            return Ok(norm);
        }
        let scale = clip_norm
            .filter(|limit| norm > *limit)
            .map_or(1.0, |limit| limit / norm);
        self.steps += 1;
        self.counter = Tensor::new(self.steps, &Device::Cpu)?;
        let AdamSettings {
            beta1,
            beta2,
            epsilon,
            weight_decay,
            ..
        } = self.settings;
        let steps = f64::from(self.steps);
        let (first_share, second_share) = (1.0 - beta1.powf(steps), 1.0 - beta2.powf(steps));
        for (slot, gradient) in self.slots.iter_mut().zip(found) {
            let gradient = (gradient * scale)?;
            slot.first = ((&slot.first * beta1)? + (&gradient * (1.0 - beta1))?)?;
            slot.second = ((&slot.second * beta2)? + (gradient.sqr()? * (1.0 - beta2))?)?;
            let root = ((&slot.second / second_share)?.sqrt()? + epsilon)?;
            let mut change = ((&slot.first / first_share)? / root)?;
            let old = slot.parameter.as_detached_tensor();
            if weight_decay > 0.0 && old.rank() > 1 {
                change = (change + (&old * weight_decay)?)?;
            }
            slot.parameter.set(&(old - (change * learning_rate)?)?)?;
        }
        Ok(norm)
    }

    /// The memory: `step` (u32 scalar), and `NAME.first_moment`, `NAME.second_moment` for every
    /// parameter.
    pub fn state(&self) -> Vec<(String, Tensor)> {
        let moments = self.slots.iter().flat_map(|slot| {
            [("first", &slot.first), ("second", &slot.second)]
                .map(|(which, moment)| (format!("{}.{which}_moment", slot.name), moment.clone()))
        });
        std::iter::once(("step".to_owned(), self.counter.clone()))
            .chain(moments)
            .collect()
    }

    /// Takes over a memory as [`Adam::state`] gave it.
    ///
    /// # Errors
    /// [`LearnError::Settings`] if a tensor is missing or has another shape; nothing has changed
    /// then.
    pub fn load_state(&mut self, state: &[(String, Tensor)]) -> Result<()> {
        let find = |name: &str| {
            let found = state.iter().find(|(own, _)| own == name);
            found
                .map(|(_, tensor)| tensor)
                .ok_or_else(|| LearnError::Settings(format!("the memory of Adam lacks {name}")))
        };
        let moment = |slot: &Slot, which: &str| {
            let name = format!("{}.{which}_moment", slot.name);
            let tensor = find(&name)?;
            if tensor.dims() != slot.parameter.dims() {
                return Err(LearnError::Settings(format!(
                    "{name} is {:?}, the parameter {:?}",
                    tensor.dims(),
                    slot.parameter.dims()
                )));
            }
            Ok(tensor.detach().to_device(slot.parameter.device())?)
        };
        let counter = find("step")?.detach().to_device(&Device::Cpu)?;
        let steps = counter.to_scalar::<u32>()?;
        let moments = self
            .slots
            .iter()
            .map(|slot| Ok((moment(slot, "first")?, moment(slot, "second")?)))
            .collect::<Result<Vec<_>>>()?;
        (self.steps, self.counter) = (steps, counter);
        for (slot, (first, second)) in self.slots.iter_mut().zip(moments) {
            (slot.first, slot.second) = (first, second);
        }
        Ok(())
    }
}
