//! Statistics of the channels over the occupied voxels of the training part, for users who scale
//! the channels themselves.
//!
//! The training part comes from a split by cluster with the set's seed and the default shares,
//! so it excludes the validation and test parts. `protomer train` splits by its own seed and
//! target, and uses the statistics of its own training part.

use super::row::Row;
use super::settings::VoxelizeSettings;
use anyhow::Result;
use protomer_field::voxels::{Channel, Voxels};
use protomer_io::zarr::{of_stored_bits, stored_bits};
use protomer_kernel::setting::Choices;
use protomer_learn::scaling::where_defined;
use protomer_learn::split::{Fractions, Ranks, Split};
use serde::Serialize;
use std::collections::BTreeMap;

/// The attribute `statistics` of a set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Statistics {
    /// Samples that the statistics cover: `training part`, or `all samples` if there are too few
    /// clusters to split.
    pub over: &'static str,
    /// Indices of these samples, from 0.
    pub samples: Vec<usize>,
    /// Seed of the split.
    pub split_seed: u64,
    /// Statistics of the channels by their names, each in the unit of the channel.
    pub channels: BTreeMap<String, ChannelStatistics>,
}

/// Statistics of a channel over occupied voxels (for surface channels: over surface voxels), in
/// its unit; null without voxels.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct ChannelStatistics {
    /// Occupied voxels.
    pub voxels: u64,
    /// Mean.
    pub mean: Option<f64>,
    /// Root of the mean square deviation from the mean.
    pub standard_deviation: Option<f64>,
    /// Median, the upper of the two in the middle.
    pub median: Option<f64>,
    /// Median of the distances from the median.
    pub median_deviation: Option<f64>,
    /// Smallest value.
    pub minimum: Option<f64>,
    /// Largest value.
    pub maximum: Option<f64>,
}

/// Accumulates statistics, one sample at a time.
pub struct Gathering {
    over: &'static str,
    /// Indices of the samples that the statistics cover, ascending.
    samples: Vec<usize>,
    split_seed: u64,
    channels: Vec<(String, Gathered)>,
}

#[derive(Default)]
struct Gathered {
    voxels: u64,
    /// Sum of squared differences from the first value, which avoids cancellation where values
    /// differ little.
    squares: f64,
    first: f64,
    shifted: f64,
    range: Option<(f32, f32)>,
    counts: Counts,
}

/// Number of occurrences of each value, by its bits in half precision: in pages of 256, since
/// values lie close together.
struct Counts(Vec<Vec<u64>>);

impl Default for Counts {
    fn default() -> Self {
        Self(vec![Vec::new(); 256])
    }
}

impl Counts {
    fn add(&mut self, bits: u16) {
        // The high byte is the page: sign, exponent and two bits, which values of a channel share.
        let [page, place] = bits.to_be_bytes().map(usize::from);
        let page = &mut self.0[page];
        // Most pages are never met and take no memory.
        if page.is_empty() {
            page.resize(256, 0);
        }
        page[place] += 1;
    }

    /// The values that occur, with their counts.
    fn values(&self) -> Vec<(f32, u64)> {
        let mut values = Vec::new();
        for (high, page) in (0..=u8::MAX).zip(&self.0) {
            for (low, count) in (0..=u8::MAX).zip(page).filter(|(_, count)| **count > 0) {
                values.push((of_stored_bits(u16::from_be_bytes([high, low])), *count));
            }
        }
        values
    }
}

impl Gathering {
    /// Starts the statistics of a set with so many samples; the function returns the manifest entry
    /// of each.
    ///
    /// # Errors
    /// Those of the function.
    pub fn new(
        settings: &VoxelizeSettings,
        count: usize,
        row: impl Fn(usize) -> Result<Row>,
    ) -> Result<Self> {
        let (over, samples) = match training_part(settings.seed, count, row)? {
            Some(samples) => ("training part", samples),
            None => ("all samples", (0..count).collect()),
        };
        let empty = |channel: &Channel| (channel.name().to_owned(), Gathered::default());
        let channels = settings.channels.iter().map(empty).collect();
        Ok(Self {
            over,
            samples,
            split_seed: settings.seed,
            channels,
        })
    }

