//! A small convolutional network: blocks, global pooling, one linear layer.
//!
//! Names and layouts of the parameters are those of PyTorch (`blocks.0.weight` is (O, C, k, k, k),
//! `head.weight` (K, F)), so that a state dictionary written from them loads there.

use crate::Result;
use crate::block::{self, BlockParameters, BlockSettings};
use crate::error::refuse;
use crate::operations::{global_average_pool, global_maximum_pool};
use candle_core::{Device, Tensor, Var};
use protomer_kernel::random::CounterRng;
use serde::{Deserialize, Serialize};

/// Reduction of a grid to one or two numbers per channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GlobalPooling {
    /// The mean over all voxels.
    #[default]
    Average,
    /// The mean, then the maximum: two numbers per channel.
    AverageAndMaximum,
}

/// The shape of a network.
///
/// ```
/// use protomer_learn::{BlockSettings, GlobalPooling, NetworkSettings};
///
/// let block = BlockSettings { width: 8, kernel: 3, groups: Some(4), pool: true };
/// let settings = NetworkSettings {
///     channels: 3,
///     classes: 2,
///     blocks: vec![block; 3],
///     pooling: GlobalPooling::AverageAndMaximum,
/// };
/// assert!(settings.check().is_ok());
/// assert_eq!(settings.features(), 16);
/// assert_eq!(settings.smallest_edge(), 8, "three poolings halve the grid");
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NetworkSettings {
    /// Channels of the grids.
    pub channels: usize,
    /// Classes told apart.
    pub classes: usize,
    /// The blocks, first to last.
    pub blocks: Vec<BlockSettings>,
    /// Pooling after the last block.
    #[serde(default)]
    pub pooling: GlobalPooling,
}

impl NetworkSettings {
    /// Checks that the settings make sense.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) says what does not.
    pub fn check(&self) -> Result<()> {
        if self.channels == 0 || self.classes < 2 || self.blocks.is_empty() {
            return refuse(format!(
                "a network of {} channels, {} blocks and {} classes: give it at least 1 channel, \
                 1 block and 2 classes",
                self.channels,
                self.blocks.len(),
                self.classes
            ));
        }
        for (number, block) in self.blocks.iter().enumerate() {
            if let Err(error) = block.check() {
                return refuse(format!("block {number}: {error}"));
            }
        }
        Ok(())
    }

    /// Numbers per sample that the last layer sees.
    ///
    /// ```
    /// use protomer_learn::{BlockSettings, GlobalPooling, NetworkSettings};
    /// let block = BlockSettings { width: 8, kernel: 3, groups: None, pool: true };
    /// let mut settings = NetworkSettings {
    ///     channels: 3,
    ///     classes: 2,
    ///     blocks: vec![block; 3],
    ///     pooling: GlobalPooling::Average,
    /// };
    /// assert_eq!((settings.features(), settings.smallest_edge()), (8, 8));
    /// settings.pooling = GlobalPooling::AverageAndMaximum;
    /// assert_eq!(settings.features(), 16);
    /// ```
    pub fn features(&self) -> usize {
        let width = self.blocks.last().map_or(0, |block| block.width);
        match self.pooling {
            GlobalPooling::Average => width,
            GlobalPooling::AverageAndMaximum => 2 * width,
        }
    }

    /// The smallest edge a grid may have: every pooling halves it, rounded down.
    pub fn smallest_edge(&self) -> usize {
        1 << self.blocks.iter().filter(|block| block.pool).count()
    }
}

