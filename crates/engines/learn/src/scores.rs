//! How good probabilities are, in several senses: with unequal classes no single number is enough.
//!
//! Every sample carries a weight w (1 if none are given); N below is the sum of weights.

use crate::Result;
use crate::error::refuse;
use serde::{Deserialize, Serialize};

/// Smallest probability in logarithms: smaller ones count as this one. Certainty in error then
/// costs much, but not everything.
pub(crate) const SMALLEST_PROBABILITY: f64 = 1e-15;
/// Bins of the confidence for the reliability.
const RELIABILITY_BINS: usize = 15;
/// Most probable classes among which the true one counts for the top-3 accuracy.
const TOP: usize = 3;

/// Scores of predicted probabilities.
///
/// ```
/// use protomer_learn::scores::Scores;
///
/// // Two samples of two classes; both are predicted to be of the first.
/// let scores = Scores::from_probabilities(&[0.9, 0.1, 0.6, 0.4], &[0, 1], 2, None)?;
/// assert_eq!(scores.accuracy, 0.5);
/// assert_eq!(scores.confusion, [[1.0, 0.0], [1.0, 0.0]]);
///
/// let guessed = Scores::from_probabilities(&[0.5; 4], &[0, 1], 2, None)?;
/// assert!(scores.nats_gained_over(&guessed) > 0.0);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Scores {
    /// Number of samples.
    pub samples: usize,
    /// Share of samples whose most probable class is right.
    pub accuracy: f64,
    /// Mean over the classes present of the share of their samples that are recognised (recall).
    pub balanced_accuracy: f64,
    /// Mean over the classes present or predicted of F1 = 2 TP / (2 TP + FP + FN).
    pub macro_f1: f64,
    /// Share of samples whose class is among the three most probable.
    pub top3_accuracy: f64,
    /// Mean of -ln p(true class), nats.
    pub log_loss_nats: f64,
    /// Mean of Σ_k (p_k - δ_k)², 0 to 2.
    pub brier: f64,
    /// Sum over 15 equal bins of confidence of (weight in the bin / N) |accuracy in it - mean
    /// confidence in it|.
    pub expected_calibration_error: f64,
    /// The multi-class correlation coefficient of Matthews (Gorodkin, Comput. Biol. Chem. 28, 367
    /// (2004)), -1 to 1. Zero if only one class is present or predicted.
    pub matthews: f64,
    /// Weight of samples by true class (row) and predicted class (column).
    pub confusion: Vec<Vec<f64>>,
    /// Confidence and accuracy, bin by bin.
    pub reliability: Vec<ReliabilityBin>,
}

/// Samples whose largest probability lies in one range.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ReliabilityBin {
    /// Sum of weights.
    pub weight: f64,
    /// Mean of the largest probability.
    pub confidence: f64,
    /// Share of the samples whose most probable class is right.
    pub accuracy: f64,
}

