//! Channels brought to comparable sizes.
//!
//! Potentials near charges exceed their usual size a hundredfold, and more than 98 % of a box is
//! empty. Division by a deviation over the whole box then leaves values so large that training
//! stalls. So statistics are taken over occupied voxels of the training part only, and large values
//! are compressed.

mod screening;
mod statistics;

pub use screening::{Quarantined, read_checked, screen};
pub use statistics::{MOST_VALUES, where_defined};

use crate::error::damaged;
use crate::{Result, SampleSource, SparseGrid};
use serde::{Deserialize, Serialize};
use statistics::{occupied, robust_scale};

/// Largest absolute value of a scaled potential.
const POTENTIAL_LIMIT: f64 = 4.0;
/// The largest value of the scale of Kyte and Doolittle, J. Mol. Biol. 157, 105 (1982).
const LARGEST_HYDROPATHY: f64 = 4.5;

protomer_kernel::choices! {
    /// Mode of the scaling of channels.
    pub enum ScalingMode, default Robust, files "snake_case" {
        /// Potential: arcsinh of the value over a robust scale of the occupied voxels; hydropathy:
        /// divided by 4.5.
        Robust = "robust",
        /// No scaling.
        Raw = "raw",
        /// Each sample standardised to mean 0 and deviation 1 over the box; a harmful control.
        BoxStandardised = "box-standardised",
    }
}

/// Transform of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Transform {
    /// y = x
    Unchanged,
    /// y = x / `scale`
    Divided {
        /// Scale in the unit of the channel.
        scale: f64,
    },
    /// y = clamp(arcsinh(x / `scale`), -4, 4)
    Arcsinh {
        /// Scale in the unit of the channel.
        scale: f64,
    },
    /// y = (x - mean) / deviation, both over the box of the sample
    BoxStandardised,
}

/// A transform for each channel of a set.
///
/// ```
/// use protomer_learn::controls::{Control, Variant};
/// use protomer_learn::scaling::{ChannelScaling, ScalingMode, Transform};
/// use protomer_learn::SampleSource;
///
/// let set = Control::Charge.samples(Variant::Usual, 8, 16, 1);
/// let training = [0, 1, 2, 3, 4, 5];
/// let scaling = ChannelScaling::fit(&set, &training, ScalingMode::Robust)?;
/// assert_eq!(scaling.channels, ["shape", "potential", "hydropathy"]);
/// assert_eq!(scaling.transforms[0], Transform::Unchanged);
///
/// let mut grid = set.voxels(7)?;
/// scaling.apply(&mut grid)?;
/// assert!(grid.values.iter().all(|value| value.abs() <= 4.0));
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChannelScaling {
    /// The mode for which the scaling was fitted.
    pub mode: ScalingMode,
    /// Names of the channels, in order.
    pub channels: Vec<String>,
    /// Transform of each channel.
    pub transforms: Vec<Transform>,
}

/// Beginning of the names of the channels of the second body of an interface.
pub(super) const PARTNER: &str = "partner_";

impl ChannelScaling {
    /// Fits a scaling to the training samples. Samples that cannot be read are passed over;
    /// [`screen`] lists them.
    ///
    /// The scale of the potential is its median absolute deviation over the voxels where it is
    /// defined, s = median |φ - median φ|; if that is zero, the mean of |φ|; if that is zero too,
    /// 1.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) if no training sample can be read.
    pub fn fit(source: &dyn SampleSource, training: &[usize], mode: ScalingMode) -> Result<Self> {
        let channels = source.channels().to_vec();
        let mut transforms = Vec::with_capacity(channels.len());
        for (channel, name) in channels.iter().enumerate() {
            transforms.push(match (mode, name.strip_prefix(PARTNER).unwrap_or(name)) {
                (ScalingMode::BoxStandardised, _) => Transform::BoxStandardised,
                (ScalingMode::Robust, "potential") => Transform::Arcsinh {
                    scale: robust_scale(occupied(source, training, channel)?),
                },
                (ScalingMode::Robust, "hydropathy") => Transform::Divided {
                    scale: LARGEST_HYDROPATHY,
                },
                _ => Transform::Unchanged,
            });
        }
        Ok(Self {
            mode,
            channels,
            transforms,
        })
    }

    /// Scales the values in place. Returns what an empty voxel becomes in each channel: zero in all
    /// modes but [`ScalingMode::BoxStandardised`].
    ///
    /// # Errors
    /// [`LearnError::Sample`](crate::LearnError::Sample) if the grid is damaged or has other
    /// channels.
    pub fn apply(&self, grid: &mut SparseGrid) -> Result<Vec<f32>> {
        grid.check()?;
        if grid.channels != self.transforms.len() {
            return Err(damaged(format!(
                "{} channels, but the scaling is for {}",
                grid.channels,
                self.transforms.len()
            )));
        }
        let (count, voxels) = (grid.index.len(), grid.size.pow(3));
        let mut empty = Vec::with_capacity(grid.channels);
        for (channel, transform) in self.transforms.iter().enumerate() {
            let values = &mut grid.values[channel * count..(channel + 1) * count];
            empty.push(transform.apply(values, voxels));
        }
        Ok(empty)
    }

