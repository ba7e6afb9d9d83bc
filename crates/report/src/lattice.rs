//! The pages of a lattice and of a sweep of lattices.

use super::html::{definitions, paragraph, significant, table};
use super::page::{Page, Section};
use super::{data, figures, provenance};
use anyhow::Result;
use protomer_io::csv::{Cell, Table};
use protomer_lattices::lattice::animation::{Animation, PLAYER, PLAYER_SCRIPT, PLAYER_STYLE};
use protomer_lattices::lattice::log::LogRow;
use protomer_lattices::lattice::run::LatticeResult;
use protomer_lattices::lattice::settings::LatticeSettings;
use protomer_lattices::lattice::sweep::{axes, tasks};
use protomer_plot::{Axis, Figure, Panel, Point, Series};
use protomer_results::{Record, Row, log};
use std::path::Path;

/// Upper limit for the numbers in an animation, some megabytes of text.
const MOST_NUMBERS: usize = 300_000;
/// Maximum number of frames.
const MOST_FRAMES: usize = 200;
/// Maximum number of log rows that are drawn and embedded.
const MOST_ROWS: usize = 1000;

/// The size of the player on this page.
const STAGE_STYLE: &str = include_str!("stage.css");

/// The figures of a sweep: file, title.
const SWEEP_FIGURES: [(&str, &str); 9] = [
    ("poisson.svg", "Poisson's ratio against rod length"),
    ("synchronisation.svg", "Synchronisation against rod length"),
    (
        "checkerboard.svg",
        "The checkerboard mode against rod length",
    ),
    ("spread.svg", "Spread of the angles against κ"),
    ("phase_differences.svg", "Phase differences"),
    ("strains.svg", "Strain against strain"),
    ("crossings.svg", "Passages through the open state"),
    (
        "lyapunov.svg",
        "Maximal Lyapunov exponent against rod length",
    ),
    ("indices.svg", "Synchronisation indices between squares"),
];

/// The page of a run with these settings.
///
/// # Errors
/// If a file is damaged.
pub fn page_of_run(directory: &Path, settings: &LatticeSettings) -> Result<Page> {
    let record = Record::read(directory)?;
    let mut problems: Vec<String> = provenance::unfinished(record.as_ref())
        .into_iter()
        .collect();
    let mut sections = Vec::new();
    match animation(directory, settings) {
        Ok(section) => sections.push(section),
        Err(error) => problems.push(format!("The run cannot be played: {error:#}")),
    }
    sections.push(history(directory, record.as_ref())?);
    sections.push(conditions(settings));
    sections.push(provenance::section(
        directory,
        "run.toml",
        record.as_ref(),
        seed(settings),
    )?);
    Ok(Page {
        title: format!("Lattice: {}", provenance::name(directory)),
        subtitle: subtitle(settings),
        verdict: None,
        problems,
        sections,
    })
}

