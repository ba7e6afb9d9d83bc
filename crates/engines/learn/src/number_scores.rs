//! How near predicted numbers come to the true ones.
//!
//! Every sample carries a weight w. With true numbers y, predicted numbers x and the mean m of the
//! training part,
//!
//! ```text
//! rms error            √(Σ w (x - y)² / Σ w)
//! variance explained   1 - Σ w (x - y)² / Σ w (m - y)²
//! rank correlation     the correlation of the ranks of x and y (Spearman)
//! ```
//!
//! The variance explained is 0 for always predicting m, and negative for what is worse than that.

use crate::Result;
use crate::bootstrap::{Interval, LEVEL, RESAMPLINGS, bootstrap};
use crate::error::refuse;
use crate::normal::PredictedNumber;
use serde::{Deserialize, Serialize};

/// Scores of predicted numbers. Errors have the unit of the numbers.
///
/// ```
/// use protomer_learn::number_scores::{NumberScores, TrueNumbers};
///
/// let truth = TrueNumbers { numbers: &[1.0, 2.0, 4.0], weights: &[1.0; 3], training_mean: 2.0 };
/// let scores = NumberScores::from_predictions(&[1.0, 3.0, 5.0], &truth)?;
/// assert_eq!(scores.rms_error, (2.0_f64 / 3.0).sqrt());
/// assert_eq!(scores.mean_absolute_error, 2.0 / 3.0);
/// assert!((scores.variance_explained - (1.0 - 2.0 / 5.0)).abs() < 1e-12);
/// assert_eq!(scores.rank_correlation, 1.0);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NumberScores {
    /// Root of the mean squared error.
    pub rms_error: f64,
    /// Mean size of the error.
    pub mean_absolute_error: f64,
    /// Share of the variance about the mean of the training part that is explained, at most 1.
    pub variance_explained: f64,
    /// Rank correlation, -1 to 1; 0 if all true or all predicted numbers are the same.
    pub rank_correlation: f64,
}

/// True numbers and weights of the samples that are scored.
#[derive(Debug, Clone, Copy)]
pub struct TrueNumbers<'a> {
    /// The number of each sample.
    pub numbers: &'a [f64],
    /// The weight of each sample.
    pub weights: &'a [f64],
    /// Mean of the numbers of the training part.
    pub training_mean: f64,
}

/// Intervals that hold 95 % of the values in draws of clusters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NumberIntervals {
    /// Interval of the root of the mean squared error.
    pub rms_error: Interval,
    /// Interval of the variance explained.
    pub variance_explained: Interval,
    /// Interval of the rank correlation.
    pub rank_correlation: Interval,
}

/// Honesty of predicted spreads: how often the truth lies within them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpreadScores {
    /// Mean predicted spread, in the unit of the numbers.
    pub mean_spread: f64,
    /// Share of the numbers within one spread of the prediction; 0.68 is honest.
    pub within_one: f64,
    /// Share of the numbers within two spreads; 0.95 is honest.
    pub within_two: f64,
}

impl SpreadScores {
    /// Scores of predictions with spreads.
    pub fn from_predictions(predicted: &[PredictedNumber], truth: &TrueNumbers) -> Self {
        let total: f64 = truth.weights.iter().sum();
        let mean = |value: &dyn Fn(&PredictedNumber, f64) -> f64| {
            let samples = predicted.iter().zip(truth.numbers).zip(truth.weights);
            let terms = samples.map(|((one, number), weight)| weight * value(one, *number));
            terms.sum::<f64>() / total
        };
        let within = |most: f64| {
            mean(&|one, number| f64::from(u8::from((number - one.mean).abs() <= most * one.spread)))
        };
        Self {
            mean_spread: mean(&|one, _| one.spread),
            within_one: within(1.0),
            within_two: within(2.0),
        }
    }
}

