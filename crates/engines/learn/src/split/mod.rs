//! Splits into training, validation and test that keep related samples together.
//!
//! With relatives on both sides of a split, a network can recognise instead of predict. So whole
//! clusters move, and labels are spread as evenly as the clusters allow.

mod assign;
mod ranks;

pub use ranks::{Ranks, ranks};

use crate::error::refuse;
use crate::{Description, LearnError, Result};
use protomer_kernel::random::{CounterRng, Purpose};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// The samples of each part, ascending.
///
/// ```
/// use protomer_learn::Description;
/// use protomer_learn::split::{Fractions, Split};
///
/// let mut samples = Vec::new();
/// for number in 0..80 {
///     samples.push(Description {
///         label: format!("{}", number % 2),
///         cluster: format!("{}", number / 4),
///         ..Description::default()
///     });
/// }
/// let split = Split::grouped(&samples, 1, Fractions::default())?;
/// assert_eq!([split.training.len(), split.validation.len(), split.test.len()], [56, 12, 12]);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Split {
    /// Samples to which weights are fitted.
    pub training: Vec<usize>,
    /// Samples on which the epoch and the temperature are chosen.
    pub validation: Vec<usize>,
    /// Samples on which scores are computed.
    pub test: Vec<usize>,
}

/// The share of the samples in each part. Shares sum to 1.
///
/// ```
/// use protomer_learn::split::Fractions;
///
/// let usual = Fractions::default();
/// assert_eq!((usual.training, usual.validation, usual.test), (0.7, 0.15, 0.15));
/// ```
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
    /// Split with whole clusters in each part, labels as evenly spread as the clusters allow.
    ///
    /// # Errors
    /// [`LearnError::Sample`] for a sample without a cluster. [`LearnError::Settings`] if fractions
    /// do not sum to 1 or clusters are too few to fill every part.
    pub fn grouped(descriptions: &[Description], seed: u64, fractions: Fractions) -> Result<Self> {
        let labels = ranks(descriptions.iter().map(|description| &description.label));
        Self::of_groups(&clusters(descriptions)?, &labels, seed, fractions)
    }

    /// The split of [`Split::grouped`] by the [`ranks`] of the labels and clusters among their
    /// names: all it depends on, in a fraction of the memory.
    ///
    /// ```
    /// use protomer_learn::split::{Fractions, Split, ranks};
    ///
    /// let labels = ranks((0..80).map(|number| number % 2));
    /// let clusters = ranks((0..80).map(|number| number / 4));
    /// let split = Split::by_ranks(&labels, &clusters, 1, Fractions::default())?;
    /// assert_eq!([split.training.len(), split.validation.len(), split.test.len()], [56, 12, 12]);
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    ///
    /// # Errors
    /// [`LearnError::Settings`] as for [`Split::grouped`], and if there are not as many labels as
    /// clusters.
    pub fn by_ranks(
        labels: &[u32],
        clusters: &[u32],
        seed: u64,
        fractions: Fractions,
    ) -> Result<Self> {
        if labels.len() != clusters.len() {
            let (labels, clusters) = (labels.len(), clusters.len());
            return refuse(format!(
                "{labels} labels and {clusters} clusters; give both of each sample"
            ));
        }
        let mut samples: Vec<usize> = (0..clusters.len()).collect();
        samples.sort_by_key(|sample| clusters[*sample]);
        let groups = samples.chunk_by(|one, other| clusters[*one] == clusters[*other]);
        let groups: Vec<&[usize]> = groups.collect();
        Self::of_groups(&groups, labels, seed, fractions)
    }

    /// Split of the samples one by one, with relatives on both sides. The difference to
    /// [`Split::grouped`] shows what leaks.
    ///
    /// ```
    /// use protomer_learn::controls::{Control, Variant};
    /// use protomer_learn::split::{Fractions, Split};
    ///
    /// // Sixteen orientations of each protein, which are a cluster.
    /// let set = Control::Identity.samples(Variant::Usual, 320, 16, 1);
    /// let split = Split::random(&set.descriptions, 1, Fractions::default())?;
    /// let cluster = |sample: &usize| &set.descriptions[*sample].cluster;
    /// let tested = cluster(&split.test[0]);
    /// assert!(split.training.iter().any(|sample| cluster(sample) == tested));
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    ///
    /// # Errors
    /// [`LearnError::Settings`] as for [`Split::grouped`].
    pub fn random(descriptions: &[Description], seed: u64, fractions: Fractions) -> Result<Self> {
        let alone: Vec<_> = (0..descriptions.len()).map(|sample| vec![sample]).collect();
        let labels = ranks(descriptions.iter().map(|description| &description.label));
        Self::of_groups(&alone, &labels, seed, fractions)
    }

    fn of_groups(
        groups: &[impl AsRef<[usize]>],
        labels: &[u32],
        seed: u64,
        fractions: Fractions,
    ) -> Result<Self> {
        let shares = [fractions.training, fractions.validation, fractions.test];
        let [training, validation, test] = assign::assign(groups, labels, seed, shares)?;
        Ok(Self {
            training,
            validation,
            test,
        })
    }

    /// The samples of a share of the clusters of the training part, ascending. Of one seed, a larger share
    /// contains a smaller one.
    ///
    /// ```
    /// use protomer_learn::Description;
    /// use protomer_learn::split::Split;
    ///
    /// let member = |number: usize| Description { cluster: format!("{}", number / 2), ..Description::default() };
    /// let samples: Vec<_> = (0..40).map(member).collect();
    /// let split = Split { training: (0..40).collect(), ..Split::default() };
    /// let (half, quarter) = (split.share_of_training(&samples, 0.5, 1)?, split.share_of_training(&samples, 0.25, 1)?);
    /// assert_eq!((half.len(), quarter.len()), (20, 10));
    /// assert!(quarter.iter().all(|sample| half.contains(sample)));
    /// assert!(split.share_of_training(&samples, 0.0, 1).is_err());
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    ///
    /// # Errors
    /// [`LearnError::Settings`] for a share that is not above 0 and at most 1, or that leaves no cluster.
    pub fn share_of_training(
        &self,
        descriptions: &[Description],
        share: f64,
        seed: u64,
    ) -> Result<Vec<usize>> {
        let mut clusters: Vec<&str> = Vec::new();
        for sample in &self.training {
            clusters.push(&descriptions[*sample].cluster);
        }
        clusters.sort_unstable();
        clusters.dedup();
        let count = (share * clusters.len() as f64).round();
        if !(share > 0.0 && share <= 1.0) || count < 1.0 {
            return refuse(format!(
                "a share of {share} of the {} clusters of the training part: give more than 0, at most 1, \
                 and enough for one cluster",
                clusters.len()
            ));
        }
        let mut random = CounterRng::for_purpose(seed, 1, 0, Purpose::Split);
        shuffle(&mut clusters, &mut random);
        let clusters_used: BTreeSet<&str> = clusters.into_iter().take(count as usize).collect();
        let is_kept =
            |sample: &&usize| clusters_used.contains(descriptions[**sample].cluster.as_str());
        Ok(self.training.iter().filter(is_kept).copied().collect())
    }

    /// Checks that every index exists and none stands in two parts.
    ///
    /// ```
    /// use protomer_learn::split::Split;
    /// let split = Split { training: vec![0, 1], validation: vec![2], test: vec![3] };
    /// assert!(split.check(4).is_ok());
    /// assert!(split.check(3).is_err(), "there is no fourth sample");
    /// assert!(Split { test: vec![0], ..split }.check(4).is_err(), "a sample in two parts");
    /// ```
    ///
    /// # Errors
    /// [`LearnError::Settings`] names the index.
    pub fn check(&self, samples: usize) -> Result<()> {
        let mut marks = vec![false; samples];
        for index in [&self.training, &self.validation, &self.test]
            .into_iter()
            .flatten()
        {
            match marks.get_mut(*index) {
                Some(mark) if !*mark => *mark = true,
                Some(_) => return refuse(format!("sample {index} is in the split twice")),
                None => return refuse(format!("the split names sample {index} of {samples}")),
            }
        }
        Ok(())
    }
}

