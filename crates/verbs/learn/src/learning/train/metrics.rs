//! `metrics.json`: how well a network predicts the test part, compared with predictions without a
//! network.

use super::history::Validation;
use super::prepared::Numbers;
use anyhow::{Context, Result};
use protomer_io::atomic::{write_atomically, write_bytes};
use protomer_io::csv::{Cell, Table};
use protomer_learn::ablation::{Ablation, AblationRun};
use protomer_learn::advantage::Advantage;
use protomer_learn::evaluation::{Evaluation, Intervals, NumberEvaluation};
use protomer_learn::normal::PredictedNumber;
use protomer_learn::number_classes::NumberClasses;
use protomer_learn::number_scores::{NumberIntervals, NumberScores, SpreadScores};
use protomer_learn::predictions::TestPredictions;
use protomer_learn::sample::Description;
use protomer_learn::scaling::Quarantined;
use protomer_learn::scores::{ReliabilityBin, Scores, most_probable};
use protomer_learn::split::Split;
use protomer_learn::targets::LabelCount;
use protomer_results::keys::read_json_if_present;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Samples in each part of the split.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parts {
    /// Samples that the weights were fitted to.
    pub training: usize,
    /// Samples on which the epoch and the temperature were chosen.
    pub validation: usize,
    /// Samples of the test part, to which all scores refer.
    pub test: usize,
    /// Clusters of the test part.
    pub test_clusters: usize,
}

/// Scores of a prediction without a network.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BaselineScores {
    /// Share of correct predictions.
    pub accuracy: f64,
    /// Mean recall.
    pub balanced_accuracy: f64,
    /// Mean F1.
    pub macro_f1: f64,
    /// Share of samples whose class is among the three most probable.
    pub top3_accuracy: f64,
    /// Cross entropy, nats.
    pub log_loss_nats: f64,
}

/// The scores of a trained network on the test part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Metrics {
    /// Version of the program.
    pub version: String,
    /// Names of the classes, in the order of every list and matrix below.
    pub classes: Vec<String>,
    /// Names of the network's input channels.
    pub channels: Vec<String>,
    /// Samples in each part.
    pub samples: Parts,
    /// Share of correct predictions; compare it with `majority_accuracy`.
    pub accuracy: f64,
    /// The accuracy of always predicting the most frequent class of the training part.
    pub majority_accuracy: f64,
    /// Mean recall over the classes.
    pub balanced_accuracy: f64,
    /// Mean F1 over the classes.
    pub macro_f1: f64,
    /// Share of samples whose class is among the three most probable.
    pub top3_accuracy: f64,
    /// Matthews' correlation coefficient for several classes.
    pub matthews_correlation: f64,
    /// Cross entropy, nats.
    pub log_loss_nats: f64,
    /// Cross entropy of the shares of the classes in the training part, nats.
    pub prior_log_loss_nats: f64,
    /// `prior_log_loss_nats` - `log_loss_nats`: the information learnt per sample.
    pub nats_gained_over_prior: f64,
    /// Brier score.
    pub brier: f64,
    /// Expected calibration error.
    pub expected_calibration_error: f64,
    /// Temperature that divides the logits, chosen on the validation part.
    pub temperature: f64,
    /// Weight of samples by true class (row) and predicted class (column).
    pub confusion_matrix: Vec<Vec<f64>>,
    /// Confidence and accuracy, bin by bin.
    pub reliability: Vec<ReliabilityBin>,
    /// Scores of predictions without a network, by name.
    pub baselines: BTreeMap<String, BaselineScores>,
    /// 95 % intervals.
    pub bootstrap_95: Intervals,
    /// Share of exchanges of labels between clusters of one size in the test part under which the
    /// same predictions have no larger log-loss (each sample counting once; the real labels count
    /// as one exchange). Only labels of the test part move and no network is fitted again: it asks
    /// whether these predictions go with the labels of the test part, not how often a training on
    /// exchanged labels would do as well.
    pub permutation_p: f64,
    /// Exchanges that were tried.
    pub permutations: usize,
    /// Share of the test part's samples whose clusters have another of their size, so that their
    /// labels can move: near 0 the test above cannot tell anything.
    #[serde(default)]
    pub permutation_movable: f64,
    /// The epoch whose weights were kept.
    pub best_epoch: usize,
    /// Epochs done.
    pub epochs: usize,
    /// Number of fitted parameters.
    pub parameters: usize,
    /// Samples left out, and why.
    pub quarantined: Vec<Quarantined>,
    /// Labels too rare for a separate class, merged into "other".
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub other_labels: Vec<LabelCount>,
    /// Classes whose samples all belong to one cluster: a split by cluster cannot both train and
    /// test them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub single_cluster_classes: Vec<String>,
    /// Samples of the test part that the training which the weights started from had seen, or whose
    /// cluster it had: their scores are too good.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub seen_before: usize,
    /// Scores of the predicted numbers, if it is a number that is predicted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub numbers: Option<NumberMetrics>,
    /// Comparison with the best baseline: of log-losses, or of squared errors if it is a number that is
    /// predicted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub advantage: Option<Advantage>,
    /// The comparison in words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verdict: Option<String>,
    /// All subsets of the channels, if requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ablation: Option<Ablation>,
    /// The verdict, for a control.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub control: Option<super::control_report::ControlReport>,
}

