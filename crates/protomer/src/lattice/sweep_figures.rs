//! The figures of a sweep, modelled on those of the paper and its preprint.
//!
//! | file | against | what |
//! |---|---|---|
//! | `phase_differences` | time | differences between the angles of two squares |
//! | `synchronisation` | r0 | leading eigenvalues of the synchronisation indices, whole and partial |
//! | `indices` | squares | the matrices of both |
//! | `strains` | ε_xx | -ε_yy between rows of the log |
//! | `poisson` | r0 | Poisson's ratio and the squared correlation behind it |
//! | `spread` | κ | first maximum of the spread of the angles, and when |
//! | `checkerboard` | r0 | fluctuation of the checkerboard mode's share of the rotational energy |
//! | `crossings` | time | angular velocity of the checkerboard mode where it passes the open state |
//! | `lyapunov` | r0 | maximal Lyapunov exponent |

use super::sweep::{LatticeSweep, Series as Data, axes};
use super::sweep_table::{ConditionRow, Estimate, RIDGE, RunRow};
use anyhow::Result;
use protomer_plot::{Axis, Figure, HeatMap, Panel, Point, Series};
use std::path::Path;

/// Upper limit for points in a scatter plot; more would not be visible.
const MOST_POINTS: usize = 2000;

/// Writes every figure that has data, as SVG and PNG.
///
/// # Errors
/// If a figure cannot be drawn or written.
pub fn write(sweep: &LatticeSweep, data: &[Data], directory: &Path) -> Result<()> {
    let figures = [
        ("phase_differences", Some(phase_differences(sweep, data))),
        ("strains", Some(strains(sweep, data))),
        ("crossings", Some(crossings(sweep, data))),
        (
            "lyapunov",
            against_r0(
                sweep,
                "Maximal Lyapunov exponent against rod length",
                &[(
                    "",
                    "λ_{max}",
                    |row| row.lyapunov_exponent,
                    |run| run.lyapunov_exponent,
                )],
            ),
        ),
        (
            "synchronisation",
            against_r0(
                sweep,
                "Synchronisation against rod length",
                &[
                    (
                        "",
                        "λ(|R|) / squares",
                        |row| row.synchronisation,
                        |run| run.synchronisation,
                    ),
                    (
                        "",
                        "λ(|P|) / squares",
                        |row| row.partial_synchronisation,
                        |run| run.partial_synchronisation,
                    ),
                ],
            ),
        ),
        (
            "poisson",
            against_r0(
                sweep,
                "Poisson's ratio against rod length",
                &[
                    (
                        "total least squares",
                        "ν",
                        |row| row.poisson_ratio,
                        |_| f64::NAN,
                    ),
                    (
                        "ordinary least squares",
                        "ν",
                        |row| row.poisson_ratio_ordinary,
                        |_| f64::NAN,
                    ),
                    ("", "r²", |row| row.r_squared, |run| run.r_squared),
                ],
            ),
        ),
        (
            "checkerboard",
            against_r0(
                sweep,
                "The checkerboard mode against rod length",
                &[
                    (
                        "",
                        "σ of its share",
                        |row| row.checkerboard_deviation,
                        |run| run.checkerboard_deviation,
                    ),
                    (
                        "",
                        "mean share",
                        |row| row.checkerboard_fraction,
                        |run| run.checkerboard_fraction,
                    ),
                ],
            ),
        ),
        ("spread", spread(sweep)),
    ];
    for (name, figure) in figures {
        let Some(figure) = figure.and_then(drawable) else {
            continue;
        };
        figure.write_svg(&directory.join(format!("{name}.svg")))?;
        figure.write_png(&directory.join(format!("{name}.png")))?;
    }
    indices(sweep, data, directory)
}

/// Removes empty panels and series; `None` if nothing is left.
fn drawable(mut figure: Figure) -> Option<Figure> {
    for panel in &mut figure.panels {
        panel.series.iter_mut().for_each(|series| {
            series
                .points
                .retain(|point| point.y.is_finite() && point.x.is_finite());
            series
                .replicas
                .retain(|[x, y]| x.is_finite() && y.is_finite());
            if panel.y.log {
                series.points.retain(|point| point.y > 0.0);
                series.replicas.retain(|[_, y]| *y > 0.0);
            }
        });
        panel
            .series
            .retain(|series| !(series.points.is_empty() && series.replicas.is_empty()));
    }
    figure.panels.retain(|panel| !panel.series.is_empty());
    (!figure.panels.is_empty()).then_some(figure)
}

