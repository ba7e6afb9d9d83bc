//! Intervals by resampling clusters: related samples are not independent evidence.

use crate::Result;
use crate::error::refuse;
use protomer_kernel::random::{CounterRng, Purpose};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::array;
use std::collections::{BTreeMap, BTreeSet};

/// Resamplings of the clusters behind each interval.
pub(crate) const RESAMPLINGS: usize = 1000;
/// Share of the resamplings that an interval holds.
pub(crate) const LEVEL: f64 = 0.95;

/// A value and the range in which it would fall in other draws of clusters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Value for the samples as they are.
    pub estimate: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Percentile intervals of N statistics (Efron and Tibshirani, *An Introduction to the Bootstrap*,
/// 1993, chapter 13).
///
/// Each of `replicates` draws takes as many clusters as there are, with replacement, and hands
/// `statistics` a weight for each sample: how often its cluster was drawn. An interval leaves (1 -
/// level) / 2 of the finite values on either side. For a paired difference, compute both numbers
/// from the same weights.
///
/// ```
/// use protomer_learn::bootstrap::bootstrap;
///
/// let (values, clusters) = ([1.0, 2.0, 3.0, 4.0], ["a", "a", "b", "c"]);
/// let mean = |weights: &[f64]| {
///     let sum: f64 = values.iter().zip(weights).map(|(value, weight)| value * weight).sum();
///     [sum / weights.iter().sum::<f64>()]
/// };
/// let [interval] = bootstrap(&clusters, 0.95, 200, 1, mean)?;
/// assert_eq!(interval.estimate, 2.5);
/// assert!(interval.low < 2.5 && interval.high > 2.5);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
///
/// # Errors
/// [`LearnError::Settings`](crate::LearnError::Settings) without clusters or replicates, for a
/// level outside (0, 1), or if no draw gives a finite value.
pub fn bootstrap<C: Ord, const N: usize>(
    clusters: &[C],
    level: f64,
    replicates: usize,
    seed: u64,
    statistics: impl Fn(&[f64]) -> [f64; N] + Sync,
) -> Result<[Interval; N]> {
    if clusters.is_empty() || replicates == 0 || !(level > 0.0 && level < 1.0) {
        let samples = clusters.len();
        return refuse(format!(
            "{replicates} resamplings of {samples} samples at the level {level}"
        ));
    }
    let clusters = Clusters::new(clusters);
    // Each replicate has its own stream of random numbers, so threads do not matter.
    let draws: Vec<[f64; N]> = (0..replicates)
        .into_par_iter()
        .map(|replicate| statistics(&clusters.draw(seed, replicate as u64)))
        .collect();
    let estimates = statistics(&vec![1.0; clusters.of_sample.len()]);
    let mut intervals = Vec::with_capacity(N);
    for (i, estimate) in estimates.into_iter().enumerate() {
        let values = draws.iter().map(|draw| draw[i]).collect();
        intervals.push(interval(estimate, values, level)?);
    }
    Ok(array::from_fn(|i| intervals[i]))
}

/// The clusters of a set, by number.
struct Clusters {
    of_sample: Vec<usize>,
    count: usize,
}

impl Clusters {
    fn new<C: Ord>(clusters: &[C]) -> Self {
        // Sorted, so that the numbers of clusters follow
        // from the names and not from the order of samples.
        let names: BTreeSet<&C> = clusters.iter().collect();
        let numbers: BTreeMap<&C, usize> = names.into_iter().zip(0..).collect();
        Self {
            of_sample: clusters.iter().map(|cluster| numbers[cluster]).collect(),
            count: numbers.len(),
        }
    }

    /// Number of times that the cluster of each sample is drawn.
    fn draw(&self, seed: u64, replicate: u64) -> Vec<f64> {
        let mut random = CounterRng::for_purpose(seed, 0, replicate, Purpose::Bootstrap);
        let mut drawn = vec![0.0; self.count];
        // As many draws as there are clusters: the number of samples
        // varies between replicates, as it would between sets.
        for _ in 0..self.count {
            drawn[random.index(self.count)] += 1.0;
        }
        self.of_sample
            .iter()
            .map(|cluster| drawn[*cluster])
            .collect()
    }
}

/// The interval that holds `level` of the finite values.
fn interval(estimate: f64, mut values: Vec<f64>, level: f64) -> Result<Interval> {
    // A replicate may lack a class and have no value of some statistic.
    values.retain(|value| value.is_finite());
    values.sort_unstable_by(f64::total_cmp);
    if values.is_empty() {
        return refuse("no resampling of the clusters gives a finite value");
    }
    let tail = 0.5 * (1.0 - level);
    Ok(Interval {
        estimate,
        low: quantile(&values, tail),
        high: quantile(&values, 1.0 - tail),
    })
}

/// The quantile of sorted values, one or more, linear between them.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    // Numbers 0 to n - 1 stand for shares 0 to 1; `ceil` of the last stays inside.
    let place = share * (sorted.len() - 1) as f64;
    let (low, high) = (
        sorted[place.floor() as usize],
        sorted[place.ceil() as usize],
    );
    low + (high - low) * place.fract()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(values: &[f64]) -> impl Fn(&[f64]) -> [f64; 1] + Sync + '_ {
        |weights| {
            let sum: f64 = values.iter().zip(weights).map(|(v, w)| v * w).sum();
            [sum / weights.iter().sum::<f64>()]
        }
    }

    #[test]
    fn a_mean_of_independent_samples_has_its_known_error() {
        let mut rng = CounterRng::new(1, 0, 0);
        let values: Vec<f64> = (0..400).map(|_| rng.uniform()).collect();
        let clusters: Vec<usize> = (0..400).collect();
        let [interval] = bootstrap(&clusters, 0.95, 4000, 2, mean(&values)).unwrap();
        // ± 1.96 sqrt(1/12/400)
        let expected = 2.0 * 1.96 * (1.0 / 12.0 / 400.0_f64).sqrt();
        assert!(
            ((interval.high - interval.low) / expected - 1.0).abs() < 0.1,
            "{interval:?} {expected}"
        );
    }

    #[test]
    fn copies_in_a_cluster_do_not_narrow_the_interval() {
        let mut rng = CounterRng::new(3, 0, 0);
        let values: Vec<f64> = (0..50).map(|_| rng.uniform()).collect();
        let copies: Vec<f64> = values.iter().flat_map(|value| [*value; 9]).collect();
        let clusters: Vec<usize> = (0..450).map(|sample| sample / 9).collect();
        let singles: Vec<usize> = (0..50).collect();
        let [with] = bootstrap(&clusters, 0.9, 500, 2, mean(&copies)).unwrap();
        let [without] = bootstrap(&singles, 0.9, 500, 2, mean(&values)).unwrap();
        assert!((with.low - without.low).abs() < 1e-12 && (with.high - without.high).abs() < 1e-12);
    }

    #[test]
    fn threads_do_not_matter_and_nonsense_is_refused() {
        let values: Vec<f64> = (0..40).map(f64::from).collect();
        let clusters: Vec<usize> = (0..40).map(|sample| sample / 3).collect();
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| bootstrap(&clusters, 0.9, 100, 5, mean(&values)).unwrap())
        };
        assert_eq!(run(1), run(3));
        assert!(bootstrap::<usize, 1>(&[], 0.9, 10, 1, |_| [0.0]).is_err());
        assert!(bootstrap(&clusters, 1.0, 10, 1, |_| [0.0]).is_err());
        assert!(bootstrap(&clusters, 0.9, 10, 1, |_| [0.0, f64::NAN]).is_err());
    }

    #[test]
    fn several_statistics_have_the_intervals_they_have_alone() {
        let values: Vec<f64> = (0..30).map(|i| f64::from(i % 7)).collect();
        let clusters: Vec<usize> = (0..30).map(|sample| sample / 2).collect();
        let alone = mean(&values);
        let both = |weights: &[f64]| [alone(weights)[0], weights[0]];
        let [first, second] = bootstrap(&clusters, 0.8, 200, 3, both).unwrap();
        let [same_first] = bootstrap(&clusters, 0.8, 200, 3, &alone).unwrap();
        let [same_second] = bootstrap(&clusters, 0.8, 200, 3, |weights| [weights[0]]).unwrap();
        assert_eq!((first, second), (same_first, same_second));
    }
}
