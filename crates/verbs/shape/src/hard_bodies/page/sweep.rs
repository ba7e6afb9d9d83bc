//! The page of a sweep: the equation of state, and the bodies of its densest run.

use super::{NO_BODIES, ONE_START, reached};
use crate::hard_bodies::run::TRAJECTORY;
use crate::hard_bodies::sweep::EquationOfState;
use crate::last_frame;
use anyhow::Result;
use protomer_common::answer::Answer;
use protomer_common::page::{Contents, Part, Section, Verdict, significant, with_error};
use protomer_results::Record;
use protomer_results::keys::read_json_if_present;
use std::path::Path;

/// Contents of the page of a directory.
///
/// # Errors
/// If the equation of state is damaged.
pub fn contents(directory: &Path, _: Option<&Record>) -> Result<Contents> {
    let equation: Option<EquationOfState> = read_json_if_present(&directory.join("equation.json"))?;
    let mut contents = Contents::new("Equation of state");
    contents.verdict = Some(arrivals(equation.as_ref()));
    let Some(equation) = equation else {
        contents.add(Section::new("Results", Vec::new()));
        return Ok(contents);
    };
    let run = &equation.settings.run;
    contents.subtitle = format!(
        "{} bodies ({}), {} states",
        run.bodies,
        run.shape.join(", "),
        equation.points.len()
    );
    let mut parts: Vec<Part> = states(&equation).into_iter().collect();
    let figure = equation.figure();
    parts.extend(figure.map(|figure| Part::figure(figure, "equation.csv")));
    contents.add(Section::new("Results", parts));
    let densest = equation.settings.tasks(directory)?.pop();
    let trajectory = densest.map(|task| task.directory().join(TRAJECTORY));
    // A sweep may have been told to keep no trajectories.
    if let Some(trajectory) = trajectory.filter(|path| path.is_file()) {
        contents.add_if_readable(last_frame::section(&trajectory, "sweeps"), NO_BODIES);
    }
    Ok(contents)
}

/// The verdict on whether all states of a sweep have arrived at their pressures or heights.
fn arrivals(equation: Option<&EquationOfState>) -> Verdict {
    let must_arrive = |equation: &&EquationOfState| {
        let mut points = equation.points.iter();
        points.any(|point| point.equilibrium.is_some())
    };
    let Some(equation) = equation.filter(must_arrive) else {
        return Verdict::equilibrated(None, ONE_START);
    };
    let warnings = equation.warnings();
    match warnings.is_empty() {
        true => Verdict::equilibrated(
            Some(true),
            "every state bears its pressure, and none drifts",
        ),
        false => Verdict::equilibrated(Some(false), &warnings.join("; ")),
    }
}

/// The table of states that must arrive at a pressure or a height; nothing without any.
fn states(equation: &EquationOfState) -> Option<Part> {
    let mut rows = Vec::new();
    for point in &equation.points {
        let Some(equilibrium) = &point.equilibrium else {
            continue;
        };
        rows.push(vec![
            with_error(point.packing_fraction, point.packing_fraction_error),
            with_error(
                equilibrium.measured_pressure_kt_per_volume,
                equilibrium.measured_pressure_kt_per_volume_error,
            ),
            significant(equilibrium.expected_pressure_kt_per_volume, 6),
            match equilibrium.drift {
                Some(drift) => with_error(drift, equilibrium.drift_error),
                None => "-".into(),
            },
            reached(equilibrium.is_reached),
        ]);
    }
    let head = [
        "packing fraction",
        "pressure of the bodies",
        "the same in equilibrium",
        "drift",
        "equilibrium",
    ];
    (!rows.is_empty()).then(|| Part::Table {
        columns: head.into(),
        rows,
    })
}
