//! The page of a run: averages, the course of its log, the profile, the bodies at the end.

use super::{NO_BODIES, ONE_START, reached};
use crate::course::Course;
use crate::hard_bodies::equilibrium::Equilibrium;
use crate::hard_bodies::log::LogRow;
use crate::hard_bodies::result::{HardBodyResult, MeanBox};
use crate::hard_bodies::run::TRAJECTORY;
use crate::last_frame;
use anyhow::Result;
use protomer_common::page::{Contents, Part, Section, Verdict, significant, with_error};
use protomer_results::Record;
use std::path::Path;

const COURSE: Course<LogRow> = Course {
    caption: "single measurements",
    against: "sweeps",
    x: |row| row.sweep as f64,
    has_lines: false,
};

/// Contents of the page of a directory.
///
/// # Errors
/// If the log is damaged.
pub fn contents(directory: &Path, record: Option<&Record>) -> Result<Contents> {
    let result: Option<HardBodyResult> = record.and_then(Record::answer);
    let mut contents = Contents::new("Hard bodies");
    contents.verdict = Some(arrival(result.as_ref()));
    let mut parts = Vec::new();
    if let Some(result) = &result {
        contents.subtitle = format!("{} bodies ({})", result.bodies, result.shape);
        parts.push(Part::Values(values(result)));
    }
    parts.extend(COURSE.part(directory)?);
    parts.push(Part::file("profile.csv"));
    contents.add(Section::new("Results", parts));
    let bodies = last_frame::section(&directory.join(TRAJECTORY), "sweeps");
    contents.add_if_readable(bodies, NO_BODIES);
    Ok(contents)
}

/// The verdict on whether a run has arrived at its pressure, or under gravity at its height. Other
/// runs do not test it.
fn arrival(result: Option<&HardBodyResult>) -> Verdict {
    match result.and_then(|result| result.equilibrium.as_ref()) {
        None => Verdict::equilibrated(None, ONE_START),
        Some(equilibrium) => {
            Verdict::equilibrated(Some(equilibrium.is_reached), &equilibrium.text())
        }
    }
}

fn values(result: &HardBodyResult) -> Vec<(&'static str, String)> {
    let number = |name, value: f64, error| (name, with_error(value, error));
    let mut values = vec![
        number(
            "Packing fraction",
            result.packing_fraction,
            result.packing_fraction_error,
        ),
        number(
            "Compressibility factor",
            result.compressibility_factor,
            result.compressibility_factor_error,
        ),
        ("Sweeps", result.sweeps.to_string()),
        ("Accepted moves", significant(result.acceptance, 3)),
    ];
    values.extend(result.equilibrium.iter().flat_map(balance));
    values.extend(result.mean_box.iter().flat_map(shape_of_box));
    if let Some(walls) = &result.walls {
        values.extend([
            number(
                "Pressure at the lower wall",
                walls.lower_pressure,
                walls.lower_pressure_error,
            ),
            number("Weight per area", walls.weight_per_area, None),
            number("Mean height", walls.mean_height, walls.mean_height_error),
        ]);
    }
    if let Some(potential_kt) = result.excess_chemical_potential_kt {
        let error_kt = result.excess_chemical_potential_kt_error;
        values.push(number(
            "Excess chemical potential (kT)",
            potential_kt,
            error_kt,
        ));
    }
    if let Some(fraction) = result.free_volume_fraction {
        let error = result.free_volume_fraction_error;
        values.push(number("Free volume of depletants", fraction, error));
    }
    values
}

/// Whether a run bears its pressure.
fn balance(equilibrium: &Equilibrium) -> Vec<(&'static str, String)> {
    let measured = with_error(
        equilibrium.measured_pressure_kt_per_volume,
        equilibrium.measured_pressure_kt_per_volume_error,
    );
    let expected = significant(equilibrium.expected_pressure_kt_per_volume, 6);
    let mut values = vec![
        ("Equilibrium", reached(equilibrium.is_reached)),
        ("Pressure of the bodies (kT per volume)", measured),
        ("The same in equilibrium", expected),
    ];
    if let Some(drift) = equilibrium.drift {
        let drift = with_error(drift, equilibrium.drift_error);
        values.push(("Drift over the measurement", drift));
    }
    values
}

/// The mean box of a run whose box changes its shape.
fn shape_of_box(mean: &MeanBox) -> Vec<(&'static str, String)> {
    let several = |numbers: &[f64], errors: &[Option<f64>]| {
        let numbers = numbers.iter().zip(errors);
        let words: Vec<String> = numbers.map(|(x, error)| with_error(*x, *error)).collect();
        words.join(", ")
    };
    let mut values = vec![(
        "Lengths of the box",
        several(&mean.lengths, &mean.lengths_error),
    )];
    if !mean.tilt_factors.is_empty() {
        let tilts = several(&mean.tilt_factors, &mean.tilt_factors_error);
        values.push(("Tilt factors of the box", tilts));
    }
    values
}
