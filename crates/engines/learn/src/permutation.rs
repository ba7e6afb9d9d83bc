//! Could the score be chance? Labels are exchanged between clusters of the test part, and the same
//! predictions are scored again and again.

use crate::predictions::TestPredictions;
use crate::scores::Scores;
use crate::split::{Split, clusters, shuffle};
use crate::{Description, Result};
use protomer_kernel::random::{CounterRng, Purpose};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Log-losses closer than this are equal: a sum may differ in its last digit.
const EQUAL: f64 = 1e-12;
/// The number of the test part among the parts.
const TEST: usize = 2;

/// The outcome of a permutation test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PermutationTest {
    /// (1 + exchanges under which the predictions do as well) / (1 + exchanges): the chance of such
    /// a score if labels mean nothing.
    pub p_value: f64,
    /// Exchanges that were tried.
    pub exchanges: usize,
    /// Share of the test part's samples whose clusters have another of their size there, so that
    /// their labels can move. Near 0 the test cannot tell anything.
    pub movable: f64,
}

/// Tests whether predictions go with the labels of the test part.
///
/// In every exchange, clusters of one size in one part swap their labels as whole lists. These
/// exchanges form a group under which data without signal look the same, so the test is exact for
/// predictions that have seen no label of the test part. A cluster that is alone in its size keeps
/// its labels, which can only make the test more cautious. Each sample counts once.
///
/// No network is fitted again: the test does not ask how often a training on exchanged labels would
/// do as well.
///
/// ```
/// use protomer_learn::Description;
/// use protomer_learn::predictions::TestPredictions;
/// use protomer_learn::permutation::permutation_test;
/// use protomer_learn::split::Split;
///
/// let mut descriptions = Vec::new();
/// for number in 0..12 {
///     descriptions.push(Description { cluster: format!("c{number}"), ..Description::default() });
/// }
/// let labels: Vec<usize> = (0..12).map(|sample| sample % 2).collect();
/// let split = Split { test: (0..12).collect(), ..Split::default() };
/// let predictions = TestPredictions {
///     descriptions: &descriptions,
///     labels: &labels,
///     classes: 2,
///     split: &split,
///     probabilities: &[0.9, 0.1, 0.1, 0.9].repeat(6),
/// };
/// let test = permutation_test(&predictions, 199, 1)?;
/// assert!(test.p_value < 0.05, "all twelve are right");
/// assert_eq!(test.movable, 1.0);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
///
/// # Errors
/// [`LearnError::Settings`](crate::LearnError::Settings) if shapes disagree or the test part is
/// empty, [`LearnError::Sample`](crate::LearnError::Sample) for a sample without a cluster.
pub fn permutation_test(
    predictions: &TestPredictions,
    exchanges: usize,
    seed: u64,
) -> Result<PermutationTest> {
    let clusters = Exchangeable::new(predictions.descriptions, predictions.split)?;
    // Without weights: they belong to the true labels and would have to move with them.
    let loss = |labels: &[usize]| {
        let truth = predictions.of_test(labels)?;
        let scores = Scores::from_probabilities(
            predictions.probabilities,
            &truth,
            predictions.classes,
            None,
        )?;
        Ok(scores.log_loss_nats)
    };
    let observed = loss(predictions.labels)?;
    let losses = (0..exchanges as u64)
        .into_par_iter()
        .map(|number| loss(&clusters.exchange(predictions.labels, seed, number)))
        .collect::<Result<Vec<f64>>>()?;
    let as_good = losses
        .iter()
        // Counting from just above the observed: an exchange that changes
        // nothing must count as being as good, whatever the order of its sum.
        .filter(|loss| **loss <= observed * (1.0 + EQUAL))
        .count();
    Ok(PermutationTest {
        // The observed order is one of the possible ones, so the p-value is never 0.
        p_value: (1 + as_good) as f64 / (1 + exchanges) as f64,
        exchanges,
        movable: clusters.movable(TEST),
    })
}

