//! One block of the network: convolution, group normalisation if wanted, ReLU, pooling if wanted.
//!
//! On the processor a block is one node of the tensor library's graph ([`fused`]): node by node,
//! passes over grids and gradients that are added to fresh zeros cost several times what the
//! convolutions do. On any other device it is composed of tensor operations ([`composed`]).

pub mod convolution;
pub mod norm;

use crate::convolution::Level;
use crate::operations::{convolution3d, group_norm, max_pool3d};
use crate::{LearnError, Result};
use candle_core::{CpuStorage, DType, Layout, Storage, Tensor};
use convolution::{Convolution, Finishing};
use norm::NormedConvolution;
use serde::{Deserialize, Serialize};

/// What a block does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BlockSettings {
    /// Channels it gives.
    pub width: usize,
    /// Edge of the convolution kernel, voxels: 1, 3 or 5.
    pub kernel: usize,
    /// Groups of the group normalisation, which must divide the width; none: no normalisation.
    #[serde(default)]
    pub groups: Option<usize>,
    /// Whether the maximum of every 2 x 2 x 2 window is taken at the end.
    #[serde(default)]
    pub pool: bool,
}

impl BlockSettings {
    /// Whether the settings make sense.
    ///
    /// # Errors
    /// [`LearnError::Settings`] says what does not.
    pub fn check(&self) -> Result<()> {
        let Self {
            width,
            kernel,
            groups,
            ..
        } = *self;
        if width == 0 {
            return Err(LearnError::Settings(
                "a block of width 0: give it at least one channel".into(),
            ));
        }
        if !matches!(kernel, 1 | 3 | 5) {
            return Err(LearnError::Settings(format!(
                "a kernel of edge {kernel}: take 1, 3 or 5"
            )));
        }
        if let Some(groups) = groups
            && (groups == 0 || width % groups != 0)
        {
            return Err(LearnError::Settings(format!(
                "{width} channels do not divide into {groups} groups: take groups that divide every width, or none"
            )));
        }
        Ok(())
    }
}

/// The parameters of a block, as tensors that may or may not be variables.
#[derive(Debug, Clone)]
pub struct BlockParameters {
    /// (O, C, k, k, k).
    pub weight: Tensor,
    /// (O).
    pub bias: Tensor,
    /// Weight and bias of the normalisation, (O) each.
    pub norm: Option<(Tensor, Tensor)>,
}

/// The block composed of the operations one by one, on any device: (B, C, D, H, W) to (B, O, D',
/// H', W').
///
/// # Errors
/// [`LearnError::Tensor`] for shapes that do not fit, [`LearnError::Settings`] for settings that
/// make no sense.
pub fn composed(
    input: &Tensor,
    parameters: &BlockParameters,
    settings: &BlockSettings,
) -> Result<Tensor> {
    let mut grid = convolution3d(input, &parameters.weight, &parameters.bias)?;
    if let (Some(groups), Some((weight, bias))) = (settings.groups, &parameters.norm) {
        grid = group_norm(&grid, groups, weight, bias)?;
    }
    grid = grid.relu()?;
    if settings.pool {
        max_pool3d(&grid)
    } else {
        Ok(grid)
    }
}

/// The block in one node on the processor, with the kernels of `level`.
///
/// # Errors
/// [`LearnError::Tensor`] for shapes that do not fit, [`LearnError::Settings`] for settings that
/// make no sense.
pub fn fused(
    level: Level,
    input: &Tensor,
    parameters: &BlockParameters,
    settings: &BlockSettings,
) -> Result<Tensor> {
    if settings.groups.is_some() {
        return NormedConvolution::apply(level, input, parameters, settings);
    }
    let finishing = if settings.pool {
        Finishing::Pool
    } else {
        Finishing::Relu
    };
    Convolution::apply(
        level,
        finishing,
        input,
        &parameters.weight,
        &parameters.bias,
    )
}

/// The block on whatever device its input is on.
///
/// # Errors
/// [`LearnError::Tensor`] for shapes that do not fit, [`LearnError::Settings`] for settings that
/// make no sense.
pub fn forward(
    input: &Tensor,
    parameters: &BlockParameters,
    settings: &BlockSettings,
) -> Result<Tensor> {
    if input.device().is_cpu() && input.dtype() == DType::F32 {
        fused(Level::best(), input, parameters, settings)
    } else {
        composed(input, parameters, settings)
    }
}

/// The numbers of a contiguous layout.
fn contiguous<'a>(storage: &'a CpuStorage, layout: &Layout) -> candle_core::Result<&'a [f32]> {
    let (start, end) = layout
        .contiguous_offsets()
        .ok_or_else(convolution::wrong_storage)?;
    storage
        .as_slice::<f32>()?
        .get(start..end)
        .ok_or_else(convolution::wrong_storage)
}

/// Calls `work` with the numbers of a contiguous tensor.
fn with_slice<T>(
    tensor: &Tensor,
    work: impl FnOnce(&[f32]) -> candle_core::Result<T>,
) -> candle_core::Result<T> {
    let (storage, layout) = tensor.storage_and_layout();
    match &*storage {
        Storage::Cpu(storage) => work(contiguous(storage, layout)?),
        _ => Err(convolution::wrong_storage()),
    }
}

/// The sum, to the precision of the numbers.
fn sum(numbers: &[f32]) -> f64 {
    sum_of(numbers, |value| value)
}

/// The sum of a function of the numbers, to their precision: f32 in lanes over short parts, f64
/// over these.
#[inline(always)]
fn sum_of(numbers: &[f32], of: impl Fn(f32) -> f32) -> f64 {
    let mut total = 0.0;
    for part in numbers.chunks(1024) {
        let mut lanes = [0.0f32; 64];
        let mut pieces = part.chunks_exact(64);
        for piece in &mut pieces {
            for (lane, value) in lanes.iter_mut().zip(piece) {
                *lane += of(*value);
            }
        }
        for value in pieces.remainder() {
            total += f64::from(of(*value));
        }
        for lane in lanes {
            total += f64::from(lane);
        }
    }
    total
}
