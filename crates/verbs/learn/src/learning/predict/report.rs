//! The report of a prediction: a row per sample, and scores where the true class is known.

use super::fit::Difference;
use super::trained::Trained;
use super::truth::{Part, Truth, Unscored};
use crate::learning::train::decimals_of;
use anyhow::{Result, bail};
use protomer_common::answer::Answer;
use protomer_io::csv::{Cell, Table};
use protomer_learn::SampleSource;
use protomer_learn::number_scores::{NumberScores, TrueNumbers};
use protomer_learn::scaling::Quarantined;
use protomer_learn::scores::{Scores, most_probable};
use protomer_learn::split::family_weights;
use protomer_learn::targets::number;
use protomer_learn::training::{ModelCard, Predictions};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The prediction for one sample.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SamplePrediction {
    /// Name of the sample.
    pub name: String,
    /// File of the sample, as the manifest of the set names it.
    pub file: String,
    /// Label of the sample in the set.
    pub label: String,
    /// True class of the sample; `None` if the label is not a class of the network.
    pub class: Option<String>,
    /// Part of the training that the sample belonged to; `None` if this is not the set of the
    /// training.
    pub part: Option<Part>,
    /// Reason why the sample is not scored, if this is not the set of the training.
    pub unscored: Option<Unscored>,
    /// The most probable class.
    pub predicted: String,
    /// The number that is predicted, if the network predicts one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub predicted_number: Option<f64>,
    /// Spread of the predicted number, if the network predicts one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub predicted_spread: Option<f64>,
    /// The probability of each class.
    pub probabilities: Vec<f64>,
}

/// Scores of the samples of known class that training has not seen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SetScores {
    /// Samples scored.
    pub samples: usize,
    /// Share of correct predictions; copies of one crystal form count once together.
    pub accuracy: f64,
    /// The accuracy of always predicting the most frequent class of the training part.
    pub majority_accuracy: f64,
    /// Mean recall over the classes present.
    pub balanced_accuracy: f64,
    /// The balanced accuracy of always predicting the most frequent class of the training part.
    pub majority_balanced_accuracy: f64,
    /// Cross entropy, nats.
    pub log_loss_nats: f64,
    /// Cross entropy of the shares of the classes in the training part, nats.
    pub prior_log_loss_nats: f64,
    /// `prior_log_loss_nats` - `log_loss_nats`: the information gained per sample.
    pub nats_gained_over_prior: f64,
    /// Scores of the predicted numbers, if the network predicts numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub numbers: Option<NumberScores>,
}

/// The number of samples that are not scored for one reason.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct NotScored {
    /// Reason why the samples are not scored.
    pub why: Unscored,
    /// Number of samples.
    pub samples: usize,
}

/// The report of a prediction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PredictReport {
    /// Version of the program.
    pub version: String,
    /// The directory of the training.
    pub run: PathBuf,
    /// The set.
    pub set: PathBuf,
    /// Whether the set is that of the training; if so, only its test part is scored.
    pub is_training_set: bool,
    /// Names of the classes, in the order of the probabilities.
    pub classes: Vec<String>,
    /// Names of the network's input channels.
    pub channels: Vec<String>,
    /// One entry per sample that could be read, in the order of the set.
    pub samples: Vec<SamplePrediction>,
    /// Scores, if any samples of known class remain to be scored.
    pub scores: Option<SetScores>,
    /// Samples that are predicted but not scored, if this is not the set of the training.
    pub not_scored: Vec<NotScored>,
    /// Samples left out, and why.
    pub left_out: Vec<Quarantined>,
    /// Settings in which the voxels differ from those of the training.
    pub differences: Vec<Difference>,
}

/// A set under the labels that predictions are held against.
pub(super) struct LabelledSet<'a> {
    /// The samples.
    pub samples: &'a dyn SampleSource,
    /// The file of each sample, as the manifest names it.
    pub files: &'a [String],
}

