//! A small convolutional network: blocks, global pooling, one linear layer.
//!
//! Names and layouts of the parameters are those of PyTorch (`blocks.0.weight` is (O, C, k, k, k),
//! `head.weight` (K, F)), so that a state dictionary written from them loads there.

use crate::block::{self, BlockParameters, BlockSettings};
use crate::operations::{global_average_pool, global_maximum_pool};
use crate::{LearnError, Result};
use candle_core::{Device, Tensor, Var};
use protomer_kernel::random::CounterRng;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// How a grid becomes one number per channel.
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
/// use protomer_learn::{BlockSettings, GlobalPooling, Network, NetworkSettings};
/// use candle_core::{DType, Device, Tensor};
/// let block = BlockSettings { width: 4, kernel: 3, groups: None, pool: true };
/// let settings = NetworkSettings { channels: 3, classes: 2, blocks: vec![block; 2], pooling: GlobalPooling::Average };
/// let network = Network::new(&settings, 7, &Device::Cpu).unwrap();
/// let batch = Tensor::zeros((5, 3, 8, 8, 8), DType::F32, &Device::Cpu).unwrap();
/// assert_eq!(network.forward(&batch).unwrap().dims(), [5, 2]);
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
    /// What follows the last block.
    #[serde(default)]
    pub pooling: GlobalPooling,
}

impl NetworkSettings {
    /// Whether the settings make sense.
    ///
    /// # Errors
    /// [`LearnError::Settings`] says what does not.
    pub fn check(&self) -> Result<()> {
        if self.channels == 0 || self.classes < 2 || self.blocks.is_empty() {
            let Self {
                channels,
                classes,
                blocks,
                ..
            } = self;
            let count = blocks.len();
            return Err(LearnError::Settings(format!(
                "a network of {channels} channels, {count} blocks and {classes} classes: \
                 give it at least 1 channel, 1 block and 2 classes"
            )));
        }
        self.blocks.iter().enumerate().try_for_each(|(i, block)| {
            block
                .check()
                .map_err(|error| LearnError::Settings(format!("block {i}: {error}")))
        })
    }

    /// Numbers per sample that the last layer sees.
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
#[derive(Debug, Clone)]
pub struct Network {
    settings: NetworkSettings,
    device: Device,
    parameters: Vec<(String, Var)>,
}

impl Network {
    /// A network with fresh weights: normal with variance 2 / (C k³) in the blocks (He et al., ICCV
    /// 2015), biases 0, normalisation 1 and 0, and a small head, normal with variance 0.001 / F, so
    /// that training starts from the prior. The weights depend on the seed alone.
    ///
    /// # Errors
    /// [`LearnError::Settings`] for a shape that makes no sense.
    pub fn new(settings: &NetworkSettings, seed: u64, device: &Device) -> Result<Self> {
        settings.check()?;
        let mut network = Self {
            settings: settings.clone(),
            device: device.clone(),
            parameters: Vec::new(),
        };
        let mut channels = settings.channels;
        for (i, block) in settings.blocks.iter().enumerate() {
            let (width, kernel) = (block.width, block.kernel);
            let variance = 2.0 / (channels * kernel.pow(3)) as f64;
            network.add_normal(
                &format!("blocks.{i}.weight"),
                &[width, channels, kernel, kernel, kernel],
                variance,
                seed,
            )?;
            network.add_constant(&format!("blocks.{i}.bias"), width, 0.0)?;
            if block.groups.is_some() {
                network.add_constant(&format!("blocks.{i}.norm.weight"), width, 1.0)?;
                network.add_constant(&format!("blocks.{i}.norm.bias"), width, 0.0)?;
            }
            channels = width;
        }
        let features = settings.features();
        network.add_normal(
            "head.weight",
            &[settings.classes, features],
            0.001 / features as f64,
            seed,
        )?;
        network.add_constant("head.bias", settings.classes, 0.0)?;
        Ok(network)
    }

    fn add(&mut self, name: &str, shape: &[usize], values: Vec<f32>) -> Result<()> {
        let tensor = Tensor::from_vec(values, shape, &self.device)?;
        self.parameters
            .push((name.into(), Var::from_tensor(&tensor)?));
        Ok(())
    }

