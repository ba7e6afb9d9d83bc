//! How good probabilities are, in several senses: with unequal classes no single number is enough.
//!
//! Every sample carries a weight w (1 if none are given); N below is the sum of weights.

use crate::{LearnError, Result};
use serde::{Deserialize, Serialize};

/// Probabilities below this count as this in logarithms, so that certainty in error costs much but
/// not everything.
pub const SMALLEST_PROBABILITY: f64 = 1e-15;
const RELIABILITY_BINS: usize = 15;
const TOP: usize = 3;

/// Scores of predicted probabilities.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Scores {
    /// Samples.
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
    /// Σ over 15 equal bins of confidence of (weight in the bin / N) |accuracy in it - mean
    /// confidence in it|.
    pub expected_calibration_error: f64,
    /// The multi-class correlation coefficient of Matthews (Gorodkin, Comput. Biol. Chem. 28, 367
    /// (2004)), -1 to 1; zero if only one class is present or predicted.
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
    /// Share that is right.
    pub accuracy: f64,
}

impl Scores {
    /// Scores of `probabilities` (sample after sample, one number per class) against true classes.
    ///
    /// ```
    /// use protomer_learn::scores::Scores;
    /// let scores = Scores::of(&[0.9, 0.1, 0.6, 0.4], &[0, 1], 2, None).unwrap();
    /// assert_eq!((scores.accuracy, scores.confusion), (0.5, vec![vec![1.0, 0.0], vec![1.0, 0.0]]));
    /// ```
    ///
    /// # Errors
    /// [`LearnError::Settings`] if lengths disagree, a class does not exist, a probability is not
    /// one, or there is nothing to score.
    pub fn of(
        probabilities: &[f64],
        labels: &[usize],
        classes: usize,
        weights: Option<&[f64]>,
    ) -> Result<Self> {
        check(probabilities, labels, classes, weights)?;
        let mut scores = Self {
            samples: labels.len(),
            confusion: vec![vec![0.0; classes]; classes],
            ..Self::default()
        };
        let mut bins = [ReliabilityBin::default(); RELIABILITY_BINS];
        let mut total = 0.0;
        for (sample, (label, p)) in labels
            .iter()
            .zip(probabilities.chunks_exact(classes))
            .enumerate()
        {
            let weight = weights.map_or(1.0, |weights| weights[sample]);
            // Ties go to the class that comes first.
            let before =
                |class: usize| p[class] > p[*label] || (p[class] == p[*label] && class < *label);
            let rank = (0..classes).filter(|class| before(*class)).count();
            let predicted = most_probable(p);
            let hit = if rank == 0 { weight } else { 0.0 };
            total += weight;
            scores.confusion[*label][predicted] += weight;
            scores.accuracy += hit;
            scores.top3_accuracy += if rank < TOP { weight } else { 0.0 };
            scores.log_loss_nats -= weight * p[*label].max(SMALLEST_PROBABILITY).ln();
            let squared =
                |(class, p): (usize, &f64)| (p - if class == *label { 1.0 } else { 0.0 }).powi(2);
            scores.brier += weight * p.iter().enumerate().map(squared).sum::<f64>();
            let bin = &mut bins
                [((p[predicted] * RELIABILITY_BINS as f64) as usize).min(RELIABILITY_BINS - 1)];
            bin.weight += weight;
            bin.confidence += weight * p[predicted];
            bin.accuracy += hit;
        }
        for sum in [
            &mut scores.accuracy,
            &mut scores.top3_accuracy,
            &mut scores.log_loss_nats,
            &mut scores.brier,
        ] {
            *sum /= total;
        }
        for bin in bins.iter_mut().filter(|bin| bin.weight > 0.0) {
            bin.confidence /= bin.weight;
            bin.accuracy /= bin.weight;
            scores.expected_calibration_error +=
                bin.weight / total * (bin.accuracy - bin.confidence).abs();
        }
        scores.reliability = bins.to_vec();
        (scores.balanced_accuracy, scores.macro_f1) = recall_and_f1(&scores.confusion);
        scores.matthews = matthews(&scores.confusion);
        Ok(scores)
    }

    /// How many nats per sample these probabilities know more than `baseline`, usually the prior.
    pub fn nats_gained_over(&self, baseline: &Self) -> f64 {
        baseline.log_loss_nats - self.log_loss_nats
    }
}

/// The class of the largest probability, the first of equals.
pub fn most_probable(probabilities: &[f64]) -> usize {
    let mut best = 0;
    for (class, p) in probabilities.iter().enumerate() {
        if *p > probabilities[best] {
            best = class;
        }
    }
    best
}