/// The weight of each sample, one over the size of its family: copies of one crystal form count
/// once together. A sample without a family has the weight 1.
///
/// ```
/// use protomer_learn::Description;
/// use protomer_learn::split::family_weights;
///
/// let relative = |family: &str| Description { family: family.into(), ..Description::default() };
/// assert_eq!(family_weights(&[relative("lysozyme"), relative(""), relative("lysozyme")]), [0.5, 1.0, 0.5]);
/// ```
pub fn family_weights(descriptions: &[Description]) -> Vec<f64> {
    let mut sizes = BTreeMap::<&str, usize>::new();
    for description in descriptions {
        *sizes.entry(&description.family).or_default() += 1;
    }
    let mut weights = Vec::with_capacity(descriptions.len());
    for description in descriptions {
        let size = if description.family.is_empty() {
            1
        } else {
            sizes[description.family.as_str()]
        };
        weights.push(1.0 / size as f64);
    }
    weights
}

/// The labels whose samples all belong to one cluster, in alphabetical order. A split by cluster
/// cannot both train and test such a class.
///
/// ```
/// use protomer_learn::Description;
/// use protomer_learn::split::labels_in_one_cluster;
///
/// let sample = |label: &str, cluster: &str| Description {
///     label: label.into(),
///     cluster: cluster.into(),
///     ..Description::default()
/// };
/// let samples = [sample("P1", "a"), sample("P1", "b"), sample("C2", "a"), sample("C2", "a")];
/// assert_eq!(labels_in_one_cluster(&samples), ["C2"]);
/// ```
pub fn labels_in_one_cluster(descriptions: &[Description]) -> Vec<&str> {
    let mut clusters = BTreeMap::<&str, BTreeSet<&str>>::new();
    for description in descriptions {
        clusters
            .entry(&description.label)
            .or_default()
            .insert(&description.cluster);
    }
    clusters.retain(|_, of_label| of_label.len() == 1);
    clusters.into_keys().collect()
}

