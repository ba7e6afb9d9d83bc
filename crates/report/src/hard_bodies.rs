//! The pages of runs of hard bodies and of free energies of crystals.

use super::html::{definitions, significant, table};
use super::page::{Page, Section};
use super::verdict::Verdict;
use super::{convex_bodies, data, figures, provenance};
use anyhow::Result;
use protomer_common::answer::Answer;
use protomer_convex::hard_bodies::free_energy::FreeEnergyResult;
use protomer_convex::hard_bodies::log::LogRow;
use protomer_convex::hard_bodies::result::HardBodyResult;
use protomer_convex::hard_bodies::sweep::EquationOfState;
use protomer_plot::{Axis, Figure, Panel, Point, Series};
use protomer_results::keys::read_json_if_present;
use protomer_results::{Record, log};
use serde::de::DeserializeOwned;
use std::path::Path;

/// The title of a sweep.
const SWEEP: &str = "Equation of state";
/// Reason why a run of hard bodies does not tell whether it is in equilibrium.
const ONE_START: &str = "a run does not test it; compare the course with that of a run from \
                         another start (--start) or seed";
/// Number of rows of a log that are drawn.
const MOST_ROWS: usize = 500;
/// Tilt factors of a box, in their order.
const TILTS: [&str; 3] = ["tilt factor xy", "tilt factor xz", "tilt factor yz"];

/// The page of a run.
///
/// # Errors
/// If a file is damaged.
pub fn page_of_run(directory: &Path) -> Result<Page> {
    let record = Record::read(directory)?;
    let result: Option<HardBodyResult> = details(record.as_ref(), directory)?;
    let rows: Vec<LogRow> = match directory.join("log.csv") {
        path if path.is_file() => log::read_so_far(&path)?,
        _ => Vec::new(),
    };
    let mut html = String::new();
    if let Some(result) = &result {
        html += &definitions(&values_of_run(result));
    }
    if !rows.is_empty() {
        let csv = data::of_file(directory, "log.csv")?;
        html += &figures::drawn(&course(&rows), &csv)?;
    }
    html += &data::of_file(directory, "profile.csv")?;
    let subtitle = result
        .as_ref()
        .map(|result| format!("{} bodies ({})", result.bodies, result.shape));
    let results = Results {
        title: "Hard bodies",
        subtitle,
        verdict: Some(arrival(result.as_ref())),
        html,
        trajectory: "trajectory.gsd".into(),
    };
    page(directory, results, record.as_ref())
}

/// The page of a sweep: the equation of state, and the bodies of its densest run.
///
/// # Errors
/// If a file is damaged.
pub fn page_of_sweep(directory: &Path) -> Result<Page> {
    let record = Record::read(directory)?;
    let equation: Option<EquationOfState> = read_json_if_present(&directory.join("equation.json"))?;
    let (mut html, mut trajectory) = (String::new(), String::new());
    if let Some(equation) = &equation {
        let csv = data::of_file(directory, "equation.csv")?;
        html += &states(equation);
        if let Some(figure) = equation.figure() {
            html += &figures::drawn(&figure, &csv)?;
        }
        if let Some(task) = equation.settings.tasks(Path::new(""))?.pop() {
            let path = task.directory().join("trajectory.gsd");
            trajectory = path.display().to_string();
        }
    }
    let subtitle = equation.as_ref().map(|equation| {
        let run = &equation.settings.run;
        format!(
            "{} bodies ({}), {} states",
            run.bodies,
            run.shape,
            equation.points.len()
        )
    });
    let results = Results {
        title: SWEEP,
        subtitle,
        verdict: Some(arrivals(equation.as_ref())),
        html,
        trajectory,
    };
    page(directory, results, record.as_ref())
}

