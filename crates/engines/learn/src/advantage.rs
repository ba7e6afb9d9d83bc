//! Whether a network predicts better than the best prediction without one: loss against loss, sample
//! by sample.

use crate::Result;
use crate::bootstrap::{Interval, LEVEL, RESAMPLINGS, bootstrap};
use crate::error::refuse;
use protomer_kernel::random::{CounterRng, Purpose};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The stream of random numbers, apart from that of the exchanges of labels.
const STREAM: u32 = 1;
/// Largest p-value that counts as more than chance.
const SIGNIFICANT: f64 = 0.05;
/// Relative difference below which two sums are equal.
const EQUAL: f64 = 1e-12;

/// The losses of two predictions of the same samples.
#[derive(Debug, Clone, Copy)]
pub struct PairedLosses<'a> {
    /// The loss of each sample under the network.
    pub network: &'a [f64],
    /// The loss of each sample under the other prediction.
    pub baseline: &'a [f64],
    /// The weight of each sample.
    pub weights: &'a [f64],
    /// The cluster of each sample.
    pub clusters: &'a [&'a str],
}

/// The advantage of a network over the best baseline on the test part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Advantage {
    /// Name of the baseline with the smallest loss on the test part. As the test part chooses it, the
    /// comparison favours the baseline.
    pub baseline: String,
    /// Mean loss of the baseline less that of the network, with the interval over draws of clusters:
    /// nats for classes, the share of the variance for numbers.
    pub gain: Interval,
    /// (1 + exchanges with at least this gain) / (1 + exchanges): in each, network and baseline are
    /// exchanged in every cluster with probability ½.
    pub p_value: f64,
}

/// The outcome of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The network is better beyond chance.
    Better,
    /// No difference beyond chance.
    Undecided,
    /// The baseline is better beyond chance.
    Worse,
}

impl Advantage {
    /// Compares losses, in `exchanges` exchanges of network and baseline.
    ///
    /// ```
    /// use protomer_learn::advantage::{Advantage, PairedLosses, Verdict};
    ///
    /// let names: Vec<String> = (0..20).map(|cluster| cluster.to_string()).collect();
    /// let losses = PairedLosses {
    ///     network: &[0.2; 20],
    ///     baseline: &[0.7; 20],
    ///     weights: &[1.0; 20],
    ///     clusters: &names.iter().map(String::as_str).collect::<Vec<_>>(),
    /// };
    /// let advantage = Advantage::from_losses("size", losses, 999, 1)?;
    /// assert!((advantage.gain.estimate - 0.5).abs() < 1e-12);
    /// assert_eq!((advantage.p_value, advantage.verdict()), (0.001, Verdict::Better));
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) if lengths disagree or there is nothing to
    /// compare.
    pub fn from_losses(
        baseline: &str,
        losses: PairedLosses,
        exchanges: usize,
        seed: u64,
    ) -> Result<Self> {
        let PairedLosses {
            network,
            baseline: of_baseline,
            weights,
            clusters,
        } = losses;
        let count = network.len();
        if [of_baseline.len(), weights.len(), clusters.len()] != [count; 3] {
            return refuse(format!(
                "{count} losses of the network, {} of the baseline, {} weights and {} clusters: give \
                 one of each per sample",
                of_baseline.len(),
                weights.len(),
                clusters.len()
            ));
        }
        let gains: Vec<f64> = of_baseline
            .iter()
            .zip(network)
            .map(|(b, n)| b - n)
            .collect();
        let mean = |drawn: &[f64]| {
            let (mut sum, mut total) = (0.0, 0.0);
            for ((gain, weight), times) in gains.iter().zip(weights).zip(drawn) {
                sum += times * weight * gain;
                total += times * weight;
            }
            [sum / total]
        };
        let [gain] = bootstrap(clusters, LEVEL, RESAMPLINGS, seed, mean)?;
        let mut by_cluster = BTreeMap::<&str, f64>::new();
        for ((gain, weight), cluster) in gains.iter().zip(weights).zip(clusters) {
            *by_cluster.entry(cluster).or_default() += weight * gain;
        }
        let sums: Vec<f64> = by_cluster.into_values().collect();
        Ok(Self {
            baseline: baseline.to_owned(),
            gain,
            p_value: p_value(&sums, exchanges, seed),
        })
    }

    /// The outcome: the interval must leave out zero, and for the network the exchanges must agree.
    pub fn verdict(&self) -> Verdict {
        if self.gain.low > 0.0 && self.p_value < SIGNIFICANT {
            Verdict::Better
        } else if self.gain.high < 0.0 {
            Verdict::Worse
        } else {
            Verdict::Undecided
        }
    }
}