/// Clusters that may exchange labels.
struct Exchangeable {
    /// The samples of each cluster, by part of the split and number of samples there.
    groups: BTreeMap<(usize, usize), Vec<Vec<usize>>>,
}

impl Exchangeable {
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) if the split does not fit,
    /// [`LearnError::Sample`](crate::LearnError::Sample) for a sample without a cluster.
    fn new(descriptions: &[Description], split: &Split) -> Result<Self> {
        split.check(descriptions.len())?;
        let mut part_of = vec![None; descriptions.len()];
        let parts = [&split.training, &split.validation, &split.test];
        for (part, samples) in parts.into_iter().enumerate() {
            for sample in samples {
                part_of[*sample] = Some(part);
            }
        }
        let mut groups = BTreeMap::<_, Vec<Vec<usize>>>::new();
        for cluster in clusters(descriptions)? {
            // A cluster that the split cuts exchanges each part apart: labels must not cross parts.
            for part in 0..parts.len() {
                let mut members = cluster.clone();
                members.retain(|sample| part_of[*sample] == Some(part));
                if !members.is_empty() {
                    groups
                        // Only clusters of one size can exchange whole
                        // lists without changing the counts of labels.
                        .entry((part, members.len()))
                        .or_default()
                        .push(members);
                }
            }
        }
        Ok(Self { groups })
    }

    /// Labels with the lists of whole clusters exchanged. Each part keeps its counts of labels.
    fn exchange(&self, labels: &[usize], seed: u64, number: u64) -> Vec<usize> {
        let mut random = CounterRng::for_purpose(seed, 0, number, Purpose::Permutation);
        let mut exchanged = labels.to_vec();
        // From `labels`, not `exchanged`: every list is read before any is overwritten.
        for group in self.groups.values() {
            let mut order: Vec<usize> = (0..group.len()).collect();
            shuffle(&mut order, &mut random);
            for (to, from) in group.iter().zip(order) {
                for (to, from) in to.iter().zip(&group[from]) {
                    exchanged[*to] = labels[*from];
                }
            }
        }
        exchanged
    }

    /// Share of a part's samples in clusters that have another of their size there.
    fn movable(&self, part: usize) -> f64 {
        let (mut movable, mut all) = (0, 0);
        for ((of_part, size), group) in &self.groups {
            if *of_part == part {
                let samples = size * group.len();
                all += samples;
                // A group with a single cluster can only exchange with itself.
                movable += if group.len() > 1 { samples } else { 0 };
            }
        }
        movable as f64 / f64::max(all as f64, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::logistic::{Logistic, Table};
    use crate::split::Fractions;

    /// Clusters of 1 to 3 samples with one label each; the feature follows the label with the given
    /// strength.
    fn set(strength: f64, seed: u64) -> (Vec<f64>, Vec<Description>, Vec<usize>) {
        let mut random = CounterRng::new(seed, 0, 0);
        let (mut features, mut descriptions, mut labels) = (Vec::new(), Vec::new(), Vec::new());
        for cluster in 0..90 {
            let label = random.index(3);
            let centre = strength * label as f64 + random.uniform_in(-1.0, 1.0);
            for _ in 0..=random.index(3) {
                features.extend([centre + random.uniform_in(-0.1, 0.1), random.uniform()]);
                labels.push(label);
                descriptions.push(Description {
                    label: label.to_string(),
                    cluster: cluster.to_string(),
                    ..Description::default()
                });
            }
        }
        (features, descriptions, labels)
    }

    fn split(descriptions: &[Description]) -> Split {
        Split::grouped(descriptions, 2, Fractions::default()).unwrap()
    }

    /// The test of a regression fitted to the training part.
    fn test(strength: f64, seed: u64, exchanges: usize) -> PermutationTest {
        let (features, descriptions, labels) = set(strength, seed);
        let split = split(&descriptions);
        let table = Table {
            features: &features,
            columns: 2,
        };
        let fit = Logistic::fit(table, &split.training, &labels, None, 3, 0.01).unwrap();
        let predictions = TestPredictions {
            descriptions: &descriptions,
            labels: &labels,
            classes: 3,
            split: &split,
            probabilities: &fit.probabilities(table, &split.test).unwrap(),
        };
        permutation_test(&predictions, exchanges, 5).unwrap()
    }

    #[test]
    fn a_signal_is_found_and_its_absence_too() {
        assert_eq!(test(1.0, 1, 39).p_value, 1.0 / 40.0);
        // Without signal p is uniform: its mean over 40 sets is 0.5 ± 0.046.
        let mut sum = 0.0;
        for seed in 0..40 {
            sum += test(0.0, 100 + seed, 19).p_value;
        }
        assert!((0.36..0.64).contains(&(sum / 40.0)), "{}", sum / 40.0);
    }

    /// The chance of a score as good follows from all exchanges of four clusters.
    #[test]
    fn few_clusters_have_the_p_value_of_all_their_exchanges() {
        let mut descriptions = Vec::new();
        for cluster in 0..4 {
            descriptions.push(Description {
                cluster: cluster.to_string(),
                ..Description::default()
            });
        }
        let split = Split {
            test: vec![0, 1, 2, 3],
            ..Split::default()
        };
        let predictions = TestPredictions {
            descriptions: &descriptions,
            labels: &[0, 0, 1, 1],
            classes: 2,
            split: &split,
            probabilities: &[0.9, 0.1, 0.8, 0.2, 0.3, 0.7, 0.4, 0.6],
        };
        // The labels are already in the best of the 6 orders.
        let found = permutation_test(&predictions, 6000, 1).unwrap();
        assert!((found.p_value - 1.0 / 6.0).abs() < 0.02, "{found:?}");
    }

    #[test]
    fn predictions_that_tell_nothing_apart_are_as_good_under_every_exchange() {
        let (_, descriptions, labels) = set(0.0, 3);
        let split = split(&descriptions);
        let predictions = TestPredictions {
            descriptions: &descriptions,
            labels: &labels,
            classes: 3,
            split: &split,
            probabilities: &[0.5, 0.3, 0.2].repeat(split.test.len()),
        };
        assert_eq!(permutation_test(&predictions, 50, 1).unwrap().p_value, 1.0);
    }

    #[test]
    fn whole_clusters_exchange_labels_within_a_part() {
        let (_, descriptions, labels) = set(0.0, 3);
        let split = split(&descriptions);
        let clusters = Exchangeable::new(&descriptions, &split).unwrap();
        let exchanged = clusters.exchange(&labels, 1, 0);
        assert_ne!(exchanged, labels);
        assert_ne!(exchanged, clusters.exchange(&labels, 1, 1));
        for i in 1..labels.len() {
            let same_cluster = descriptions[i].cluster == descriptions[i - 1].cluster;
            assert!(!same_cluster || exchanged[i] == exchanged[i - 1]);
        }
        for part in [&split.training, &split.validation, &split.test] {
            let sorted = |labels: &[usize]| {
                let mut of_part: Vec<usize> = part.iter().map(|sample| labels[*sample]).collect();
                of_part.sort_unstable();
                of_part
            };
            assert_eq!(sorted(&exchanged), sorted(&labels));
        }
    }

    #[test]
    fn a_cluster_alone_in_its_size_does_not_move() {
        let cluster = |name: &str| Description {
            cluster: name.into(),
            ..Description::default()
        };
        let descriptions = ["a", "b", "c", "c"].map(cluster);
        let split = Split {
            test: vec![0, 1, 2, 3],
            ..Split::default()
        };
        let clusters = Exchangeable::new(&descriptions, &split).unwrap();
        assert_eq!(clusters.movable(TEST), 0.5);
        for number in 0..20 {
            assert_eq!(clusters.exchange(&[0, 1, 2, 3], 1, number)[2..], [2, 3]);
        }
    }
}
