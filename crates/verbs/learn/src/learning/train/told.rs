//! What the terminal and the page both say about a training, written once.

use super::metrics::{BaselineScores, Metrics, simplest_first};
use protomer_learn::advantage::Verdict;
use protomer_learn::bootstrap::Interval;
use protomer_learn::targets::{LabelCount, OTHER};

/// The baseline that names one class with certainty.
const MAJORITY: &str = "majority";

/// A row of the table that compares the network with predictions without voxels.
#[derive(Debug, Clone, PartialEq)]
pub struct ScoreRow {
    /// The network, or the baseline.
    pub name: String,
    /// Accuracy, balanced accuracy, macro F1 and top-3 accuracy.
    pub shares: [f64; 4],
    /// Cross entropy, nats; `None` for a prediction that names one class with certainty. The other
    /// classes have probability zero there, so only the smallest number allowed in its place would
    /// decide the value.
    pub log_loss_nats: Option<f64>,
    /// The prior's cross entropy less this one, nats.
    pub gained_nats: Option<f64>,
}

impl Metrics {
    /// The network and the baselines, the simplest first.
    pub fn score_rows(&self) -> Vec<ScoreRow> {
        let network = BaselineScores {
            accuracy: self.accuracy,
            balanced_accuracy: self.balanced_accuracy,
            macro_f1: self.macro_f1,
            top3_accuracy: self.top3_accuracy,
            log_loss_nats: self.log_loss_nats,
        };
        let mut rows = vec![self.score_row("network", &network)];
        for name in simplest_first(&self.baselines) {
            rows.push(self.score_row(name, &self.baselines[name]));
        }
        rows
    }

    fn score_row(&self, name: &str, scores: &BaselineScores) -> ScoreRow {
        let log_loss_nats = (name != MAJORITY).then_some(scores.log_loss_nats);
        ScoreRow {
            name: name.replace('_', " "),
            shares: [
                scores.accuracy,
                scores.balanced_accuracy,
                scores.macro_f1,
                scores.top3_accuracy,
            ],
            log_loss_nats,
            gained_nats: log_loss_nats.map(|loss| self.prior_log_loss_nats - loss),
        }
    }

    /// The comparison with the best baseline in words; `None` in a training of an earlier version.
    pub(super) fn words_of_verdict(&self) -> Option<String> {
        let advantage = self.advantage.as_ref()?;
        let (baseline, is_prior) = match (advantage.baseline.as_str(), &self.numbers) {
            ("prior", Some(_)) => ("the mean of the training part".to_owned(), true),
            ("prior", None) => ("the shares of the classes".to_owned(), true),
            (name, _) => (name.replace('_', " "), false),
        };
        let Interval {
            estimate,
            low: least,
            high: most,
        } = advantage.gain;
        let unit = match self.numbers {
            Some(_) => "of the variance",
            None => "nats",
        };
        let range = format!(
            "{:+.3} {unit} for the network, 95 % {:+.3} to {:+.3}, {}",
            estimate,
            least,
            most,
            p_words(advantage.p_value)
        );
        Some(match (advantage.verdict(), is_prior) {
            (Verdict::Better, _) => {
                format!("the network predicts better than the best baseline, {baseline} ({range})")
            }
            (Verdict::Worse, true) => {
                format!("{baseline} alone predict better ({range}): the network has learnt nothing")
            }
            (Verdict::Worse, false) => {
                format!("{baseline} alone does better ({range}): the grid adds nothing here")
            }
            (Verdict::Undecided, true) => format!(
                "no better than {baseline} ({range}): nothing was learnt that these {} clusters of the \
                 test part can show",
                self.samples.test_clusters
            ),
            (Verdict::Undecided, false) => format!(
                "no better than {baseline} alone ({range}): the grid adds nothing that these {} clusters \
                 of the test part can show",
                self.samples.test_clusters
            ),
        })
    }

    /// The classes that the test part has none of; `None` if there are none.
    pub fn absent_classes(&self) -> Option<String> {
        let classes = self.classes.iter().zip(&self.confusion_matrix);
        let absent = classes.filter(|(_, row)| row.iter().sum::<f64>() == 0.0);
        let absent: Vec<&str> = absent.map(|(class, _)| class.as_str()).collect();
        (!absent.is_empty()).then(|| {
            format!(
                "it has none of {}, about which these scores say nothing",
                absent.join(", ")
            )
        })
    }

    /// Classes and labels that the split or their counts did not allow, a sentence each.
    pub fn cautions(&self) -> Vec<String> {
        let confined = self.single_cluster_classes.iter().map(|class| {
            format!(
                "all samples of the class {class} belong to one cluster, so a split by cluster cannot \
                 both train and test it"
            )
        });
        let seen_sentence = (self.seen_before > 0).then(|| {
            format!(
                "{} of {} samples of the test part, or relatives of theirs, were in the training that the \
                 weights come from, so these scores are too good; predict scores new ones only",
                self.seen_before, self.samples.test
            )
        });
        confined
            .chain(self.joined_labels())
            .chain(seen_sentence)
            .collect()
    }