/// The page of a sweep with these settings.
///
/// # Errors
/// If a file is damaged.
pub fn page_of_sweep(directory: &Path, settings: &LatticeSettings) -> Result<Page> {
    let record = Record::read(directory)?;
    let mut problems: Vec<String> = provenance::unfinished(record.as_ref())
        .into_iter()
        .collect();
    let mut html = String::new();
    for (file, title) in SWEEP_FIGURES {
        html += &figures::of_file(directory, file, title, "")?;
    }
    if html.is_empty() {
        html += &paragraph("There are no figures yet: they are drawn when all runs are done.");
    }
    html += &data::of_file(directory, "lattice.csv")?;
    html += &data::of_file(directory, "runs.csv")?;
    html += &data::of_file(directory, "crossings.csv")?;
    let mut sections = vec![Section::new("Results", html)];
    let tasks = tasks(settings, directory)?;
    let mut rows = Vec::new();
    for task in &tasks {
        let record = Record::read(&task.directory)?;
        let [r0, kappa] = [task.settings.r0, task.settings.kappa].map(|x| significant(x, 6));
        let steps = record.as_ref().and_then(|record| record.done);
        let progress = steps.map_or_else(String::new, |steps| format!(" after {steps} steps"));
        if let Some(problem) = provenance::problem_of_part(record.as_ref(), &progress) {
            problems.push(format!(
                "r0 = {r0}, κ = {kappa}, seed {}: {problem}",
                task.settings.seed
            ));
        }
        rows.push(vec![
            r0,
            kappa,
            task.settings.seed.to_string(),
            provenance::ended(record.as_ref()).to_owned(),
        ]);
    }
    let playable = tasks
        .iter()
        .find_map(|task| animation(&task.directory, &task.settings).ok());
    match playable {
        Some(section) => sections.push(section),
        None => problems.push(
            "No run can be played: none has frames; run with --trajectory-every 50 or so".into(),
        ),
    }
    sections.push(conditions(settings));
    let head = ["r0", "κ", "seed", "ended"].map(str::to_owned);
    sections.push(Section::new("Runs", table(&head, &rows)));
    sections.push(provenance::section(
        directory,
        "run.toml",
        record.as_ref(),
        seed(settings),
    )?);
    Ok(Page {
        title: format!("Sweep of lattices: {}", provenance::name(directory)),
        subtitle: format!("{}; {} runs", subtitle(settings), tasks.len()),
        verdict: None,
        problems,
        sections,
    })
}

fn subtitle(settings: &LatticeSettings) -> String {
    format!(
        "{} × {} rigid squares joined by rigid rods; reduced units",
        settings.rows, settings.columns
    )
}

fn seed(settings: &LatticeSettings) -> Vec<(&'static str, String)> {
    let seeds: Vec<String> = axes(settings).seeds.iter().map(u64::to_string).collect();
    vec![("seed", seeds.join(", "))]
}

/// The player with frames of a run.
fn animation(directory: &Path, settings: &LatticeSettings) -> Result<Section> {
    let numbers = 3 * settings.rows.saturating_mul(settings.columns).max(1);
    let animation = Animation::read(directory, (MOST_NUMBERS / numbers).clamp(20, MOST_FRAMES))?;
    let note = format!(
        "{}; {} frames, evenly spaced over the run.",
        animation.title(),
        animation.len()
    );
    Ok(Section {
        title: "Animation".into(),
        html: format!(
            "<div class=\"stage\" tabindex=\"0\">\n{PLAYER}</div>\n{}",
            paragraph(&note)
        ),
        style: PLAYER_STYLE.to_owned() + STAGE_STYLE,
        library: PLAYER_SCRIPT,
        script: format!(
            "{{ const stage = document.querySelector(\".stage\"); playLattice(stage.firstElementChild, stage, {}); }}\n",
            animation.to_json()
        ),
    })
}

/// The result of a run, and its log.
fn history(directory: &Path, record: Option<&Record>) -> Result<Section> {
    let result: Option<LatticeResult> =
        record.and_then(|record| serde_json::from_value(record.details.clone()).ok());
    let mut html = result.as_ref().map_or_else(String::new, describe);
    let path = directory.join("log.csv");
    let rows = if path.is_file() {
        log::read_so_far(&path)?
    } else {
        Vec::new()
    };
    if rows.is_empty() {
        html += &paragraph("The log has no rows yet.");
        return Ok(Section::new("History", html));
    }
    let every = rows.len().div_ceil(MOST_ROWS).max(1);
    let thinned: Vec<&LogRow> = rows.iter().step_by(every).collect();
    let mut csv = Table::new(LogRow::columns());
    for row in &thinned {
        csv.push(row.to_cells().into_iter().map(Cell::Text))?;
    }
    let name = if every > 1 {
        format!("log.csv, every {every} rows")
    } else {
        "log.csv".into()
    };
    let table = data::data(&name, &csv.to_csv()?)?;
    html += &figures::drawn(&figure(&thinned), &table)?;
    Ok(Section::new("History", html))
}

