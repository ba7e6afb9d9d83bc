//! The log of a run as a figure: every column that its declaration gives a panel.

use anyhow::Result;
use protomer_common::page::Part;
use protomer_plot::{Axis, Figure, Panel, Point, Series};
use protomer_results::Row;
use protomer_results::log::{self, Curve};
use std::path::Path;

/// Number of rows of a log that are drawn.
const MOST_ROWS: usize = 500;

/// Style in which a log is drawn.
#[derive(Debug)]
pub struct Course<R> {
    /// A line in small print below the title.
    pub caption: &'static str,
    /// Label of the x axis.
    pub against: &'static str,
    /// Abscissa of a row.
    pub x: fn(&R) -> f64,
    /// Whether rows are states that lines join; otherwise they are single measurements.
    pub has_lines: bool,
}

impl<R: Row> Course<R> {
    /// The figure of the log in a directory, with its table; `None` if there are no rows yet.
    ///
    /// # Errors
    /// If the log is damaged.
    pub fn part(&self, directory: &Path) -> Result<Option<Part>> {
        let path = directory.join(log::FILE);
        if !path.is_file() {
            return Ok(None);
        }
        let rows: Vec<R> = log::read_so_far(&path)?;
        Ok((!rows.is_empty()).then(|| Part::figure(self.figure(&rows), log::FILE)))
    }

    /// A figure of these rows. Panels in which nothing changes are left out, unless all are such.
    fn figure(&self, rows: &[R]) -> Figure {
        let every = rows.len().div_ceil(MOST_ROWS).max(1);
        let thinned: Vec<&R> = rows.iter().step_by(every).collect();
        let mut panels: Vec<Panel> = Vec::new();
        for curve in R::curves() {
            let places = self.places(&thinned, &curve);
            if places.is_empty() {
                continue;
            }
            let series = self.series(&curve, places);
            match panels.iter_mut().find(|panel| panel.y.label == curve.panel) {
                Some(panel) => panel.series.push(series),
                None => panels.push(Panel {
                    y: Axis::linear(curve.panel),
                    series: vec![series],
                }),
            }
        }
        if panels.iter().any(changes) {
            panels.retain(changes);
        }
        Figure {
            title: "Course of the run".into(),
            caption: self.caption.into(),
            x: Axis::linear(self.against),
            panels,
        }
    }

    fn places(&self, rows: &[&R], curve: &Curve<R>) -> Vec<[f64; 2]> {
        let places = rows
            .iter()
            .filter_map(|row| Some([(self.x)(row), curve.value(row)?]));
        places.filter(|[_, y]| y.is_finite()).collect()
    }

    fn series(&self, curve: &Curve<R>, places: Vec<[f64; 2]>) -> Series {
        let point = |[x, y]: [f64; 2]| Point { x, y, error: None };
        let (points, replicas) = match self.has_lines {
            true => (places.into_iter().map(point).collect(), Vec::new()),
            false => (Vec::new(), places),
        };
        Series {
            name: curve.name.into(),
            line: self.has_lines,
            points,
            replicas,
            ..Series::default()
        }
    }
}

/// Whether a curve of a panel has two values.
fn changes(panel: &Panel) -> bool {
    panel.series.iter().any(|series| {
        let points = series.points.iter().map(|point| point.y);
        let replicas = series.replicas.iter().map(|[_, y]| *y);
        let values: Vec<f64> = points.chain(replicas).collect();
        values.windows(2).any(|pair| pair[0] != pair[1])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    protomer_results::log_row! {
        /// A row with columns of every kind.
        struct State {
            step: u64,
            energy: f64 => "energy" as "total",
            kept_energy: f64 => "energy" as "conserved",
            pressure: f64 => "pressure",
            density: f64 => "density",
        }
    }

    const COURSE: Course<State> = Course {
        caption: "",
        against: "steps",
        x: |row| row.step as f64,
        has_lines: true,
    };

    fn states(count: u64) -> Vec<State> {
        let state = |step| State {
            step,
            energy: step as f64,
            kept_energy: 1.0,
            pressure: if step == 1 {
                f64::NAN
            } else {
                2.0 * step as f64
            },
            density: 0.5,
        };
        (0..count).map(state).collect()
    }

    #[test]
    fn each_declared_column_that_changes_is_drawn_in_its_panel() {
        let figure = COURSE.figure(&states(4));
        let panels: Vec<&str> = figure
            .panels
            .iter()
            .map(|panel| panel.y.label.as_str())
            .collect();
        assert_eq!(panels, ["energy", "pressure"]);
        let names: Vec<&str> = figure.panels[0]
            .series
            .iter()
            .map(|series| series.name.as_str())
            .collect();
        assert_eq!(names, ["total", "conserved"]);
        let pressures: Vec<[f64; 2]> = figure.panels[1].series[0]
            .points
            .iter()
            .map(|point| [point.x, point.y])
            .collect();
        assert_eq!(pressures, [[0.0, 0.0], [2.0, 4.0], [3.0, 6.0]]);
    }

    #[test]
    fn one_row_is_drawn_and_a_long_log_is_thinned() {
        assert_eq!(COURSE.figure(&states(1)).panels.len(), 3);
        let drawn = COURSE.figure(&states(1200));
        assert_eq!(drawn.panels[0].series[0].points.len(), 400);
    }
}
