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
//! | `correlation` | distance | correlation of the sides to which squares close |
//! | `domains` | r0 | number and size of the domains, and the time from which phases are locked |
//! | `orbits` | θ_c | angular velocity of the checkerboard mode |

use super::answer::LatticeSweep;
use super::plan::axes;
use super::series::Series as Data;
use super::table::{ConditionRow, RIDGE};
use anyhow::Result;
use nalgebra::{Complex, DMatrix};
use protomer_plot::{Axis, Figure, HeatMap, Panel, Point, Series};
use std::path::Path;

/// Upper limit for points in a scatter plot; more would not be visible.
const MOST_POINTS: usize = 2000;

/// A quantity of a figure.
struct Quantity {
    /// Column of the quantity in the tables of conditions and of runs.
    column: &'static str,
    /// Label of the axis.
    label: &'static str,
    /// Whether single runs are shown: the pooled ratios of the conditions have none.
    of_runs: bool,
    /// Whether the axis is logarithmic.
    log: bool,
}

impl Quantity {
    const fn new(column: &'static str, label: &'static str) -> Self {
        Self {
            column,
            label,
            of_runs: true,
            log: false,
        }
    }

    const fn pooled(column: &'static str, label: &'static str) -> Self {
        let of_runs = false;
        Self {
            of_runs,
            ..Self::new(column, label)
        }
    }

    const fn logarithmic(column: &'static str, label: &'static str) -> Self {
        let log = true;
        Self {
            log,
            ..Self::new(column, label)
        }
    }
}

const LYAPUNOV: [Quantity; 1] = [Quantity::new("lyapunov_exponent", "λ_{max}")];
const SYNCHRONISATION: [Quantity; 2] = [
    Quantity::new("synchronisation", "λ(|R|) / squares"),
    Quantity::new("partial_synchronisation", "λ(|P|) / squares"),
];
const POISSON: [Quantity; 3] = [
    Quantity::pooled("poisson_ratio_xy", "ν_{xy}, load along x"),
    Quantity::pooled("poisson_ratio_yx", "ν_{yx}, load along y"),
    Quantity::new("r_squared", "r²"),
];
const DOMAINS: [Quantity; 3] = [
    Quantity::new("domains", "domains"),
    Quantity::new("largest_domain", "share of the largest"),
    Quantity::new("locking_time", "locking time"),
];
const CHECKERBOARD: [Quantity; 2] = [
    Quantity::new("checkerboard_deviation", "σ of its share"),
    Quantity::new("checkerboard_fraction", "mean share"),
];
const SPREAD: [Quantity; 2] = [
    Quantity::logarithmic("largest_spread", "first maximum σ_{max} (rad)"),
    Quantity::new("largest_spread_time", "its time"),
];