impl Scores {
    /// Scores of `probabilities` (sample after sample, one number per class) against true classes.
    ///
    /// ```
    /// use protomer_learn::scores::Scores;
    /// let probabilities = [0.9, 0.1, 0.6, 0.4, 0.2, 0.8];
    /// let scores = Scores::from_probabilities(&probabilities, &[0, 1, 1], 2, None)?;
    /// assert!((scores.accuracy - 2.0 / 3.0).abs() < 1e-12);
    /// assert!((scores.balanced_accuracy - 0.75).abs() < 1e-12, "the mean of 1 and ½");
    /// assert_eq!(scores.confusion, [[1.0, 0.0], [1.0, 1.0]]);
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) if lengths disagree, a class does not
    /// exist, a number is not a probability, or there is nothing to score.
    pub fn from_probabilities(
        probabilities: &[f64],
        labels: &[usize],
        classes: usize,
        weights: Option<&[f64]>,
    ) -> Result<Self> {
        check(probabilities, labels, classes, weights)?;
        let mut scores = Self {
            samples: labels.len(),
            confusion: vec![vec![0.0; classes]; classes],
            reliability: vec![ReliabilityBin::default(); RELIABILITY_BINS],
            ..Self::default()
        };
        // Every sum is divided at the end by the weights alone, so their scale does not matter.
        let mut total = 0.0;
        let rows = labels.iter().zip(probabilities.chunks_exact(classes));
        for (sample, (label, p)) in rows.enumerate() {
            let weight = weights.map_or(1.0, |weights| weights[sample]);
            scores.add(p, *label, weight);
            total += weight;
        }
        scores.divide_by(total);
        (scores.balanced_accuracy, scores.macro_f1) = recall_and_f1(&scores.confusion);
        scores.matthews = matthews(&scores.confusion);
        Ok(scores)
    }

    /// Adds a sample to the sums.
    fn add(&mut self, p: &[f64], label: usize, weight: f64) {
        let predicted = most_probable(p);
        let rank = rank(p, label);
        // Rank 0 and the most probable class break ties alike, so `hit` agrees with the confusion.
        let hit = if rank == 0 { weight } else { 0.0 };
        // Row: the true class. Column: the predicted one.
        self.confusion[label][predicted] += weight;
        self.accuracy += hit;
        self.top3_accuracy += if rank < TOP { weight } else { 0.0 };
        self.log_loss_nats -= weight * p[label].max(SMALLEST_PROBABILITY).ln();
        let mut squares = 0.0;
        for (class, p) in p.iter().enumerate() {
            let truth = if class == label { 1.0 } else { 0.0 };
            squares += (p - truth).powi(2);
        }
        self.brier += weight * squares;
        let confidence = p[predicted];
        let bin = (confidence * RELIABILITY_BINS as f64) as usize;
        // A confidence of exactly 1 would fall behind the last bin.
        let bin = &mut self.reliability[bin.min(RELIABILITY_BINS - 1)];
        bin.weight += weight;
        bin.confidence += weight * confidence;
        bin.accuracy += hit;
    }

    /// Turns sums into means.
    fn divide_by(&mut self, total: f64) {
        self.accuracy /= total;
        self.top3_accuracy /= total;
        self.log_loss_nats /= total;
        self.brier /= total;
        for bin in &mut self.reliability {
            if bin.weight > 0.0 {
                bin.confidence /= bin.weight;
                bin.accuracy /= bin.weight;
                // Inside `if`: an empty bin has no mean, and counts nothing.
                self.expected_calibration_error +=
                    bin.weight / total * (bin.accuracy - bin.confidence).abs();
            }
        }
    }

    /// Nats per sample that these probabilities gain over `baseline`, usually the prior.
    ///
    /// ```
    /// use protomer_learn::scores::Scores;
    /// let [sure, guess] = [[1.0, 0.0], [0.5, 0.5]].map(|p| Scores::from_probabilities(&p, &[0], 2, None));
    /// assert!((sure?.nats_gained_over(&guess?) - 2.0_f64.ln()).abs() < 1e-12);
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    pub fn nats_gained_over(&self, baseline: &Self) -> f64 {
        baseline.log_loss_nats - self.log_loss_nats
    }
}

/// The cross entropy of each sample, nats.
///
/// ```
/// use protomer_learn::scores::losses_nats;
/// assert_eq!(losses_nats(&[0.5, 0.5, 0.0, 1.0], &[0, 1], 2), [2f64.ln(), 0.0]);
/// ```
pub fn losses_nats(probabilities: &[f64], labels: &[usize], classes: usize) -> Vec<f64> {
    let rows = labels
        .iter()
        .zip(probabilities.chunks_exact(classes.max(1)));
    let of_label = rows.map(|(label, p)| p.get(*label).copied().unwrap_or_default());
    of_label
        .map(|p| 0.0 - p.max(SMALLEST_PROBABILITY).ln())
        .collect()
}

/// The class of the largest probability, the first of equals.
///
/// ```
/// use protomer_learn::scores::most_probable;
/// assert_eq!(most_probable(&[0.2, 0.4, 0.4]), 1);
/// ```
pub fn most_probable(probabilities: &[f64]) -> usize {
    let mut best = 0;
    for (class, p) in probabilities.iter().enumerate() {
        if *p > probabilities[best] {
            best = class;
        }
    }
    best
}

