//! The figure of a single simulation: its observables against time. A curve over salt would be one
//! point.

use crate::stability::run::LogRow;
use protomer_plot::{Axis, Figure, Panel, Point, Series};

/// Largest number of points that can be told apart on a page.
const MOST_POINTS: usize = 1000;

/// An observable of the log: its label, its value in a row, and the range of its axis.
pub type Observable = (&'static str, fn(&LogRow) -> f64, Option<[f64; 2]>);

const FRACTION: Option<[f64; 2]> = Some([0.0, 1.05]);

/// The observables that are drawn against sweeps, here and on a page.
pub const OBSERVABLES: [Observable; 5] = [
    ("radius of gyration (Å)", |row| row.r_g_angstrom, None),
    ("native contacts left", |row| row.native_contacts, FRACTION),
    ("pairs of bodies in contact", |row| row.contacts, None),
    (
        "bodies that touch another",
        |row| row.bound_fraction,
        FRACTION,
    ),
    ("energy (kT)", |row| row.energy_kt, None),
];

/// The observables against sweeps; what has no value is left out.
pub fn figure(title: String, caption: String, rows: &[LogRow]) -> Figure {
    let step = rows.len().div_ceil(MOST_POINTS).max(1);
    let mut panels = Vec::new();
    for (label, value, range) in OBSERVABLES {
        if !rows.iter().all(|row| value(row).is_finite()) {
            continue;
        }
        let points = rows.iter().step_by(step).map(|row| Point {
            x: row.sweep as f64,
            y: value(row),
            error: None,
        });
        panels.push(Panel {
            y: Axis {
                range,
                ..Axis::linear(label)
            },
            series: vec![Series {
                name: String::new(),
                points: points.collect(),
                line: true,
                ..Series::default()
            }],
        });
    }
    Figure {
        title,
        caption,
        x: Axis::count("sweeps of production"),
        panels,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(sweep: u64, native_contacts: f64) -> LogRow {
        LogRow {
            sweep,
            r_g_angstrom: 20.0,
            native_contacts,
            largest_cluster: 2,
            energy_kt: -3.0,
            cluster_moved: 1.0,
            contacts: 1.0,
            bound_fraction: 1.0,
        }
    }

    #[test]
    fn each_known_observable_has_a_panel_over_the_whole_run() {
        let rows: Vec<LogRow> = (1..=2500).map(|sweep| row(sweep, 0.5)).collect();
        let drawn = figure("title".into(), "caption".into(), &rows);
        assert_eq!(drawn.panels.len(), 5);
        for panel in &drawn.panels {
            let points = &panel.series[0].points;
            assert!(
                (800..=MOST_POINTS).contains(&points.len()),
                "{}",
                points.len()
            );
            assert!(points[0].x == 1.0 && points[points.len() - 1].x > 2490.0);
        }
        // An assembly without contacts has no fraction of them.
        let none = figure("title".into(), "caption".into(), &[row(1, f64::NAN)]);
        let labels: Vec<&str> = none
            .panels
            .iter()
            .map(|panel| panel.y.label.as_str())
            .collect();
        assert_eq!(labels.len(), 4);
        assert!(!labels.contains(&"native contacts left"));
    }
}
