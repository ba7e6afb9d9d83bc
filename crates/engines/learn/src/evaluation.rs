//! The evaluation of predictions on a test part: scores compared with baselines, intervals over
//! clusters, and whether it could be chance.

use crate::Result;
use crate::advantage::{Advantage, PairedLosses};
use crate::baselines::{Baseline, baselines, number_baselines};
use crate::bootstrap::{Interval, LEVEL, RESAMPLINGS, bootstrap};
use crate::error::refuse;
use crate::normal::PredictedNumber;
use crate::number_classes::NumberClasses;
use crate::number_scores::{NumberIntervals, NumberScores, SpreadScores, TrueNumbers};
use crate::permutation::{PermutationTest, permutation_test};
use crate::predictions::TestPredictions;
use crate::scores::{Scores, losses_nats};
use crate::split::family_weights;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// The baseline that names one class with certainty.
const MAJORITY: &str = "majority";

/// Intervals that hold 95 % of the values in draws of clusters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Intervals {
    /// Interval of the accuracy.
    pub accuracy: Interval,
    /// Interval of the balanced accuracy.
    pub balanced_accuracy: Interval,
    /// Interval of the nats gained over the prior.
    pub nats_gained_over_prior: Interval,
}

/// Predictions evaluated. Copies of one crystal form count once together, except in the permutation
/// test.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// Scores of the predictions.
    pub scores: Scores,
    /// Baselines, which predict without a network, and their scores.
    pub baselines: Vec<(Baseline, Scores)>,
    /// 95 % intervals.
    pub intervals: Intervals,
    /// Test of whether the predictions could be right by chance.
    pub permutation: PermutationTest,
    /// Comparison with the best baseline.
    pub advantage: Advantage,
    /// Clusters of the test part.
    pub test_clusters: usize,
}

