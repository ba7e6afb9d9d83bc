//! The verdict on a control, as it stands in the metrics.

use protomer_kernel::setting::Choices;
use protomer_learn::controls::{Control, Form};
use serde::{Deserialize, Serialize};

/// The result of one experiment of a control.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExperimentReport {
    /// Name of the experiment.
    pub name: String,
    /// The network's input channels.
    pub channels: Vec<String>,
    /// Lower bound of the expected balanced accuracy.
    pub at_least: f64,
    /// Upper bound of the expected balanced accuracy.
    pub at_most: f64,
    /// Balanced accuracy on the test part.
    pub balanced_accuracy: f64,
    /// Accuracy on the test part of always predicting the most frequent class.
    pub majority_accuracy: f64,
    /// Nats gained over the prior on the test part.
    pub nats_gained_over_prior: f64,
    /// Whether the balanced accuracy lies between the bounds.
    pub reached: bool,
}

/// The result of a control.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControlReport {
    /// The control.
    pub name: Control,
    /// The form of the control: short or full.
    pub form: Form,
    /// The purpose of the control.
    pub shows: String,
    /// Experiments of the control, the main one first.
    pub experiments: Vec<ExperimentReport>,
    /// Whether all experiments met the expectation.
    pub reached: bool,
}

impl ControlReport {
    /// The report of a control.
    pub fn from_experiments(
        control: Control,
        form: Form,
        experiments: Vec<ExperimentReport>,
    ) -> Self {
        let reached = experiments.iter().all(|experiment| experiment.reached);
        Self {
            name: control,
            form,
            shows: control.shows().to_owned(),
            experiments,
            reached,
        }
    }

    /// The table as lines of text.
    pub fn summary(&self) -> String {
        let line = |experiment: &ExperimentReport| {
            let ExperimentReport {
                name,
                balanced_accuracy,
                at_least,
                at_most,
                reached,
                ..
            } = experiment;
            let wanted = match at_most {
                1.0 => format!("at least {at_least:.2}"),
                _ => format!("chance, {at_least:.2} to {at_most:.2}"),
            };
            let verdict = if *reached {
                "as expected"
            } else {
                "NOT AS EXPECTED"
            };
            format!(
                "{} {name}: balanced accuracy {balanced_accuracy:.3}, expected {wanted}: {verdict}",
                self.name.name()
            )
        };
        self.experiments
            .iter()
            .map(line)
            .collect::<Vec<_>>()
            .join("\n")
    }
}
