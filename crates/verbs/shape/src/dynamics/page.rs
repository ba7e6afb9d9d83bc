//! The page of a run: averages, the course of its log, the bodies at the end.

use super::log::LogRow;
use super::run::{DynamicsResult, TRAJECTORY};
use crate::course::Course;
use crate::last_frame;
use anyhow::Result;
use protomer_common::page::{
    Contents, Part, Section, Verdict, significant, significant_or_dash, with_error,
};
use protomer_results::Record;
use std::path::Path;

/// Reason why a run does not tell whether it is in equilibrium.
const ONE_RUN: &str = "a run does not test it; compare the course below with that of a run of \
                       another seed or a longer preparation (--equilibrate-steps)";

const COURSE: Course<LogRow> = Course {
    caption: "rows of the log; the preparation lies before time 0",
    against: "time",
    x: |row| row.time,
    has_lines: true,
};

/// Contents of the page of a directory.
///
/// # Errors
/// If the log is damaged.
pub fn contents(directory: &Path, record: Option<&Record>) -> Result<Contents> {
    let mut contents = Contents::new("Contact dynamics");
    contents.verdict = Some(Verdict::equilibrated(None, ONE_RUN));
    let mut parts = Vec::new();
    if let Some(result) = record.and_then(Record::answer::<DynamicsResult>) {
        contents.subtitle = format!(
            "{} bodies in {} dimensions, followed for a time of {}",
            result.bodies,
            result.dimension,
            significant(result.time, 6)
        );
        parts.push(Part::Values(values(&result)));
    }
    parts.extend(COURSE.part(directory)?);
    contents.add(Section::new("Results", parts));
    let trajectory = directory.join(TRAJECTORY);
    // A run may have been told to keep no trajectory.
    if trajectory.is_file() {
        let bodies = last_frame::section(&trajectory, "steps");
        contents.add_if_readable(bodies, "The bodies cannot be shown");
    }
    Ok(contents)
}

fn values(result: &DynamicsResult) -> Vec<(&'static str, String)> {
    let number = |name, value: f64| (name, significant(value, 6));
    let rough = |name, value| (name, significant_or_dash(value, 3));
    let mut values = vec![
        number(
            "Packing fraction with the layer",
            result.mean_packing_fraction,
        ),
        number("Packing fraction at the end", result.packing_fraction),
        number("The same without the layer", result.core_packing_fraction),
        (
            "Pressure",
            with_error(result.pressure, result.pressure_error),
        ),
        number("kT of all motion", result.temperature_kt),
        number("kT of the centres", result.translational_temperature_kt),
        number("kT of the rotations", result.rotational_temperature_kt),
        number("Energy per body at the end", result.energy_per_body),
        number(
            "Energy of the repulsion per body",
            result.potential_energy_per_body,
        ),
        rough(
            "Drift of the energy per body, without the heat of a bath",
            result.energy_drift_per_body,
        ),
        rough("Noise of the energy per body", result.energy_noise_per_body),
        ("Steps after the preparation", result.steps.to_string()),
    ];
    if let Some(acceptance) = result.volume_acceptance {
        values.push(("Accepted trials of the volume", significant(acceptance, 3)));
    }
    values
}
