//! Channels brought to comparable sizes.
//!
//! Potentials near charges exceed their usual size a hundredfold, and more than 98 % of a box is
//! empty. Dividing by a deviation over the whole box then leaves values so large that training
//! stalls. So statistics are taken over occupied voxels of the training split only, and large
//! values are compressed.

use crate::{Description, LearnError, Result, SampleSource, SparseGrid};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Scaled potentials stay within ± this.
const POTENTIAL_LIMIT: f64 = 4.0;
/// The largest value of the scale of Kyte and Doolittle, J. Mol. Biol. 157, 105 (1982).
const LARGEST_HYDROPATHY: f64 = 4.5;
/// Medians are over at most this many values, evenly spread over the samples, to bound memory.
pub const MOST_VALUES: usize = 1 << 22;

/// How channels are scaled.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ScalingMode {
    /// By what the channel means: `potential` compressed, `hydropathy` divided by 4.5, everything
    /// else as it is.
    #[default]
    Robust,
    /// As it is.
    Raw,
    /// Each channel of each sample to mean 0 and deviation 1 over the whole box, empty voxels
    /// included; a control, known to do harm.
    BoxStandardised,
}

/// What happens to a channel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Transform {
    /// y = x
    Unchanged,
    /// y = x / `scale`
    Divided {
        /// In the unit of the channel.
        scale: f64,
    },
    /// y = clamp(arcsinh(x / `scale`), -4, 4)
    Arcsinh {
        /// In the unit of the channel.
        scale: f64,
    },
    /// y = (x - mean) / deviation, both over the box of the sample
    BoxStandardised,
}

/// A transform for each channel of a set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChannelScaling {
    /// The mode it was fitted for.
    pub mode: ScalingMode,
    /// Names of the channels, in order.
    pub channels: Vec<String>,
    /// What happens to each.
    pub transforms: Vec<Transform>,
}

/// A sample left out, and why.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Quarantined {
    /// Its place in the source.
    pub sample: usize,
    /// Its name.
    pub name: String,
    /// What is wrong with it.
    pub reason: String,
}

/// The voxels of a sample, if they can be read, fit the source, and are finite.
///
/// # Errors
/// [`LearnError::Sample`] names the sample and what is wrong.
pub fn read_checked(source: &dyn SampleSource, sample: usize) -> Result<SparseGrid> {
    let name = || {
        source
            .descriptions()
            .get(sample)
            .map_or_else(|| sample.to_string(), |known| known.name.clone())
    };
    let named = |error: LearnError| match error {
        LearnError::Sample { reason, .. } => LearnError::Sample {
            name: name(),
            reason,
        },
        other => LearnError::Sample {
            name: name(),
            reason: other.to_string(),
        },
    };
    let grid = source.voxels(sample).map_err(named)?;
    grid.check().map_err(named)?;
    if grid.size != source.size() || grid.channels != source.channels().len() {
        let found = format!("{} channels of {}³ voxels", grid.channels, grid.size);
        let reason = format!(
            "{found}, but the set has {} of {}³",
            source.channels().len(),
            source.size()
        );
        return Err(LearnError::Sample {
            name: name(),
            reason,
        });
    }
    Ok(grid)
}

/// Splits `samples` into those that can be read and those that cannot, with the reason.
pub fn screen(source: &dyn SampleSource, samples: &[usize]) -> (Vec<usize>, Vec<Quarantined>) {
    let check = |sample: &usize| {
        read_checked(source, *sample)
            .err()
            .map(|error| quarantine(source, *sample, &error))
    };
    let verdicts: Vec<Option<Quarantined>> = samples.par_iter().map(check).collect();
    let good = samples
        .iter()
        .zip(&verdicts)
        .filter_map(|(sample, bad)| bad.is_none().then_some(*sample))
        .collect();
    (good, verdicts.into_iter().flatten().collect())
}

fn quarantine(source: &dyn SampleSource, sample: usize, error: &LearnError) -> Quarantined {
    let known: Option<&Description> = source.descriptions().get(sample);
    let name = known.map_or_else(String::new, |known| known.name.clone());
    let reason = match error {
        LearnError::Sample { reason, .. } => reason.clone(),
        other => other.to_string(),
    };
    Quarantined {
        sample,
        name,
        reason,
    }
}

impl ChannelScaling {
    /// Scaling for the mode, from the occupied voxels of the training samples, of channels of the
    /// surface those of the surface; samples that cannot be read are passed over ([`screen`] lists
    /// them).
    ///
    /// The scale of the potential is its median absolute deviation, s = median |φ - median φ|; if
    /// that is zero, the mean of |φ|; if that is zero too, 1.
    ///
    /// # Errors
    /// [`LearnError::Settings`] if no training sample can be read.
    pub fn fit(source: &dyn SampleSource, training: &[usize], mode: ScalingMode) -> Result<Self> {
        let channels = source.channels().to_vec();
        let transform = |(channel, name): (usize, &String)| {
            Ok(match (mode, name.as_str()) {
                (ScalingMode::BoxStandardised, _) => Transform::BoxStandardised,
                (ScalingMode::Robust, "potential") => Transform::Arcsinh {
                    scale: robust_scale(occupied(source, training, channel)?),
                },
                (ScalingMode::Robust, "hydropathy") => Transform::Divided {
                    scale: LARGEST_HYDROPATHY,
                },
                _ => Transform::Unchanged,
            })
        };
        let transforms = channels
            .iter()
            .enumerate()
            .map(transform)
            .collect::<Result<_>>()?;
        Ok(Self {
            mode,
            channels,
            transforms,
        })
    }

