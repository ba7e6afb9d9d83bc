//! `learning_curve.svg`: loss and balanced accuracy against epochs, with the values of guessing;
//! `predicted_numbers.svg`: predicted against true numbers.

use protomer_learn::training::EpochRecord;
use protomer_plot::{Axis, Figure, Panel, Point, Series};

/// The figure of a training.
///
/// `prior_nats`: cross entropy of the class shares on the validation split; `classes`: their
/// number.
pub fn learning_curve(
    title: &str,
    caption: &str,
    curve: &[EpochRecord],
    prior_nats: f64,
    classes: usize,
) -> Figure {
    let line = |name: &str, value: &dyn Fn(&EpochRecord) -> f64| Series {
        name: name.into(),
        points: curve
            .iter()
            .map(|record| Point {
                x: record.epoch as f64,
                y: value(record),
                error: None,
            })
            .collect(),
        line: true,
        ..Series::default()
    };
    let loss = Panel {
        y: Axis::linear("cross entropy (nats)"),
        series: vec![
            line("training", &|record| record.training_loss_nats),
            line("validation", &|record| {
                record.validation_loss_nats.unwrap_or(f64::NAN)
            }),
            line("prior", &|_| prior_nats),
        ],
    };
    let accuracy = Panel {
        y: Axis::linear("balanced accuracy").with_range(0.0, 1.05),
        series: vec![
            line("validation", &|record| {
                record.validation_balanced_accuracy.unwrap_or(f64::NAN)
            }),
            line("guessing", &|_| 1.0 / classes.max(1) as f64),
        ],
    };
    Figure {
        title: title.into(),
        caption: caption.into(),
        x: Axis::count("epoch"),
        panels: vec![loss, accuracy],
    }
}

/// Predicted against true numbers, given as pairs of true and predicted ones, with the line on which both
/// agree.
pub fn predicted_numbers(title: &str, caption: &str, pairs: &[(f64, f64)]) -> Figure {
    let points = |pairs: &[(f64, f64)]| {
        let point = |(x, y): &(f64, f64)| Point {
            x: *x,
            y: *y,
            error: None,
        };
        pairs.iter().map(point).collect()
    };
    let numbers = || pairs.iter().map(|(number, _)| *number);
    let least = numbers().fold(f64::INFINITY, f64::min);
    let greatest = numbers().fold(f64::NEG_INFINITY, f64::max);
    let series = |name: &str, pairs: &[(f64, f64)], line| Series {
        name: name.into(),
        points: points(pairs),
        line,
        ..Series::default()
    };
    Figure {
        title: title.into(),
        caption: caption.into(),
        x: Axis::linear("true number"),
        panels: vec![Panel {
            y: Axis::linear("predicted number"),
            series: vec![
                series("samples of the test part", pairs, false),
                series("equal", &[(least, least), (greatest, greatest)], true),
            ],
        }],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_is_drawn_with_its_baselines() {
        let point = |epoch| EpochRecord {
            epoch,
            training_loss_nats: 1.0 / epoch as f64,
            validation_loss_nats: Some(0.7),
            validation_balanced_accuracy: Some(0.5),
            gradient_norm: 1.0,
            largest_gradient_norm: 2.0,
            learning_rate: 1e-3,
            skipped_steps: 0,
        };
        let svg = learning_curve("shapes", "seed 1", &[point(1), point(2)], 1.79, 6)
            .to_svg()
            .unwrap();
        for word in ["prior", "guessing", "validation", "epoch"] {
            assert!(svg.contains(word), "{word}");
        }
        // A single epoch can be drawn too.
        assert!(
            learning_curve("", "", &[point(1)], 0.69, 2)
                .to_svg()
                .is_ok()
        );
    }
}