/// For serde: whether a count is left out.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// Scores of predicted numbers on the test part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NumberMetrics {
    /// The classes that the numbers are cut into.
    pub classes: NumberClasses,
    /// Scores of the network.
    pub scores: NumberScores,
    /// Scores of predictions without a network, by name.
    pub baselines: BTreeMap<String, NumberScores>,
    /// 95 % intervals.
    pub bootstrap_95: NumberIntervals,
    /// Comparison with the best baseline, in shares of the variance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub advantage: Option<Advantage>,
    /// Honesty of the predicted spreads, with the loss `normal`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread: Option<SpreadScores>,
}

impl NumberMetrics {
    /// The headings of a table of scores, after one for the names.
    pub const HEADINGS: [&str; 4] = [
        "rms error",
        "mean absolute error",
        "variance explained",
        "rank correlation",
    ];

    /// Scores of predictions without the network, by name, the simplest first. The majority is left
    /// out: it names one class, which only accuracies can judge.
    pub fn of_baselines(&self) -> Vec<(String, &NumberScores)> {
        let mut rows = Vec::new();
        for name in simplest_first(&self.baselines) {
            let shown = match name.as_str() {
                "majority" => continue,
                "prior" => "mean of the training part".to_owned(),
                _ => name.replace('_', " "),
            };
            rows.push((shown, &self.baselines[name]));
        }
        rows
    }
}

/// The names of baselines, the simplest first.
pub(super) fn simplest_first<T>(baselines: &BTreeMap<String, T>) -> Vec<&String> {
    let first = ["majority", "prior", "size"];
    let place = |name: &&String| {
        let rank = first.iter().position(|baseline| baseline == name);
        // Unknown names come after the known ones, among themselves by name, as the sort is stable.
        rank.unwrap_or(first.len())
    };
    let mut names: Vec<&String> = baselines.keys().collect();
    names.sort_by_key(place);
    names
}

/// The data that the scores are computed from.
#[derive(Debug)]
pub struct Predictions<'a> {
    /// All samples of the set.
    pub descriptions: &'a [Description],
    /// The class of each sample.
    pub labels: &'a [usize],
    /// The numbers of all samples, if it is a number that is predicted.
    pub numbers: Option<&'a Numbers>,
    /// Names of the classes.
    pub classes: &'a [String],
    /// Names of the channels.
    pub channels: &'a [String],
    /// The split, without samples left out.
    pub split: &'a Split,
    /// Probabilities of the test part, in its order, samples x classes.
    pub probabilities: &'a [f64],
    /// Number and spread of each sample of the test part, if the network predicts them.
    pub predicted_numbers: &'a [PredictedNumber],
    /// Temperature of these probabilities.
    pub temperature: f64,
    /// Samples left out.
    pub quarantined: &'a [Quarantined],
    /// Labels that were merged into "other".
    pub other_labels: &'a [LabelCount],
    /// Classes confined to one cluster, if clusters stay together.
    pub single_cluster_classes: &'a [String],
    /// Epochs done.
    pub epochs: usize,
    /// The epoch whose weights were kept.
    pub best_epoch: usize,
    /// Number of fitted parameters.
    pub parameters: usize,
    /// Exchanges of labels for the permutation test.
    pub permutations: usize,
    /// Seed of resamplings and exchanges.
    pub seed: u64,
}

