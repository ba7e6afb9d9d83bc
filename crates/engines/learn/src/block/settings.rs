//! What a block does.

use crate::Result;
use crate::error::refuse;
use serde::{Deserialize, Serialize};

/// The most channels of a block: with kernels of edge 5, a convolution between two such blocks has 0.5 GB of weights.
const MOST_CHANNELS: usize = 1024;

/// Settings of a block: convolution, group normalisation if wanted, ReLU, pooling if wanted.
///
/// ```
/// use protomer_learn::BlockSettings;
///
/// let block = BlockSettings { width: 16, kernel: 3, groups: Some(4), pool: true };
/// assert!(block.check().is_ok());
/// assert!(BlockSettings { groups: Some(5), ..block }.check().is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BlockSettings {
    /// Number of output channels.
    pub width: usize,
    /// Edge of the convolution kernel, voxels: 1, 3 or 5.
    pub kernel: usize,
    /// Groups of the group normalisation, which must divide the width. `None`: no normalisation.
    #[serde(default)]
    pub groups: Option<usize>,
    /// Whether the maximum of every 2 x 2 x 2 window is taken at the end.
    #[serde(default)]
    pub pool: bool,
}

impl BlockSettings {
    /// Blocks of these widths, each with its own kernel or one kernel for all, and with
    /// pooling. 0 groups: no normalisation.
    ///
    /// ```
    /// use protomer_learn::BlockSettings;
    ///
    /// let blocks = BlockSettings::chain(&[8, 16], &[5, 3], 4)?;
    /// assert_eq!((blocks[0].kernel, blocks[1].width), (5, 16));
    /// assert!(BlockSettings::chain(&[8, 16, 32], &[5, 3], 4).is_err());
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) if there are not as many kernels as
    /// widths (or one for all), or a block makes no sense.
    pub fn chain(widths: &[usize], kernels: &[usize], groups: usize) -> Result<Vec<Self>> {
        if kernels.len() != 1 && kernels.len() != widths.len() {
            return refuse(format!(
                "{} kernels for {} blocks; give one for all, or one for each",
                kernels.len(),
                widths.len()
            ));
        }
        let mut blocks = Vec::with_capacity(widths.len());
        for (width, kernel) in widths.iter().zip(kernels.iter().cycle()) {
            let block = Self {
                width: *width,
                kernel: *kernel,
                groups: (groups > 0).then_some(groups),
                pool: true,
            };
            block.check()?;
            blocks.push(block);
        }
        Ok(blocks)
    }

    /// Checks that the settings make sense.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) says what does not.
    pub fn check(&self) -> Result<()> {
        let Self { width, kernel, .. } = *self;
        if !(1..=MOST_CHANNELS).contains(&width) {
            return refuse(format!(
                "a block of width {width}: give it 1 to {MOST_CHANNELS} channels"
            ));
        }
        if !matches!(kernel, 1 | 3 | 5) {
            return refuse(format!("a kernel of edge {kernel}: take 1, 3 or 5"));
        }
        match self.groups {
            Some(groups) if groups == 0 || width % groups != 0 => refuse(format!(
                "{width} channels do not divide into {groups} groups: take groups that divide \
                 every width, or none"
            )),
            _ => Ok(()),
        }
    }
}
