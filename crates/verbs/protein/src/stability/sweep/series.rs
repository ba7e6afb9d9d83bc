//! The figure of a single simulation: its observables against time. A curve over salt would be one
//! point.

use crate::stability::run::LogRow;
use crate::stability::run::columns::{Column, Drawn};
use protomer_plot::{Axis, Figure, Panel, Point, Series};

/// Largest number of points that can be told apart on a page.
const MOST_POINTS: usize = 1000;

/// The columns that are drawn against sweeps, here and on a page.
pub fn drawn() -> Vec<&'static Column> {
    let mut all = Column::all();
    all.retain(|column| column.drawn != Drawn::Nowhere);
    all
}

/// The axis of a column.
pub fn axis(column: &Column) -> Axis {
    Axis {
        range: column.range,
        ..Axis::linear(column.title)
    }
}

/// The observables against sweeps; what has no value is left out.
pub fn figure(title: String, caption: String, rows: &[LogRow]) -> Figure {
    let step = rows.len().div_ceil(MOST_POINTS).max(1);
    let mut panels = Vec::new();
    for column in drawn() {
        let value = |row: &LogRow| row.numbers.get(column);
        if !rows.iter().all(|row| value(row).is_finite()) {
            continue;
        }
        let points = rows.iter().step_by(step).map(|row| Point {
            x: row.sweep as f64,
            y: value(row),
            error: None,
        });
        panels.push(Panel {
            y: axis(column),
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
    use crate::stability::run::Columns;

    fn row(sweep: u64, native_contacts: f64) -> LogRow {
        LogRow {
            sweep,
            numbers: Columns {
                native_contacts,
                ..Columns::new(|_| 1.0)
            },
        }
    }

    #[test]
    fn each_known_observable_has_a_panel_over_the_whole_run() {
        let rows: Vec<LogRow> = (1..=2500).map(|sweep| row(sweep, 0.5)).collect();
        let drawn = figure("title".into(), "caption".into(), &rows);
        assert_eq!(drawn.panels.len(), super::drawn().len());
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
        assert_eq!(labels.len(), super::drawn().len() - 1);
        assert!(!labels.contains(&"native contacts left"));
    }
}
