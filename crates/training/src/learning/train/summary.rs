//! The scores of a training as text: the network compared with predictions without one, on the
//! same split.

use super::ablation_summary;
use super::metrics::{BaselineScores, Metrics, NumberMetrics, simplest_first};
use protomer_common::answer::{Answer, columns, heading};
use protomer_learn::bootstrap::Interval;
use protomer_learn::evaluation::Intervals;
use protomer_learn::number_scores::{NumberIntervals, NumberScores};
use protomer_learn::targets::{LabelCount, OTHER};

/// Largest number of classes for which the confusion matrix is shown.
const MOST_CLASSES_SHOWN: usize = 12;

impl Answer for Metrics {
    /// The accuracy is never shown without that of the majority class.
    fn text(&self) -> String {
        let mut parts = vec![head(self)];
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
    let absent = metrics
        .classes
        .iter()
        .zip(&metrics.confusion_matrix)
        .filter(|(_, row)| row.iter().sum::<f64>() == 0.0);
    let absent: Vec<&str> = absent.map(|(class, _)| class.as_str()).collect();
    if !absent.is_empty() {
        head += &format!(
            "; it has none of {}, about which these scores say nothing",
            absent.join(", ")
        );
    }
    if !metrics.other_labels.is_empty() {
        let mut joined = Vec::new();
        for LabelCount { label, samples } in &metrics.other_labels {
            joined.push(format!("{label} ({samples})"));
        }
        head += &format!("\n{OTHER}, by samples: {}", joined.join(", "));
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
    let network = BaselineScores {
        accuracy: metrics.accuracy,
        balanced_accuracy: metrics.balanced_accuracy,
        macro_f1: metrics.macro_f1,
        top3_accuracy: metrics.top3_accuracy,
        log_loss_nats: metrics.log_loss_nats,
    };
    let mut add = |name: &str, scores: &BaselineScores| {
        let shares = [
            scores.accuracy,
            scores.balanced_accuracy,
            scores.macro_f1,
            scores.top3_accuracy,
        ];
        let mut row = vec![name.replace('_', " ")];
        row.extend(shares.map(|share| format!("{share:.3}")));
        // Always predicting one class gives the others probability 0, so its log-loss is
        // meaningless.
        let (loss, gained) = if name == "majority" {
            ("-".into(), "-".into())
        } else {
            let gained = metrics.prior_log_loss_nats - scores.log_loss_nats;
            (
                format!("{:.3}", scores.log_loss_nats),
                format!("{gained:+.3}"),
            )
        };
        row.extend([loss, gained]);
        rows.push(row);
    };
    add("network", &network);
    for name in simplest_first(&metrics.baselines) {
        add(name, &metrics.baselines[name]);
    }
    columns(&rows)
}

/// How near predicted numbers come, in their own unit.
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
    format!(
        "{}\n\n95 % over clusters: rms error {} to {}, variance explained {}, rank correlation {}",
        columns(&rows),
        error(rms_error.low),
        error(rms_error.high),
        range(variance_explained),
        range(rank_correlation)
    )
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
    let p = if metrics.permutation_p < 0.001 {
        "< 0.001".into()
    } else {
        format!("{:.3}", metrics.permutation_p)
    };
    // Each score is shown beside that of the majority class.
    let majority = metrics.baselines.get("majority");
    let majority_balanced = majority.map_or(f64::NAN, |majority| majority.balanced_accuracy);
    format!(
        "95 % over clusters: accuracy {} (majority {:.3}), balanced accuracy {} (majority {:.3}), \
         gained {} nats\npermutation p {p} of {} exchanges; labels of {:.0} % of the samples can \
         move",
        range(accuracy),
        metrics.majority_accuracy,
        range(balanced_accuracy),
        majority_balanced,
        range(nats_gained_over_prior),
        metrics.permutations,
        100.0 * metrics.permutation_movable
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
