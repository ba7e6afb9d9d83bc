//! The logs of simulations: radius of gyration and energy against sweeps.

use super::html::millimolar;
use anyhow::Result;
use protomer::stability::run::replica_directory;
use protomer::stability::run::{LogRow, RunSettings};
use protomer_io::csv::{Cell, Table};
use protomer_plot::{Axis, Figure, Panel, Series};
use protomer_results::log;
use std::path::Path;

/// Number of distinguishable colours.
const MOST_SALTS: usize = 6;
/// Maximum number of rows drawn per log.
const MOST_ROWS: usize = 150;
/// Target for the rows drawn of all logs together; each log keeps at least a few.
const MOST_POINTS: usize = 6000;

/// One log, thinned.
struct Trace {
    salt_molar: f64,
    replica: u32,
    rows: Vec<LogRow>,
}

/// The figure and its table; `None` if no log has rows yet.
///
/// # Errors
/// If a log is damaged.
pub fn traces(directory: &Path, settings: &RunSettings) -> Result<Option<(Figure, Table)>> {
    let step = settings.salt_molar.len().div_ceil(MOST_SALTS).max(1);
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
    Ok(Some((figure(&traces), table(&traces)?)))
}

fn figure(traces: &[Trace]) -> Figure {
    let panel = |label: &str, value: fn(&LogRow) -> f64| {
        let mut series: Vec<Series> = Vec::new();
        for trace in traces {
            let name = format!("{} mM", millimolar(trace.salt_molar));
            let points = trace
                .rows
                .iter()
                .map(|row| [row.sweep as f64, value(row)])
                .filter(|[_, y]| y.is_finite());
            match series.iter_mut().find(|series| series.name == name) {
                Some(series) => series.replicas.extend(points),
                None => series.push(Series {
                    name,
                    replicas: points.collect(),
                    ..Series::default()
                }),
            }
        }
        series.retain(|series| !series.replicas.is_empty());
        Panel {
            y: Axis::linear(label),
            series,
        }
    };
    let panels = [
        panel("radius of gyration (Å)", |row| row.r_g_angstrom),
        panel("energy (kT)", |row| row.energy_kt),
    ];
    Figure {
        title: "Course of the simulations".into(),
        caption: "thinned rows of the logs; one colour per salt concentration".into(),
        x: Axis::linear("sweeps of production"),
        panels: panels
            .into_iter()
            .filter(|panel| !panel.series.is_empty())
            .collect(),
    }
}

fn table(traces: &[Trace]) -> Result<Table> {
    let mut table = Table::new([
        "salt_M",
        "replica",
        "sweep",
        "r_g_angstrom",
        "native_contacts",
        "largest_cluster",
        "energy_kT",
    ]);
    for trace in traces {
        for row in &trace.rows {
            table.push([
                trace.salt_molar.into(),
                Cell::Integer(i64::from(trace.replica)),
                Cell::Integer(i64::try_from(row.sweep).unwrap_or(i64::MAX)),
                row.r_g_angstrom.into(),
                row.native_contacts.into(),
                row.largest_cluster.into(),
                row.energy_kt.into(),
            ])?;
        }
    }
    Ok(table)
}
