//! Adam with decoupled weight decay and clipping of the gradient.

use crate::Result;
use crate::error::refuse;
use crate::numbers::{Numbers, sum_in_lanes};
use candle_core::backprop::GradStore;
use candle_core::{DType, Device, Tensor, Var};
use serde::{Deserialize, Serialize};

/// Settings of [`Adam`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AdamSettings {
    /// Length of a step.
    pub learning_rate: f64,
    /// Memory of the mean of the gradient, β₁.
    pub beta1: f64,
    /// Memory of the mean of the squared gradient, β₂.
    pub beta2: f64,
    /// Constant added to the root of the second mean, ε.
    pub epsilon: f64,
    /// Decoupled weight decay. Biases and normalisations do not decay: only parameters with two
    /// axes or more do.
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

impl AdamSettings {
    fn check(&self) -> Result<()> {
        let memories = [self.beta1, self.beta2];
        let is_sound = self.learning_rate > 0.0
            && memories.iter().all(|beta| (0.0..1.0).contains(beta))
            && self.epsilon > 0.0
            && self.weight_decay >= 0.0;
        if is_sound {
            return Ok(());
        }
        refuse(format!(
            "Adam with {self:?}: the rate and epsilon must be above 0, the betas in [0, 1), the \
             decay not negative"
        ))
    }
}

/// Adam (Kingma and Ba, ICLR 2015) with decoupled weight decay (Loshchilov and Hutter, ICLR 2019):
/// for the gradient g of step t,
///
/// m = β₁ m + (1 - β₁) g, v = β₂ v + (1 - β₂) g²,
/// p = p - r (m / (1 - β₁ᵗ) / (√(v / (1 - β₂ᵗ)) + ε) + decay p).
///
/// ```
/// use candle_core::{Device, Tensor, Var};
/// use protomer_learn::{Adam, AdamSettings};
///
/// let x = Var::from_tensor(&Tensor::new(3f32, &Device::Cpu)?)?;
/// let mut adam = Adam::new(&[("x".into(), x.clone())], AdamSettings::default())?;
/// for _ in 0..100 {
///     let loss = x.sqr()?;
///     adam.step(&loss.backward()?, 0.1, None)?;
/// }
/// assert!(x.to_scalar::<f32>()?.abs() < 0.2);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
#[derive(Debug)]
pub struct Adam {
    settings: AdamSettings,
    steps: u32,
    /// The number of steps as part of the memory, a scalar.
    counter: Tensor,
    slots: Vec<Slot>,
}

/// A parameter and its memory.
#[derive(Debug)]
struct Slot {
    name: String,
    parameter: Var,
    /// Mean of the gradient, m.
    first: Tensor,
    /// Mean of the squared gradient, v.
    second: Tensor,
}

impl Adam {
    /// An optimiser of these parameters, with no memory yet.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) for settings that make no sense.
    pub fn new(parameters: &[(String, Var)], settings: AdamSettings) -> Result<Self> {
        settings.check()?;
        let mut slots = Vec::with_capacity(parameters.len());
        for (name, parameter) in parameters {
            let zeros = Tensor::zeros(parameter.shape(), DType::F32, parameter.device())?;
            slots.push(Slot {
                name: name.clone(),
                parameter: parameter.clone(),
                first: zeros.clone(),
                second: zeros,
            });
        }
        Ok(Self {
            settings,
            steps: 0,
            counter: Tensor::new(0u32, &Device::Cpu)?,
            slots,
        })
    }

    /// Steps taken.
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// Takes one step with this learning rate. Returns the norm of the gradient over all
    /// parameters.
    ///
    /// A gradient longer than `clip_norm` is shortened to it first. If the norm is not finite,
    /// nothing changes: the caller sees it and decides.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) if a parameter has no gradient.
    pub fn step(
        &mut self,
        gradients: &GradStore,
        learning_rate: f64,
        clip_norm: Option<f64>,
    ) -> Result<f64> {
        // All gradients before anything changes: a missing
        // one leaves parameters and memory as they were.
        let gradients = self.gradients(gradients)?;
        let norm = norm(&gradients)?;
        // One infinite gradient would stay in the moments for good.
        // The step is left out; the caller sees it by the norm and counts it.
        if !norm.is_finite() {
            return Ok(norm);
        }
        // One factor for all parameters keeps the direction of the step.
        let scale = match clip_norm {
            Some(limit) if norm > limit => limit / norm,
            _ => 1.0,
        };
        // Before the slots: the correction for the start divides by 1 - β^t, with t = 1 at first.
        self.steps += 1;
        self.counter = Tensor::new(self.steps, &Device::Cpu)?;
        for (slot, gradient) in self.slots.iter_mut().zip(gradients) {
            slot.step(
                &(gradient * scale)?,
                learning_rate,
                self.steps,
                &self.settings,
            )?;
        }
        Ok(norm)
    }