    /// Scales the grid and overwrites `dense`, (channel, z, y, x), with the channels at these
    /// places.
    ///
    /// # Errors
    /// As for [`ChannelScaling::apply`], and if `dense` has not the size of the channels.
    pub(crate) fn write_dense(
        &self,
        mut grid: SparseGrid,
        channels: &[usize],
        dense: &mut [f32],
    ) -> Result<()> {
        let empty = self.apply(&mut grid)?;
        let voxels = grid.size.pow(3);
        if dense.len() != channels.len() * voxels {
            return Err(damaged(format!(
                "{} channels of {voxels} voxels do not fit into {} numbers",
                channels.len(),
                dense.len()
            )));
        }
        for (channel, dense) in channels.iter().zip(dense.chunks_exact_mut(voxels.max(1))) {
            let Some(empty) = empty.get(*channel) else {
                let channels = grid.channels;
                return Err(damaged(format!(
                    "there is no channel {channel} of {channels}"
                )));
            };
            dense.fill(*empty);
            for (voxel, value) in grid.index.iter().zip(grid.of_channel(*channel)) {
                dense[*voxel as usize] = *value;
            }
        }
        Ok(())
    }
}

impl Transform {
    /// Transforms the occupied voxels of a box and returns what empty ones become.
    fn apply(&self, values: &mut [f32], voxels: usize) -> f32 {
        match *self {
            Self::Unchanged => {}
            Self::Divided { scale } => {
                for value in values {
                    *value = (f64::from(*value) / scale) as f32;
                }
            }
            Self::Arcsinh { scale } => {
                for value in values {
                    let compressed = (f64::from(*value) / scale).asinh();
                    *value = compressed.clamp(-POTENTIAL_LIMIT, POTENTIAL_LIMIT) as f32;
                }
            }
            Self::BoxStandardised => return standardise(values, voxels),
        }
        0.0
    }
}

