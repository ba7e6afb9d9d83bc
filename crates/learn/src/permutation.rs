//! Could the score be chance? Labels are permuted between clusters and a cheap head is fitted again
//! and again.

use crate::baselines::regression;
use crate::logistic::{Table, prior};
use crate::scores::Scores;
use crate::split::{Split, clusters, shuffle};
use crate::{Description, LearnError, Result};
use protomer_kernel::random::{CounterRng, Purpose};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The outcome of a permutation test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PermutationTest {
    /// Nats gained over the prior on the test part, with the labels as they are.
    pub observed_nats: f64,
    /// The same for each permutation.
    pub permuted_nats: Vec<f64>,
    /// (1 + permutations that do as well) / (1 + permutations): the chance of such a score if
    /// labels mean nothing.
    pub p_value: f64,
    /// Share of samples in clusters that have another of their size, whose labels can move.
    pub movable: f64,
}

/// Labels with the lists of whole clusters exchanged, among clusters of one part and one size.
///
/// These exchanges form a group under which data without signal look the same, so the test is
/// exact; each part keeps its counts of labels. A cluster alone in its size keeps its labels, which
/// can only make the test more cautious.
pub fn permute_labels(
    descriptions: &[Description],
    labels: &[usize],
    split: &Split,
    seed: u64,
    number: u64,
) -> Result<Vec<usize>> {
    let mut rng = CounterRng::for_purpose(seed, 0, number, Purpose::Permutation);
    let mut permuted = labels.to_vec();
    for group in exchangeable(descriptions, labels.len(), split)? {
        let mut order: Vec<usize> = (0..group.len()).collect();
        shuffle(&mut order, &mut rng);
        for (to, from) in group.iter().zip(order) {
            for (to, from) in to.iter().zip(&group[from]) {
                permuted[*to] = labels[*from];
            }
        }
    }
    Ok(permuted)
}

/// Share of the test part's samples in clusters that have another of their size there, whose labels
/// can move.
///
/// # Errors
/// [`LearnError::Settings`] if the split does not fit; [`LearnError::Sample`] for a sample without
/// a cluster.
pub fn movable_share(descriptions: &[Description], split: &Split) -> Result<f64> {
    let test = Split {
        training: Vec::new(),
        validation: Vec::new(),
        test: split.test.clone(),
    };
    Ok(movable(&exchangeable(
        descriptions,
        descriptions.len(),
        &test,
    )?))
}

fn movable(groups: &[Vec<Vec<usize>>]) -> f64 {
    let count = |least: usize| {
        groups
            .iter()
            .filter(|group| group.len() >= least)
            .flatten()
            .map(Vec::len)
            .sum::<usize>() as f64
    };
    count(2) / count(1).max(1.0)
}

/// Clusters that may exchange labels: those with the same number of samples in the same part.
fn exchangeable(
    descriptions: &[Description],
    labels: usize,
    split: &Split,
) -> Result<Vec<Vec<Vec<usize>>>> {
    split.check(labels)?;
    if descriptions.len() != labels {
        return Err(LearnError::Settings(format!(
            "{} descriptions for {labels} labels",
            descriptions.len()
        )));
    }
    let mut part_of = vec![3; labels];
    for (part, samples) in [&split.training, &split.validation, &split.test]
        .into_iter()
        .enumerate()
    {
        samples.iter().for_each(|sample| part_of[*sample] = part);
    }
    let mut groups = BTreeMap::<(usize, usize), Vec<Vec<usize>>>::new();
    for cluster in clusters(descriptions)? {
        for part in 0..3 {
            let members: Vec<usize> = cluster
                .iter()
                .copied()
                .filter(|sample| part_of[*sample] == part)
                .collect();
            if !members.is_empty() {
                groups
                    .entry((part, members.len()))
                    .or_default()
                    .push(members);
            }
        }
    }
    Ok(groups.into_values().collect())
}