    /// Calibration error, Brier score and temperature.
    pub fn calibration(&self) -> [(&'static str, f64); 3] {
        [
            (
                "expected calibration error",
                self.expected_calibration_error,
            ),
            ("Brier score", self.brier),
            ("temperature", self.temperature),
        ]
    }

    /// The labels that became one class, and the flag that keeps them apart; `None` if there are
    /// none.
    pub fn joined_labels(&self) -> Option<String> {
        if self.other_labels.is_empty() {
            return None;
        }
        let mut joined = Vec::new();
        for LabelCount { label, samples } in &self.other_labels {
            joined.push(format!("{label} ({samples})"));
        }
        Some(format!(
            "the class {OTHER} joins labels of few samples: {}; a smaller --least-samples keeps \
             them apart",
            joined.join(", ")
        ))
    }

    /// The permutation test: its number, and the question that it answers. The gain over the prior
    /// answers another one, so its size and this number need not agree.
    pub fn permutation_test(&self) -> String {
        let p = p_words(self.permutation_p);
        format!(
            "{p} that predictions go with the labels of the test part by chance ({} exchanges of \
             labels; those of {:.0} % of the samples can move); it does not test the gain over the \
             prior",
            self.permutations,
            100.0 * self.permutation_movable
        )
    }
}

fn p_words(p: f64) -> String {
    match p < 0.001 {
        true => "p < 0.001".into(),
        false => format!("p = {p:.3}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_learn::advantage::Advantage;
    use serde_json::json;

    /// The metrics of a training of two classes.
    fn metrics() -> Metrics {
        let interval = json!({"estimate": 0.5, "low": 0.4, "high": 0.6});
        let fields = json!({
            "version": "1", "classes": ["a", "b"], "channels": ["shape"],
            "samples": {"training": 6, "validation": 2, "test": 2, "test_clusters": 2},
            "accuracy": 0.5, "majority_accuracy": 0.5, "balanced_accuracy": 0.5, "macro_f1": 0.5,
            "top3_accuracy": 1.0, "matthews_correlation": 0.0, "log_loss_nats": 0.69,
            "prior_log_loss_nats": 0.7, "nats_gained_over_prior": 0.01, "brier": 0.5,
            "expected_calibration_error": 0.1, "temperature": 1.0,
            "confusion_matrix": [[1.0, 0.0], [1.0, 0.0]], "reliability": [], "baselines": {},
            "bootstrap_95": {
                "accuracy": interval, "balanced_accuracy": interval,
                "nats_gained_over_prior": interval,
            },
            "permutation_p": 0.5, "permutations": 1000, "permutation_movable": 1.0,
            "best_epoch": 1, "epochs": 1, "parameters": 9, "quarantined": [],
        });
        serde_json::from_value(fields).unwrap()
    }

    #[test]
    fn a_prediction_with_certainty_has_no_log_loss() {
        let mut metrics = metrics();
        let scores = |log_loss_nats| BaselineScores {
            accuracy: 0.5,
            balanced_accuracy: 0.5,
            macro_f1: 0.3,
            top3_accuracy: 1.0,
            log_loss_nats,
        };
        metrics.prior_log_loss_nats = 0.7;
        metrics.baselines = [
            ("prior".to_owned(), scores(0.7)),
            (MAJORITY.to_owned(), scores(17.27)),
            ("size_and_charge".to_owned(), scores(0.6)),
        ]
        .into();
        let rows = metrics.score_rows();
        let names: Vec<&str> = rows.iter().map(|row| row.name.as_str()).collect();
        assert_eq!(names, ["network", "majority", "prior", "size and charge"]);
        assert_eq!((rows[1].log_loss_nats, rows[1].gained_nats), (None, None));
        assert_eq!(rows[2].gained_nats, Some(0.0));
        assert!((rows[3].gained_nats.unwrap() - 0.1).abs() < 1e-12);
    }

    #[test]
    fn a_verdict_says_what_the_grid_adds() {
        let mut metrics = metrics();
        assert_eq!(metrics.words_of_verdict(), None);
        let mut told = |baseline: &str, low, high, p_value| {
            metrics.advantage = Some(Advantage {
                baseline: baseline.into(),
                gain: Interval {
                    estimate: 0.5 * (low + high),
                    low,
                    high,
                },
                p_value,
            });
            metrics.words_of_verdict().unwrap()
        };
        assert_eq!(
            told("composition", -0.3, -0.1, 1.0),
            "composition alone does better (-0.200 nats for the network, 95 % -0.300 to -0.100, p = \
             1.000): the grid adds nothing here"
        );
        assert!(told("size_and_charge", 0.1, 0.3, 0.0004).starts_with(
            "the network predicts better than the best baseline, size and charge (+0.200 nats for \
             the network, 95 % +0.100 to +0.300, p < 0.001)"
        ));
        assert!(told("size", -0.1, 0.3, 0.2).contains("these 2 clusters"));
        // The interval alone does not decide.
        assert!(told("size", 0.01, 0.3, 0.2).starts_with("no better than size alone"));
        assert!(told("prior", -0.3, 0.1, 0.7).contains("nothing was learnt"));
    }

    #[test]
    fn joined_labels_come_with_the_flag_that_keeps_them_apart() {
        let mut metrics = metrics();
        assert_eq!(metrics.joined_labels(), None);
        let rare = |label: &str, samples| LabelCount {
            label: label.into(),
            samples,
        };
        metrics.other_labels = vec![rare("P 3", 2), rare("P 4", 1)];
        let told = metrics.joined_labels().unwrap();
        assert!(
            told.contains("P 3 (2), P 4 (1)") && told.contains("--least-samples"),
            "{told}"
        );
    }

    #[test]
    fn a_p_value_names_its_question() {
        let mut metrics = metrics();
        metrics.permutation_p = 0.051;
        let told = metrics.permutation_test();
        assert!(
            told.starts_with("p = 0.051 that predictions go with the labels")
                && told.contains("does not test the gain"),
            "{told}"
        );
        metrics.permutation_p = 0.0002;
        assert!(metrics.permutation_test().starts_with("p < 0.001 "));
    }
}