    /// Scales the values in place and returns the value of empty voxels in each channel, zero in
    /// all modes but [`ScalingMode::BoxStandardised`].
    ///
    /// # Errors
    /// [`LearnError::Sample`] if the grid is damaged or has other channels.
    pub fn apply(&self, grid: &mut SparseGrid) -> Result<Vec<f32>> {
        grid.check()?;
        if grid.channels != self.transforms.len() {
            let reason = format!(
                "{} channels, but the scaling is for {}",
                grid.channels,
                self.transforms.len()
            );
            return Err(LearnError::Sample {
                name: "voxels".into(),
                reason,
            });
        }
        let mut empty = vec![0.0; grid.channels];
        let (count, voxels) = (grid.index.len().max(1), grid.size.pow(3));
        for ((values, transform), empty) in grid
            .values
            .chunks_mut(count)
            .zip(&self.transforms)
            .zip(&mut empty)
        {
            *empty = transform.apply(values, voxels);
        }
        Ok(empty)
    }

    /// Scales the grid and writes the channels at these places as (channel, z, y, x) over `dense`.
    ///
    /// # Errors
    /// As [`ChannelScaling::apply`], and if `dense` is no room for the channels.
    pub fn write_dense(
        &self,
        mut grid: SparseGrid,
        channels: &[usize],
        dense: &mut [f32],
    ) -> Result<()> {
        let empty = self.apply(&mut grid)?;
        let voxels = grid.size.pow(3);
        if dense.len() != channels.len() * voxels {
            let reason = format!(
                "{} numbers of room for {} x {voxels}",
                dense.len(),
                channels.len()
            );
            return Err(LearnError::Sample {
                name: "voxels".into(),
                reason,
            });
        }
        for (channel, dense) in channels.iter().zip(dense.chunks_exact_mut(voxels.max(1))) {
            let Some(empty) = empty.get(*channel) else {
                let reason = format!("there is no channel {channel} of {}", grid.channels);
                return Err(LearnError::Sample {
                    name: "voxels".into(),
                    reason,
                });
            };
            dense.fill(*empty);
            let values = &grid.values[channel * grid.index.len()..(channel + 1) * grid.index.len()];
            for (voxel, value) in grid.index.iter().zip(values) {
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
            Self::Divided { scale } => values
                .iter_mut()
                .for_each(|value| *value = (f64::from(*value) / scale) as f32),
            Self::Arcsinh { scale } => {
                let compress = |value: f32| {
                    (f64::from(value) / scale)
                        .asinh()
                        .clamp(-POTENTIAL_LIMIT, POTENTIAL_LIMIT)
                };
                values
                    .iter_mut()
                    .for_each(|value| *value = compress(*value) as f32);
            }
            Self::BoxStandardised => {
                let moment = |power| {
                    values
                        .iter()
                        .map(|value| f64::from(*value).powi(power))
                        .sum::<f64>()
                };
                let mean = moment(1) / voxels.max(1) as f64;
                let variance = moment(2) / voxels.max(1) as f64 - mean * mean;
                let deviation = if variance > 0.0 { variance.sqrt() } else { 1.0 };
                values
                    .iter_mut()
                    .for_each(|value| *value = ((f64::from(*value) - mean) / deviation) as f32);
                return (-mean / deviation) as f32;
            }
        }
        0.0
    }
}

/// Values of a channel where it means something in the training samples, thinned evenly if they are
/// many.
fn occupied(source: &dyn SampleSource, training: &[usize], channel: usize) -> Result<Vec<f32>> {
    let most = (MOST_VALUES / training.len().max(1)).max(1);
    let read = |sample: &usize| {
        let grid = read_checked(source, *sample).ok()?;
        let values: Vec<&[f32]> = grid.values.chunks(grid.index.len().max(1)).collect();
        let values = where_defined(source.channels(), &values, channel);
        Some(
            values
                .iter()
                .copied()
                .step_by(values.len().div_ceil(most).max(1))
                .collect::<Vec<f32>>(),
        )
    };
    let samples: Vec<Vec<f32>> = training.par_iter().filter_map(read).collect();
    if samples.is_empty() {
        let reason = format!(
            "none of the {} training samples can be read, so nothing can be scaled",
            training.len()
        );
        return Err(LearnError::Settings(reason));
    }
    Ok(samples.concat())
}

/// The values of a channel in the occupied voxels where it means something. With the channel
/// `solid`, voxels inside are occupied as well, and channels of the surface are 0 there: left are
/// the voxels that `shape` marks or, without it, those that are not 0.
pub fn where_defined(channels: &[String], values: &[&[f32]], channel: usize) -> Vec<f32> {
    let place = |name: &str| channels.iter().position(|channel| channel == name);
    let own = values.get(channel).copied().unwrap_or_default();
    let of_surface =
        place("solid").is_some_and(|solid| solid != channel) && place("shape") != Some(channel);
    let marks = match place("shape").and_then(|shape| values.get(shape)) {
        _ if !of_surface => return own.to_vec(),
        Some(shape) => shape,
        None => own,
    };
    own.iter()
        .zip(marks)
        .filter(|(_, mark)| **mark != 0.0)
        .map(|(value, _)| *value)
        .collect()
}

fn robust_scale(mut values: Vec<f32>) -> f64 {
    let mean_size = values
        .iter()
        .map(|value| f64::from(value.abs()))
        .sum::<f64>()
        / values.len().max(1) as f64;
    let middle = median(&mut values);
    values
        .iter_mut()
        .for_each(|value| *value = (*value - middle).abs());
    let deviation = f64::from(median(&mut values));
    [deviation, mean_size]
        .into_iter()
        .find(|scale| *scale > 0.0)
        .unwrap_or(1.0)
}

/// The median, the upper of the two in the middle for an even count; zero for none. The values are
/// left in another order.
pub fn median(values: &mut [f32]) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::InMemory;

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
