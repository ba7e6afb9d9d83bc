//! Splits into training, validation and test that keep related samples together.
//!
//! Relatives on both sides of a split let a network recognise instead of predict. So whole clusters
//! move, and labels are spread as evenly as the clusters allow.

use crate::{Description, LearnError, Result};
use protomer_kernel::random::{CounterRng, Purpose};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The samples of each part, ascending.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Split {
    /// Weights are fitted to these.
    pub training: Vec<usize>,
    /// The epoch and the temperature are chosen on these.
    pub validation: Vec<usize>,
    /// Scores are computed on these.
    pub test: Vec<usize>,
}

/// The share of the samples in each part, which sum to 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fractions {
    /// Share of the training part.
    pub training: f64,
    /// Share of the validation part.
    pub validation: f64,
    /// Share of the test part.
    pub test: f64,
}

impl Default for Fractions {
    fn default() -> Self {
        Self {
            training: 0.7,
            validation: 0.15,
            test: 0.15,
        }
    }
}

impl Split {
    /// Whole clusters in each part, labels as evenly spread as they allow.
    ///
    /// ```
    /// use protomer_learn::{Description, split::{Fractions, Split}};
    /// let sample = |number: usize| Description {
    ///     label: format!("{}", number % 2), cluster: format!("{}", number / 4), ..Description::default()
    /// };
    /// let samples: Vec<_> = (0..80).map(sample).collect();
    /// let split = Split::grouped(&samples, 1, Fractions::default()).unwrap();
    /// assert_eq!((split.training.len(), split.validation.len(), split.test.len()), (56, 12, 12));
    /// ```
    ///
    /// # Errors
    /// [`LearnError::Sample`] for a sample without a cluster; [`LearnError::Settings`] if fractions
    /// do not sum to 1 or clusters are too few to fill every part.
    pub fn grouped(descriptions: &[Description], seed: u64, fractions: Fractions) -> Result<Self> {
        Self::of(&clusters(descriptions)?, descriptions, seed, fractions)
    }

    /// Every sample on its own, relatives on both sides: what leakage brings is the difference to
    /// [`Split::grouped`].
    ///
    /// # Errors
    /// As [`Split::grouped`].
    pub fn random(descriptions: &[Description], seed: u64, fractions: Fractions) -> Result<Self> {
        let groups: Vec<_> = (0..descriptions.len()).map(|sample| vec![sample]).collect();
        Self::of(&groups, descriptions, seed, fractions)
    }

    /// `count` grouped splits: each cluster is tested once, validates once, and trains otherwise.
    ///
    /// # Errors
    /// As [`Split::grouped`]; `count` must be 3 or more.
    pub fn folds(descriptions: &[Description], seed: u64, count: usize) -> Result<Vec<Self>> {
        if count < 3 {
            return Err(LearnError::Settings(format!(
                "{count} folds: one tests and one validates, so take 3 or more"
            )));
        }
        let parts = assign(
            &clusters(descriptions)?,
            descriptions,
            seed,
            &vec![1.0 / count as f64; count],
        )?;
        let split = |fold: usize| {
            let next = (fold + 1) % count;
            let mut training: Vec<_> = (0..count)
                .filter(|part| *part != fold && *part != next)
                .flat_map(|part| parts[part].clone())
                .collect();
            training.sort_unstable();
            Self {
                training,
                validation: parts[next].clone(),
                test: parts[fold].clone(),
            }
        };
        Ok((0..count).map(split).collect())
    }

    fn of(
        groups: &[Vec<usize>],
        descriptions: &[Description],
        seed: u64,
        fractions: Fractions,
    ) -> Result<Self> {
        let shares = [fractions.training, fractions.validation, fractions.test];
        let mut parts = assign(groups, descriptions, seed, &shares)?.into_iter();
        let mut part = || parts.next().unwrap_or_default();
        Ok(Self {
            training: part(),
            validation: part(),
            test: part(),
        })
    }

    /// Whether every index exists and none stands in two parts.
    ///
    /// # Errors
    /// [`LearnError::Settings`] names the index.
    pub fn check(&self, samples: usize) -> Result<()> {
        let mut seen = vec![false; samples];
        for index in self
            .training
            .iter()
            .chain(&self.validation)
            .chain(&self.test)
        {
            match seen.get_mut(*index) {
                Some(seen) if !*seen => *seen = true,
                Some(_) => {
                    return Err(LearnError::Settings(format!(
                        "sample {index} is in the split twice"
                    )));
                }
                None => {
                    return Err(LearnError::Settings(format!(
                        "the split names sample {index} of {samples}"
                    )));
                }
            }
        }
        Ok(())
    }
}

