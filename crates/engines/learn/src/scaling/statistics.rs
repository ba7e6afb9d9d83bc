//! What is typical for the values of a channel.

use super::PARTNER;
use super::screening::read_checked;
use crate::error::refuse;
use crate::{Result, SampleSource};
use protomer_kernel::statistics::median;
use rayon::prelude::*;

/// Largest number of values for a median, evenly spread over the samples, to bound memory.
pub const MOST_VALUES: usize = 1 << 22;

/// Values of a channel where it is defined in the training samples, thinned evenly if they are
/// many.
pub(super) fn occupied(
    source: &dyn SampleSource,
    training: &[usize],
    channel: usize,
) -> Result<Vec<f32>> {
    let most = (MOST_VALUES / training.len().max(1)).max(1);
    let samples: Vec<Vec<f32>> = training
        .par_iter()
        .filter_map(|sample| of_sample(source, *sample, channel, most))
        .collect();
    if samples.is_empty() {
        return refuse(format!(
            "none of the {} training samples can be read, so nothing can be scaled",
            training.len()
        ));
    }
    Ok(samples.concat())
}

/// At most `most` values of a sample; `None` if it cannot be read.
fn of_sample(
    source: &dyn SampleSource,
    sample: usize,
    channel: usize,
    most: usize,
) -> Option<Vec<f32>> {
    let grid = read_checked(source, sample).ok()?;
    let values: Vec<&[f32]> = grid.values.chunks(grid.index.len().max(1)).collect();
    let values = where_defined(source.channels(), &values, channel);
    let step = values.len().div_ceil(most).max(1);
    Some(values.into_iter().step_by(step).collect())
}

/// The values of a channel in the occupied voxels where it is defined.
///
/// With the channel `solid`, voxels inside are occupied as well, and channels of the surface are 0
/// there; in an interface, voxels of the other body are occupied too. The voxels that the `shape` of the
/// body marks are then left or, without `shape`, those that are not 0.
///
/// ```
/// use protomer_learn::scaling::where_defined;
/// let channels = ["shape", "solid", "potential"].map(str::to_owned);
/// let (shape, solid, potential) = ([1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.5, 0.0, 0.0]);
/// assert_eq!(where_defined(&channels, &[&shape, &solid, &potential], 2), [0.5, 0.0]);
/// ```
pub fn where_defined(channels: &[String], values: &[&[f32]], channel: usize) -> Vec<f32> {
    let place = |name: &str| channels.iter().position(|channel| channel == name);
    let is_of_partner = |name: &String| name.starts_with(PARTNER);
    let shape = match channels.get(channel).is_some_and(is_of_partner) {
        true => place(&format!("{PARTNER}shape")),
        false => place("shape"),
    };
    let solid = place("solid");
    let channel_values = values.get(channel).copied().unwrap_or_default();
    // Without `solid` and a partner, all occupied voxels are of the one shell.
    let is_one_shell = solid.is_none() && !channels.iter().any(is_of_partner);
    let everywhere = is_one_shell || solid == Some(channel) || shape == Some(channel);
    if everywhere {
        return channel_values.to_vec();
    }
    let marks = shape
        .and_then(|shape| values.get(shape))
        .unwrap_or(&channel_values);
    let mut defined = Vec::new();
    for (value, mark) in channel_values.iter().zip(*marks) {
        if *mark != 0.0 {
            defined.push(*value);
        }
    }
    defined
}

/// The median absolute deviation; if that is zero, the mean size; if that is zero too, 1.
pub(super) fn robust_scale(mut values: Vec<f32>) -> f64 {
    let sizes: f64 = values.iter().map(|value| f64::from(value.abs())).sum();
    let mean_size = sizes / values.len().max(1) as f64;
    let middle = median(&mut values, f32::total_cmp).unwrap_or(0.0);
    for value in &mut values {
        *value = (*value - middle).abs();
    }
    let deviation = f64::from(median(&mut values, f32::total_cmp).unwrap_or(0.0));
    if deviation > 0.0 {
        deviation
    } else if mean_size > 0.0 {
        mean_size
    } else {
        1.0
    }
}