/// The conditions, which belong to every curve.
fn caption(sweep: &LatticeSweep) -> String {
    let settings = &sweep.settings;
    format!(
        "{} × {} squares, {} seeds, error bars: standard error over seeds; small: single runs",
        settings.rows,
        settings.columns,
        axes(settings).seeds.len()
    )
}

fn name(row: &ConditionRow, sweep: &LatticeSweep) -> String {
    let varies = axes(&sweep.settings);
    match (varies.r0.len() > 1, varies.kappa.len() > 1) {
        (true, true) => format!("r0 = {:.4}, κ = {}", row.r0, row.kappa),
        (false, true) => format!("κ = {}", row.kappa),
        _ => format!("r0 = {:.4}", row.r0),
    }
}

/// Most entries that fit into a legend; the tables have all of them.
const MOST_SERIES: usize = 8;
/// Most matrices in one figure.
const MOST_MATRICES: usize = 24;

/// If both vary: the rod lengths of the first κ.
fn shown<'a>(
    sweep: &'a LatticeSweep,
    data: &'a [Data],
) -> impl Iterator<Item = (&'a ConditionRow, &'a Data)> {
    let axes = axes(&sweep.settings);
    let first = (axes.r0.len() > 1)
        .then(|| axes.kappa.first().copied())
        .flatten();
    let is_shown = move |row: &ConditionRow| first.is_none_or(|kappa| row.kappa == kappa);
    sweep
        .conditions
        .iter()
        .zip(data)
        .filter(move |(row, _)| is_shown(row))
        .take(MOST_SERIES)
}

fn phase_differences(sweep: &LatticeSweep, data: &[Data]) -> Figure {
    let series = shown(sweep, data).map(|(row, data)| Series {
        name: name(row, sweep),
        points: thinned(&data.phase_differences)
            .map(|[x, y]| Point { x, y, error: None })
            .collect(),
        replicas: Vec::new(),
        line: true,
    });
    Figure {
        title: "Phase differences".into(),
        caption: caption(sweep),
        x: Axis::linear("time"),
        panels: vec![Panel {
            y: Axis::linear("√⟨(Δθ)^{2}⟩ over pairs"),
            series: series.collect(),
        }],
    }
}

fn strains(sweep: &LatticeSweep, data: &[Data]) -> Figure {
    let series = shown(sweep, data).map(|(row, data)| Series {
        name: name(row, sweep),
        points: Vec::new(),
        replicas: thinned(&data.strains).map(|[x, y]| [x, -y]).collect(),
        line: false,
    });
    Figure {
        title: "Strain against strain".into(),
        caption: format!(
            "between rows of the log, every {} steps; the slope is Poisson's ratio; {} × {} squares",
            sweep.settings.log_every, sweep.settings.rows, sweep.settings.columns
        ),
        x: Axis::linear("strain ε_{xx}"),
        panels: vec![Panel {
            y: Axis::linear("-ε_{yy}"),
            series: series.collect(),
        }],
    }
}

fn crossings(sweep: &LatticeSweep, data: &[Data]) -> Figure {
    let series = shown(sweep, data).map(|(row, data)| {
        let passages = data.crossings.iter().flatten();
        let speeds: Vec<[f64; 2]> = passages.map(|at| [at.time, at.rate.abs()]).collect();
        Series {
            name: name(row, sweep),
            points: Vec::new(),
            replicas: thinned(&speeds).collect(),
            line: false,
        }
    });
    Figure {
        title: "Passages through the open state".into(),
        caption: format!(
            "of the checkerboard mode, all runs; in the coherent motion its angular velocity there \
             is constant; {} × {} squares",
            sweep.settings.rows, sweep.settings.columns
        ),
        x: Axis::linear("time"),
        panels: vec![Panel {
            y: Axis::linear("|ω_{c}| at θ_{c} = π/4"),
            series: series.collect(),
        }],
    }
}

fn thinned(points: &[[f64; 2]]) -> impl Iterator<Item = [f64; 2]> + '_ {
    points
        .iter()
        .copied()
        .step_by(points.len().div_ceil(MOST_POINTS).max(1))
}

/// A note for the label, the label, and the value for a condition and for a run.
type Quantity = (
    &'static str,
    &'static str,
    fn(&ConditionRow) -> Estimate,
    fn(&RunRow) -> f64,
);