/// Brings a channel to mean 0 and deviation 1 over the box, whose other voxels are 0. Returns what
/// these become.
fn standardise(values: &mut [f32], voxels: usize) -> f32 {
    let (mut sum, mut sum_of_squares) = (0.0, 0.0);
    for value in values.iter() {
        sum += f64::from(*value);
        sum_of_squares += f64::from(*value).powi(2);
    }
    let mean = sum / voxels.max(1) as f64;
    let variance = sum_of_squares / voxels.max(1) as f64 - mean * mean;
    let deviation = if variance > 0.0 { variance.sqrt() } else { 1.0 };
    for value in values {
        *value = ((f64::from(*value) - mean) / deviation) as f32;
    }
    (-mean / deviation) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Description, InMemory};

    fn source(grids: Vec<SparseGrid>) -> InMemory {
        let named = |name: usize| Description {
            name: format!("s{name}"),
            ..Description::default()
        };
        let channels = ["shape", "potential", "hydropathy"]
            .map(String::from)
            .to_vec();
        InMemory {
            size: 4,
            channels,
            descriptions: (0..grids.len()).map(named).collect(),
            grids,
        }
    }

    fn grid(potential: &[f32]) -> SparseGrid {
        let count = potential.len();
        let values = [vec![1.0; count], potential.to_vec(), vec![-4.5; count]].concat();
        SparseGrid {
            size: 4,
            channels: 3,
            index: (0..count as u32).map(|place| 3 * place).collect(),
            values,
        }
    }

    #[test]
    fn the_scale_is_the_median_deviation_of_occupied_training_voxels() {
        // The third sample is no training sample. The median of -3 -1 0 2 9 is 0; deviations 0 1 2
        // 3 9 have the median 2.
        let source = source(vec![
            grid(&[-3.0, 2.0, 0.0]),
            grid(&[9.0, -1.0]),
            grid(&[1e6; 9]),
        ]);
        let scaling = ChannelScaling::fit(&source, &[0, 1], ScalingMode::Robust).unwrap();
        let expected = [
            Transform::Unchanged,
            Transform::Arcsinh { scale: 2.0 },
            Transform::Divided { scale: 4.5 },
        ];
        assert_eq!(scaling.transforms, expected);
        let mut scaled = grid(&[3.0, -1e5]);
        assert_eq!(scaling.apply(&mut scaled).unwrap(), [0.0; 3]);
        // arcsinh(3/2) = ln(3/2 + sqrt(13)/2)
        let expected = [
            1.0,
            1.0,
            (1.5_f32 + 13_f32.sqrt() / 2.0).ln(),
            -4.0,
            -1.0,
            -1.0,
        ];
        for (value, expected) in scaled.values.iter().zip(expected) {
            assert!((value - expected).abs() < 1e-6, "{value} {expected}");
        }
    }

    #[test]
    fn voxels_inside_have_no_potential() {
        let names = |list: &[&str]| {
            list.iter()
                .map(|name| (*name).to_owned())
                .collect::<Vec<String>>()
        };
        let (shape, solid, potential) = ([1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, -2.0, 0.0]);
        let all = names(&["shape", "solid", "potential"]);
        let values: [&[f32]; 3] = [&shape, &solid, &potential];
        assert_eq!(where_defined(&all, &values, 2), [0.0, -2.0]);
        assert_eq!(where_defined(&all, &values, 0), shape);
        assert_eq!(where_defined(&all, &values, 1), solid);
        assert_eq!(
            where_defined(&names(&["solid", "potential"]), &values[1..], 1),
            [-2.0]
        );
        assert_eq!(
            where_defined(&names(&["shape", "potential"]), &[&shape, &potential], 1),
            potential
        );
        // In an interface each body has a shell of its own.
        let pair = names(&["shape", "potential", "partner_shape", "partner_potential"]);
        let values: [&[f32]; 4] = [&shape, &potential, &solid, &potential];
        assert_eq!(where_defined(&pair, &values, 1), [0.0, -2.0]);
        assert_eq!(where_defined(&pair, &values, 3), [-2.0, 0.0]);
    }

    #[test]
    fn a_potential_without_spread_is_not_divided_by_zero() {
        assert_eq!(robust_scale(vec![0.0; 5]), 1.0);
        assert_eq!(robust_scale(vec![3.0; 5]), 3.0);
        assert_eq!(robust_scale(Vec::new()), 1.0);
    }

    #[test]
    fn a_standardised_box_has_mean_zero_and_deviation_one() {
        let source = source(vec![grid(&[3.0, 1.0, 8.0])]);
        let scaling = ChannelScaling::fit(&source, &[0], ScalingMode::BoxStandardised).unwrap();
        let mut dense = vec![9.0; 128];
        scaling
            .write_dense(grid(&[3.0, 1.0, 8.0]), &[1, 0], &mut dense)
            .unwrap();
        for channel in dense.chunks(64) {
            let mean = channel.iter().sum::<f32>() / 64.0;
            let variance = channel
                .iter()
                .map(|value| (value - mean).powi(2))
                .sum::<f32>()
                / 64.0;
            assert!(
                mean.abs() < 1e-5 && (variance - 1.0).abs() < 1e-5,
                "{mean} {variance}"
            );
        }
    }

    #[test]
    fn raw_means_as_written_by_the_grid_itself() {
        let source = source(vec![grid(&[3.0, 1.0, 8.0])]);
        let scaling = ChannelScaling::fit(&source, &[0], ScalingMode::Raw).unwrap();
        let (mut dense, mut expected) = (vec![9.0; 192], vec![9.0; 192]);
        scaling
            .write_dense(grid(&[3.0, 1.0, 8.0]), &[0, 1, 2], &mut dense)
            .unwrap();
        grid(&[3.0, 1.0, 8.0]).write_dense(&mut expected).unwrap();
        assert_eq!(dense, expected);
        assert!(
            scaling
                .write_dense(grid(&[1.0]), &[3], &mut [0.0; 64])
                .is_err()
        );
        assert!(
            scaling
                .write_dense(grid(&[1.0]), &[0], &mut [0.0; 65])
                .is_err()
        );
    }

    #[test]
    fn unusable_samples_are_listed_with_the_reason() {
        let other_size = SparseGrid {
            size: 5,
            channels: 3,
            ..SparseGrid::default()
        };
        let source = source(vec![grid(&[1.0, f32::NAN]), grid(&[1.0]), other_size]);
        let (good, bad) = screen(&source, &[0, 1, 2, 3]);
        assert_eq!(good, [1]);
        let reasons: Vec<_> = bad
            .iter()
            .map(|bad| (bad.sample, bad.name.as_str(), bad.reason.as_str()))
            .collect();
        assert_eq!(reasons[0], (0, "s0", "channel 1 holds NaN"));
        assert_eq!(
            reasons[1],
            (
                1 + 1,
                "s2",
                "3 channels of 5³ voxels, but the set has 3 of 4³"
            )
        );
        assert_eq!(reasons[2].2, "there is no such sample");
        assert!(ChannelScaling::fit(&source, &[0, 2], ScalingMode::Robust).is_err());
    }

    #[test]
    fn a_scaling_survives_json() {
        let source = source(vec![grid(&[3.0, 1.1, 8.0])]);
        let scaling = ChannelScaling::fit(&source, &[0], ScalingMode::Robust).unwrap();
        let text = serde_json::to_string(&scaling).unwrap();
        assert_eq!(
            serde_json::from_str::<ChannelScaling>(&text).unwrap(),
            scaling
        );
    }
}