/// The weight of each sample, one over the size of its family: copies of one crystal form count
/// once together.
///
/// A sample without a family has the weight 1.
pub fn family_weights(descriptions: &[Description]) -> Vec<f64> {
    let mut sizes = BTreeMap::new();
    for description in descriptions {
        *sizes.entry(description.family.as_str()).or_insert(0_usize) += 1;
    }
    let weight = |family: &str| match sizes.get(family) {
        Some(size) if !family.is_empty() => 1.0 / *size as f64,
        _ => 1.0,
    };
    descriptions
        .iter()
        .map(|description| weight(&description.family))
        .collect()
}

/// The samples of each cluster, clusters by name.
///
/// # Errors
/// [`LearnError::Sample`] for a sample without a cluster.
pub(crate) fn clusters(descriptions: &[Description]) -> Result<Vec<Vec<usize>>> {
    let mut clusters = BTreeMap::<&str, Vec<usize>>::new();
    for (sample, description) in descriptions.iter().enumerate() {
        if description.cluster.is_empty() {
            let reason = "it has no cluster; if nothing in the set is related to it, name the cluster after the sample";
            return Err(LearnError::Sample {
                name: description.name.clone(),
                reason: reason.into(),
            });
        }
        clusters
            .entry(&description.cluster)
            .or_default()
            .push(sample);
    }
    Ok(clusters.into_values().collect())
}

/// Distributes groups over parts, largest first, each to the part p where it lowers most
///
/// E = Σ_p [ Σ_k (n_pk - f_p N_k)² / N_k + K (n_p - f_p N)² / N ]
///
/// with n_pk samples of the label k in the part p, N_k in all, K labels, and f_p the share the part
/// should have. Adding c_k samples lowers a term by c (2 (f N - n) - c) / N. Groups of one size go
/// in a random order.
fn assign(
    groups: &[Vec<usize>],
    descriptions: &[Description],
    seed: u64,
    shares: &[f64],
) -> Result<Vec<Vec<usize>>> {
    let usable = shares.iter().all(|share| (0.0..=1.0).contains(share));
    if !usable || (shares.iter().sum::<f64>() - 1.0).abs() > 1e-9 {
        return Err(LearnError::Settings(format!(
            "the shares {shares:?} of a split must be 0 to 1 and sum to 1"
        )));
    }
    let mut numbers = BTreeMap::new();
    for description in descriptions {
        numbers.entry(description.label.as_str()).or_insert(0);
    }
    for (number, entry) in numbers.values_mut().enumerate() {
        *entry = number;
    }
    let classes = numbers.len();
    // The last column counts all samples, with the weight K.
    let count = |samples: &[usize]| {
        let mut counts = vec![0.0; classes + 1];
        for sample in samples {
            if let Some(class) = numbers.get(descriptions[*sample].label.as_str()) {
                counts[*class] += 1.0;
            }
            counts[classes] += 1.0;
        }
        counts
    };
    let all: Vec<usize> = (0..descriptions.len()).collect();
    let total = count(&all);
    let mut order: Vec<usize> = (0..groups.len()).collect();
    shuffle(
        &mut order,
        &mut CounterRng::for_purpose(seed, 0, 0, Purpose::Split),
    );
    order.sort_by_key(|group| std::cmp::Reverse(groups[*group].len()));

    let mut filled = vec![vec![0.0; classes + 1]; shares.len()];
    let mut parts = vec![Vec::new(); shares.len()];
    for group in order {
        let added = count(&groups[group]);
        let gain = |part: usize| {
            let term = |column: usize| {
                let weight = if column == classes {
                    classes as f64
                } else {
                    1.0
                };
                let shortage = shares[part] * total[column] - filled[part][column];
                weight * added[column] * (2.0 * shortage - added[column])
                    / f64::max(total[column], 1.0)
            };
            (0..=classes).map(term).sum::<f64>()
        };
        let gains: Vec<f64> = (0..shares.len()).map(gain).collect();
        let mut best = None;
        for part in (0..shares.len()).filter(|part| shares[*part] > 0.0) {
            if best.is_none_or(|best: usize| gains[part] > gains[best] + 1e-12) {
                best = Some(part);
            }
        }
        let Some(part) = best else { continue };
        for (filled, added) in filled[part].iter_mut().zip(added) {
            *filled += added;
        }
        parts[part].extend_from_slice(&groups[group]);
    }
    for (part, share) in parts.iter_mut().zip(shares) {
        if part.is_empty() && *share > 0.0 {
            let reason = format!(
                "{} groups are too few for the shares {shares:?}: a part stays empty; take more of them, or other shares",
                groups.len()
            );
            return Err(LearnError::Settings(reason));
        }
        part.sort_unstable();
    }
    Ok(parts)
}

