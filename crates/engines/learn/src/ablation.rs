//! What each channel brings: every subset of the channels is trained with the same seeds.
//!
//! Channels are chosen by the validation part, whose scores each training notes; the test part serves for the final
//! figures only. Intervals of a mean over n seeds are ± t(n - 1) standard errors, with Student's t at 97.5 %.

use crate::Result;
use crate::error::refuse;
use protomer_kernel::statistics::RunningMoments;
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;

/// Largest number of channels: more have too many subsets.
const MOST_CHANNELS: usize = 6;
/// Student's t at 97.5 % for 1, 2, ... degrees of freedom.
const STUDENT_T: [f64; 15] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160,
    2.145, 2.131,
];
/// Student's t at 97.5 % for more degrees of freedom: at most 0.16 above the exact value.
const STUDENT_T_BEYOND: f64 = 2.12;

/// The trainings of an ablation: channels and seed of each, seed after seed.
///
/// ```
/// use protomer_learn::ablation::plan;
///
/// let channels = ["shape".to_owned(), "potential".to_owned()];
/// let plan = plan(&channels, 7, 3)?;
/// assert_eq!(plan.len(), 9, "three subsets with three seeds");
/// assert_eq!(plan[1], (vec!["shape".to_owned()], 7));
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
///
/// # Errors
/// [`LearnError::Settings`](crate::LearnError::Settings) for too many channels.
pub fn plan(channels: &[String], first_seed: u64, seeds: u64) -> Result<Vec<(Vec<String>, u64)>> {
    let count = channels.len();
    if count > MOST_CHANNELS {
        return refuse(format!(
            "{count} channels have too many subsets; choose at most {MOST_CHANNELS} with --channels"
        ));
    }
    let mut trainings = Vec::new();
    for seed in first_seed..first_seed.saturating_add(seeds) {
        for subset in subsets(channels) {
            trainings.push((subset, seed));
        }
    }
    Ok(trainings)
}

/// All subsets but the empty one, larger ones first, each in the order of the channels.
fn subsets(channels: &[String]) -> Vec<Vec<String>> {
    let mut subsets = Vec::new();
    for mask in 1_usize..1 << channels.len() {
        let mut subset = Vec::new();
        for (i, name) in channels.iter().enumerate() {
            if mask >> i & 1 == 1 {
                subset.push(name.clone());
            }
        }
        subsets.push(subset);
    }
    subsets.sort_by_key(|subset| Reverse(subset.len()));
    subsets
}

/// Result of one training of an ablation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AblationRun {
    /// The channels the network saw.
    pub channels: Vec<String>,
    /// Seed of split, weights and order. Runs of one seed differ in their channels only.
    pub seed: u64,
    /// Mean recall on the test part.
    pub balanced_accuracy: f64,
    /// Accuracy on the test part.
    pub accuracy: f64,
    /// Accuracy on the test part if always the most frequent class is named.
    pub majority_accuracy: f64,
    /// Nats gained over the prior on the test part.
    pub nats_gained_over_prior: f64,
    /// Loss of the validation part at the epoch that was kept, nats.
    #[serde(default)]
    pub validation_loss_nats: Option<f64>,
    /// Balanced accuracy of the validation part at that epoch.
    #[serde(default)]
    pub validation_balanced_accuracy: Option<f64>,
}

/// A mean over seeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mean {
    /// The mean.
    pub mean: f64,
    /// Standard error of the mean from the scatter over seeds; `None` for a single seed.
    pub standard_error: Option<f64>,
    /// 95 % interval of the mean; `None` for a single seed.
    #[serde(default)]
    pub interval_95: Option<[f64; 2]>,
}

impl Mean {
    fn from_values(values: &[f64]) -> Self {
        let moments = RunningMoments::in_two_passes(values);
        let mean = moments.mean();
        let standard_error = (values.len() > 1).then(|| moments.independent_standard_error());
        let degrees_of_freedom = values.len().saturating_sub(1);
        let factor = *STUDENT_T
            .get(degrees_of_freedom.saturating_sub(1))
            .unwrap_or(&STUDENT_T_BEYOND);
        Self {
            mean,
            standard_error,
            interval_95: standard_error.map(|error| [mean - factor * error, mean + factor * error]),
        }
    }
}