/// Predicted numbers evaluated. Copies of one crystal form count once together.
#[derive(Debug, Clone, PartialEq)]
pub struct NumberEvaluation {
    /// Scores of the predictions.
    pub scores: NumberScores,
    /// Scores of what is predicted without a network, by name.
    pub baselines: Vec<(&'static str, NumberScores)>,
    /// 95 % intervals.
    pub intervals: NumberIntervals,
    /// Comparison with the best baseline.
    pub advantage: Advantage,
    /// Honesty of the predicted spreads, if there are any.
    pub spread: Option<SpreadScores>,
}

impl TestPredictions<'_> {
    /// Evaluates the predictions, with `exchanges` of labels in the permutation test.
    ///
    /// ```
    /// use protomer_learn::controls::{Control, Variant};
    /// use protomer_learn::predictions::TestPredictions;
    /// use protomer_learn::split::{Fractions, Split};
    ///
    /// let set = Control::Charge.samples(Variant::Usual, 60, 16, 1);
    /// let labels: Vec<usize> = (0..60).map(|sample| sample % 2).collect();
    /// let split = Split::grouped(&set.descriptions, 1, Fractions::default())?;
    /// let guess = TestPredictions {
    ///     descriptions: &set.descriptions,
    ///     labels: &labels,
    ///     classes: 2,
    ///     split: &split,
    ///     probabilities: &[0.5, 0.5].repeat(split.test.len()),
    /// };
    /// let evaluation = guess.evaluate(100, 1)?;
    /// assert_eq!(evaluation.scores.log_loss_nats, 2f64.ln());
    /// let majority = evaluation.baseline("majority")?;
    /// assert_eq!(evaluation.scores.balanced_accuracy, majority.balanced_accuracy);
    /// assert_eq!(evaluation.permutation.p_value, 1.0);
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) if there is nothing to score or
    /// lengths disagree, [`LearnError::Sample`](crate::LearnError::Sample) names a description that
    /// is not finite or has no cluster.
    pub fn evaluate(&self, exchanges: usize, seed: u64) -> Result<Evaluation> {
        let all_weights = family_weights(self.descriptions);
        let of_test = Truth {
            labels: self.of_test(self.labels)?,
            classes: self.classes,
            weights: self.of_test(&all_weights)?,
        };
        let references = baselines(
            self.descriptions,
            self.labels,
            self.classes,
            Some(&all_weights),
            self.split,
        )?;
        let mut scores_of_baselines = Vec::with_capacity(references.len());
        let mut prior = Vec::new();
        for baseline in references {
            let scores = of_test.score(&baseline.probabilities, &of_test.weights)?;
            if baseline.name == "prior" {
                prior.clone_from(&baseline.probabilities);
            }
            scores_of_baselines.push((baseline, scores));
        }
        let clusters = self.clusters();
        let advantage =
            of_test.advantage(self, &scores_of_baselines, &clusters, exchanges, seed)?;
        Ok(Evaluation {
            advantage,
            scores: of_test.score(self.probabilities, &of_test.weights)?,
            baselines: scores_of_baselines,
            intervals: of_test.intervals(self.probabilities, &prior, &clusters, seed)?,
            permutation: permutation_test(self, exchanges, seed)?,
            test_clusters: clusters.iter().collect::<BTreeSet<_>>().len(),
        })
    }

    /// The predictions as numbers, where the classes are those of a number: the scores, and those of the
    /// baselines of an evaluation. `numbers` holds the true number of every sample. `direct` holds the
    /// predicted number of every sample of the test part, from a network that predicts numbers; its
    /// baselines are linear regressions of the numbers.
    ///
    /// # Errors
    /// As for [`NumberScores::from_predictions`] and [`TrueNumbers::intervals`].
    pub fn evaluate_numbers(
        &self,
        evaluation: &Evaluation,
        numbers: &[f64],
        classes: &NumberClasses,
        direct: Option<&[PredictedNumber]>,
        seed: u64,
    ) -> Result<NumberEvaluation> {
        let of_test = self.of_test(numbers)?;
        let weights = self.of_test(&family_weights(self.descriptions))?;
        let (prior, _) = evaluation.named("prior")?;
        let means = classes.predicted(&prior.probabilities);
        let truth = TrueNumbers {
            numbers: &of_test,
            weights: &weights,
            // The prior is the same for every sample.
            training_mean: means.first().copied().unwrap_or_default(),
        };
        let predicted = match direct {
            Some(direct) => direct.iter().map(|one| one.mean).collect(),
            None => classes.predicted(self.probabilities),
        };
        let linear = match direct {
            Some(_) => Some(number_baselines(self.descriptions, numbers, self.split)?),
            None => None,
        };
        let mut baselines = Vec::new();
        let mut best: Option<(&str, Vec<f64>, f64)> = None;
        for (baseline, _) in &evaluation.baselines {
            let of_linear = linear.iter().flatten();
            let mut of_linear = of_linear
                .filter(|(name, _)| *name == baseline.name)
                .map(|(_, predicted)| predicted.clone());
            let from_classes = || classes.predicted(&baseline.probabilities);
            let predicted = of_linear.next().unwrap_or_else(from_classes);
            let scores = NumberScores::from_predictions(&predicted, &truth)?;
            let is_better = best.as_ref().is_none_or(|best| scores.rms_error < best.2);
            // The majority names one class, which is no prediction of a number.
            if is_better && baseline.name != MAJORITY {
                best = Some((baseline.name, predicted, scores.rms_error));
            }
            baselines.push((baseline.name, scores));
        }
        let Some((name, of_best, _)) = best else {
            return refuse("there is no baseline for numbers");
        };
        let clusters = self.clusters();
        let losses = |predicted: &[f64]| truth.squares_over_variance(predicted);
        let paired = PairedLosses {
            network: &losses(&predicted),
            baseline: &losses(&of_best),
            weights: &weights,
            clusters: &clusters,
        };
        Ok(NumberEvaluation {
            advantage: Advantage::from_losses(
                name,
                paired,
                evaluation.permutation.exchanges,
                seed,
            )?,
            scores: NumberScores::from_predictions(&predicted, &truth)?,
            baselines,
            intervals: truth.intervals(&predicted, &clusters, seed)?,
            spread: direct.map(|direct| SpreadScores::from_predictions(direct, &truth)),
        })
    }

    /// Values of the samples of the test part, picked from those of all samples.
    pub(crate) fn of_test<T: Copy>(&self, all: &[T]) -> Result<Vec<T>> {
        let mut of_test = Vec::with_capacity(self.split.test.len());
        for sample in &self.split.test {
            match all.get(*sample) {
                Some(value) => of_test.push(*value),
                None => {
                    return refuse(format!("the split names sample {sample} of {}", all.len()));
                }
            }
        }
        Ok(of_test)
    }

    /// The cluster of each sample of the test part.
    fn clusters(&self) -> Vec<&str> {
        let of_test = self.split.test.iter();
        of_test
            .map(|sample| &*self.descriptions[*sample].cluster)
            .collect()
    }
}

/// True labels of the test part, and weights of its samples.
struct Truth {
    labels: Vec<usize>,
    classes: usize,
    weights: Vec<f64>,
}

impl Truth {
    /// The comparison with the baseline of the smallest log-loss.
    fn advantage(
        &self,
        predictions: &TestPredictions,
        baselines: &[(Baseline, Scores)],
        clusters: &[&str],
        exchanges: usize,
        seed: u64,
    ) -> Result<Advantage> {
        // The majority is certain of one class: where that is wrong, its loss has no meaning.
        let graded = baselines.iter().filter(|(one, _)| one.name != MAJORITY);
        let best = graded.min_by(|(_, a), (_, b)| a.log_loss_nats.total_cmp(&b.log_loss_nats));
        let Some((best, _)) = best else {
            return refuse("there is no baseline");
        };
        let losses = |probabilities: &[f64]| losses_nats(probabilities, &self.labels, self.classes);
        let paired = PairedLosses {
            network: &losses(predictions.probabilities),
            baseline: &losses(&best.probabilities),
            weights: &self.weights,
            clusters,
        };
        Advantage::from_losses(best.name, paired, exchanges, seed)
    }

