//! The expected and the actual outcome of a control.

use super::control_report::ExperimentReport;
use super::metrics::Metrics;
use protomer_learn::controls::{Experiment, Verdict};

impl ExperimentReport {
    /// Compares the metrics of an experiment with the expectation.
    pub fn from_metrics(experiment: &Experiment, metrics: &Metrics) -> Self {
        let clusters = if experiment.split_by_cluster {
            metrics.samples.test_clusters
        } else {
            metrics.samples.test
        };
        let Verdict {
            at_least,
            at_most,
            balanced_accuracy,
            is_reached,
        } = experiment
            .expected
            .verdict(metrics.balanced_accuracy, metrics.classes.len(), clusters);
        Self {
            name: experiment.name.to_owned(),
            channels: metrics.channels.clone(),
            at_least,
            at_most,
            balanced_accuracy,
            majority_accuracy: metrics.majority_accuracy,
            nats_gained_over_prior: metrics.nats_gained_over_prior,
            reached: is_reached,
        }
    }
}