impl Predictions<'_> {
    /// Computes all scores.
    ///
    /// # Errors
    /// If there is nothing to score, or a descriptor is not finite.
    pub fn metrics(&self) -> Result<Metrics> {
        let predictions = TestPredictions {
            descriptions: self.descriptions,
            labels: self.labels,
            classes: self.classes.len(),
            split: self.split,
            probabilities: self.probabilities,
        };
        let evaluation = predictions.evaluate(self.permutations, self.seed)?;
        let numbers = match self.numbers {
            Some(numbers) => Some(self.number_metrics(numbers, &predictions, &evaluation)?),
            None => None,
        };
        let (majority, prior) = (
            evaluation.baseline("majority")?.accuracy,
            evaluation.baseline("prior")?.log_loss_nats,
        );
        let Evaluation {
            scores: network_scores,
            baselines,
            intervals,
            permutation,
            advantage,
            test_clusters,
        } = evaluation;
        let advantage = match &numbers {
            Some(numbers) => numbers.advantage.clone(),
            None => Some(advantage),
        };
        let mut scores_of_baselines = BTreeMap::new();
        for (baseline, scores) in baselines {
            scores_of_baselines.insert(
                baseline.name.to_owned(),
                BaselineScores::from_scores(&scores),
            );
        }
        let mut metrics = Metrics {
            version: env!("CARGO_PKG_VERSION").into(),
            classes: self.classes.to_vec(),
            channels: self.channels.to_vec(),
            samples: Parts {
                training: self.split.training.len(),
                validation: self.split.validation.len(),
                test: self.split.test.len(),
                test_clusters,
            },
            accuracy: network_scores.accuracy,
            majority_accuracy: majority,
            balanced_accuracy: network_scores.balanced_accuracy,
            macro_f1: network_scores.macro_f1,
            top3_accuracy: network_scores.top3_accuracy,
            matthews_correlation: network_scores.matthews,
            log_loss_nats: network_scores.log_loss_nats,
            prior_log_loss_nats: prior,
            nats_gained_over_prior: prior - network_scores.log_loss_nats,
            brier: network_scores.brier,
            expected_calibration_error: network_scores.expected_calibration_error,
            temperature: self.temperature,
            confusion_matrix: network_scores.confusion,
            reliability: network_scores.reliability,
            bootstrap_95: intervals,
            baselines: scores_of_baselines,
            permutation_p: permutation.p_value,
            permutations: permutation.exchanges,
            permutation_movable: permutation.movable,
            best_epoch: self.best_epoch,
            epochs: self.epochs,
            parameters: self.parameters,
            quarantined: self.quarantined.to_vec(),
            other_labels: self.other_labels.to_vec(),
            single_cluster_classes: self.single_cluster_classes.to_vec(),
            seen_before: 0,
            numbers,
            advantage,
            verdict: None,
            ablation: None,
            control: None,
        };
        metrics.verdict = metrics.words_of_verdict();
        Ok(metrics)
    }

    fn number_metrics(
        &self,
        numbers: &Numbers,
        predictions: &TestPredictions,
        evaluation: &Evaluation,
    ) -> Result<NumberMetrics> {
        let NumberEvaluation {
            scores,
            baselines,
            intervals,
            advantage,
            spread,
        } = predictions.evaluate_numbers(
            evaluation,
            &numbers.of_samples,
            &numbers.classes,
            (!self.predicted_numbers.is_empty()).then_some(self.predicted_numbers),
            self.seed,
        )?;
        let baselines = baselines.into_iter();
        Ok(NumberMetrics {
            classes: numbers.classes.clone(),
            scores,
            baselines: baselines
                .map(|(name, baseline)| (name.to_owned(), baseline))
                .collect(),
            bootstrap_95: intervals,
            advantage: Some(advantage),
            spread,
        })
    }

    /// The predicted numbers of the test part.
    pub(super) fn numbers_of_test(&self, numbers: &Numbers) -> Vec<f64> {
        if self.predicted_numbers.is_empty() {
            return numbers.classes.predicted(self.probabilities);
        }
        self.predicted_numbers.iter().map(|one| one.mean).collect()
    }

    /// Writes `predictions.csv`: one row per sample of the test part.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_csv(&self, path: &Path) -> Result<()> {
        let mut heading = ["name", "cluster", "label", "predicted"]
            .map(str::to_owned)
            .to_vec();
        if self.numbers.is_some() {
            heading.extend(["number", "predicted_number"].map(str::to_owned));
        }
        if !self.predicted_numbers.is_empty() {
            heading.push("predicted_spread".to_owned());
        }
        heading.extend(self.classes.iter().map(|class| format!("p_{class}")));
        let predicted = self.numbers.map(|numbers| self.numbers_of_test(numbers));
        let mut table = Table::new(heading);
        let name = |class: usize| self.classes.get(class).map_or("", String::as_str);
        let rows = self.probabilities.chunks(self.classes.len().max(1));
        for (place, (sample, p)) in self.split.test.iter().zip(rows).enumerate() {
            let (Some(description), Some(label)) =
                (self.descriptions.get(*sample), self.labels.get(*sample))
            else {
                continue;
            };
            let best = name(most_probable(p)).into();
            let mut cells: Vec<Cell> = vec![
                description.name.as_str().into(),
                description.cluster.as_str().into(),
                name(*label).into(),
                best,
            ];
            if let (Some(numbers), Some(predicted)) = (self.numbers, &predicted) {
                cells.push(numbers.of_samples[*sample].into());
                cells.extend(predicted.get(place).map(|number| Cell::from(*number)));
            }
            let number = self.predicted_numbers.get(place);
            cells.extend(number.map(|number| Cell::from(number.spread)));
            cells.extend(p.iter().map(|p| Cell::from(*p)));
            table.push(cells)?;
        }
        let csv = table.to_csv()?;
        write_bytes(path, csv.as_bytes())?;
        Ok(())
    }
}