/// Means over all seeds of one subset.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AblationRow {
    /// The channels the network saw.
    pub channels: Vec<String>,
    /// Balanced accuracy on the test part.
    pub balanced_accuracy: Mean,
    /// Nats gained over the prior on the test part.
    pub nats_gained_over_prior: Mean,
    /// Balanced accuracy less that of all channels, seed by seed.
    pub balanced_accuracy_less_all: Mean,
    /// Nats gained less those of all channels, seed by seed.
    pub nats_less_all: Mean,
    /// Loss of the validation part less that with all channels, nats, seed by seed: positive where leaving channels out
    /// costs something. `None` for trainings of earlier versions, which did not note it.
    #[serde(default)]
    pub validation_loss_more_than_all: Option<Mean>,
}

/// The table of an ablation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ablation {
    /// The seeds every subset was trained with.
    pub seeds: Vec<u64>,
    /// One row per subset, all channels first.
    pub rows: Vec<AblationRow>,
    /// Results of all trainings, one per subset and seed.
    pub runs: Vec<AblationRun>,
}

impl Ablation {
    /// The table of runs.
    ///
    /// ```
    /// use protomer_learn::ablation::{Ablation, AblationRun};
    ///
    /// let run = |channels: &[&str], balanced_accuracy| AblationRun {
    ///     channels: channels.iter().map(|name| name.to_string()).collect(),
    ///     seed: 1,
    ///     balanced_accuracy,
    ///     accuracy: balanced_accuracy,
    ///     majority_accuracy: 0.5,
    ///     nats_gained_over_prior: 0.0,
    ///     validation_loss_nats: Some(1.0 - balanced_accuracy),
    ///     validation_balanced_accuracy: None,
    /// };
    /// let runs = vec![run(&["shape"], 0.5), run(&["shape", "potential"], 0.75)];
    /// let table = Ablation::from_runs(runs)?;
    /// assert_eq!(table.rows[1].channels, ["shape"]);
    /// assert_eq!(table.rows[1].balanced_accuracy_less_all.mean, -0.25);
    /// assert_eq!(table.rows[1].validation_loss_more_than_all.unwrap().mean, 0.25);
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) if a subset lacks a seed of another.
    pub fn from_runs(runs: Vec<AblationRun>) -> Result<Self> {
        let (mut seeds, mut sets) = (Vec::new(), Vec::new());
        for run in &runs {
            if !seeds.contains(&run.seed) {
                seeds.push(run.seed);
            }
            if !sets.contains(&run.channels) {
                sets.push(run.channels.clone());
            }
        }
        sets.sort_by_key(|channels| Reverse(channels.len()));
        let mut rows = Vec::with_capacity(sets.len());
        if let Some(all) = sets.first() {
            let all = Values::from_runs(&runs, all, &seeds)?;
            for channels in &sets {
                rows.push(Values::from_runs(&runs, channels, &seeds)?.row(channels, &all));
            }
        }
        Ok(Self { seeds, rows, runs })
    }
}

/// Results of a subset, seed by seed.
struct Values {
    balanced_accuracy: Vec<f64>,
    nats: Vec<f64>,
    /// `None` if a seed lacks it.
    validation_loss: Option<Vec<f64>>,
}

impl Values {
    fn from_runs(runs: &[AblationRun], channels: &[String], seeds: &[u64]) -> Result<Self> {
        let (mut balanced_accuracy, mut nats) = (Vec::new(), Vec::new());
        let mut validation_loss = Vec::new();
        for seed in seeds {
            let is_wanted = |run: &&AblationRun| run.seed == *seed && run.channels == channels;
            let Some(run) = runs.iter().find(is_wanted) else {
                let channels = channels.join(" + ");
                return refuse(format!("the channels {channels} lack the seed {seed}"));
            };
            balanced_accuracy.push(run.balanced_accuracy);
            nats.push(run.nats_gained_over_prior);
            validation_loss.extend(run.validation_loss_nats);
        }
        let is_complete = validation_loss.len() == seeds.len();
        Ok(Self {
            balanced_accuracy,
            nats,
            validation_loss: is_complete.then_some(validation_loss),
        })
    }