    fn score(&self, probabilities: &[f64], weights: &[f64]) -> Result<Scores> {
        Scores::from_probabilities(probabilities, &self.labels, self.classes, Some(weights))
    }

    fn intervals(
        &self,
        probabilities: &[f64],
        prior: &[f64],
        clusters: &[&str],
        seed: u64,
    ) -> Result<Intervals> {
        let statistics = |drawn: &[f64]| {
            let mut weights = self.weights.clone();
            for (weight, times) in weights.iter_mut().zip(drawn) {
                *weight *= times;
            }
            match (
                self.score(probabilities, &weights),
                self.score(prior, &weights),
            ) {
                (Ok(scores), Ok(prior)) => [
                    scores.accuracy,
                    scores.balanced_accuracy,
                    scores.nats_gained_over(&prior),
                ],
                // No sample of this draw has a weight.
                _ => [f64::NAN; 3],
            }
        };
        let [accuracy, balanced_accuracy, nats_gained_over_prior] =
            bootstrap(clusters, LEVEL, RESAMPLINGS, seed, statistics)?;
        Ok(Intervals {
            accuracy,
            balanced_accuracy,
            nats_gained_over_prior,
        })
    }
}

impl Evaluation {
    /// The scores of a baseline.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) if there is none of this name.
    pub fn baseline(&self, name: &str) -> Result<&Scores> {
        self.named(name).map(|(_, scores)| scores)
    }

    fn named(&self, name: &str) -> Result<&(Baseline, Scores)> {
        match self
            .baselines
            .iter()
            .find(|(baseline, _)| baseline.name == name)
        {
            Some(entry) => Ok(entry),
            None => refuse(format!("there is no baseline {name}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Description;
    use crate::split::{Fractions, Split};

    /// A set in which every third sample is a copy of one crystal form; predictions are right with
    /// 0.8.
    fn set() -> (Vec<Description>, Vec<usize>, Split, Vec<f64>) {
        let (mut descriptions, mut labels) = (Vec::new(), Vec::new());
        for number in 0..90 {
            labels.push(number / 2 % 3);
            descriptions.push(Description {
                label: format!("{}", labels[number]),
                cluster: format!("c{}", number / 2),
                family: if number % 3 == 0 {
                    "f".into()
                } else {
                    String::new()
                },
                residues: 100.0,
                ..Description::default()
            });
        }
        let split = Split::grouped(&descriptions, 1, Fractions::default()).unwrap();
        let mut probabilities = Vec::new();
        for sample in &split.test {
            let mut p = [0.1; 3];
            p[labels[*sample]] = 0.8;
            probabilities.extend(p);
        }
        (descriptions, labels, split, probabilities)
    }

    /// The twin: each number by its own call.
    #[test]
    fn every_number_is_that_of_its_own_call() {
        let (descriptions, labels, split, probabilities) = set();
        let predictions = TestPredictions {
            descriptions: &descriptions,
            labels: &labels,
            classes: 3,
            split: &split,
            probabilities: &probabilities,
        };
        let evaluation = predictions.evaluate(50, 4).unwrap();
        let all_weights = family_weights(&descriptions);
        let truth = predictions.of_test(&labels).unwrap();
        let weights = predictions.of_test(&all_weights).unwrap();
        let own = Scores::from_probabilities(&probabilities, &truth, 3, Some(&weights)).unwrap();
        assert_eq!(evaluation.scores, own);
        assert_eq!(
            evaluation.permutation,
            permutation_test(&predictions, 50, 4).unwrap()
        );
        let names: Vec<_> = evaluation
            .baselines
            .iter()
            .map(|(own, _)| own.name)
            .collect();
        assert_eq!(
            names,
            [
                "majority",
                "prior",
                "size",
                "size_and_charge",
                "composition"
            ]
        );
        assert!(evaluation.baseline("voxels").is_err());
        let clusters = predictions.clusters();
        let accuracy = |drawn: &[f64]| {
            let weights: Vec<f64> = drawn.iter().zip(&weights).map(|(n, w)| n * w).collect();
            let scores = Scores::from_probabilities(&probabilities, &truth, 3, Some(&weights));
            [scores.map_or(f64::NAN, |scores| scores.accuracy)]
        };
        let [interval] = bootstrap(&clusters, 0.95, RESAMPLINGS, 4, accuracy).unwrap();
        assert_eq!(evaluation.intervals.accuracy, interval);
        assert_eq!(evaluation.test_clusters, split.test.len() / 2);
    }
}