    /// Adds a sample, if it belongs to the training part.
    pub fn add(&mut self, sample: usize, voxels: &Voxels) {
        // Only the training part: statistics of the others would leak into it.
        if self.samples.binary_search(&sample).is_err() {
            return;
        }
        let names: Vec<String> = self.channels.iter().map(|(name, _)| name.clone()).collect();
        let values: Vec<&[f32]> = voxels.values.iter().map(Vec::as_slice).collect();
        for (channel, (_, gathered)) in self.channels.iter_mut().enumerate() {
            gathered.add(&where_defined(&names, &values, channel));
        }
    }

    /// The statistics.
    pub fn finish(self) -> Statistics {
        let channels = self
            .channels
            .into_iter()
            .map(|(name, gathered)| (name, gathered.finish()))
            .collect();
        Statistics {
            over: self.over,
            samples: self.samples,
            split_seed: self.split_seed,
            channels,
        }
    }
}

/// The training part of a split by cluster; `None` if there are too few clusters.
fn training_part(
    seed: u64,
    count: usize,
    row: impl Fn(usize) -> Result<Row>,
) -> Result<Option<Vec<usize>>> {
    let (mut labels, mut clusters) = (Ranks::default(), Ranks::default());
    for sample in 0..count {
        let row = row(sample)?;
        labels.push(row.label);
        clusters.push(row.cluster);
    }
    let (labels, clusters) = (labels.finish(), clusters.finish());
    // By ranks, so that names of clusters need not be in memory.
    let split = Split::by_ranks(&labels, &clusters, seed, Fractions::default());
    let training = split.ok().map(|split| split.training);
    Ok(training.filter(|training| !training.is_empty()))
}

impl Gathered {
    fn add(&mut self, values: &[f32]) {
        // Rounded as they are stored: the statistics are those of what a reader finds.
        for bits in values.iter().map(|value| stored_bits(*value)) {
            let value = of_stored_bits(bits);
            let (low, high) = self.range.unwrap_or((value, value));
            self.range = Some((low.min(value), high.max(value)));
            if self.voxels == 0 {
                // The first value as the shift: variance from
                // sums of squares would cancel otherwise.
                self.first = f64::from(value);
            }
            let difference = f64::from(value) - self.first;
            self.shifted += difference;
            self.squares += difference * difference;
            self.voxels += 1;
            self.counts.add(bits);
        }
    }

    fn finish(self) -> ChannelStatistics {
        let Some((minimum, maximum)) = self.range else {
            return ChannelStatistics::default();
        };
        let count = self.voxels as f64;
        let shift = self.shifted / count;
        // var = <(x - x₀)²> - <x - x₀>².
        let variance = (self.squares / count - shift * shift).max(0.0);
        let mut counted = self.counts.values();
        let middle = median(&mut counted);
        // The same counts serve for the distances from the median.
        for (value, _) in &mut counted {
            *value = (*value - middle).abs();
        }
        ChannelStatistics {
            voxels: self.voxels,
            mean: Some(self.first + shift),
            standard_deviation: Some(variance.sqrt()),
            median: Some(f64::from(middle)),
            median_deviation: Some(f64::from(median(&mut counted))),
            minimum: Some(f64::from(minimum)),
            maximum: Some(f64::from(maximum)),
        }
    }
}