/// A uniformly random order (Fisher and Yates).
pub(crate) fn shuffle<T>(items: &mut [T], rng: &mut CounterRng) {
    for last in (1..items.len()).rev() {
        items.swap(last, rng.index(last + 1));
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::collections::BTreeSet;

    /// Clusters of 1 to 7 samples, three labels of shares near 0.5, 0.3, 0.2; members of a cluster
    /// may differ in label.
    fn set(count: usize) -> Vec<Description> {
        let mut rng = CounterRng::new(4, 0, 0);
        let mut samples = Vec::new();
        for cluster in 0..count {
            for _ in 0..=rng.index(7) {
                let label =
                    ["a", "a", "a", "a", "a", "b", "b", "b", "c", "c"][rng.index(10)].to_string();
                samples.push(Description {
                    label,
                    cluster: format!("c{cluster}"),
                    ..Description::default()
                });
            }
        }
        samples
    }

    fn names<'a>(samples: &'a [Description], part: &[usize]) -> BTreeSet<&'a str> {
        part.iter()
            .map(|sample| samples[*sample].cluster.as_str())
            .collect()
    }

    #[test]
    fn clusters_stay_together_and_labels_are_spread() {
        let samples = set(200);
        let fractions = Fractions {
            training: 0.6,
            validation: 0.15,
            test: 0.25,
        };
        let split = Split::grouped(&samples, 3, fractions).unwrap();
        let parts = [&split.training, &split.validation, &split.test];
        let mut all: Vec<usize> = parts.iter().flat_map(|part| part.iter().copied()).collect();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..samples.len()));
        for (first, second) in [(0, 1), (0, 2), (1, 2)] {
            assert!(names(&samples, parts[first]).is_disjoint(&names(&samples, parts[second])));
        }
        for label in ["a", "b", "c"] {
            let of = |part: &[usize]| {
                part.iter()
                    .filter(|sample| samples[**sample].label == label)
                    .count() as f64
            };
            let total = samples
                .iter()
                .filter(|sample| sample.label == label)
                .count() as f64;
            for (part, share) in parts.iter().zip([0.6, 0.15, 0.25]) {
                assert!(
                    (of(part) - share * total).abs() < 2.5,
                    "{label}: {} of {total}",
                    of(part)
                );
            }
        }
    }

    #[test]
    fn the_seed_decides_and_nothing_else() {
        let samples = set(60);
        let split = |seed| Split::grouped(&samples, seed, Fractions::default()).unwrap();
        assert_eq!(split(1), split(1));
        assert_ne!(split(1), split(2));
    }

    #[test]
    fn a_random_split_separates_relatives() {
        let samples = set(60);
        let split = Split::random(&samples, 1, Fractions::default()).unwrap();
        split.check(samples.len()).unwrap();
        assert!(!names(&samples, &split.training).is_disjoint(&names(&samples, &split.test)));
    }

    #[test]
    fn every_fold_tests_each_sample_once() {
        let samples = set(60);
        let folds = Split::folds(&samples, 5, 4).unwrap();
        let mut tested: Vec<usize> = folds.iter().flat_map(|fold| fold.test.clone()).collect();
        tested.sort_unstable();
        assert!(tested.into_iter().eq(0..samples.len()));
        for fold in &folds {
            fold.check(samples.len()).unwrap();
            assert_eq!(
                fold.training.len() + fold.validation.len() + fold.test.len(),
                samples.len()
            );
            assert!(names(&samples, &fold.training).is_disjoint(&names(&samples, &fold.test)));
            assert!(names(&samples, &fold.validation).is_disjoint(&names(&samples, &fold.test)));
        }
    }

    #[test]
    fn labels_seen_once_still_fill_every_part() {
        let sample = |number: usize| Description {
            label: number.to_string(),
            cluster: number.to_string(),
            ..Description::default()
        };
        let samples: Vec<_> = (0..20).map(sample).collect();
        let split = Split::grouped(
            &samples,
            1,
            Fractions {
                training: 0.8,
                validation: 0.1,
                test: 0.1,
            },
        )
        .unwrap();
        assert_eq!(
            (
                split.training.len(),
                split.validation.len(),
                split.test.len()
            ),
            (16, 2, 2)
        );
    }

    #[test]
    fn families_share_a_weight() {
        let sample = |family: &str| Description {
            family: family.into(),
            ..Description::default()
        };
        let samples = [
            sample("f"),
            sample(""),
            sample("f"),
            sample(""),
            sample("g"),
        ];
        assert_eq!(family_weights(&samples), [0.5, 1.0, 0.5, 1.0, 1.0]);
    }

    #[test]
    fn what_cannot_be_split_is_refused() {
        let samples = set(2);
        assert!(
            Split::grouped(&samples, 1, Fractions::default())
                .unwrap_err()
                .to_string()
                .contains("too few")
        );
        let shares = Fractions {
            training: 0.7,
            validation: 0.7,
            test: -0.4,
        };
        assert!(Split::grouped(&set(9), 1, shares).is_err());
        let lone = [Description {
            name: "x".into(),
            ..Description::default()
        }];
        assert!(
            Split::grouped(&lone, 1, Fractions::default())
                .unwrap_err()
                .to_string()
                .contains("no cluster")
        );
        assert!(Split::folds(&set(9), 1, 2).is_err());
        let twice = Split {
            training: vec![0],
            validation: vec![0],
            test: vec![],
        };
        assert!(twice.check(2).is_err());
    }
}
