//! The logs of simulations: their observables against sweeps.

use crate::stability::run::replica_directory;
use crate::stability::run::{Column, LogRow, RunSettings, Start, Starts};
use crate::stability::sweep::series::{axis, drawn};
use anyhow::Result;
use protomer_common::page::{Data, Part, millimolar};
use protomer_io::csv::{Cell, Table};
use protomer_plot::{Axis, Figure, Panel, Series};
use protomer_results::{Row, log};
use std::path::Path;

/// Number of distinguishable colours.
const MOST_COLOURS: usize = 6;
/// Maximum number of rows drawn per log.
const MOST_ROWS: usize = 150;
/// Target for the rows drawn of all logs together; each log keeps at least a few.
const MOST_POINTS: usize = 6000;

/// One log, thinned.
struct Trace {
    /// Name of the series: the salt concentration, and the start where there are two.
    name: String,
    salt_molar: f64,
    replica: u32,
    rows: Vec<LogRow>,
}

/// The figure with its table; `None` if no log has rows yet.
///
/// # Errors
/// If a log is damaged.
pub fn traces(directory: &Path, settings: &RunSettings) -> Result<Option<Part>> {
    let most_salts = match settings.starts {
        Starts::Both => MOST_COLOURS / 2,
        Starts::Assembly | Starts::Fluid => MOST_COLOURS,
    };
    let step = settings.salt_molar.len().div_ceil(most_salts).max(1);
    let salts: Vec<f64> = settings.salt_molar.iter().copied().step_by(step).collect();
    let logs = salts.len() * settings.replicas as usize;
    let most_rows = (MOST_POINTS / logs.max(1)).clamp(5, MOST_ROWS);
    let mut traces = Vec::new();
    for salt_molar in salts {
        for replica in 0..settings.replicas {
            let path = replica_directory(directory, salt_molar, replica).join("log.csv");
            if path.is_file() {
                let rows: Vec<LogRow> = log::read_so_far(&path)?;
                let every = rows.len().div_ceil(most_rows).max(1);
                traces.push(Trace {
                    name: name(settings, salt_molar, replica),
                    salt_molar,
                    replica,
                    rows: rows.into_iter().step_by(every).collect(),
                });
            }
        }
    }
    traces.retain(|trace| !trace.rows.is_empty());
    if traces.is_empty() {
        return Ok(None);
    }
    let data = Data::Table {
        name: "traces.csv".into(),
        csv: table(&traces)?.to_csv()?,
    };
    Ok(Some(Part::Figure(Box::new(figure(&traces)), Some(data))))
}

fn name(settings: &RunSettings, salt_molar: f64, replica: u32) -> String {
    let start = match (settings.starts, settings.starts.of_replica(replica)) {
        (Starts::Both, Start::Assembly) => ", from the assembly",
        (Starts::Both, Start::Fluid) => ", from a fluid",
        (Starts::Assembly | Starts::Fluid, _) => "",
    };
    format!("{} mM{start}", millimolar(salt_molar))
}

fn figure(traces: &[Trace]) -> Figure {
    let panels = drawn().into_iter().map(|column| Panel {
        y: axis(column),
        series: series(traces, column),
    });
    Figure {
        title: "Course of the simulations".into(),
        caption: "thinned rows of the logs; one colour per salt concentration and start".into(),
        x: Axis::linear("sweeps of production"),
        panels: panels.filter(|panel| !panel.series.is_empty()).collect(),
    }
}

/// A series per salt concentration and start.
fn series(traces: &[Trace], column: &Column) -> Vec<Series> {
    let mut series: Vec<Series> = Vec::new();
    for trace in traces {
        let points = trace
            .rows
            .iter()
            .map(|row| [row.sweep as f64, row.numbers.get(column)])
            .filter(|[_, y]| y.is_finite());
        match series.iter_mut().find(|series| series.name == trace.name) {
            Some(series) => series.replicas.extend(points),
            None => series.push(Series {
                name: trace.name.clone(),
                replicas: points.collect(),
                ..Series::default()
            }),
        }
    }
    series.retain(|series| !series.replicas.is_empty());
    series
}

/// A table of the rows as in the logs, with all of their columns.
fn table(traces: &[Trace]) -> Result<Table> {
    let mut columns = vec!["salt_M", "replica"];
    columns.extend(LogRow::columns());
    let mut table = Table::new(columns);
    for trace in traces {
        for row in &trace.rows {
            let mut cells = vec![
                Cell::from(trace.salt_molar),
                Cell::Integer(i64::from(trace.replica)),
            ];
            for cell in row.to_cells() {
                // A value that an earlier version did not write.
                cells.push(match cell.as_str() {
                    "NaN" => Cell::Empty,
                    _ => Cell::Text(cell),
                });
            }
            table.push(cells)?;
        }
    }
    Ok(table)
}