impl NumberScores {
    /// Scores of predicted numbers.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) if lengths disagree, no sample has a
    /// weight, or a number is not finite.
    pub fn from_predictions(predicted: &[f64], truth: &TrueNumbers) -> Result<Self> {
        let (numbers, weights) = (truth.numbers, truth.weights);
        let total: f64 = weights.iter().sum();
        if predicted.len() != numbers.len() || weights.len() != numbers.len() || total <= 0.0 {
            return refuse(format!(
                "{} predicted numbers, {} true ones and {} weights with the sum {total}: give one of \
                 each per sample",
                predicted.len(),
                numbers.len(),
                weights.len()
            ));
        }
        let mut all = predicted
            .iter()
            .chain(numbers)
            .chain([&truth.training_mean]);
        if let Some(wrong) = all.find(|number| !number.is_finite()) {
            return refuse(format!("{wrong} cannot be scored; numbers must be finite"));
        }
        let mean = |term: &dyn Fn(usize) -> f64| {
            let terms = (0..numbers.len()).map(|sample| weights[sample] * term(sample));
            terms.sum::<f64>() / total
        };
        let square = mean(&|sample| (predicted[sample] - numbers[sample]).powi(2));
        let variance = mean(&|sample| (truth.training_mean - numbers[sample]).powi(2));
        Ok(Self {
            rms_error: square.sqrt(),
            mean_absolute_error: mean(&|sample| (predicted[sample] - numbers[sample]).abs()),
            variance_explained: match variance > 0.0 {
                true => 1.0 - square / variance,
                false => 0.0,
            },
            rank_correlation: correlation(
                &ranks(predicted, weights),
                &ranks(numbers, weights),
                weights,
            ),
        })
    }
}

impl TrueNumbers<'_> {
    /// The squared error of each sample over the variance about the mean of the training part: their
    /// weighted mean is one less the variance explained.
    pub(crate) fn squares_over_variance(&self, predicted: &[f64]) -> Vec<f64> {
        let (mut sum, mut total) = (0.0, 0.0);
        for (number, weight) in self.numbers.iter().zip(self.weights) {
            sum += weight * (number - self.training_mean).powi(2);
            total += weight;
        }
        // Numbers that are all the same have no variance to share: their errors stay as they are.
        let variance = if sum > 0.0 { sum / total } else { 1.0 };
        let pairs = predicted.iter().zip(self.numbers);
        pairs
            .map(|(predicted, number)| (predicted - number).powi(2) / variance)
            .collect()
    }

    /// 95 % intervals of the scores over draws of clusters, one cluster given per sample.
    ///
    /// # Errors
    /// As for [`NumberScores::from_predictions`], and without clusters.
    pub fn intervals(
        &self,
        predicted: &[f64],
        clusters: &[&str],
        seed: u64,
    ) -> Result<NumberIntervals> {
        NumberScores::from_predictions(predicted, self)?;
        let statistics = |drawn: &[f64]| {
            let pairs = self.weights.iter().zip(drawn);
            let weights: Vec<f64> = pairs.map(|(weight, times)| weight * times).collect();
            let truth = TrueNumbers {
                weights: &weights,
                ..*self
            };
            match NumberScores::from_predictions(predicted, &truth) {
                Ok(scores) => [
                    scores.rms_error,
                    scores.variance_explained,
                    scores.rank_correlation,
                ],
                // No sample of this draw has a weight.
                Err(_) => [f64::NAN; 3],
            }
        };
        let [rms_error, variance_explained, rank_correlation] =
            bootstrap(clusters, LEVEL, RESAMPLINGS, seed, statistics)?;
        Ok(NumberIntervals {
            rms_error,
            variance_explained,
            rank_correlation,
        })
    }
}

