//! The page of a run of contact dynamics.

use super::hard_bodies::{details, with_error};
use super::html::{definitions, significant, significant_or_dash};
use super::page::{Page, Section};
use super::verdict::Verdict;
use super::{convex_bodies, data, figures, provenance};
use anyhow::Result;
use protomer_convex::dynamics::log::LogRow;
use protomer_convex::dynamics::run::DynamicsResult;
use protomer_plot::{Axis, Figure, Panel, Point, Series};
use protomer_results::{Record, log};
use std::path::Path;

/// Number of rows of a log that are drawn.
const MOST_ROWS: usize = 500;
/// Reason why a run does not tell whether it is in equilibrium.
const ONE_RUN: &str = "a run does not test it; compare the course below with that of a run of \
                       another seed or a longer preparation (--equilibrate-steps)";

/// The page of a run.
///
/// # Errors
/// If a file is damaged.
pub fn page(directory: &Path) -> Result<Page> {
    let record = Record::read(directory)?;
    let result: Option<DynamicsResult> = details(record.as_ref(), directory)?;
    let mut problems: Vec<String> = provenance::unfinished(record.as_ref())
        .into_iter()
        .collect();
    let mut html = String::new();
    if let Some(result) = &result {
        html += &definitions(&values(result));
    }
    let rows: Vec<LogRow> = match directory.join("log.csv") {
        path if path.is_file() => log::read_so_far(&path)?,
        _ => Vec::new(),
    };
    if !rows.is_empty() {
        let csv = data::of_file(directory, "log.csv")?;
        html += &figures::drawn(&course(&rows), &csv)?;
    }
    let mut sections = vec![Section::new("Results", html)];
    let trajectory = directory.join("trajectory.gsd");
    // A run may have been told to keep no trajectory.
    if trajectory.is_file() {
        match convex_bodies::section(&trajectory, "steps") {
            Ok(section) => sections.push(section),
            Err(error) => problems.push(format!("The bodies cannot be shown: {error:#}")),
        }
    }
    sections.push(provenance::section(
        directory,
        "run.toml",
        record.as_ref(),
        Vec::new(),
    )?);
    let subtitle = result.as_ref().map(|result| {
        format!(
            "{} bodies in {} dimensions, followed for a time of {}",
            result.bodies,
            result.dimension,
            significant(result.time, 6)
        )
    });
    Ok(Page {
        title: format!("Contact dynamics: {}", provenance::name(directory)),
        subtitle: subtitle.unwrap_or_else(|| "Not finished".into()),
        verdict: Some(Verdict::equilibrated(None, ONE_RUN)),
        problems,
        sections,
    })
}

fn values(result: &DynamicsResult) -> Vec<(&'static str, String)> {
    let number = |value: f64| significant(value, 6);
    let mut values = vec![
        (
            "Packing fraction with the layer",
            number(result.mean_packing_fraction),
        ),
        (
            "Packing fraction at the end",
            number(result.packing_fraction),
        ),
        (
            "The same without the layer",
            number(result.core_packing_fraction),
        ),
        (
            "Pressure",
            with_error(result.pressure, result.pressure_error),
        ),
        ("kT of all motion", number(result.temperature_kt)),
        (
            "kT of the centres",
            number(result.translational_temperature_kt),
        ),
        (
            "kT of the rotations",
            number(result.rotational_temperature_kt),
        ),
        ("Energy per body at the end", number(result.energy_per_body)),
        (
            "Energy of the repulsion per body",
            number(result.potential_energy_per_body),
        ),
        (
            "Drift of the energy per body, without the heat of a bath",
            significant_or_dash(result.energy_drift_per_body, 3),
        ),
        (
            "Noise of the energy per body",
            significant_or_dash(result.energy_noise_per_body, 3),
        ),
        ("Steps after the preparation", result.steps.to_string()),
    ];
    if let Some(acceptance) = result.volume_acceptance {
        values.push(("Accepted trials of the volume", significant(acceptance, 3)));
    }
    values
}

/// A figure of the log against time; times below zero are the preparation.
fn course(rows: &[LogRow]) -> Figure {
    let every = rows.len().div_ceil(MOST_ROWS).max(1);
    let panel = |label: &str, value: fn(&LogRow) -> f64| {
        let points = rows.iter().step_by(every).map(|row| Point {
            x: row.time,
            y: value(row),
            error: None,
        });
        let series = Series {
            points: points.filter(|point| point.y.is_finite()).collect(),
            line: true,
            ..Series::default()
        };
        Panel {
            y: Axis::linear(label),
            series: vec![series],
        }
    };
    let mut panels = vec![
        panel("kT", |row| row.temperature),
        panel("pressure", |row| row.pressure),
        panel("conserved energy per body", |row| row.kept_energy),
    ];
    let first = rows.first().map(|row| row.packing_fraction);
    if rows.iter().any(|row| Some(row.packing_fraction) != first) {
        panels.push(panel("packing fraction", |row| row.packing_fraction));
    }
    panels.retain(|panel| !panel.series[0].points.is_empty());
    Figure {
        title: "Course of the run".into(),
        caption: "rows of the log; the preparation lies before time 0".into(),
        x: Axis::linear("time"),
        panels,
    }
}