/// The samples of each cluster, clusters by name.
///
/// # Errors
/// [`LearnError::Sample`] for a sample without a cluster.
pub(crate) fn clusters(descriptions: &[Description]) -> Result<Vec<Vec<usize>>> {
    let mut clusters = BTreeMap::<&str, Vec<usize>>::new();
    for (sample, description) in descriptions.iter().enumerate() {
        if description.cluster.is_empty() {
            return Err(LearnError::Sample {
                name: description.name.clone(),
                reason: "it has no cluster; if nothing in the set is related to it, name the \
                         cluster after the sample"
                    .into(),
            });
        }
        clusters
            .entry(&description.cluster)
            .or_default()
            .push(sample);
    }
    Ok(clusters.into_values().collect())
}

/// A uniformly random order (Fisher and Yates).
pub(crate) fn shuffle<T>(items: &mut [T], random: &mut CounterRng) {
    for last in (1..items.len()).rev() {
        items.swap(last, random.index(last + 1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            let count = |part: &[usize]| {
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
                    (count(part) - share * total).abs() < 2.5,
                    "{label}: {} of {total}",
                    count(part)
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
    fn ranks_say_as_much_as_names() {
        for count in [9, 60, 200] {
            let samples = set(count);
            let labels = ranks(samples.iter().map(|sample| &sample.label));
            let clusters = ranks(samples.iter().map(|sample| sample.cluster.clone()));
            let by_names = Split::grouped(&samples, 5, Fractions::default()).unwrap();
            let by_ranks = Split::by_ranks(&labels, &clusters, 5, Fractions::default());
            assert_eq!(by_ranks.unwrap(), by_names);
        }
        assert!(Split::by_ranks(&[0, 1], &[0], 1, Fractions::default()).is_err());
    }

    #[test]
    fn a_random_split_separates_relatives() {
        let samples = set(60);
        let split = Split::random(&samples, 1, Fractions::default()).unwrap();
        split.check(samples.len()).unwrap();
        assert!(!names(&samples, &split.training).is_disjoint(&names(&samples, &split.test)));
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
        let twice = Split {
            training: vec![0],
            validation: vec![0],
            test: vec![],
        };
        assert!(twice.check(2).is_err());
    }
}
