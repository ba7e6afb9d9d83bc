//! The scores of a training as text: the network compared with predictions without one, on the
//! same split.

use super::ablation_summary;
use super::metrics::{Metrics, NumberMetrics};
use protomer_common::answer::{Answer, columns, heading};
use protomer_learn::bootstrap::Interval;
use protomer_learn::evaluation::Intervals;
use protomer_learn::number_scores::{NumberIntervals, NumberScores};

/// Largest number of classes for which the confusion matrix is shown.
const MOST_CLASSES_SHOWN: usize = 12;

impl Answer for Metrics {
    /// The scores as text. The accuracy is never shown without that of the majority class.
    fn text(&self) -> String {
        let mut parts = vec![head(self)];
        // A control has a verdict of its own, on whether it came out as expected.
        let verdict = self.verdict.as_ref().filter(|_| self.control.is_none());
        parts.extend(verdict.map(|verdict| format!("verdict: {verdict}")));
        parts.extend(self.numbers.as_ref().map(numbers));
        parts.extend([scores(self), intervals(self), calibration(self)]);
        parts.extend((self.classes.len() <= MOST_CLASSES_SHOWN).then(|| confusion(self)));
        if !self.quarantined.is_empty() {
            parts.push(format!(
                "{} samples left out: see quarantined in metrics.json",
                self.quarantined.len()
            ));
        }
        let mut lines = vec![parts.join("\n\n")];
        lines.extend(self.ablation.as_ref().map(ablation_summary));
        lines.extend(self.control.as_ref().map(|control| control.summary()));
        lines.join("\n")
    }
}

fn head(metrics: &Metrics) -> String {
    let (samples, classes) = (&metrics.samples, metrics.classes.len());
    let mut head = format!(
        "test part: {} samples in {} clusters, {classes} classes",
        samples.test, samples.test_clusters
    );
    if let Some(absent) = metrics.absent_classes() {
        head += &format!("; {absent}");
    }
    if let Some(joined) = metrics.joined_labels() {
        head += &format!("\n{joined}");
    }
    head
}

fn scores(metrics: &Metrics) -> String {
    let words = [
        "",
        "accuracy",
        "balanced accuracy",
        "macro-F1",
        "top 3",
        "log-loss (nats)",
        "gained over prior",
    ];
    let mut rows = vec![heading(words)];
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".into());
    for scores in metrics.score_rows() {
        let mut row = vec![scores.name];
        row.extend(scores.shares.map(|share| format!("{share:.3}")));
        row.push(or_dash(
            scores.log_loss_nats.map(|loss| format!("{loss:.3}")),
        ));
        row.push(or_dash(
            scores.gained_nats.map(|gained| format!("{gained:+.3}")),
        ));
        rows.push(row);
    }
    columns(&rows)
}

/// Table of the scores of predicted numbers, in their own unit.
fn numbers(metrics: &NumberMetrics) -> String {
    let decimals = decimals_of(metrics.scores.rms_error);
    let error = |value: f64| format!("{value:.decimals$}");
    let mut words = heading([""]);
    words.extend(heading(NumberMetrics::HEADINGS));
    let mut rows = vec![words];
    let mut add = |name: &str, scores: &NumberScores| {
        rows.push(vec![
            name.to_owned(),
            error(scores.rms_error),
            error(scores.mean_absolute_error),
            format!("{:.3}", scores.variance_explained),
            format!("{:.3}", scores.rank_correlation),
        ]);
    };
    add("network", &metrics.scores);
    for (name, scores) in metrics.of_baselines() {
        add(&name, scores);
    }
    let NumberIntervals {
        rms_error,
        variance_explained,
        rank_correlation,
    } = &metrics.bootstrap_95;
    let spread = metrics.spread.map(|spread| {
        format!(
            "\npredicted spread {} on average; {:.3} of the numbers within it (0.683 if honest), {:.3} \
             within twice (0.954)",
            error(spread.mean_spread),
            spread.within_one,
            spread.within_two
        )
    });
    format!(
        "{}\n\n95 % over clusters: rms error {} to {}, variance explained {}, rank correlation {}",
        columns(&rows),
        error(rms_error.low),
        error(rms_error.high),
        range(variance_explained),
        range(rank_correlation)
    ) + spread.as_deref().unwrap_or_default()
}

/// Decimals that show three digits of an error.
pub(crate) fn decimals_of(error: f64) -> usize {
    let magnitude = error.max(f64::MIN_POSITIVE).log10().floor();
    (2.0 - magnitude).clamp(0.0, 12.0) as usize
}

fn range(interval: &Interval) -> String {
    format!("{:.3} to {:.3}", interval.low, interval.high)
}

fn intervals(metrics: &Metrics) -> String {
    let Intervals {
        accuracy,
        balanced_accuracy,
        nats_gained_over_prior,
    } = &metrics.bootstrap_95;
    // Each score is shown with that of the majority class.
    let majority = metrics.baselines.get("majority");
    let majority_balanced = majority.map_or(f64::NAN, |majority| majority.balanced_accuracy);
    format!(
        "95 % over clusters: accuracy {} (majority {:.3}), balanced accuracy {} (majority {:.3}), \
         gained {} nats\npermutation test: {}",
        range(accuracy),
        metrics.majority_accuracy,
        range(balanced_accuracy),
        majority_balanced,
        range(nats_gained_over_prior),
        metrics.permutation_test()
    )
}

fn calibration(metrics: &Metrics) -> String {
    let error = metrics.expected_calibration_error;
    format!(
        "calibration: error {error:.3}, Brier score {:.3}, temperature {:.2}",
        metrics.brier, metrics.temperature
    )
}

fn confusion(metrics: &Metrics) -> String {
    let mut head = vec!["true \\ predicted".to_owned()];
    head.extend(metrics.classes.iter().cloned());
    let mut rows = vec![head];
    for (class, counts) in metrics.classes.iter().zip(&metrics.confusion_matrix) {
        let mut row = vec![class.clone()];
        // Copies of one crystal form share a weight of 1, so counts can be fractional.
        row.extend(
            counts
                .iter()
                .map(|count| format!("{}", (10.0 * count).round() / 10.0)),
        );
        rows.push(row);
    }
    columns(&rows)
}