/// Writes every figure that has data, as SVG and PNG.
///
/// # Errors
/// If a figure cannot be drawn or written.
pub fn write(sweep: &LatticeSweep, data: &[Data], directory: &Path) -> Result<()> {
    let domains = "Domains against rod length";
    let lyapunov = "Maximal Lyapunov exponent against rod length";
    let synchronisation = "Synchronisation against rod length";
    let poisson = "Poisson's ratio against rod length";
    let checkerboard = "The checkerboard mode against rod length";
    let mut figures = vec![
        ("phase_differences", phase_differences(sweep, data)),
        ("strains", strains(sweep, data)),
        ("crossings", crossings(sweep, data)),
        ("correlation", correlations(sweep, data)),
        ("orbits", orbits(sweep, data)),
        ("domains", against_r0(sweep, domains, &DOMAINS)),
        ("lyapunov", against_r0(sweep, lyapunov, &LYAPUNOV)),
        (
            "synchronisation",
            against_r0(sweep, synchronisation, &SYNCHRONISATION),
        ),
        ("poisson", against_r0(sweep, poisson, &POISSON)),
        (
            "checkerboard",
            against_r0(sweep, checkerboard, &CHECKERBOARD),
        ),
    ];
    if axes(&sweep.settings).kappa.len() > 1 {
        figures.push(("spread", spread(sweep)));
    }
    for (name, figure) in figures {
        let Some(figure) = drawable(figure) else {
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
        for series in &mut panel.series {
            remove_undrawable(series, panel.y.log);
        }
        panel
            .series
            .retain(|series| !(series.points.is_empty() && series.replicas.is_empty()));
    }
    figure.panels.retain(|panel| !panel.series.is_empty());
    (!figure.panels.is_empty()).then_some(figure)
}

/// Removes what is not finite, or not positive on a logarithmic axis.
fn remove_undrawable(series: &mut Series, log: bool) {
    let is_drawable = |x: f64, y: f64| x.is_finite() && y.is_finite() && (y > 0.0 || !log);
    series.points.retain(|point| is_drawable(point.x, point.y));
    series.replicas.retain(|[x, y]| is_drawable(*x, *y));
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

/// The conditions whose time series are drawn. If both axes vary: the rod lengths of the first κ.
fn shown<'a>(sweep: &'a LatticeSweep, data: &'a [Data]) -> Vec<(&'a ConditionRow, &'a Data)> {
    let axes = axes(&sweep.settings);
    let mut shown: Vec<_> = sweep.conditions.iter().zip(data).collect();
    if let (true, Some(first)) = (axes.r0.len() > 1, axes.kappa.first()) {
        shown.retain(|(row, _)| row.kappa == *first);
    }
    shown.truncate(MOST_SERIES);
    shown
}

fn phase_differences(sweep: &LatticeSweep, data: &[Data]) -> Figure {
    let mut series = Vec::new();
    for (row, data) in shown(sweep, data) {
        let mut points = Vec::new();
        for [x, y] in thinned(&data.phase_differences) {
            points.push(Point { x, y, error: None });
        }
        series.push(Series {
            name: name(row, sweep),
            points,
            line: true,
            ..Series::default()
        });
    }
    Figure {
        title: "Phase differences".into(),
        caption: caption(sweep),
        x: Axis::linear("time"),
        panels: vec![Panel {
            y: Axis::linear("√⟨(Δθ)^{2}⟩ over pairs"),
            series,
        }],
    }
}

fn strains(sweep: &LatticeSweep, data: &[Data]) -> Figure {
    let mut series = Vec::new();
    for (row, data) in shown(sweep, data) {
        let strains = thinned(&data.strains).map(|[x, y]| [x, -y]);
        series.push(scatter(name(row, sweep), strains.collect()));
    }
    Figure {
        title: "Strain against strain".into(),
        caption: format!(
            "between rows of the log, every {} steps; the slope is Poisson's ratio; {} × {} squares",
            sweep.settings.log_every, sweep.settings.rows, sweep.settings.columns
        ),
        x: Axis::linear("strain ε_{xx}"),
        panels: vec![Panel {
            y: Axis::linear("-ε_{yy}"),
            series,
        }],
    }
}

fn crossings(sweep: &LatticeSweep, data: &[Data]) -> Figure {
    let mut series = Vec::new();
    for (row, data) in shown(sweep, data) {
        let mut speeds = Vec::new();
        for crossing in data.crossings.iter().flatten() {
            speeds.push([crossing.time, crossing.rate.abs()]);
        }
        series.push(scatter(name(row, sweep), thinned(&speeds).collect()));
    }
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
            series,
        }],
    }
}

fn correlations(sweep: &LatticeSweep, data: &[Data]) -> Figure {
    let mut series = Vec::new();
    for (row, data) in shown(sweep, data) {
        let mut points = Vec::new();
        for (distance, y) in data.correlation.values().into_iter().enumerate() {
            points.push(Point {
                x: distance as f64,
                y,
                error: None,
            });
        }
        series.push(Series {
            name: name(row, sweep),
            points,
            line: true,
            ..Series::default()
        });
    }
    Figure {
        title: "Correlation of the sides to which squares close".into(),
        caption: caption(sweep),
        x: Axis::linear("distance (squares)"),
        panels: vec![Panel {
            y: Axis::linear("⟨u u'⟩ / ⟨u^{2}⟩"),
            series,
        }],
    }
}

fn orbits(sweep: &LatticeSweep, data: &[Data]) -> Figure {
    let mut panels = Vec::new();
    for (row, data) in shown(sweep, data) {
        let mut all: Vec<[f64; 2]> = Vec::new();
        for orbit in &data.orbits {
            all.extend(orbit);
        }
        panels.push(Panel {
            y: Axis::linear("ω_{c}"),
            series: vec![scatter(name(row, sweep), thinned(&all).collect())],
        });
    }
    Figure {
        title: "Phase space of the checkerboard mode".into(),
        caption: format!(
            "all runs, rows of the log every {} steps; {} × {} squares",
            sweep.settings.log_every, sweep.settings.rows, sweep.settings.columns
        ),
        x: Axis::linear("θ_{c} (rad)"),
        panels,
    }
}

/// Small dots without a line.
fn scatter(name: String, replicas: Vec<[f64; 2]>) -> Series {
    Series {
        name,
        replicas,
        line: false,
        ..Series::default()
    }
}

fn thinned(points: &[[f64; 2]]) -> impl Iterator<Item = [f64; 2]> + '_ {
    points
        .iter()
        .copied()
        .step_by(points.len().div_ceil(MOST_POINTS).max(1))
}

/// The parameter on the x axis; the other one distinguishes the series.
#[derive(Clone, Copy)]
enum Against {
    RodLength,
    Kappa,
}