/// The page of a free energy.
///
/// # Errors
/// If a file is damaged.
pub fn page_of_free_energy(directory: &Path) -> Result<Page> {
    let record = Record::read(directory)?;
    let result: Option<FreeEnergyResult> = details(record.as_ref(), directory)?;
    let mut html = String::new();
    if let Some(result) = &result {
        html += &terms(result);
        let csv = data::of_file(directory, "points.csv")?;
        html += &figures::drawn(&integrand(result), &csv)?;
    }
    let subtitle = result.as_ref().map(|result| {
        format!(
            "{} bodies ({}), {}",
            result.bodies, result.shape, result.crystal
        )
    });
    let results = Results {
        title: "Free energy",
        subtitle,
        verdict: result.as_ref().map(sampling),
        html,
        trajectory: "crystal.gsd".into(),
    };
    page(directory, results, record.as_ref())
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

fn sampling(result: &FreeEnergyResult) -> Verdict {
    match result.slow() {
        None => Verdict::sampled_enough(true, "every strength has enough independent samples"),
        Some(slow) => Verdict::sampled_enough(false, slow.trim_start_matches("slow: ")),
    }
}

/// Results of a kind of run, as its page shows them.
struct Results {
    title: &'static str,
    /// Subtitle of the page; `None` before there is a result.
    subtitle: Option<String>,
    verdict: Option<Verdict>,
    html: String,
    /// The file with the bodies.
    trajectory: String,
}

fn page(directory: &Path, results: Results, record: Option<&Record>) -> Result<Page> {
    let mut problems: Vec<String> = provenance::unfinished(record).into_iter().collect();
    let mut sections = vec![Section::new("Results", results.html)];
    let trajectory = directory.join(&results.trajectory);
    match convex_bodies::section(&trajectory, "sweeps") {
        // A sweep may have been told to keep no trajectories.
        _ if !trajectory.is_file() && results.title == SWEEP => {}
        Ok(section) => sections.push(section),
        Err(error) => problems.push(format!("The bodies cannot be shown: {error:#}")),
    }
    sections.push(provenance::section(
        directory,
        "run.toml",
        record,
        Vec::new(),
    )?);
    Ok(Page {
        title: format!("{}: {}", results.title, provenance::name(directory)),
        subtitle: results.subtitle.unwrap_or_else(|| "Not finished".into()),
        verdict: results.verdict,
        problems,
        sections,
    })
}

/// The result in the record; `None` before there is one.
pub fn details<T: DeserializeOwned>(
    record: Option<&Record>,
    directory: &Path,
) -> Result<Option<T>> {
    match record {
        Some(record) if !record.details.is_null() => Ok(record.read_details(directory).ok()),
        _ => Ok(None),
    }
}

/// The table of states that must arrive at a pressure or a height; nothing without any.
fn states(equation: &EquationOfState) -> String {
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
            match equilibrium.is_reached {
                true => "reached".into(),
                false => "not reached".into(),
            },
        ]);
    }
    let head = [
        "packing fraction",
        "pressure of the bodies",
        "the same in equilibrium",
        "drift",
        "equilibrium",
    ];
    match rows.is_empty() {
        true => String::new(),
        false => table(&head.map(str::to_owned), &rows),
    }
}

pub fn with_error(value: f64, error: Option<f64>) -> String {
    match error {
        Some(error) => format!("{} ± {}", significant(value, 6), significant(error, 2)),
        None => significant(value, 6),
    }
}