/// A network and its parameters.
///
/// ```
/// use candle_core::{DType, Device, Tensor};
/// use protomer_learn::{BlockSettings, GlobalPooling, Network, NetworkSettings};
///
/// let block = BlockSettings { width: 4, kernel: 3, groups: None, pool: true };
/// let settings = NetworkSettings {
///     channels: 3,
///     classes: 2,
///     blocks: vec![block; 2],
///     pooling: GlobalPooling::Average,
/// };
/// let network = Network::new(&settings, 7, &Device::Cpu)?;
/// let batch = Tensor::zeros((5, 3, 8, 8, 8), DType::F32, &Device::Cpu)?;
/// assert_eq!(network.forward(&batch)?.dims(), [5, 2]);
/// assert_eq!(network.parameters()[0].0, "blocks.0.weight");
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Network {
    settings: NetworkSettings,
    device: Device,
    parameters: Vec<(String, Var)>,
}

impl Network {
    /// A network with fresh weights, which depend on the seed alone.
    ///
    /// Weights of the blocks are normal with variance 2 / (C k³) (He et al., ICCV 2015), biases 0,
    /// normalisations 1 and 0. Weights of the head are normal with variance 0.001 / F: so small
    /// that training starts from the prior.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) for a shape that makes no sense.
    pub fn new(settings: &NetworkSettings, seed: u64, device: &Device) -> Result<Self> {
        settings.check()?;
        let mut network = Self {
            settings: settings.clone(),
            device: device.clone(),
            parameters: Vec::new(),
        };
        let mut channels = settings.channels;
        for (number, block) in settings.blocks.iter().enumerate() {
            network.add_block(&format!("blocks.{number}"), channels, block, seed)?;
            channels = block.width;
        }
        let (classes, features) = (settings.classes, settings.features());
        let variance = 0.001 / features as f64;
        network.add_normal("head.weight", &[classes, features], variance, seed)?;
        network.add_constant("head.bias", classes, 0.0)?;
        Ok(network)
    }

    fn add_block(
        &mut self,
        name: &str,
        channels: usize,
        block: &BlockSettings,
        seed: u64,
    ) -> Result<()> {
        let (width, kernel) = (block.width, block.kernel);
        let variance = 2.0 / (channels * kernel.pow(3)) as f64;
        let shape = [width, channels, kernel, kernel, kernel];
        self.add_normal(&format!("{name}.weight"), &shape, variance, seed)?;
        self.add_constant(&format!("{name}.bias"), width, 0.0)?;
        if block.groups.is_some() {
            self.add_constant(&format!("{name}.norm.weight"), width, 1.0)?;
            self.add_constant(&format!("{name}.norm.bias"), width, 0.0)?;
        }
        Ok(())
    }

    fn add_constant(&mut self, name: &str, count: usize, value: f32) -> Result<()> {
        self.add(name, &[count], vec![value; count])
    }

    fn add_normal(&mut self, name: &str, shape: &[usize], variance: f64, seed: u64) -> Result<()> {
        let mut random = CounterRng::new(seed, 0, self.parameters.len() as u64);
        let mut values = vec![0.0; shape.iter().product()];
        for value in &mut values {
            *value = (variance.sqrt() * random.normal()) as f32;
        }
        self.add(name, shape, values)
    }

    fn add(&mut self, name: &str, shape: &[usize], values: Vec<f32>) -> Result<()> {
        let tensor = Tensor::from_vec(values, shape, &self.device)?;
        let parameter = Var::from_tensor(&tensor)?;
        self.parameters.push((name.into(), parameter));
        Ok(())
    }

    /// The shape of the network.
    pub fn settings(&self) -> &NetworkSettings {
        &self.settings
    }

    /// Device on which the network is computed.
    pub(crate) fn device(&self) -> &Device {
        &self.device
    }

    /// The logits of a batch of grids, (B, C, D, H, W), as a tensor (B, classes) that gradients
    /// flow through.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) for a batch of another number of
    /// channels or grids too small for the poolings.
    pub fn forward(&self, batch: &Tensor) -> Result<Tensor> {
        self.run(batch, |parameter| parameter.as_tensor().clone())
    }

    /// The logits as [`Network::forward`] computes them, without what a gradient would need:
    /// faster, and less memory.
    ///
    /// # Errors
    /// As for [`Network::forward`].
    pub fn predict(&self, batch: &Tensor) -> Result<Tensor> {
        self.run(&batch.detach(), |parameter| parameter.as_detached_tensor())
    }