/// Tests whether the features of `table` (for instance a network's, before its last layer) tell
/// classes apart: the head is multinomial logistic regression, fitted anew for every permutation.
///
/// # Errors
/// [`LearnError::Settings`] if shapes disagree or a part is empty; [`LearnError::Sample`] for a
/// sample without a cluster.
pub fn permutation_test(
    table: Table,
    descriptions: &[Description],
    labels: &[usize],
    classes: usize,
    split: &Split,
    permutations: usize,
    seed: u64,
) -> Result<PermutationTest> {
    let gained = |labels: &[usize]| {
        let truth: Vec<usize> = split.test.iter().map(|sample| labels[*sample]).collect();
        let p = regression(table, labels, classes, None, split)?;
        let prior = prior(&split.training, labels, None, classes).repeat(truth.len());
        Ok(Scores::of(&p, &truth, classes, None)?
            .nats_gained_over(&Scores::of(&prior, &truth, classes, None)?))
    };
    let movable = movable(&exchangeable(descriptions, labels.len(), split)?);
    let observed_nats = gained(labels)?;
    let permuted =
        |number: u64| gained(&permute_labels(descriptions, labels, split, seed, number)?);
    let permuted_nats = (0..permutations as u64)
        .into_par_iter()
        .map(permuted)
        .collect::<Result<Vec<f64>>>()?;
    let as_good = permuted_nats
        .iter()
        .filter(|nats| **nats >= observed_nats)
        .count();
    let p_value = (1 + as_good) as f64 / (1 + permutations) as f64;
    Ok(PermutationTest {
        observed_nats,
        permuted_nats,
        p_value,
        movable,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::split::Fractions;

    /// Clusters of 1 to 3 samples with one label each; the feature follows the label with the given
    /// strength.
    fn set(strength: f64, seed: u64) -> (Vec<f64>, Vec<Description>, Vec<usize>) {
        let mut rng = CounterRng::new(seed, 0, 0);
        let (mut features, mut descriptions, mut labels) = (Vec::new(), Vec::new(), Vec::new());
        for cluster in 0..90 {
            let label = rng.index(3);
            let centre = strength * label as f64 + rng.uniform_in(-1.0, 1.0);
            for _ in 0..=rng.index(3) {
                features.extend([centre + rng.uniform_in(-0.1, 0.1), rng.uniform()]);
                labels.push(label);
                let (label, cluster) = (label.to_string(), cluster.to_string());
                descriptions.push(Description {
                    label,
                    cluster,
                    ..Description::default()
                });
            }
        }
        (features, descriptions, labels)
    }

    fn test(strength: f64, seed: u64, permutations: usize) -> PermutationTest {
        let (features, descriptions, labels) = set(strength, seed);
        let split = Split::grouped(&descriptions, 2, Fractions::default()).unwrap();
        let table = Table {
            features: &features,
            columns: 2,
        };
        permutation_test(table, &descriptions, &labels, 3, &split, permutations, 5).unwrap()
    }

    #[test]
    fn a_signal_is_found_and_its_absence_too() {
        let found = test(1.0, 1, 39);
        assert!(
            found.observed_nats > 0.2 && found.p_value == 1.0 / 40.0,
            "{found:?}"
        );
        // Without signal p is uniform: its mean over 12 sets is 0.5 ± 0.083.
        let mean = (0..12)
            .map(|seed| test(0.0, 100 + seed, 19).p_value)
            .sum::<f64>()
            / 12.0;
        assert!((0.25..0.75).contains(&mean), "{mean}");
    }

    #[test]
    fn whole_clusters_exchange_labels_within_a_part() {
        let (_, descriptions, labels) = set(0.0, 3);
        let split = Split::grouped(&descriptions, 2, Fractions::default()).unwrap();
        let permuted = permute_labels(&descriptions, &labels, &split, 1, 0).unwrap();
        assert_ne!(permuted, labels);
        assert_ne!(
            permuted,
            permute_labels(&descriptions, &labels, &split, 1, 1).unwrap()
        );
        for (first, second) in descriptions
            .iter()
            .zip(&permuted)
            .zip(descriptions.iter().zip(&permuted).skip(1))
        {
            assert!(first.0.cluster != second.0.cluster || first.1 == second.1);
        }
        for part in [&split.training, &split.validation, &split.test] {
            let sorted = |labels: &[usize]| {
                let mut of: Vec<usize> = part.iter().map(|sample| labels[*sample]).collect();
                of.sort_unstable();
                of
            };
            assert_eq!(sorted(&permuted), sorted(&labels));
        }
    }
}
