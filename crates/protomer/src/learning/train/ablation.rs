//! What each channel brings: every subset of the channels trained with the same seeds.

use super::metrics::Metrics;
use anyhow::Result;
use protomer_io::atomic::write_atomically;
use protomer_io::csv::{Cell, Table};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// More channels than this have too many subsets.
pub const MOST_CHANNELS: usize = 6;

/// One training of an ablation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AblationRun {
    /// The channels the network saw.
    pub channels: Vec<String>,
    /// Seed of split, weights and order: runs of one seed differ in their channels only.
    pub seed: u64,
    /// Mean recall on the test part.
    pub balanced_accuracy: f64,
    /// Accuracy on the test part.
    pub accuracy: f64,
    /// What always naming the most frequent class gives there.
    pub majority_accuracy: f64,
    /// Nats gained over the prior there.
    pub nats_gained_over_prior: f64,
}

/// A mean over seeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mean {
    /// The mean.
    pub mean: f64,
    /// Its standard error from the scatter over seeds; nothing for a single seed.
    pub standard_error: Option<f64>,
}

impl Mean {
    fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let variance = values
            .iter()
            .map(|value| (value - mean).powi(2))
            .sum::<f64>()
            / (count - 1.0);
        Self {
            mean,
            standard_error: (values.len() > 1).then(|| (variance / count).sqrt()),
        }
    }
}

/// All seeds of one subset.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AblationRow {
    /// The channels the network saw.
    pub channels: Vec<String>,
    /// Balanced accuracy on the test part.
    pub balanced_accuracy: Mean,
    /// Nats gained over the prior there.
    pub nats_gained_over_prior: Mean,
    /// Balanced accuracy less that of all channels, seed by seed.
    pub balanced_accuracy_less_all: Mean,
    /// Nats gained less those of all channels, seed by seed.
    pub nats_less_all: Mean,
}

/// The table of an ablation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ablation {
    /// The seeds every subset was trained with.
    pub seeds: Vec<u64>,
    /// One row per subset, all channels first.
    pub rows: Vec<AblationRow>,
    /// One per subset and seed.
    pub runs: Vec<AblationRun>,
}

/// All subsets but the empty one, larger ones first, each in the order of the channels.
///
/// ```
/// let names = ["shape".to_owned(), "potential".to_owned()];
/// let subsets = protomer::learning::train::subsets(&names);
/// assert_eq!(subsets, [vec!["shape", "potential"], vec!["shape"], vec!["potential"]]);
/// ```
pub fn subsets(channels: &[String]) -> Vec<Vec<String>> {
    let of_mask = |mask: usize| -> Vec<String> {
        channels
            .iter()
            .enumerate()
            .filter(|(i, _)| mask >> i & 1 == 1)
            .map(|(_, name)| name.clone())
            .collect()
    };
    let mut subsets: Vec<Vec<String>> = (1..1 << channels.len()).map(of_mask).collect();
    subsets.sort_by_key(|subset| std::cmp::Reverse(subset.len()));
    subsets
}

impl AblationRun {
    /// What a training of this seed came to.
    pub fn of(metrics: &Metrics, seed: u64) -> Self {
        Self {
            channels: metrics.channels.clone(),
            seed,
            balanced_accuracy: metrics.balanced_accuracy,
            accuracy: metrics.accuracy,
            majority_accuracy: metrics.majority_accuracy,
            nats_gained_over_prior: metrics.nats_gained_over_prior,
        }
    }
}

impl Ablation {
    /// The table of runs, which hold each seed once for each subset.
    pub fn of(runs: Vec<AblationRun>) -> Self {
        let mut seeds = Vec::new();
        let mut sets: Vec<Vec<String>> = Vec::new();
        for run in &runs {
            if !seeds.contains(&run.seed) {
                seeds.push(run.seed);
            }
            if !sets.contains(&run.channels) {
                sets.push(run.channels.clone());
            }
        }
        sets.sort_by_key(|channels| std::cmp::Reverse(channels.len()));
        let values = |channels: &[String], value: fn(&AblationRun) -> f64| -> Vec<f64> {
            let of_seed = |seed: &u64| {
                runs.iter()
                    .find(|run| run.seed == *seed && run.channels == channels)
            };
            seeds.iter().filter_map(of_seed).map(value).collect()
        };
        let all = sets.first().cloned().unwrap_or_default();
        let row = |channels: &Vec<String>| {
            let mean = |value: fn(&AblationRun) -> f64| Mean::of(&values(channels, value));
            let less_all = |value: fn(&AblationRun) -> f64| {
                let pairs = values(channels, value).into_iter().zip(values(&all, value));
                Mean::of(&pairs.map(|(own, all)| own - all).collect::<Vec<_>>())
            };
            AblationRow {
                channels: channels.clone(),
                balanced_accuracy: mean(|run| run.balanced_accuracy),
                nats_gained_over_prior: mean(|run| run.nats_gained_over_prior),
                balanced_accuracy_less_all: less_all(|run| run.balanced_accuracy),
                nats_less_all: less_all(|run| run.nats_gained_over_prior),
            }
        };
        let rows = sets.iter().map(row).collect();
        Self { seeds, rows, runs }
    }