    fn row(&self, channels: &[String], all: &Self) -> AblationRow {
        let accuracy_less_all = differences(&self.balanced_accuracy, &all.balanced_accuracy);
        let losses = self
            .validation_loss
            .as_ref()
            .zip(all.validation_loss.as_ref());
        AblationRow {
            channels: channels.to_vec(),
            balanced_accuracy: Mean::from_values(&self.balanced_accuracy),
            nats_gained_over_prior: Mean::from_values(&self.nats),
            balanced_accuracy_less_all: Mean::from_values(&accuracy_less_all),
            nats_less_all: Mean::from_values(&differences(&self.nats, &all.nats)),
            validation_loss_more_than_all: losses
                .map(|(own, all)| Mean::from_values(&differences(own, all))),
        }
    }
}

fn differences(scores: &[f64], all: &[f64]) -> Vec<f64> {
    scores
        .iter()
        .zip(all)
        .map(|(score, all)| score - all)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(channels: &[&str], seed: u64, accuracy: f64) -> AblationRun {
        AblationRun {
            channels: channels.iter().map(|name| (*name).to_owned()).collect(),
            seed,
            balanced_accuracy: accuracy,
            accuracy,
            majority_accuracy: 0.5,
            nats_gained_over_prior: accuracy - 0.5,
            validation_loss_nats: Some(1.0 - accuracy),
            validation_balanced_accuracy: Some(accuracy),
        }
    }

    #[test]
    fn differences_are_taken_seed_by_seed() {
        let both = ["shape", "potential"];
        let runs = vec![
            run(&["shape"], 1, 0.5),
            run(&both, 1, 0.8),
            run(&["shape"], 2, 0.6),
            run(&both, 2, 1.0),
        ];
        let table = Ablation::from_runs(runs).unwrap();
        assert_eq!(table.seeds, [1, 2]);
        assert_eq!(table.rows[0].channels, both);
        let nothing = Mean {
            mean: 0.0,
            standard_error: Some(0.0),
            interval_95: Some([0.0, 0.0]),
        };
        assert_eq!(table.rows[0].balanced_accuracy_less_all, nothing);
        let shape = &table.rows[1];
        assert!((shape.balanced_accuracy.mean - 0.55).abs() < 1e-12);
        // -0.3 and -0.4: mean -0.35, standard error 0.05.
        let difference = shape.balanced_accuracy_less_all;
        assert!((difference.mean + 0.35).abs() < 1e-12);
        assert!((difference.standard_error.unwrap() - 0.05).abs() < 1e-12);
        // One degree of freedom: ± 12.706 · 0.05.
        let costs = shape.validation_loss_more_than_all.unwrap();
        let [low, high] = costs.interval_95.unwrap();
        assert!((low - (0.35 - 0.6353)).abs() < 1e-12 && (high - (0.35 + 0.6353)).abs() < 1e-12);
    }

    #[test]
    fn a_single_seed_has_no_error_and_a_missing_one_is_named() {
        let one = Ablation::from_runs(vec![run(&["shape"], 1, 0.7)]).unwrap();
        assert_eq!(one.rows[0].balanced_accuracy.standard_error, None);
        assert_eq!(one.rows[0].balanced_accuracy.interval_95, None);
        let earlier = AblationRun {
            validation_loss_nats: None,
            ..run(&["shape"], 1, 0.7)
        };
        let table = Ablation::from_runs(vec![earlier]).unwrap();
        assert_eq!(table.rows[0].validation_loss_more_than_all, None);
        let runs = vec![run(&["shape"], 1, 0.7), run(&["potential"], 2, 0.7)];
        let error = Ablation::from_runs(runs).unwrap_err().to_string();
        assert!(error.contains("shape lack the seed 2"), "{error}");
    }

    #[test]
    fn there_are_all_subsets() {
        let names: Vec<String> = ["a", "b", "c"].map(String::from).to_vec();
        let subsets = subsets(&names);
        assert_eq!(subsets.len(), 7);
        assert_eq!(subsets[0], names);
        let falls = |pair: &[Vec<String>]| pair[0].len() >= pair[1].len();
        assert!(subsets.windows(2).all(falls));
    }

    #[test]
    fn too_many_channels_are_refused() {
        let seven: Vec<String> = (0..7).map(|i| i.to_string()).collect();
        assert!(plan(&seven, 1, 1).is_err());
        assert_eq!(plan(&seven[..6], 1, 2).unwrap().len(), 126);
    }
}