impl PredictReport {
    /// Combines the known classes with the predictions.
    ///
    /// # Errors
    /// If the predictions do not fit the set, or contain a number that is not a probability.
    pub(super) fn new(
        run: &Path,
        path: &Path,
        trained: &Trained,
        set: &LabelledSet<'_>,
        truth: &Truth,
        predictions: Predictions,
        differences: Vec<Difference>,
    ) -> Result<Self> {
        let card = &trained.model.card;
        let class = |number: usize| card.classes.get(number).cloned().unwrap_or_default();
        let mut samples = Vec::with_capacity(predictions.samples.len());
        let probabilities = predictions.probabilities.chunks(card.classes.len().max(1));
        for (place, (sample, p)) in predictions.samples.iter().zip(probabilities).enumerate() {
            let direct = predictions.numbers.get(place);
            let Some(description) = set.samples.descriptions().get(*sample) else {
                bail!("there is no sample {sample}");
            };
            samples.push(SamplePrediction {
                name: description.name.clone(),
                file: set.files.get(*sample).cloned().unwrap_or_default(),
                label: description.label.clone(),
                class: truth.classes.get(*sample).copied().flatten().map(class),
                part: truth.parts.get(*sample).copied().flatten(),
                unscored: truth.unscored.get(*sample).copied().flatten(),
                predicted: class(most_probable(p)),
                predicted_number: match (direct, &card.number_classes) {
                    (Some(number), _) => Some(number.mean),
                    (None, Some(classes)) => classes.predicted(p).pop(),
                    (None, None) => None,
                },
                predicted_spread: direct.map(|number| number.spread),
                probabilities: p.to_vec(),
            });
        }
        let not_scored = count(&samples);
        Ok(Self {
            version: env!("CARGO_PKG_VERSION").into(),
            run: run.to_owned(),
            set: path.to_owned(),
            is_training_set: truth.is_training_set,
            classes: card.classes.clone(),
            channels: card.channels.clone(),
            samples,
            not_scored,
            scores: scores(card, set.samples, truth, &predictions)?,
            left_out: predictions.quarantined,
            differences,
        })
    }

    /// One row per sample: name, file, label, class, part, predicted, the predicted number if there is
    /// one, and a probability per class.
    ///
    /// # Errors
    /// If rows and classes disagree.
    pub fn table(&self) -> Result<Table> {
        let fixed = ["name", "file", "label", "class", "part", "predicted"];
        let mut heading = fixed.map(str::to_owned).to_vec();
        let has_number = |sample: &SamplePrediction| sample.predicted_number.is_some();
        let has_numbers = self.samples.iter().any(has_number);
        heading.extend(has_numbers.then(|| "predicted_number".to_owned()));
        let has_spread = |sample: &SamplePrediction| sample.predicted_spread.is_some();
        let has_spreads = self.samples.iter().any(has_spread);
        heading.extend(has_spreads.then(|| "predicted_spread".to_owned()));
        for class in &self.classes {
            heading.push(format!("p_{class}"));
        }
        let mut table = Table::new(heading);
        for sample in &self.samples {
            let mut cells = vec![
                Cell::from(sample.name.as_str()),
                Cell::from(sample.file.as_str()),
                Cell::from(sample.label.as_str()),
                Cell::from(sample.class.as_deref()),
                Cell::from(sample.part.map(Part::name)),
                Cell::from(sample.predicted.as_str()),
            ];
            cells.extend(sample.predicted_number.map(Cell::from));
            cells.extend(sample.predicted_spread.map(Cell::from));
            for probability in &sample.probabilities {
                cells.push(Cell::from(*probability));
            }
            table.push(cells)?;
        }
        Ok(table)
    }
}