    /// The gradient of each parameter.
    fn gradients(&self, store: &GradStore) -> Result<Vec<Tensor>> {
        let mut gradients = Vec::with_capacity(self.slots.len());
        for slot in &self.slots {
            let Some(gradient) = store.get(slot.parameter.as_tensor()) else {
                let name = &slot.name;
                return refuse(format!("{name} has no gradient: is it part of the loss?"));
            };
            // Off the graph, or the moments would hold every epoch's graph in memory.
            gradients.push(gradient.detach());
        }
        Ok(gradients)
    }

    /// The memory: `step` (u32 scalar), and `NAME.first_moment`, `NAME.second_moment` for every
    /// parameter.
    pub fn state(&self) -> Vec<(String, Tensor)> {
        let mut state = vec![("step".to_owned(), self.counter.clone())];
        for Slot {
            name,
            first,
            second,
            ..
        } in &self.slots
        {
            state.push((format!("{name}.first_moment"), first.clone()));
            state.push((format!("{name}.second_moment"), second.clone()));
        }
        state
    }

    /// Takes over a memory as [`Adam::state`] returned it.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) if a tensor is missing or has another
    /// shape. Nothing has changed then.
    pub fn load_state(&mut self, state: &[(String, Tensor)]) -> Result<()> {
        let counter = find(state, "step")?.detach().to_device(&Device::Cpu)?;
        let steps = counter.to_scalar::<u32>()?;
        // All moments are read before the first is replaced: a file
        // that does not fit must not leave half a memory behind.
        let mut moments = Vec::with_capacity(self.slots.len());
        for slot in &self.slots {
            moments.push((
                slot.moment(state, "first_moment")?,
                slot.moment(state, "second_moment")?,
            ));
        }
        (self.steps, self.counter) = (steps, counter);
        for (slot, (first, second)) in self.slots.iter_mut().zip(moments) {
            (slot.first, slot.second) = (first, second);
        }
        Ok(())
    }
}

impl Slot {
    /// Updates the memory and the parameter.
    fn step(
        &mut self,
        gradient: &Tensor,
        learning_rate: f64,
        steps: u32,
        settings: &AdamSettings,
    ) -> Result<()> {
        let AdamSettings {
            beta1,
            beta2,
            epsilon,
            weight_decay,
            ..
        } = *settings;
        let steps = f64::from(steps);
        // Both moments began at zero and so are too small by 1 - β^t.
        let (first_share, second_share) = (1.0 - beta1.powf(steps), 1.0 - beta2.powf(steps));
        self.first = ((&self.first * beta1)? + (gradient * (1.0 - beta1))?)?;
        self.second = ((&self.second * beta2)? + (gradient.sqr()? * (1.0 - beta2))?)?;
        let root = ((&self.second / second_share)?.sqrt()? + epsilon)?;
        let mut change = ((&self.first / first_share)? / root)?;
        // Detached, or each step would hang on to the graph of the one before.
        let old = self.parameter.as_detached_tensor();
        // Decay of a bias or of a normalisation's scale would pull the output, not simplify it.
        if weight_decay > 0.0 && old.rank() > 1 {
            change = (change + (&old * weight_decay)?)?;
        }
        Ok(self.parameter.set(&(old - (change * learning_rate)?)?)?)
    }

    /// A part of the memory of this parameter.
    fn moment(&self, state: &[(String, Tensor)], which: &str) -> Result<Tensor> {
        let name = format!("{}.{which}", self.name);
        let tensor = find(state, &name)?;
        if tensor.dims() != self.parameter.dims() {
            return refuse(format!(
                "{name} is {:?}, the parameter {:?}",
                tensor.dims(),
                self.parameter.dims()
            ));
        }
        Ok(tensor.detach().to_device(self.parameter.device())?)
    }
}

/// The norm over all gradients together.
fn norm(gradients: &[Tensor]) -> Result<f64> {
    let mut square = 0.0;
    for gradient in gradients {
        square += f64::from(sum_of_squares(gradient)?);
    }
    // One norm over all parameters: clipping by parameter would turn the step.
    Ok(square.sqrt())
}

fn sum_of_squares(gradient: &Tensor) -> Result<f32> {
    // Away from the processor one number comes back, not the whole gradient.
    if !gradient.device().is_cpu() {
        return Ok(gradient.sqr()?.sum_all()?.to_scalar()?);
    }
    let gradient = gradient.contiguous()?;
    let numbers = Numbers::from_tensor(&gradient);
    Ok(sum_in_lanes(numbers.slice()?, |value| value * value))
}

fn find<'a>(state: &'a [(String, Tensor)], name: &str) -> Result<&'a Tensor> {
    match state.iter().find(|(candidate, _)| candidate == name) {
        Some((_, tensor)) => Ok(tensor),
        None => refuse(format!("the memory of Adam lacks {name}")),
    }
}