pub(crate) fn check(
    p: &[f64],
    labels: &[usize],
    classes: usize,
    weights: Option<&[f64]>,
) -> Result<()> {
    let refuse = |reason: String| Err(LearnError::Settings(reason));
    if classes == 0 || labels.is_empty() || p.len() != labels.len() * classes {
        return refuse(format!(
            "{} probabilities for {} samples of {classes} classes",
            p.len(),
            labels.len()
        ));
    }
    if let Some(label) = labels.iter().find(|label| **label >= classes) {
        return refuse(format!("class {label} of {classes}"));
    }
    if let Some(place) = p.iter().position(|p| !(-1e-9..=1.0 + 1e-9).contains(p)) {
        return refuse(format!(
            "the probability of class {} in sample {} is {}",
            place % classes,
            place / classes,
            p[place]
        ));
    }
    if let Some(weights) = weights {
        let usable = weights
            .iter()
            .all(|weight| weight.is_finite() && *weight >= 0.0);
        if weights.len() != labels.len() || !usable || weights.iter().sum::<f64>() <= 0.0 {
            return refuse(format!(
                "{} weights for {} samples: not negative, and not all zero",
                weights.len(),
                labels.len()
            ));
        }
    }
    Ok(())
}

/// Mean recall and mean F1 from a confusion matrix.
fn recall_and_f1(confusion: &[Vec<f64>]) -> (f64, f64) {
    let (mut recalls, mut present, mut f1, mut named) = (0.0, 0.0, 0.0, 0.0);
    for (class, row) in confusion.iter().enumerate() {
        let hit = row[class];
        let truth: f64 = row.iter().sum();
        let predicted: f64 = confusion.iter().map(|row| row[class]).sum();
        if truth > 0.0 {
            recalls += hit / truth;
            present += 1.0;
        }
        // 2 TP + FP + FN = (TP + FN) + (TP + FP)
        if truth + predicted > 0.0 {
            f1 += 2.0 * hit / (truth + predicted);
            named += 1.0;
        }
    }
    (recalls / f64::max(present, 1.0), f1 / f64::max(named, 1.0))
}

/// With t_k the weight of the true class k, p_k that of the predicted one, c that of the correct
/// ones and N all:
///
/// MCC = (c N - Σ t_k p_k) / √[(N² - Σ p_k²) (N² - Σ t_k²)]
fn matthews(confusion: &[Vec<f64>]) -> f64 {
    let truth: Vec<f64> = confusion.iter().map(|row| row.iter().sum()).collect();
    let predicted: Vec<f64> = (0..confusion.len())
        .map(|k| confusion.iter().map(|row| row[k]).sum())
        .collect();
    let all: f64 = truth.iter().sum();
    let correct: f64 = confusion
        .iter()
        .enumerate()
        .map(|(class, row)| row[class])
        .sum();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let square = (all * all - dot(&predicted, &predicted)) * (all * all - dot(&truth, &truth));
    if square > 0.0 {
        (correct * all - dot(&truth, &predicted)) / square.sqrt()
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
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
        let scores = Scores::of(&p, &[0, 1, 1, 2], 4, None).unwrap();
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
        let weighted = Scores::of(&p, &[0, 1, 1], 2, Some(&[1.0, 2.0, 1.0])).unwrap();
        let repeated = Scores::of(&[&p[..4], &p[2..]].concat(), &[0, 1, 1, 1], 2, None).unwrap();
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
        let perfect = Scores::of(&[1.0, 0.0, 0.0, 1.0], &[0, 1], 2, None).unwrap();
        assert_eq!(
            (
                perfect.matthews,
                perfect.macro_f1,
                perfect.log_loss_nats,
                perfect.brier
            ),
            (1.0, 1.0, 0.0, 0.0)
        );
        let constant = Scores::of(&[0.5; 4], &[0, 1], 2, None).unwrap();
        assert_eq!((constant.matthews, constant.balanced_accuracy), (0.0, 0.5));
        near(perfect.nats_gained_over(&constant), 2_f64.ln());
    }

    #[test]
    fn what_cannot_be_scored_is_refused() {
        assert!(Scores::of(&[0.5; 3], &[0, 1], 2, None).is_err());
        assert!(Scores::of(&[0.5; 4], &[0, 2], 2, None).is_err());
        assert!(Scores::of(&[0.5, f64::NAN], &[0], 2, None).is_err());
        assert!(Scores::of(&[], &[], 2, None).is_err());
        assert!(Scores::of(&[0.5; 4], &[0, 1], 2, Some(&[0.0, 0.0])).is_err());
    }
}