fn describe(result: &LatticeResult) -> String {
    let mut rows = vec![
        (
            "squares, rods",
            format!("{}, {}", result.squares, result.rods),
        ),
        ("steps", result.steps.to_string()),
        ("time", significant(result.time, 6)),
        ("time step", significant(result.shortest_step(), 6)),
        ("collisions", result.events.to_string()),
        (
            "energy at the start and at the end",
            format!(
                "{}, {}",
                significant(result.start_energy, 6),
                significant(result.energy, 6)
            ),
        ),
        (
            "largest relative deviation of the energy",
            significant(result.energy_error, 3),
        ),
        (
            "largest deviation of a rod from its length",
            significant(result.max_rod_violation, 3),
        ),
    ];
    if let Some(paper) = &result.paper {
        rows.push((
            "steps of the paper's protocol that end with overlaps",
            format!(
                "{}, the deepest {}",
                paper.steps_with_overlap,
                significant(paper.deepest_overlap, 3)
            ),
        ));
        rows.push((
            "impulses of the paper's protocol that pull",
            format!("{} of {}", paper.pulling_impulses, paper.contacts),
        ));
        rows.push((
            "collisions that the paper's protocol left unsolved",
            paper.unsolved_collisions.to_string(),
        ));
    }
    definitions(&rows)
}

fn figure(rows: &[&LogRow]) -> Figure {
    let series = |name: &str, value: fn(&LogRow) -> f64| Series {
        name: name.into(),
        points: rows
            .iter()
            .map(|row| Point {
                x: row.time,
                y: value(row),
                error: None,
            })
            .filter(|point| point.y.is_finite())
            .collect(),
        line: true,
        ..Series::default()
    };
    let mut energies = vec![series("total", |row| row.energy)];
    if rows.iter().any(|row| row.potential_energy != 0.0) {
        energies.push(series("kinetic", |row| row.kinetic_energy));
    }
    let panels = [
        (
            "turn (rad)",
            vec![
                series("checkerboard", |row| row.checkerboard),
                series("uniform", |row| row.uniform),
            ],
        ),
        (
            "strain",
            vec![
                series("along x", |row| row.strain_xx),
                series("along y", |row| row.strain_yy),
            ],
        ),
        ("energy", energies),
    ];
    let panels = panels.into_iter().map(|(label, mut series)| {
        series.retain(|series| !series.points.is_empty());
        Panel {
            y: Axis::linear(label),
            series,
        }
    });
    Figure {
        title: "History of the lattice".into(),
        caption: String::new(),
        x: Axis::linear("time"),
        panels: panels.filter(|panel| !panel.series.is_empty()).collect(),
    }
}

fn conditions(settings: &LatticeSettings) -> Section {
    let axes = axes(settings);
    let list = |values: &[f64]| {
        values
            .iter()
            .map(|value| significant(*value, 6))
            .collect::<Vec<_>>()
            .join(", ")
    };
    let collisions = match (settings.collisions, settings.paper) {
        (false, _) => "none: squares pass through each other".to_owned(),
        (true, true) => "those of the paper".to_owned(),
        (true, false) => format!(
            "event by event, coefficient of restitution {}",
            settings.restitution
        ),
    };
    let bath = match settings.temperature {
        Some(temperature) => format!("kT = {temperature}, friction {}", settings.friction),
        None if settings.friction > 0.0 => format!("none, friction {}", settings.friction),
        None => "none".into(),
    };
    let rows = [
        (
            "squares",
            format!("{} rows of {}", settings.rows, settings.columns),
        ),
        ("length of the rods, r0", list(&axes.r0)),
        ("κ of the coherence potential", list(&axes.kappa)),
        ("edges", format!("{:?}", settings.edges).to_lowercase()),
        (
            "orientation at the start",
            format!("± {} rad", significant(settings.start.angle_rad(), 5)),
        ),
        (
            "velocities at the start",
            format!("{:?}, {}", settings.velocities, settings.speed).to_lowercase(),
        ),
        ("collisions", collisions),
        ("heat bath", bath),
    ];
    let units = "Reduced units: the half-diagonal of a square and its mass are 1.";
    Section::new("Conditions", definitions(&rows) + &paragraph(units))
}
