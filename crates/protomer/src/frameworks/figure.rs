//! The figure of moduli against loading direction.

use super::report::{Direction, Report};
use protomer_plot::{Axis, Figure, Panel, Point, Series};

/// E above ν against direction; `None` if there is nothing to draw.
pub fn polar_figure(report: &Report) -> Option<Figure> {
    let series = |name: &str, value: fn(&Direction) -> Option<f64>| Series {
        name: name.into(),
        // Half a turn closes the curve.
        points: report
            .polar
            .iter()
            .map(|direction| (direction.angle_deg, direction))
            .chain(report.polar.first().map(|first| (180.0, first)))
            .filter_map(|(x, direction)| {
                value(direction)
                    .filter(|y| y.is_finite())
                    .map(|y| Point { x, y, error: None })
            })
            .collect(),
        replicas: Vec::new(),
        line: true,
    };
    let panels = [
        (
            Axis::linear("Young's modulus (GPa)"),
            series("E", |direction| direction.e_gpa),
        ),
        (
            Axis::linear("Poisson's ratio"),
            series("ν", |direction| direction.nu),
        ),
    ];
    let panels: Vec<Panel> = panels
        .into_iter()
        .filter(|(_, series)| !series.points.is_empty())
        .map(|(axis, series)| Panel {
            y: spread(axis, &series),
            series: vec![series],
        })
        .collect();
    (!panels.is_empty()).then(|| Figure {
        title: format!("Elastic constants of {}", report.network),
        caption: format!(
            "{} nodes, N_A = {:e} /mol",
            report.nodes, report.avogadro_per_mol
        ),
        x: Axis::linear("direction of the load from y (degrees)").with_range(0.0, 180.0),
        panels,
    })
}

/// A logarithmic axis for positive values that span more than a decade.
fn spread(axis: Axis, series: &Series) -> Axis {
    let values = || series.points.iter().map(|point| point.y);
    let (low, high) = (
        values().fold(f64::INFINITY, f64::min),
        values().fold(f64::NEG_INFINITY, f64::max),
    );
    if low > 0.0 && high > 10.0 * low {
        Axis { log: true, ..axis }
    } else {
        axis
    }
}