/// Number of classes that are more probable than this one. Of equals the first comes first.
fn rank(p: &[f64], label: usize) -> usize {
    let mut rank = 0;
    for (class, other) in p.iter().enumerate() {
        rank += usize::from(*other > p[label] || (*other == p[label] && class < label));
    }
    rank
}

/// Checks that probabilities, labels and weights fit together.
///
/// # Errors
/// [`LearnError::Settings`](crate::LearnError::Settings) says what does not.
pub(crate) fn check(
    p: &[f64],
    labels: &[usize],
    classes: usize,
    weights: Option<&[f64]>,
) -> Result<()> {
    let samples = labels.len();
    if classes == 0 || samples == 0 || p.len() != samples * classes {
        let given = p.len();
        return refuse(format!(
            "{given} probabilities for {samples} samples of {classes} classes"
        ));
    }
    if let Some(label) = labels.iter().find(|label| **label >= classes) {
        return refuse(format!("class {label} of {classes}"));
    }
    // Room for rounding in a softmax of f32; an error of logic is larger by far.
    let is_probability = |p: &f64| (-1e-9..=1.0 + 1e-9).contains(p);
    if let Some(place) = p.iter().position(|p| !is_probability(p)) {
        return refuse(format!(
            "the probability of class {} in sample {} is {}",
            place % classes,
            place / classes,
            p[place]
        ));
    }
    let Some(weights) = weights else {
        return Ok(());
    };
    let usable = weights
        .iter()
        .all(|weight| weight.is_finite() && *weight >= 0.0);
    // Weights all zero would divide by zero.
    if weights.len() != samples || !usable || weights.iter().sum::<f64>() <= 0.0 {
        let given = weights.len();
        return refuse(format!(
            "{given} weights for {samples} samples: give one each, none negative, not all zero"
        ));
    }
    Ok(())
}

/// Mean recall and mean F1 from a confusion matrix.
fn recall_and_f1(confusion: &[Vec<f64>]) -> (f64, f64) {
    let predicted = column_sums(confusion);
    let (mut recalls, mut present, mut f1, mut named) = (0.0, 0.0, 0.0, 0.0);
    for (class, row) in confusion.iter().enumerate() {
        let hit = row[class];
        let truth: f64 = row.iter().sum();
        // A class absent from the truth has no recall.
        if truth > 0.0 {
            recalls += hit / truth;
            present += 1.0;
        }
        // 2 TP + FP + FN = (TP + FN) + (TP + FP)
        // A class neither present nor predicted has no F1.
        if truth + predicted[class] > 0.0 {
            f1 += 2.0 * hit / (truth + predicted[class]);
            named += 1.0;
        }
    }
    (recalls / f64::max(present, 1.0), f1 / f64::max(named, 1.0))
}

/// Correlation coefficient of Matthews. With t_k the weight of the true class k, p_k that of the
/// predicted one, c that of the correct ones and N all:
///
/// MCC = (c N - Σ t_k p_k) / √[(N² - Σ p_k²) (N² - Σ t_k²)]
fn matthews(confusion: &[Vec<f64>]) -> f64 {
    let truth: Vec<f64> = confusion.iter().map(|row| row.iter().sum()).collect();
    let predicted = column_sums(confusion);
    let all: f64 = truth.iter().sum();
    let mut correct = 0.0;
    for (class, row) in confusion.iter().enumerate() {
        correct += row[class];
    }
    // Zero when every sample has, or gets, the same class: there is no correlation with a constant.
    let square = (all * all - dot(&predicted, &predicted)) * (all * all - dot(&truth, &truth));
    if square > 0.0 {
        (correct * all - dot(&truth, &predicted)) / square.sqrt()
    } else {
        0.0
    }
}