    fn add_constant(&mut self, name: &str, count: usize, value: f32) -> Result<()> {
        self.add(name, &[count], vec![value; count])
    }

    fn add_normal(&mut self, name: &str, shape: &[usize], variance: f64, seed: u64) -> Result<()> {
        let mut random = CounterRng::new(seed, 0, self.parameters.len() as u64);
        let count: usize = shape.iter().product();
        let values = (0..count)
            .map(|_| (variance.sqrt() * normal(&mut random)) as f32)
            .collect();
        self.add(name, shape, values)
    }

    /// The shape of the network.
    pub fn settings(&self) -> &NetworkSettings {
        &self.settings
    }

    /// The logits of a batch of grids, (B, C, D, H, W), as a tensor (B, classes) that gradients
    /// flow through.
    ///
    /// # Errors
    /// [`LearnError::Settings`] for a batch of another number of channels or grids too small for
    /// the poolings.
    pub fn forward(&self, batch: &Tensor) -> Result<Tensor> {
        self.run(batch, |parameter| parameter.as_tensor().clone())
    }

    /// The logits as [`Network::forward`] gives them, without what a gradient would need: faster,
    /// and less memory.
    ///
    /// # Errors
    /// As for [`Network::forward`].
    pub fn predict(&self, batch: &Tensor) -> Result<Tensor> {
        self.run(&batch.detach(), |parameter| parameter.as_detached_tensor())
    }

    fn run(&self, batch: &Tensor, tensor: impl Fn(&Var) -> Tensor) -> Result<Tensor> {
        let (_, channels, depth, height, width) = batch.dims5()?;
        let smallest = self.settings.smallest_edge();
        if channels != self.settings.channels || depth.min(height).min(width) < smallest {
            return Err(LearnError::Settings(format!(
                "grids of {channels} channels and {depth} x {height} x {width} voxels: the network takes {} channels \
                 and at least {smallest} voxels along each edge",
                self.settings.channels
            )));
        }
        let mut parameters = self
            .parameters
            .iter()
            .map(|(_, parameter)| tensor(parameter));
        let mut next = || {
            parameters
                .next()
                .ok_or_else(|| LearnError::Settings("the network lacks parameters".into()))
        };
        let mut grid = batch.clone();
        for settings in &self.settings.blocks {
            let (weight, bias) = (next()?, next()?);
            let norm = if settings.groups.is_some() {
                Some((next()?, next()?))
            } else {
                None
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

    /// The parameters, named as PyTorch would name them, in a fixed order.
    pub fn parameters(&self) -> &[(String, Var)] {
        &self.parameters
    }

    /// Sets a parameter by name.
    ///
    /// # Errors
    /// [`LearnError::Settings`] for a name the network lacks or another shape.
    pub fn set_parameter(&self, name: &str, value: &Tensor) -> Result<()> {
        let (_, parameter) = self
            .parameters
            .iter()
            .find(|(own, _)| own == name)
            .ok_or_else(|| LearnError::Settings(format!("the network has no parameter {name}")))?;
        if parameter.dims() != value.dims() {
            return Err(LearnError::Settings(format!(
                "parameter {name} is {:?} in the network and {:?} here",
                parameter.dims(),
                value.dims()
            )));
        }
        Ok(parameter.set(&value.to_device(&self.device)?)?)
    }

    /// Sets the bias of the last layer to the logarithms of the classes' shares, so that training
    /// starts from the prior.
    ///
    /// # Errors
    /// [`LearnError::Settings`] if there is not one finite number per class.
    pub fn set_head_bias(&self, log_prior: &[f32]) -> Result<()> {
        if log_prior.len() != self.settings.classes
            || log_prior.iter().any(|value| !value.is_finite())
        {
            return Err(LearnError::Settings(format!(
                "{} logarithms of shares for {} classes: give one finite number per class",
                log_prior.len(),
                self.settings.classes
            )));
        }
        self.set_parameter("head.bias", &Tensor::new(log_prior, &self.device)?)
    }
}

/// A number of the standard normal distribution (Box and Muller, Ann. Math. Statist. 29 (1958),
/// 610).
fn normal(random: &mut CounterRng) -> f64 {
    let radius = (-2.0 * (1.0 - random.uniform()).ln()).sqrt();
    radius * (TAU * random.uniform()).cos()
}