/// The weight below each number and half of that at it: ranks less one half, if all weights are 1.
fn ranks(numbers: &[f64], weights: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..numbers.len()).collect();
    order.sort_by(|a, b| numbers[*a].total_cmp(&numbers[*b]));
    let mut ranks = vec![0.0; numbers.len()];
    let mut below = 0.0;
    for tied in order.chunk_by(|a, b| numbers[*a] == numbers[*b]) {
        let weight: f64 = tied.iter().map(|sample| weights[*sample]).sum();
        for sample in tied {
            ranks[*sample] = below + 0.5 * weight;
        }
        below += weight;
    }
    ranks
}

/// The weighted correlation coefficient; 0 if one side is constant.
fn correlation(a: &[f64], b: &[f64], weights: &[f64]) -> f64 {
    let total: f64 = weights.iter().sum();
    let mean = |x: &[f64]| x.iter().zip(weights).map(|(x, w)| x * w).sum::<f64>() / total;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for ((a, b), weight) in a.iter().zip(b).zip(weights) {
        let (a, b) = (a - mean_a, b - mean_b);
        ab += weight * a * b;
        aa += weight * a * a;
        bb += weight * b * b;
    }
    let scale = (aa * bb).sqrt();
    if scale > 0.0 { ab / scale } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The slow twin of whole weights: every sample that many times.
    #[test]
    fn a_weight_counts_a_sample_so_many_times() {
        let truth = [3.0, 1.0, 4.0, 1.0, 5.0, 9.0, 2.0];
        let predicted = [2.5, 1.5, 4.5, 0.5, 2.5, 7.0, 2.5];
        let weights = [1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 1.0];
        let (mut many_true, mut many_predicted) = (Vec::new(), Vec::new());
        for sample in 0..truth.len() {
            for _ in 0..weights[sample] as usize {
                many_true.push(truth[sample]);
                many_predicted.push(predicted[sample]);
            }
        }
        let weighted = TrueNumbers {
            numbers: &truth,
            weights: &weights,
            training_mean: 3.0,
        };
        let repeated = TrueNumbers {
            numbers: &many_true,
            weights: &vec![1.0; many_true.len()],
            training_mean: 3.0,
        };
        let found = NumberScores::from_predictions(&predicted, &weighted).unwrap();
        let expected = NumberScores::from_predictions(&many_predicted, &repeated).unwrap();
        for (a, b) in [
            (found.rms_error, expected.rms_error),
            (found.mean_absolute_error, expected.mean_absolute_error),
            (found.variance_explained, expected.variance_explained),
            (found.rank_correlation, expected.rank_correlation),
        ] {
            assert!((a - b).abs() < 1e-12, "{found:?} {expected:?}");
        }
        // Spearman by the textbook, without ties: 1 - 6 Σ d² / (n (n² - 1)).
        let ones = [1.0; 4];
        let truth = TrueNumbers {
            numbers: &[1.0, 2.0, 3.0, 4.0],
            weights: &ones,
            training_mean: 2.5,
        };
        let scores = NumberScores::from_predictions(&[10.0, 30.0, 20.0, 40.0], &truth).unwrap();
        assert!((scores.rank_correlation - 0.8).abs() < 1e-12);
    }

    #[test]
    fn the_mean_explains_nothing_and_ranks_nothing() {
        let truth = TrueNumbers {
            numbers: &[1.0, 2.0, 6.0],
            weights: &[1.0; 3],
            training_mean: 2.0,
        };
        let scores = NumberScores::from_predictions(&[2.0; 3], &truth).unwrap();
        assert_eq!(
            (scores.variance_explained, scores.rank_correlation),
            (0.0, 0.0)
        );
        let intervals = truth
            .intervals(&[1.0, 2.0, 6.0], &["a", "b", "c"], 1)
            .unwrap();
        assert_eq!(intervals.rms_error.high, 0.0);
        assert_eq!(intervals.rank_correlation.estimate, 1.0);
        assert!(NumberScores::from_predictions(&[1.0], &truth).is_err());
        assert!(NumberScores::from_predictions(&[1.0, f64::NAN, 2.0], &truth).is_err());
    }
}
