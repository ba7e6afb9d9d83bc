//! One block of the network: convolution, group normalisation if wanted, ReLU, pooling if wanted.
//!
//! On the processor a block is one node of the tensor library's graph ([`fused`]). Node by node,
//! passes over grids and gradients that are added to fresh zeros cost several times what the
//! convolutions do: elementwise passes, copies of the library's autograd and fresh pages took four
//! fifths of a step. The kernels are our own; candle has no three-dimensional convolution. On any
//! other device a block is composed of tensor operations ([`composed`]).
//!
//! | module | one idea |
//! |---|---|
//! | `settings` | what a block does |
//! | `node` | the block as a node of the graph |
//! | `convolution` | a convolution of one sample and how it is finished |
//! | `group_norm` | normalisation, ReLU and pooling of one sample, forward and backward |
//! | `gradients` | the backward pass of a convolution, sample by sample, and the sum over samples |

mod convolution;
mod gradients;
mod group_norm;
mod node;
mod settings;

pub use settings::BlockSettings;

use crate::Result;
use crate::operations::{convolution3d, group_norm, max_pool3d};
use candle_core::{DType, Tensor};
use node::Node;
use protomer_convolution::Level;

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

/// The block on whatever device its input is on: (B, C, D, H, W) to (B, O, D', H', W').
///
/// ```
/// use candle_core::{DType, Device, Tensor};
/// use protomer_learn::BlockSettings;
/// use protomer_learn::block::{BlockParameters, composed, forward};
///
/// let settings = BlockSettings { width: 4, kernel: 3, groups: None, pool: true };
/// let parameters = BlockParameters {
///     weight: Tensor::ones((4, 2, 3, 3, 3), DType::F32, &Device::Cpu)?,
///     bias: Tensor::zeros(4, DType::F32, &Device::Cpu)?,
///     norm: None,
/// };
/// let grids = Tensor::ones((1, 2, 8, 8, 8), DType::F32, &Device::Cpu)?;
/// let fast = forward(&grids, &parameters, &settings)?;
/// assert_eq!(fast.dims(), [1, 4, 4, 4, 4]);
/// let slow = composed(&grids, &parameters, &settings)?;
/// assert_eq!((fast - slow)?.abs()?.max_all()?.to_scalar::<f32>()?, 0.0);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
///
/// # Errors
/// [`LearnError::Tensor`](crate::LearnError::Tensor) for shapes that do not fit,
/// [`LearnError::Settings`](crate::LearnError::Settings) for settings that make no sense.
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

/// The block composed of the operations one by one, on any device.
///
/// # Errors
/// As for [`forward`].
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

/// The block as one node on the processor, with the kernels of `level`.
///
/// # Errors
/// As for [`forward`].
pub fn fused(
    level: Level,
    input: &Tensor,
    parameters: &BlockParameters,
    settings: &BlockSettings,
) -> Result<Tensor> {
    Node::apply(level, input, parameters, settings)
}
