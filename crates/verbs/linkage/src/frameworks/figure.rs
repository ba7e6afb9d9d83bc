//! The figure of moduli against loading direction.

use super::report::Report;
use protomer_plot::{Axis, Figure, Panel, Point, Series};

/// A figure of E, above one of ν, against direction; `None` if there is nothing to draw.
pub fn polar_figure(report: &Report) -> Option<Figure> {
    let (mut youngs, mut poissons) = (Vec::new(), Vec::new());
    for direction in &report.polar {
        push(&mut youngs, direction.angle_deg, direction.e_gpa);
        push(&mut poissons, direction.angle_deg, direction.nu);
    }
    // Half a turn closes the curve.
    if let Some(first) = report.polar.first() {
        push(&mut youngs, 180.0, first.e_gpa);
        push(&mut poissons, 180.0, first.nu);
    }
    let mut panels = Vec::new();
    for (label, name, points) in [
        ("Young's modulus (GPa)", "E", youngs),
        ("Poisson's ratio", "ν", poissons),
    ] {
        if !points.is_empty() {
            panels.push(panel(label, name, points));
        }
    }
    if panels.is_empty() {
        return None;
    }
    Some(Figure {
        title: format!("Elastic constants of {}", report.network),
        caption: format!(
            "{} nodes, N_A = {:e} /mol",
            report.nodes, report.avogadro_per_mol
        ),
        x: Axis::linear("direction of the load from y (degrees)").with_range(0.0, 180.0),
        panels,
    })
}

/// Adds a point, unless the modulus is unknown.
fn push(points: &mut Vec<Point>, x: f64, modulus: Option<f64>) {
    if let Some(y) = modulus
        && y.is_finite()
    {
        points.push(Point { x, y, error: None });
    }
}

/// A panel with one curve. The axis is logarithmic for positive values that span more than a decade.
fn panel(label: &str, name: &str, points: Vec<Point>) -> Panel {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for point in &points {
        (low, high) = (low.min(point.y), high.max(point.y));
    }
    let y = match low > 0.0 && high > 10.0 * low {
        true => Axis::log(label),
        false => Axis::linear(label),
    };
    let series = Series {
        name: name.into(),
        points,
        line: true,
        ..Series::default()
    };
    Panel {
        y,
        series: vec![series],
    }
}
