//! One block of the network: convolution, group normalisation if wanted, ReLU, pooling if wanted.

use crate::operations::{convolution3d, group_norm, max_pool3d};
use crate::{LearnError, Result};
use candle_core::Tensor;
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
        let Self { width, kernel, groups, .. } = *self;
        if width == 0 {
            return Err(LearnError::Settings("a block of width 0: give it at least one channel".into()));
        }
        if !matches!(kernel, 1 | 3 | 5) {
            return Err(LearnError::Settings(format!("a kernel of edge {kernel}: take 1, 3 or 5")));
        }
        if let Some(groups) = groups
            && (groups == 0 || width % groups != 0)
        {
            return Err(LearnError::Settings(format!("{width} channels do not divide into {groups} groups")));
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

/// The block composed of the operations one by one, on any device: (B, C, D, H, W) to (B, O, D', H', W').
///
/// # Errors
/// [`LearnError::Tensor`] for shapes that do not fit, [`LearnError::Settings`] for settings that make no sense.
pub fn composed(input: &Tensor, parameters: &BlockParameters, settings: &BlockSettings) -> Result<Tensor> {
    let mut grid = convolution3d(input, &parameters.weight, &parameters.bias)?;
    if let (Some(groups), Some((weight, bias))) = (settings.groups, &parameters.norm) {
        grid = group_norm(&grid, groups, weight, bias)?;
    }
    grid = grid.relu()?;
    if settings.pool { max_pool3d(&grid) } else { Ok(grid) }
}
