//! The content of the channels of a set of voxels, and how a training scales them.

use crate::voxels::samples::VoxelSet;
use anyhow::{Context, Result};
use protomer_common::page::{Part, Section, significant};
use protomer_learn::SampleSource;
use protomer_learn::scaling::{ChannelScaling, ScalingMode, Transform};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Maximum number of samples read, so that a page takes seconds.
const MOST_SAMPLES: usize = 200;

/// Moments and extremes of the values of a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Values {
    count: u64,
    sum: f64,
    sum_of_squares: f64,
    low: f64,
    high: f64,
}

/// The section, with the meanings of the channels; the samples read are evenly spaced over the set.
///
/// # Errors
/// Names the damaged file.
pub fn section(set: &VoxelSet, meanings: &BTreeMap<String, String>) -> Result<Section> {
    let step = set.reader().len().div_ceil(MOST_SAMPLES).max(1);
    let read: Vec<usize> = (0..set.reader().len()).step_by(step).collect();
    if read.is_empty() {
        let text = "The set has no samples.";
        return Ok(Section::new("Channels", vec![Part::Paragraph(text.into())]));
    }
    let of_sample = |sample: &usize| -> Result<Vec<Values>> {
        let stored = set
            .reader()
            .sample(*sample)
            .with_context(|| format!("sample {sample}"))?;
        Ok(stored
            .values
            .iter()
            .map(|values| Values::from_values(values))
            .collect())
    };
    let of_samples = read.par_iter().map(of_sample).collect::<Result<Vec<_>>>()?;
    let scaling = ChannelScaling::fit(set, &read, ScalingMode::Robust)?;
    let rows = set
        .channels()
        .iter()
        .zip(&scaling.transforms)
        .enumerate()
        .map(|(channel, (name, transform))| {
            let values = of_samples
                .iter()
                .filter_map(|sample| sample.get(channel))
                .copied()
                .reduce(Values::and);
            let meaning = meanings.get(name).map_or("–", String::as_str);
            let mut row = vec![name.clone(), meaning.to_owned()];
            row.extend(
                values.map_or_else(|| [const { String::new() }; 4], |values| values.shown()),
            );
            row.push(describe(transform));
            row
        });
    let columns = vec![
        "channel",
        "value",
        "lowest",
        "mean",
        "deviation",
        "highest",
        "as a training scales it",
    ];
    let selection = if step > 1 {
        format!("{} of the {} samples", read.len(), set.reader().len())
    } else {
        "all samples".into()
    };
    let note = format!(
        "Numbers are over the occupied voxels of {selection}. A training fits its scale to its own training part, so \
         it may differ in the last digits; 'train --scaling' lists the other scalings."
    );
    Ok(Section::new(
        "Channels",
        vec![
            Part::Table {
                columns,
                rows: rows.collect(),
            },
            Part::Paragraph(note),
        ],
    ))
}

fn describe(transform: &Transform) -> String {
    match transform {
        Transform::Unchanged => "unchanged".into(),
        Transform::Divided { scale } => format!("x / {}", significant(*scale, 4)),
        Transform::Arcsinh { scale } => {
            format!("arcsinh(x / {}), at most ±4", significant(*scale, 4))
        }
        Transform::BoxStandardised => "mean 0, deviation 1 in each box".into(),
    }
}

impl Values {
    fn from_values(values: &[f32]) -> Self {
        let nothing = Self {
            count: 0,
            sum: 0.0,
            sum_of_squares: 0.0,
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
        };
        values
            .iter()
            .map(|value| f64::from(*value))
            .fold(nothing, |so_far, value| {
                so_far.and(Self {
                    count: 1,
                    sum: value,
                    sum_of_squares: value * value,
                    low: value,
                    high: value,
                })
            })
    }

    fn and(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            sum: self.sum + other.sum,
            sum_of_squares: self.sum_of_squares + other.sum_of_squares,
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    /// Texts of the lowest value, the mean, the standard deviation and the highest value.
    fn shown(&self) -> [String; 4] {
        let count = self.count.max(1) as f64;
        let mean = self.sum / count;
        let deviation = (self.sum_of_squares / count - mean * mean).max(0.0).sqrt();
        [self.low, mean, deviation, self.high].map(|value| significant(value, 4))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_make_the_whole() {
        let parts = [
            Values::from_values(&[1.0, -2.0]),
            Values::from_values(&[4.0]),
        ];
        let whole = parts.into_iter().reduce(Values::and).unwrap();
        assert_eq!(whole, Values::from_values(&[1.0, -2.0, 4.0]));
        assert_eq!(whole.shown(), ["−2", "1", "2.449", "4"]);
    }
}