impl Answer for PredictReport {
    /// The scores as text. The accuracy is never shown without that of the majority class.
    fn text(&self) -> String {
        let mut lines = vec![format!(
            "{} samples predicted, {} left out",
            self.samples.len(),
            self.left_out.len()
        )];
        match &self.scores {
            Some(scores) => {
                lines.push(match self.is_training_set {
                    true => format!(
                        "scores of the test part of the training, {} samples",
                        scores.samples
                    ),
                    false => {
                        format!(
                            "scores of the samples of known class that are new to the network, {}",
                            scores.samples
                        )
                    }
                });
                lines.push(format!(
                    "balanced accuracy {:.3} (majority {:.3}), accuracy {:.3} (majority {:.3})",
                    scores.balanced_accuracy,
                    scores.majority_balanced_accuracy,
                    scores.accuracy,
                    scores.majority_accuracy
                ));
                lines.push(format!(
                    "log-loss {:.3} nats, prior {:.3}: gained {:+.3}",
                    scores.log_loss_nats, scores.prior_log_loss_nats, scores.nats_gained_over_prior
                ));
                lines.extend(scores.numbers.map(|numbers| {
                    let (error, decimals) = (numbers.rms_error, decimals_of(numbers.rms_error));
                    format!(
                        "numbers: rms error {error:.decimals$}, variance explained {:.3}, rank correlation {:.3}",
                        numbers.variance_explained, numbers.rank_correlation
                    )
                }));
            }
            None if self.is_training_set => {
                lines.push("no scores: no sample of the test part can be read".into())
            }
            None => lines.push("no scores: no sample remains to be scored".into()),
        }
        for NotScored { why, samples } in &self.not_scored {
            lines.push(format!("not scored: {samples} {}", why.words()));
        }
        lines.join("\n")
    }
}

/// Counts samples by the reason why they are not scored.
fn count(samples: &[SamplePrediction]) -> Vec<NotScored> {
    let mut counts: BTreeMap<Unscored, usize> = BTreeMap::new();
    for sample in samples {
        if let Some(why) = sample.unscored {
            *counts.entry(why).or_default() += 1;
        }
    }
    let mut not_scored = Vec::new();
    for (why, samples) in counts {
        not_scored.push(NotScored { why, samples });
    }
    not_scored
}

/// Computes scores with the weights of training: a sample counts 1 / (size of its family). Families
/// are counted over all samples with a class in the set of the training, and over the scored
/// samples in any other set.
fn scores(
    card: &ModelCard,
    set: &dyn SampleSource,
    truth: &Truth,
    predictions: &Predictions,
) -> Result<Option<SetScores>> {
    let count = card.log_prior.len();
    let (mut labelled, mut descriptions) = (Vec::new(), Vec::new());
    for (sample, class) in truth.classes.iter().enumerate() {
        if class.is_some() && (truth.is_training_set || truth.may_be_scored(sample)) {
            labelled.push(sample);
            descriptions.push(set.descriptions()[sample].clone());
        }
    }
    let all_weights = family_weights(&descriptions);
    let (mut probabilities, mut labels, mut weights) = (Vec::new(), Vec::new(), Vec::new());
    let (mut numbers, mut direct) = (Vec::new(), Vec::new());
    let of_samples = predictions.probabilities.chunks(count.max(1));
    for (place_of_row, (sample, p)) in predictions.samples.iter().zip(of_samples).enumerate() {
        if let Some(class) = truth.classes[*sample]
            && let Ok(place) = labelled.binary_search(sample)
            && truth.may_be_scored(*sample)
        {
            probabilities.extend_from_slice(p);
            direct.extend(predictions.numbers.get(place_of_row).map(|one| one.mean));
            labels.push(class);
            weights.push(all_weights[place]);
            numbers.extend(number(&set.descriptions()[*sample].label));
        }
    }
    if labels.is_empty() {
        return Ok(None);
    }
    let score = |p: &[f64]| Scores::from_probabilities(p, &labels, count, Some(&weights));
    let prior: Vec<f64> = card.log_prior.iter().map(|log| log.exp()).collect();
    let numbers = match &card.number_classes {
        Some(classes) => {
            let truth = TrueNumbers {
                numbers: &numbers,
                weights: &weights,
                training_mean: classes.predicted(&prior).iter().sum(),
            };
            let predicted = match direct.is_empty() {
                true => classes.predicted(&probabilities),
                false => direct,
            };
            Some(NumberScores::from_predictions(&predicted, &truth)?)
        }
        None => None,
    };
    let (network, prior) = (score(&probabilities)?, score(&prior.repeat(labels.len()))?);
    Ok(Some(SetScores {
        samples: labels.len(),
        accuracy: network.accuracy,
        majority_accuracy: prior.accuracy,
        balanced_accuracy: network.balanced_accuracy,
        majority_balanced_accuracy: prior.balanced_accuracy,
        log_loss_nats: network.log_loss_nats,
        prior_log_loss_nats: prior.log_loss_nats,
        nats_gained_over_prior: network.nats_gained_over(&prior),
        numbers,
    }))
}