/// A panel per quantity, a series per κ.
fn against_r0(sweep: &LatticeSweep, title: &str, quantities: &[Quantity]) -> Option<Figure> {
    let axes = axes(&sweep.settings);
    let panels = quantities
        .iter()
        .map(|(what, label, of_row, of_run)| Panel {
            y: Axis::linear(if what.is_empty() {
                (*label).to_owned()
            } else {
                format!("{label}, {what}")
            }),
            series: axes
                .kappa
                .iter()
                .take(MOST_SERIES)
                .map(|kappa| Series {
                    name: format!("κ = {kappa}"),
                    points: points(sweep, |row| row.kappa == *kappa, |row| row.r0, of_row),
                    replicas: replicas(sweep, |run| run.kappa == *kappa, |run| run.r0, of_run),
                    line: true,
                })
                .collect(),
        });
    let log = axes.r0.len() > 1;
    Some(Figure {
        title: title.into(),
        caption: caption(sweep),
        x: if log {
            Axis::log("rod length r_{0} / l")
        } else {
            Axis::linear("rod length r_{0} / l")
        },
        panels: panels.collect(),
    })
}

fn points(
    sweep: &LatticeSweep,
    is_meant: impl Fn(&ConditionRow) -> bool,
    x: impl Fn(&ConditionRow) -> f64,
    y: impl Fn(&ConditionRow) -> Estimate,
) -> Vec<Point> {
    let rows = sweep.conditions.iter().filter(|row| is_meant(row));
    let mut points: Vec<Point> = rows
        .map(|row| {
            let Estimate { mean, error } = y(row);
            Point {
                x: x(row),
                y: mean,
                error: error.is_finite().then_some(error),
            }
        })
        .collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x));
    points
}

fn replicas(
    sweep: &LatticeSweep,
    is_meant: impl Fn(&RunRow) -> bool,
    x: impl Fn(&RunRow) -> f64,
    y: impl Fn(&RunRow) -> f64,
) -> Vec<[f64; 2]> {
    sweep
        .runs
        .iter()
        .filter(|run| is_meant(run))
        .map(|run| [x(run), y(run)])
        .collect()
}

/// Against κ, one series per r0; κ = 0 cannot be shown on a logarithmic axis.
fn spread(sweep: &LatticeSweep) -> Option<Figure> {
    let axes = axes(&sweep.settings);
    if axes.kappa.len() < 2 {
        return None;
    }
    let log = axes.kappa.iter().filter(|kappa| **kappa > 0.0).count() > 1;
    let shown = move |kappa: f64| !log || kappa > 0.0;
    let panel =
        |y: Axis, of_row: fn(&ConditionRow) -> Estimate, of_run: fn(&RunRow) -> f64| Panel {
            y,
            series: axes
                .r0
                .iter()
                .take(MOST_SERIES)
                .map(|r0| Series {
                    name: format!("r_{{0}} = {r0:.4}"),
                    points: points(
                        sweep,
                        |row| row.r0 == *r0 && shown(row.kappa),
                        |row| row.kappa,
                        of_row,
                    ),
                    replicas: replicas(
                        sweep,
                        |run| run.r0 == *r0 && shown(run.kappa),
                        |run| run.kappa,
                        of_run,
                    ),
                    line: true,
                })
                .collect(),
        };
    Some(Figure {
        title: "Spread of the angles against κ".into(),
        caption: caption(sweep),
        x: if log {
            Axis::log("κ")
        } else {
            Axis::linear("κ")
        },
        panels: vec![
            panel(
                Axis::log("first maximum σ_{max} (rad)"),
                |row| row.largest_spread,
                |run| run.largest_spread,
            ),
            panel(
                Axis::linear("its time"),
                |row| row.largest_spread_time,
                |run| run.largest_spread_time,
            ),
        ],
    })
}

/// |R| and |P| of every condition side by side.
fn indices(sweep: &LatticeSweep, data: &[Data], directory: &Path) -> Result<()> {
    let mut maps = Vec::new();
    for (row, data) in sweep.conditions.iter().zip(data).take(MOST_MATRICES) {
        if data.synchronisation.samples() == 0 {
            return Ok(());
        }
        let whole = data.synchronisation.index()?;
        let values = |matrix: &nalgebra::DMatrix<nalgebra::Complex<f64>>| {
            matrix.transpose().iter().map(|x| x.norm()).collect()
        };
        let size = whole.nrows();
        maps.push(HeatMap {
            title: format!("whole, {}", name(row, sweep)),
            size,
            values: values(&whole),
        });
        // Squares that always move together have no partial indices.
        if let Ok(partial) = data.synchronisation.partial(RIDGE) {
            maps.push(HeatMap {
                title: format!("partial, {}", name(row, sweep)),
                size,
                values: values(&partial),
            });
        }
    }
    let title = "Synchronisation indices between squares";
    Ok(HeatMap::write_svg(
        &maps,
        title,
        2,
        &directory.join("indices.svg"),
    )?)
}
