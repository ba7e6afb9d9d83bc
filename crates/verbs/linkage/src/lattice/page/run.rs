//! The page of a run: an animation, its result and its log.

use super::{animation, conditions, with_settings};
use crate::lattice::log::LogRow;
use crate::lattice::run::LatticeResult;
use crate::lattice::settings::LatticeSettings;
use anyhow::Result;
use protomer_common::page::{Contents, Data, Part, Section, significant};
use protomer_io::csv::{Cell, Table};
use protomer_plot::{Axis, Figure, Panel, Point, Series};
use protomer_results::keys::read_toml;
use protomer_results::{Record, Row, log};
use std::path::Path;

/// Maximum number of log rows that are drawn and embedded.
const MOST_ROWS: usize = 1000;

/// Contents of the page of a directory.
///
/// # Errors
/// If a file is damaged.
pub fn contents(directory: &Path, record: Option<&Record>) -> Result<Contents> {
    let settings: LatticeSettings = read_toml(&directory.join("run.toml"))?;
    let mut contents = with_settings("Lattice", &settings);
    let played = animation(directory, &settings);
    contents.add_if_readable(played, "The run cannot be played");
    contents.add(history(directory, record)?);
    contents.add(conditions(&settings));
    Ok(contents)
}

/// The result of a run, and its log.
fn history(directory: &Path, record: Option<&Record>) -> Result<Section> {
    let result: Option<LatticeResult> = record.and_then(Record::answer);
    let mut parts = Vec::new();
    parts.extend(result.map(|result| Part::Values(describe(&result))));
    let path = directory.join(log::FILE);
    let rows: Vec<LogRow> = match path.is_file() {
        true => log::read_so_far(&path)?,
        false => Vec::new(),
    };
    parts.push(match rows.is_empty() {
        true => Part::Paragraph("The log has no rows yet.".into()),
        false => course(&rows)?,
    });
    Ok(Section::new("History", parts))
}

/// The figure of a log, with the rows that are drawn.
fn course(rows: &[LogRow]) -> Result<Part> {
    let every = rows.len().div_ceil(MOST_ROWS).max(1);
    let thinned: Vec<&LogRow> = rows.iter().step_by(every).collect();
    let mut table = Table::new(LogRow::columns());
    for row in &thinned {
        table.push(row.to_cells().into_iter().map(Cell::Text))?;
    }
    let name = match every {
        1 => log::FILE.into(),
        _ => format!("{}, every {every} rows", log::FILE),
    };
    let data = Data::Table {
        name,
        csv: table.to_csv()?,
    };
    Ok(Part::Figure(Box::new(figure(&thinned)), Some(data)))
}

fn describe(result: &LatticeResult) -> Vec<(&'static str, String)> {
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
    rows
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