impl Against {
    /// The abscissa of a condition, and the parameter of its series.
    fn split(self, r0: f64, kappa: f64) -> (f64, f64) {
        match self {
            Self::RodLength => (r0, kappa),
            Self::Kappa => (kappa, r0),
        }
    }
}

/// A figure against r0 with a panel per quantity and a series per κ.
fn against_r0(sweep: &LatticeSweep, title: &str, quantities: &[Quantity]) -> Figure {
    let axes = axes(&sweep.settings);
    let label = "rod length r_{0} / l";
    let log = axes.r0.len() > 1;
    let mut panels = Vec::new();
    for quantity in quantities {
        let mut series = Vec::new();
        for kappa in axes.kappa.iter().take(MOST_SERIES) {
            let name = format!("κ = {kappa}");
            series.push(curve(sweep, quantity, Against::RodLength, *kappa, name));
        }
        panels.push(panel(quantity, series));
    }
    Figure {
        title: title.into(),
        caption: caption(sweep),
        x: axis(label, log),
        panels,
    }
}

/// A figure of the spread against κ, one series per r0; κ = 0 cannot be shown on a logarithmic
/// axis.
fn spread(sweep: &LatticeSweep) -> Figure {
    let axes = axes(&sweep.settings);
    let log = axes.kappa.iter().filter(|kappa| **kappa > 0.0).count() > 1;
    let mut panels = Vec::new();
    for quantity in &SPREAD {
        let mut series = Vec::new();
        for r0 in axes.r0.iter().take(MOST_SERIES) {
            let name = format!("r_{{0}} = {r0:.4}");
            let mut curve = curve(sweep, quantity, Against::Kappa, *r0, name);
            if log {
                curve.points.retain(|point| point.x > 0.0);
                curve.replicas.retain(|[x, _]| *x > 0.0);
            }
            series.push(curve);
        }
        panels.push(panel(quantity, series));
    }
    Figure {
        title: "Spread of the angles against κ".into(),
        caption: caption(sweep),
        x: axis("κ", log),
        panels,
    }
}

fn axis(label: &str, log: bool) -> Axis {
    match log {
        true => Axis::log(label),
        false => Axis::linear(label),
    }
}

fn panel(quantity: &Quantity, series: Vec<Series>) -> Panel {
    Panel {
        y: axis(quantity.label, quantity.log),
        series,
    }
}

/// A quantity of the conditions of one series, with those of their runs.
fn curve(
    sweep: &LatticeSweep,
    quantity: &Quantity,
    against: Against,
    parameter: f64,
    name: String,
) -> Series {
    let mut points = Vec::new();
    for row in &sweep.conditions {
        let (x, of_series) = against.split(row.r0, row.kappa);
        if let Some(estimate) = find(row.estimates(), quantity.column)
            && of_series == parameter
        {
            points.push(Point {
                x,
                y: estimate.mean,
                error: estimate.error.is_finite().then_some(estimate.error),
            });
        }
    }
    points.sort_by(|a, b| a.x.total_cmp(&b.x));
    let mut replicas = Vec::new();
    for run in &sweep.runs {
        let (x, of_series) = against.split(run.r0, run.kappa);
        if let Some(y) = find(run.values(), quantity.column)
            && quantity.of_runs
            && of_series == parameter
        {
            replicas.push([x, y]);
        }
    }
    Series {
        name,
        points,
        replicas,
        line: true,
        ..Series::default()
    }
}

/// The value of a named column.
fn find<T, const N: usize>(columns: [(&'static str, T); N], name: &str) -> Option<T> {
    let mut columns = columns.into_iter();
    columns.find_map(|(column, value)| (column == name).then_some(value))
}

/// Draws |R| and |P| of every condition side by side.
fn indices(sweep: &LatticeSweep, data: &[Data], directory: &Path) -> Result<()> {
    let mut maps = Vec::new();
    for (row, data) in sweep.conditions.iter().zip(data).take(MOST_MATRICES) {
        if data.synchronisation.samples() == 0 {
            continue;
        }
        let whole = data.synchronisation.index()?;
        maps.push(heat_map(format!("whole, {}", name(row, sweep)), &whole));
        // Squares that always move together have no partial indices.
        if let Ok(partial) = data.synchronisation.partial(RIDGE) {
            maps.push(heat_map(format!("partial, {}", name(row, sweep)), &partial));
        }
    }
    if maps.is_empty() {
        return Ok(());
    }
    let title = "Synchronisation indices between squares";
    Ok(HeatMap::write_svg(
        &maps,
        title,
        2,
        &directory.join("indices.svg"),
    )?)
}

/// The absolute values of a matrix.
fn heat_map(title: String, matrix: &DMatrix<Complex<f64>>) -> HeatMap {
    HeatMap {
        title,
        size: matrix.nrows(),
        values: matrix.transpose().map(|x| x.norm()).as_slice().to_vec(),
    }
}