/// The median of values that occur so many times each, the upper of the two in the middle.
fn median(counted: &mut [(f32, u64)]) -> f32 {
    counted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    // Half of all lie below the upper middle.
    let mut remaining_count = counted.iter().map(|(_, count)| count).sum::<u64>() / 2;
    for (value, count) in &*counted {
        if remaining_count < *count {
            return *value;
        }
        remaining_count -= count;
    }
    f32::NAN
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_io::zarr::as_stored;

    fn row(number: usize, cluster: &str) -> Row {
        Row {
            entry: number,
            name: format!("s{number}"),
            label: format!("{}", number % 2),
            cluster: cluster.into(),
            ..Row::default()
        }
    }

    fn gathering(rows: &[Row]) -> Gathering {
        Gathering::new(&settings(), rows.len(), |sample| Ok(rows[sample].clone())).unwrap()
    }

    fn voxels(potential: &[f32]) -> Voxels {
        Voxels {
            index: (0..potential.len() as u32).collect(),
            values: vec![vec![1.0; potential.len()], potential.to_vec()],
        }
    }

    fn settings() -> VoxelizeSettings {
        VoxelizeSettings {
            channels: vec![Channel::Shape, Channel::Potential],
            ..VoxelizeSettings::default()
        }
    }

    #[test]
    fn of_few_clusters_all_samples_count() {
        let samples = [row(0, "a"), row(1, "a")];
        let mut gathering = gathering(&samples);
        gathering.add(0, &voxels(&[-1.0, 3.0]));
        gathering.add(1, &voxels(&[5.0, 7.0, -9.0]));
        let statistics = gathering.finish();
        assert_eq!(
            (statistics.over, &statistics.samples[..]),
            ("all samples", &[0, 1][..])
        );
        // -9 -1 3 5 7: mean 1, squares of deviations 100 4 4 16 36, median 3, distances from it 12
        // 4 0 2 4.
        let expected = ChannelStatistics {
            voxels: 5,
            mean: Some(1.0),
            standard_deviation: Some(32.0_f64.sqrt()),
            median: Some(3.0),
            median_deviation: Some(4.0),
            minimum: Some(-9.0),
            maximum: Some(7.0),
        };
        assert_eq!(statistics.channels["potential"], expected);
        assert_eq!(statistics.channels["shape"].standard_deviation, Some(0.0));
    }

    #[test]
    fn what_is_not_of_the_training_part_changes_nothing() {
        let samples: Vec<Row> = (0..40)
            .map(|number| row(number, &format!("c{number}")))
            .collect();
        let drifts = |outside: f32| {
            let mut gathering = gathering(&samples);
            let inside = gathering.samples.clone();
            assert!(inside.len() > 20 && inside.len() < 35);
            for sample in 0..samples.len() {
                let value = if inside.contains(&sample) {
                    sample as f32
                } else {
                    outside
                };
                gathering.add(sample, &voxels(&[value]));
            }
            gathering.finish()
        };
        assert_eq!(drifts(1e4), drifts(-7.0));
        assert_eq!(drifts(0.0).over, "training part");
    }

    /// The slow twin: all values in a list.
    #[test]
    fn a_median_of_counted_values_is_that_of_their_list() {
        let mut state = 1_u32;
        for length in 1..200 {
            let mut draw = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                as_stored((state >> 28) as f32 / 3.0 - 2.0)
            };
            let values: Vec<f32> = (0..length).map(|_| draw()).collect();
            let mut gathered = Gathered::default();
            gathered.add(&values);
            let statistics = gathered.finish();
            let mut list = values.clone();
            let middle = protomer_kernel::statistics::median(&mut list, f32::total_cmp).unwrap();
            let mut distances: Vec<f32> = values.iter().map(|x| (x - middle).abs()).collect();
            let deviation =
                protomer_kernel::statistics::median(&mut distances, f32::total_cmp).unwrap();
            assert_eq!(statistics.median, Some(f64::from(middle)));
            assert_eq!(statistics.median_deviation, Some(f64::from(deviation)));
        }
    }

    #[test]
    fn no_voxels_have_no_mean() {
        let statistics = gathering(&[]).finish();
        assert_eq!(
            statistics.channels["potential"],
            ChannelStatistics::default()
        );
    }
}