    /// Lines for a reader.
    pub fn summary(&self) -> String {
        let number = |mean: &Mean| match mean.standard_error {
            Some(error) => format!("{:+.3} ± {error:.3}", mean.mean),
            None => format!("{:+.3}", mean.mean),
        };
        let line = |row: &AblationRow| {
            format!(
                "{:<32} balanced accuracy {:.3}, less all channels {}; nats gained {}",
                row.channels.join(" + "),
                row.balanced_accuracy.mean,
                number(&row.balanced_accuracy_less_all),
                number(&row.nats_gained_over_prior)
            )
        };
        self.rows.iter().map(line).collect::<Vec<_>>().join("\n")
    }

    /// Writes `ablation.csv`, one row per subset and seed.
    ///
    /// # Errors
    /// If the disk does not take it.
    pub fn write_csv(&self, directory: &Path) -> Result<()> {
        let columns = [
            "channels",
            "seed",
            "balanced_accuracy",
            "accuracy",
            "majority_accuracy",
            "nats_gained_over_prior",
        ];
        let mut table = Table::new(columns);
        for run in &self.runs {
            let seed = i64::try_from(run.seed).map_or(Cell::Text(run.seed.to_string()), Cell::from);
            table.push([
                run.channels.join("+").as_str().into(),
                seed,
                run.balanced_accuracy.into(),
                run.accuracy.into(),
                run.majority_accuracy.into(),
                run.nats_gained_over_prior.into(),
            ])?;
        }
        write_atomically(&directory.join("ablation.csv"), |file| {
            file.write_all(table.to_csv().as_bytes())
        })?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_taken_seed_by_seed() {
        let run = |channels: &[&str], seed: u64, accuracy: f64| AblationRun {
            channels: channels.iter().map(|name| (*name).to_owned()).collect(),
            seed,
            balanced_accuracy: accuracy,
            accuracy,
            majority_accuracy: 0.5,
            nats_gained_over_prior: accuracy - 0.5,
        };
        let both = ["shape", "potential"];
        let runs = vec![
            run(&["shape"], 1, 0.5),
            run(&both, 1, 0.8),
            run(&["shape"], 2, 0.6),
            run(&both, 2, 1.0),
        ];
        let table = Ablation::of(runs);
        assert_eq!(table.seeds, [1, 2]);
        assert_eq!(table.rows[0].channels, both);
        assert_eq!(
            table.rows[0].balanced_accuracy_less_all,
            Mean {
                mean: 0.0,
                standard_error: Some(0.0)
            }
        );
        let shape = &table.rows[1];
        assert!((shape.balanced_accuracy.mean - 0.55).abs() < 1e-12);
        // -0.3 and -0.4: mean -0.35, standard error 0.05.
        let difference = shape.balanced_accuracy_less_all;
        assert!(
            (difference.mean + 0.35).abs() < 1e-12
                && (difference.standard_error.unwrap() - 0.05).abs() < 1e-12
        );
        assert_eq!(
            Ablation::of(vec![run(&both, 1, 0.7)]).rows[0]
                .balanced_accuracy
                .standard_error,
            None
        );
    }

    #[test]
    fn there_are_all_subsets() {
        let names: Vec<String> = ["a", "b", "c"].map(String::from).to_vec();
        let subsets = subsets(&names);
        assert_eq!(subsets.len(), 7);
        assert_eq!(subsets[0], names);
        assert!(
            subsets
                .windows(2)
                .all(|pair| pair[0].len() >= pair[1].len())
        );
    }
}