/// Share of exchanges of the signs of `sums` whose total is at least as large as theirs.
fn p_value(sums: &[f64], exchanges: usize, seed: u64) -> f64 {
    let observed: f64 = sums.iter().sum();
    let size: f64 = sums.iter().map(|sum| sum.abs()).sum();
    let as_large = (0..exchanges as u64)
        .into_par_iter()
        .filter(|exchange| {
            let mut random = CounterRng::for_purpose(seed, STREAM, *exchange, Purpose::Permutation);
            let signed = sums.iter().map(|sum| match random.index(2) {
                0 => *sum,
                _ => -sum,
            });
            // Sums of the same terms may differ in their last digit.
            signed.sum::<f64>() >= observed - EQUAL * size
        })
        .count();
    (1 + as_large) as f64 / (1 + exchanges) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn losses<'a>(network: &'a [f64], weights: &'a [f64], clusters: &'a [&'a str]) -> Advantage {
        let zeros = vec![0.0; network.len()];
        let losses = PairedLosses {
            network,
            baseline: &zeros,
            weights,
            clusters,
        };
        Advantage::from_losses("size", losses, 4000, 1).unwrap()
    }

    /// The slow twin: all exchanges of four clusters, one of two samples.
    #[test]
    fn few_clusters_have_the_p_value_of_all_their_exchanges() {
        let network = [-1.0, -2.0, 0.5, -0.25, -0.25];
        let clusters = ["a", "b", "c", "d", "d"];
        let advantage = losses(&network, &[1.0; 5], &clusters);
        let sums = [1.0, 2.0, -0.5, 0.5];
        let observed: f64 = sums.iter().sum();
        let mut as_large = 0;
        for mask in 0..16 {
            let signed = sums.iter().enumerate();
            let total: f64 = signed
                .map(|(i, sum)| if mask >> i & 1 == 1 { -sum } else { *sum })
                .sum();
            as_large += usize::from(total >= observed);
        }
        let expected = as_large as f64 / 16.0;
        assert!(
            (advantage.p_value - expected).abs() < 0.02,
            "{advantage:?} {expected}"
        );
        assert!((advantage.gain.estimate - 0.6).abs() < 1e-12);
    }

    #[test]
    fn equal_predictions_have_no_advantage() {
        let names: Vec<String> = (0..30).map(|cluster| cluster.to_string()).collect();
        let clusters: Vec<&str> = names.iter().map(String::as_str).collect();
        let advantage = losses(&[0.0; 30], &[1.0; 30], &clusters);
        assert_eq!(
            (advantage.p_value, advantage.verdict()),
            (1.0, Verdict::Undecided)
        );
        let worse = losses(&[0.1; 30], &[1.0; 30], &clusters);
        assert_eq!(worse.verdict(), Verdict::Worse);
    }

    /// Without a difference in truth, one comparison in twenty is called better, at most.
    #[test]
    fn chance_is_rarely_called_better() {
        let names: Vec<String> = (0..25).map(|cluster| cluster.to_string()).collect();
        let clusters: Vec<&str> = names.iter().map(String::as_str).collect();
        let mut better = 0;
        for trial in 0..200 {
            let mut random = CounterRng::new(7, 0, trial);
            let network: Vec<f64> = (0..25).map(|_| random.uniform_in(-1.0, 1.0)).collect();
            let zeros = [0.0; 25];
            let losses = PairedLosses {
                network: &network,
                baseline: &zeros,
                weights: &[1.0; 25],
                clusters: &clusters,
            };
            let advantage = Advantage::from_losses("size", losses, 199, trial).unwrap();
            better += usize::from(advantage.verdict() == Verdict::Better);
        }
        assert!(better <= 18, "{better} of 200");
    }

    #[test]
    fn lists_of_other_lengths_are_refused() {
        let losses = PairedLosses {
            network: &[0.0],
            baseline: &[0.0, 1.0],
            weights: &[1.0],
            clusters: &["a"],
        };
        assert!(Advantage::from_losses("size", losses, 10, 1).is_err());
    }
}