    fn run(&self, batch: &Tensor, tensor: impl Fn(&Var) -> Tensor) -> Result<Tensor> {
        self.check(batch)?;
        let mut parameters = self.parameters.iter();
        let mut next = || match parameters.next() {
            Some((_, parameter)) => Ok(tensor(parameter)),
            None => refuse("the network lacks parameters"),
        };
        let mut grid = batch.clone();
        for settings in &self.settings.blocks {
            let (weight, bias) = (next()?, next()?);
            let norm = match settings.groups {
                Some(_) => Some((next()?, next()?)),
                None => None,
            };
            grid = block::forward(&grid, &BlockParameters { weight, bias, norm }, settings)?;
        }
        let mut features = global_average_pool(&grid)?;
        if self.settings.pooling == GlobalPooling::AverageAndMaximum {
            features = Tensor::cat(&[features, global_maximum_pool(&grid)?], 1)?;
        }
        let (weight, bias) = (next()?, next()?);
        Ok(features.matmul(&weight.t()?)?.broadcast_add(&bias)?)
    }

    fn check(&self, batch: &Tensor) -> Result<()> {
        let (_, channels, depth, height, width) = batch.dims5()?;
        let (expected, smallest) = (self.settings.channels, self.settings.smallest_edge());
        if channels != expected || depth.min(height).min(width) < smallest {
            return refuse(format!(
                "grids of {channels} channels and {depth} x {height} x {width} voxels: the network \
                 takes {expected} channels and at least {smallest} voxels along each edge"
            ));
        }
        Ok(())
    }

    /// The parameters, named as PyTorch would name them, in a fixed order.
    pub fn parameters(&self) -> &[(String, Var)] {
        &self.parameters
    }

    /// Numbers that training fits.
    ///
    /// ```
    /// use protomer_learn::{BlockSettings, Device, GlobalPooling, Network, NetworkSettings};
    /// let block = BlockSettings { width: 4, kernel: 3, groups: None, pool: true };
    /// let settings = NetworkSettings {
    ///     channels: 2,
    ///     classes: 3,
    ///     blocks: vec![block],
    ///     pooling: GlobalPooling::Average,
    /// };
    /// let network = Network::new(&settings, 1, &Device::Cpu)?;
    /// assert_eq!(network.parameter_count(), 4 * (2 * 27 + 1) + 3 * (4 + 1));
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    pub fn parameter_count(&self) -> usize {
        self.parameters
            .iter()
            .map(|(_, parameter)| parameter.elem_count())
            .sum()
    }

    /// Sets a parameter by name.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) for a name the network lacks or
    /// another shape.
    pub fn set_parameter(&self, name: &str, value: &Tensor) -> Result<()> {
        let Some((_, parameter)) = self
            .parameters
            .iter()
            .find(|(candidate, _)| candidate == name)
        else {
            return refuse(format!("the network has no parameter {name}"));
        };
        if parameter.dims() != value.dims() {
            return refuse(format!(
                "parameter {name} is {:?} in the network and {:?} here",
                parameter.dims(),
                value.dims()
            ));
        }
        Ok(parameter.set(&value.to_device(&self.device)?)?)
    }

    /// Sets the bias of the last layer to the logarithms of the classes' shares, so that training
    /// starts from the prior.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) if there is not one finite number per
    /// class.
    pub fn set_head_bias(&self, log_prior: &[f32]) -> Result<()> {
        let (given, classes) = (log_prior.len(), self.settings.classes);
        if given != classes || log_prior.iter().any(|value| !value.is_finite()) {
            return refuse(format!(
                "{given} logarithms of shares for {classes} classes: give one finite number per \
                 class"
            ));
        }
        self.set_parameter("head.bias", &Tensor::new(log_prior, &self.device)?)
    }
}