fn column_sums(matrix: &[Vec<f64>]) -> Vec<f64> {
    let mut sums = vec![0.0; matrix.len()];
    for row in matrix {
        for (sum, value) in sums.iter_mut().zip(row) {
            *sum += value;
        }
    }
    sums
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(value: f64, expected: f64) {
        assert!((value - expected).abs() < 1e-12, "{value} {expected}");
    }

    /// Worked by hand: predictions 0 0 1 3 of classes 0 1 1 2 among 4.
    #[test]
    fn four_samples_by_hand() {
        let p = [
            [0.7, 0.1, 0.1, 0.1],
            [0.4, 0.3, 0.2, 0.1],
            [0.2, 0.5, 0.2, 0.1],
            [0.25, 0.2, 0.15, 0.4],
        ]
        .concat();
        let scores = Scores::from_probabilities(&p, &[0, 1, 1, 2], 4, None).unwrap();
        near(scores.accuracy, 0.5);
        near(scores.top3_accuracy, 0.75);
        near(scores.balanced_accuracy, (1.0 + 0.5 + 0.0) / 3.0);
        near(scores.macro_f1, (2.0 / 3.0 + 2.0 / 3.0 + 0.0 + 0.0) / 4.0);
        near(
            scores.log_loss_nats,
            -(0.7_f64 * 0.3 * 0.5 * 0.15).ln() / 4.0,
        );
        let brier = [
            0.09 + 0.03,
            0.16 + 0.49 + 0.04 + 0.01,
            0.04 + 0.25 + 0.04 + 0.01,
            0.0625 + 0.04 + 0.7225 + 0.16,
        ];
        near(scores.brier, brier.iter().sum::<f64>() / 4.0);
        // Bins of width 1/15: 0.4 twice (both wrong), 0.5, 0.7.
        near(
            scores.expected_calibration_error,
            (2.0 * 0.4 + 0.5 + 0.3) / 4.0,
        );
        // c = 2, N = 4, t = (1, 2, 1, 0), p = (2, 1, 0, 1)
        near(scores.matthews, (8.0 - 4.0) / (10.0_f64 * 10.0).sqrt());
        assert_eq!(scores.confusion[1], [1.0, 1.0, 0.0, 0.0]);
    }

    #[test]
    fn a_weight_of_two_is_a_sample_twice() {
        let p = [0.6, 0.4, 0.3, 0.7, 0.8, 0.2];
        let weighted =
            Scores::from_probabilities(&p, &[0, 1, 1], 2, Some(&[1.0, 2.0, 1.0])).unwrap();
        let repeated =
            Scores::from_probabilities(&[&p[..4], &p[2..]].concat(), &[0, 1, 1, 1], 2, None)
                .unwrap();
        near(weighted.log_loss_nats, repeated.log_loss_nats);
        near(
            weighted.expected_calibration_error,
            repeated.expected_calibration_error,
        );
        near(weighted.matthews, repeated.matthews);
        assert_eq!(weighted.confusion, repeated.confusion);
    }

    #[test]
    fn perfect_and_constant_predictions_stand_at_the_ends() {
        let perfect = Scores::from_probabilities(&[1.0, 0.0, 0.0, 1.0], &[0, 1], 2, None).unwrap();
        assert_eq!(
            (
                perfect.matthews,
                perfect.macro_f1,
                perfect.log_loss_nats,
                perfect.brier
            ),
            (1.0, 1.0, 0.0, 0.0)
        );
        let constant = Scores::from_probabilities(&[0.5; 4], &[0, 1], 2, None).unwrap();
        assert_eq!((constant.matthews, constant.balanced_accuracy), (0.0, 0.5));
        near(perfect.nats_gained_over(&constant), 2_f64.ln());
    }

    #[test]
    fn what_cannot_be_scored_is_refused() {
        assert!(Scores::from_probabilities(&[0.5; 3], &[0, 1], 2, None).is_err());
        assert!(Scores::from_probabilities(&[0.5; 4], &[0, 2], 2, None).is_err());
        assert!(Scores::from_probabilities(&[0.5, f64::NAN], &[0], 2, None).is_err());
        assert!(Scores::from_probabilities(&[], &[], 2, None).is_err());
        assert!(Scores::from_probabilities(&[0.5; 4], &[0, 1], 2, Some(&[0.0, 0.0])).is_err());
    }
}
