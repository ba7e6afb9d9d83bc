//! Intervals by resampling clusters: related samples are no independent evidence.

use crate::{LearnError, Result};
use protomer_kernel::random::{CounterRng, Purpose};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A value and where it would fall in other draws of clusters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// From the samples as they are.
    pub estimate: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// The percentile interval of a statistic (Efron and Tibshirani, *An Introduction to the
/// Bootstrap*, 1993, chapter 13).
///
/// Each of `replicates` draws takes as many clusters as there are, with replacement, and hands the
/// statistic a weight for each sample: how often its cluster was drawn. The interval leaves (1 -
/// level) / 2 of the finite values on either side. Paired differences come from a statistic that
/// computes both numbers from the same weights.
///
/// ```
/// use protomer_learn::bootstrap::bootstrap;
/// let (values, clusters) = ([1.0, 2.0, 3.0, 4.0], ["a", "a", "b", "c"]);
/// let mean = |weights: &[f64]| {
///     values.iter().zip(weights).map(|(value, weight)| value * weight).sum::<f64>() / weights.iter().sum::<f64>()
/// };
/// let interval = bootstrap(&clusters, 0.95, 200, 1, mean).unwrap();
/// assert!(interval.low < 2.5 && interval.estimate == 2.5 && interval.high > 2.5);
/// ```
///
/// # Errors
/// [`LearnError::Settings`] without clusters or replicates, for a level outside (0, 1), or if no
/// draw gives a finite value.
pub fn bootstrap<C: Ord>(
    clusters: &[C],
    level: f64,
    replicates: usize,
    seed: u64,
    statistic: impl Fn(&[f64]) -> f64 + Sync,
) -> Result<Interval> {
    if clusters.is_empty() || replicates == 0 || !(level > 0.0 && level < 1.0) {
        let reason = format!(
            "{replicates} resamplings of {} samples at the level {level}",
            clusters.len()
        );
        return Err(LearnError::Settings(reason));
    }
    let mut numbers: BTreeMap<&C, usize> = clusters.iter().map(|cluster| (cluster, 0)).collect();
    for (number, entry) in numbers.values_mut().enumerate() {
        *entry = number;
    }
    let members: Vec<usize> = clusters
        .iter()
        .filter_map(|cluster| numbers.get(cluster).copied())
        .collect();
    let count = numbers.len();
    let draw = |replicate: usize| {
        let mut rng = CounterRng::for_purpose(seed, 0, replicate as u64, Purpose::Bootstrap);
        let mut drawn = vec![0.0; count];
        for _ in 0..count {
            drawn[rng.index(count)] += 1.0;
        }
        let weights: Vec<f64> = members.iter().map(|cluster| drawn[*cluster]).collect();
        statistic(&weights)
    };
    let estimate = statistic(&vec![1.0; clusters.len()]);
    let mut values: Vec<f64> = (0..replicates).into_par_iter().map(draw).collect();
    values.retain(|value| value.is_finite());
    values.sort_unstable_by(f64::total_cmp);
    let tail = 0.5 * (1.0 - level);
    match (quantile(&values, tail), quantile(&values, 1.0 - tail)) {
        (Some(low), Some(high)) => Ok(Interval {
            estimate,
            low,
            high,
        }),
        _ => Err(LearnError::Settings(
            "no resampling of the clusters gives a finite value".into(),
        )),
    }
}

/// The quantile of sorted values, linear between them.
fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let place = share * sorted.len().checked_sub(1)? as f64;
    let low = sorted.get(place.floor() as usize)?;
    let high = sorted.get(place.ceil() as usize)?;
    Some(low + (high - low) * place.fract())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn mean<'a>(values: &'a [f64]) -> impl Fn(&[f64]) -> f64 + Sync + 'a {
        |weights| {
            values.iter().zip(weights).map(|(v, w)| v * w).sum::<f64>()
                / weights.iter().sum::<f64>()
        }
    }

    #[test]
    fn a_mean_of_independent_samples_has_its_known_error() {
        let mut rng = CounterRng::new(1, 0, 0);
        let values: Vec<f64> = (0..400).map(|_| rng.uniform()).collect();
        let clusters: Vec<usize> = (0..400).collect();
        let interval = bootstrap(&clusters, 0.95, 4000, 2, mean(&values)).unwrap();
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
        let with = bootstrap(&clusters, 0.9, 500, 2, mean(&copies)).unwrap();
        let without = bootstrap(&singles, 0.9, 500, 2, mean(&values)).unwrap();
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
        assert!(bootstrap::<usize>(&[], 0.9, 10, 1, |_| 0.0).is_err());
        assert!(bootstrap(&clusters, 1.0, 10, 1, |_| 0.0).is_err());
        assert!(bootstrap(&clusters, 0.9, 10, 1, |_| f64::NAN).is_err());
    }
}
