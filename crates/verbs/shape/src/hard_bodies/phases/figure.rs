//! The phase diagram as a figure.

use super::{Coexistence, Phases};
use anyhow::{Result, bail};
use protomer_common::answer::Answer;
use protomer_common::output_file::write_once;
use protomer_plot::{Axis, Figure, Panel, Point, Series, literal};
use std::path::Path;

/// Packing fractions of coexisting phases against that of the depletants in the reservoir.
pub(super) fn against_reservoir(phases: &Phases, size_ratio: Option<f64>) -> Figure {
    let is_here = |coexistence: &&Coexistence| coexistence.size_ratio == size_ratio;
    let series = |name: &str, points: Vec<Point>, line: bool| Series {
        name: name.to_owned(),
        points,
        line,
        ..Series::default()
    };
    let plain_point = |x: f64, y: f64| Point { x, y, error: None };
    let mut drawn = Vec::new();
    for (tie_lines, name) in [
        (&phases.metastable, "metastable gas and liquid"),
        (&phases.coexistences, "coexistence"),
    ] {
        for tie in tie_lines.iter().filter(is_here) {
            let y = tie.reservoir_packing_fraction.unwrap_or_default();
            let ends = tie.packing_fractions.map(|x| plain_point(x, y)).to_vec();
            let measured = literal(&tie.phases.join(", "));
            let name = tie.uncertainty.map_or(name, |_| &measured);
            drawn.push(series(name, ends, true));
        }
    }
    for point in phases
        .critical_points
        .iter()
        .filter(|point| Some(point.size_ratio) == size_ratio)
    {
        let place = plain_point(point.packing_fraction, point.reservoir_packing_fraction);
        drawn.push(series("critical point", vec![place], false));
    }
    for point in phases
        .triple_points
        .iter()
        .filter(|point| Some(point.size_ratio) == size_ratio)
    {
        let y = point.reservoir_packing_fraction;
        let places = point.packing_fractions.map(|x| plain_point(x, y)).to_vec();
        drawn.push(series("triple point", places, true));
    }
    Figure {
        title: match size_ratio {
            Some(q) => format!("Spheres among depletants, size ratio {q}"),
            None => "Bodies among depletants".into(),
        },
        caption: "lines join phases that coexist".into(),
        x: Axis::linear("packing fraction of the bodies"),
        panels: vec![Panel {
            y: Axis::linear("packing fraction of the depletants in the reservoir"),
            series: drawn,
        }],
    }
}

/// Draws a phase diagram of bodies among depletants, a PNG or SVG file.
///
/// # Errors
/// Without a coexistence, for several size ratios, for another extension, or a file that exists with
/// other content unless `force` is set.
pub fn draw(phases: &Phases, output: &Path, force: bool) -> Result<()> {
    let ratios = phases
        .coexistences
        .iter()
        .map(|coexistence| coexistence.size_ratio);
    let Some(figure) = phases.figure() else {
        bail!("no phases coexist, so there is no diagram to draw; leave out --output");
    };
    if ratios
        .clone()
        .any(|ratio| Some(ratio) != ratios.clone().next())
    {
        bail!("a figure holds one size ratio; give one, or leave out --output");
    }
    match output.extension().and_then(|ending| ending.to_str()) {
        Some("png") => write_once(output, &figure.to_png()?, force),
        Some("svg") => write_once(output, &figure.to_svg()?, force),
        _ => bail!(
            "{} ends in neither .png nor .svg; choose one of them",
            output.display()
        ),
    }
}
