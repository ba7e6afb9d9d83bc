//! `trials.svg`: the result of each trial of a search against its learning rate, by number of
//! epochs.

use crate::learning::tune::Trial;
use protomer_plot::{Axis, Figure, Panel, Point, Series};
use std::collections::BTreeSet;

/// The figure of a search, without diverged trials.
pub fn figure(trials: &[Trial], channels: &[String]) -> Figure {
    let finite: Vec<&Trial> = trials
        .iter()
        .filter(|trial| trial.reached.validation_loss_nats.is_some())
        .collect();
    let epochs: BTreeSet<usize> = finite.iter().map(|trial| trial.reached.epochs).collect();
    let series = |value: fn(&Trial) -> Option<f64>| -> Vec<Series> {
        let of_epochs = |epochs: &usize| {
            let point = |trial: &&Trial| {
                let (x, y) = (trial.settings.training.learning_rate, value(trial)?);
                (trial.reached.epochs == *epochs).then_some(Point { x, y, error: None })
            };
            let name = if *epochs == 1 {
                "1 epoch".to_owned()
            } else {
                format!("{epochs} epochs")
            };
            Series {
                name,
                points: finite.iter().filter_map(point).collect(),
                line: false,
                ..Series::default()
            }
        };
        epochs.iter().map(of_epochs).collect()
    };
    let diverged = trials.len() - finite.len();
    let note = if diverged > 0 {
        format!(", {diverged} of which diverged")
    } else {
        String::new()
    };
    Figure {
        title: format!("search over networks for {}", channels.join(", ")),
        caption: format!(
            "{} trials{note}; smallest validation loss of each",
            trials.len()
        ),
        x: Axis::log("learning rate"),
        panels: vec![
            Panel {
                y: Axis::linear("validation cross entropy (nats)"),
                series: series(|trial| trial.reached.validation_loss_nats),
            },
            Panel {
                y: Axis::linear("balanced accuracy").with_range(0.0, 1.05),
                series: series(|trial| trial.reached.validation_balanced_accuracy),
            },
        ],
    }
}