fn values_of_run(result: &HardBodyResult) -> Vec<(&'static str, String)> {
    let mut values = vec![
        (
            "Packing fraction",
            with_error(result.packing_fraction, result.packing_fraction_error),
        ),
        (
            "Compressibility factor",
            with_error(
                result.compressibility_factor,
                result.compressibility_factor_error,
            ),
        ),
        ("Sweeps", result.sweeps.to_string()),
        ("Accepted moves", significant(result.acceptance, 3)),
    ];
    if let Some(equilibrium) = &result.equilibrium {
        values.push((
            "Equilibrium",
            match equilibrium.is_reached {
                true => "reached".into(),
                false => "not reached".into(),
            },
        ));
        values.push((
            "Pressure of the bodies (kT per volume)",
            with_error(
                equilibrium.measured_pressure_kt_per_volume,
                equilibrium.measured_pressure_kt_per_volume_error,
            ),
        ));
        values.push((
            "The same in equilibrium",
            significant(equilibrium.expected_pressure_kt_per_volume, 6),
        ));
        if let Some(drift) = equilibrium.drift {
            values.push((
                "Drift over the measurement",
                with_error(drift, equilibrium.drift_error),
            ));
        }
    }
    if let Some(mean) = &result.mean_box {
        let several = |numbers: &[f64], errors: &[Option<f64>]| {
            let numbers = numbers.iter().zip(errors);
            let words: Vec<String> = numbers.map(|(x, error)| with_error(*x, *error)).collect();
            words.join(", ")
        };
        values.push((
            "Lengths of the box",
            several(&mean.lengths, &mean.lengths_error),
        ));
        if !mean.tilt_factors.is_empty() {
            let tilts = several(&mean.tilt_factors, &mean.tilt_factors_error);
            values.push(("Tilt factors of the box", tilts));
        }
    }
    if let Some(walls) = &result.walls {
        values.extend([
            (
                "Pressure at the lower wall",
                with_error(walls.lower_pressure, walls.lower_pressure_error),
            ),
            ("Weight per area", significant(walls.weight_per_area, 6)),
            (
                "Mean height",
                with_error(walls.mean_height, walls.mean_height_error),
            ),
        ]);
    }
    if let Some(potential) = result.excess_chemical_potential_kt {
        let error = result.excess_chemical_potential_kt_error;
        values.push((
            "Excess chemical potential (kT)",
            with_error(potential, error),
        ));
    }
    if let Some(fraction) = result.free_volume_fraction {
        let error = result.free_volume_fraction_error;
        values.push(("Free volume of depletants", with_error(fraction, error)));
    }
    values
}

/// A figure of the measurements against sweeps.
fn course(rows: &[LogRow]) -> Figure {
    let every = rows.len().div_ceil(MOST_ROWS).max(1);
    let panel = |label: &str, value: &dyn Fn(&LogRow) -> Option<f64>| {
        let points = rows.iter().step_by(every);
        let replicas: Vec<[f64; 2]> = points
            .filter_map(|row| Some([row.sweep as f64, value(row)?]))
            .collect();
        let series = Series {
            name: label.into(),
            replicas,
            ..Series::default()
        };
        Panel {
            y: Axis::linear(label),
            series: vec![series],
        }
    };
    let first = rows.first().map(|row| row.packing_fraction);
    let changes = rows.iter().any(|row| Some(row.packing_fraction) != first);
    let mut panels = vec![panel("compressibility factor", &|row| {
        Some(row.compressibility_factor)
    })];
    if changes {
        panels.push(panel("packing fraction", &|row| Some(row.packing_fraction)));
    }
    for (number, label) in TILTS.into_iter().enumerate() {
        let tilt = |row: &LogRow| row.box_tilt_factors.get(number).copied();
        if rows.iter().any(|row| tilt(row).is_some()) {
            panels.push(panel(label, &tilt));
        }
    }
    if rows.iter().any(|row| row.walls.is_some()) {
        panels.push(panel("mean height", &|row| Some(row.walls?.mean_height)));
    }
    if rows.iter().any(|row| !row.free_volume.is_empty()) {
        panels.push(panel("free volume fraction", &|row| {
            row.free_volume.first().copied()
        }));
    }
    Figure {
        title: "Course of the run".into(),
        caption: "single measurements".into(),
        x: Axis::linear("sweeps"),
        panels,
    }
}

fn terms(result: &FreeEnergyResult) -> String {
    let terms = &result.terms;
    let row = |name: &str, value: f64, error: Option<f64>| {
        vec![name.to_owned(), with_error(value, error)]
    };
    let rows = [
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
    let head = ["term", "kT per body"];
    table(&head.map(str::to_owned), &rows)
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