impl BaselineScores {
    fn from_scores(scores: &Scores) -> Self {
        Self {
            accuracy: scores.accuracy,
            balanced_accuracy: scores.balanced_accuracy,
            macro_f1: scores.macro_f1,
            top3_accuracy: scores.top3_accuracy,
            log_loss_nats: scores.log_loss_nats,
        }
    }
}

impl Metrics {
    /// The contribution of a training with this seed to an ablation.
    pub(super) fn ablation_run(&self, seed: u64, validation: Validation) -> AblationRun {
        AblationRun {
            channels: self.channels.clone(),
            seed,
            balanced_accuracy: self.balanced_accuracy,
            accuracy: self.accuracy,
            majority_accuracy: self.majority_accuracy,
            nats_gained_over_prior: self.nats_gained_over_prior,
            validation_loss_nats: validation.loss_nats,
            validation_balanced_accuracy: validation.balanced_accuracy,
        }
    }

    /// Writes `metrics.json` into a directory.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, directory: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(self).context("metrics.json")?;
        write_atomically(&directory.join(FILE_NAME), |file| writeln!(file, "{text}"))?;
        Ok(())
    }

    /// Reads the metrics of a directory, if its training is done.
    ///
    /// # Errors
    /// If the file exists but cannot be read.
    pub fn read(directory: &Path) -> Result<Option<Self>> {
        Ok(read_json_if_present(&directory.join(FILE_NAME))?)
    }
}

/// Name of the file of the metrics.
pub const FILE_NAME: &str = "metrics.json";
