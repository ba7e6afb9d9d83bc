//! The page of a free energy: its terms, the springs' energy against their strength, the crystal.

use super::NO_BODIES;
use crate::hard_bodies::free_energy::{CRYSTAL, FreeEnergyResult, POINTS};
use crate::last_frame;
use anyhow::Result;
use protomer_common::page::{Contents, Part, Section, Verdict, with_error};
use protomer_plot::{Axis, Figure, Panel, Point, Series};
use protomer_results::Record;
use std::path::Path;

/// Contents of the page of a directory.
///
/// # Errors
/// Never; the signature is that of all pages.
pub fn contents(directory: &Path, record: Option<&Record>) -> Result<Contents> {
    let mut contents = Contents::new("Free energy");
    let mut parts = Vec::new();
    if let Some(result) = record.and_then(Record::answer::<FreeEnergyResult>) {
        contents.subtitle = format!(
            "{} bodies ({}), {}",
            result.bodies, result.shape, result.crystal
        );
        contents.verdict = Some(sampling(&result));
        parts.push(terms(&result));
        parts.push(Part::figure(integrand(&result), POINTS));
    }
    contents.add(Section::new("Results", parts));
    let bodies = last_frame::section(&directory.join(CRYSTAL), "sweeps");
    contents.add_if_readable(bodies, NO_BODIES);
    Ok(contents)
}

fn sampling(result: &FreeEnergyResult) -> Verdict {
    match result.slow() {
        None => Verdict::sampled_enough(true, "every strength has enough independent samples"),
        Some(slow) => Verdict::sampled_enough(false, slow.trim_start_matches("slow: ")),
    }
}

fn terms(result: &FreeEnergyResult) -> Part {
    let terms = &result.terms;
    let row = |name: &str, value: f64, error: Option<f64>| {
        vec![name.to_owned(), with_error(value, error)]
    };
    let rows = vec![
        row("centre of mass", terms.centre_of_mass_kt, None),
        row("strongest springs", terms.springs_kt, None),
        row("orientations", terms.orientations_kt, None),
        row(
            "overlaps with them",
            terms.overlaps_kt,
            Some(terms.overlaps_kt_error),
        ),
        row(
            "weaker springs",
            -terms.integral_kt,
            Some(terms.integral_kt_error),
        ),
        row("free energy", terms.total_kt, Some(terms.total_kt_error)),
        row(
            "excess over an ideal gas",
            result.excess_free_energy_per_body_kt,
            Some(result.excess_free_energy_per_body_kt_error),
        ),
        row(
            "difference to a coarser rule",
            terms.rules_difference_kt,
            Some(terms.rules_difference_kt_error),
        ),
    ];
    Part::Table {
        columns: vec!["term", "kT per body"],
        rows,
    }
}

/// A figure of the integrand against the logarithm of the strength.
fn integrand(result: &FreeEnergyResult) -> Figure {
    let mut points = Vec::new();
    for point in &result.points {
        points.push(Point {
            x: point.strength_kt_per_area,
            y: point.strength_kt_per_area * point.extent,
            error: Some(point.strength_kt_per_area * point.extent_error),
        });
    }
    let series = Series {
        name: "springs".into(),
        points,
        line: true,
        ..Series::default()
    };
    Figure {
        title: "Energy of the springs".into(),
        caption: "half of the degrees of freedom where bodies hardly meet".into(),
        x: Axis::log("strength of the springs λ"),
        panels: vec![Panel {
            y: Axis::linear("λ f (kT per body)"),
            series: vec![series],
        }],
    }
}
