//! The figure of a sweep: radius of gyration, surviving contacts and bound bodies against salt, a
//! curve per start with its replicas, and where one half is left.

use super::result::SweepResult;
use super::series::{self, axis};
use super::stability::CountedContacts;
use super::table::{ReplicaResult, standard_deviation};
use crate::stability::run::columns::{Column, Drawn};
use crate::stability::run::{RunSettings, Start, Starts};
use anyhow::Result;
use protomer_kernel::statistics::{Summary, mean};
use protomer_plot::{Axis, Figure, Panel, Point, Series, Span};
use std::path::Path;

/// The name of the figure, without its extension: a single simulation has no curve over salt.
pub fn name(settings: &RunSettings) -> &'static str {
    match settings.simulations() {
        1 => "simulation",
        _ => "sweep",
    }
}

/// Writes the figure as SVG and PNG into a directory.
///
/// # Errors
/// If a figure cannot be drawn or written.
pub fn write(result: &SweepResult, directory: &Path) -> Result<()> {
    let figure = figure(result);
    let path = directory.join(name(&result.settings));
    figure.write_svg(&path.with_extension("svg"))?;
    figure.write_png(&path.with_extension("png"))?;
    Ok(())
}

/// The figure of a sweep, or of its only simulation.
pub fn figure(result: &SweepResult) -> Figure {
    if !result.time_series.is_empty() {
        let salts = &result.settings.salt_molar;
        let salts: Vec<String> = salts.iter().map(|salt| (1e3 * salt).to_string()).collect();
        let title = format!("One simulation at {} mM salt", salts.join(", "));
        return series::figure(title, caption(result), &result.time_series);
    }
    let groups = groups(result);
    let panels = observables(result)
        .into_iter()
        .filter_map(|observable| panel(result, &groups, &observable));
    let panels = panels.collect();
    let all_have_salt = result.salts.iter().all(|row| row.salt_molar > 0.0);
    // Zero salt cannot be shown on a logarithmic axis.
    let x = match all_have_salt && result.salts.len() > 1 {
        true => Axis::log("salt (mM)"),
        false => Axis::linear("salt (mM)"),
    };
    Figure {
        title: "Stability against salt".into(),
        caption: caption(result),
        x,
        panels,
    }
}

/// Replicas that are averaged together, and the name of their curve.
struct Group {
    name: &'static str,
    /// Start of the replicas; `None` for all replicas.
    start: Option<Start>,
}

/// A group per start: where starts disagree, their common mean is a state that no replica is in.
fn groups(result: &SweepResult) -> Vec<Group> {
    let group = |name, start| Group { name, start };
    match (result.settings.starts, result.settings.replicas) {
        (Starts::Both, 2..) => vec![
            group("from the assembly", Some(Start::Assembly)),
            group("from a fluid", Some(Start::Fluid)),
        ],
        (_, 1) => vec![group("one replica", None)],
        _ => vec![group("mean of the replicas", None)],
    }
}

/// Average of a replica; `None` without a value.
type Average<'a> = Box<dyn Fn(&ReplicaResult) -> Option<Summary> + 'a>;

/// Observable that is drawn against salt.
struct Observable<'a> {
    axis: Axis,
    value: Average<'a>,
    /// Salt at which the observable is one half, with the interval, mol/L.
    half: Option<(f64, [Option<f64>; 2])>,
}

/// Quantities of a sweep in the order of their panels; columns that later versions added come last.
fn observables(result: &SweepResult) -> Vec<Observable<'_>> {
    let stability = &result.stability;
    let half = |salt: Option<f64>, interval: Option<[Option<f64>; 2]>| salt.zip(interval);
    let contacts = match stability.half_salt_contacts {
        CountedContacts::Native => Axis::linear("native contacts left").with_range(0.0, 1.05),
        // Bodies may come to touch more others than they did in the assembly.
        CountedContacts::Any => Axis::linear("contacts over those of the assembly"),
    };
    let of_column = |column: &'static Column| Observable {
        axis: axis(column),
        value: Box::new(|replica| replica.averages.get(column)),
        half: None,
    };
    let mut drawn = Column::all();
    drawn.retain(|column| column.drawn == Drawn::AgainstSalt);
    let mut observables: Vec<Observable<'_>> = drawn.into_iter().map(of_column).collect();
    let stated = [
        Observable {
            axis: contacts,
            value: Box::new(|replica| stability.contacts_left(replica)),
            half: half(
                stability.half_salt_molar,
                stability.half_salt_interval_molar,
            ),
        },
        Observable {
            axis: Axis::linear("bodies that touch another").with_range(0.0, 1.05),
            value: Box::new(|replica| replica.averages.bound_fraction),
            half: half(
                stability.half_bound_salt_molar,
                stability.half_bound_salt_interval_molar,
            ),
        },
    ];
    // After the radius of gyration, before what later versions draw.
    let second = observables.len().min(1);
    observables.splice(second..second, stated);
    observables
}

/// The panel of an observable; `None` if a replica does not have it.
fn panel(result: &SweepResult, groups: &[Group], observable: &Observable<'_>) -> Option<Panel> {
    let mut series = Vec::with_capacity(groups.len() + 1);
    for group in groups {
        series.push(curve(result, group, observable)?);
    }
    let salts = &result.settings.salt_molar;
    series.extend(observable.half.map(|half| half_salt(salts, half)));
    Some(Panel {
        y: observable.axis.clone(),
        series,
    })
}

/// Means of a group with their standard deviations, and the replicas behind them.
fn curve(result: &SweepResult, group: &Group, observable: &Observable<'_>) -> Option<Series> {
    let mut curve = Series {
        name: group.name.into(),
        line: true,
        ..Series::default()
    };
    let starts = result.settings.starts;
    for (row, replicas) in result.salts.iter().zip(&result.replicas) {
        let x = 1e3 * row.salt_molar;
        let is_ours = |replica: &&ReplicaResult| {
            let start = starts.of_replica(replica.replica);
            group.start.is_none_or(|ours| ours == start)
        };
        let mut values = Vec::with_capacity(replicas.len());
        for replica in replicas.iter().filter(is_ours) {
            values.push((observable.value)(replica)?.mean);
        }
        curve.points.push(Point {
            x,
            y: mean(&values),
            error: (values.len() > 1).then(|| standard_deviation(&values)),
        });
        curve
            .replicas
            .extend(values.iter().map(|value| [x, *value]));
    }
    Some(curve)
}

/// The salt at which one half is left (mol/L), with its interval. An open one reaches to the end of the salts.
pub(in crate::stability) fn half_salt(
    salts: &[f64],
    (salt, [low, high]): (f64, [Option<f64>; 2]),
) -> Series {
    let lowest = salts.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = salts.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Series {
        name: "half, and its interval of 95 %".into(),
        spans: vec![Span {
            x: 1e3 * salt,
            y: 0.5,
            from: 1e3 * low.unwrap_or(lowest),
            to: 1e3 * high.unwrap_or(highest),
        }],
        ..Series::default()
    }
}

/// The conditions, which belong to the curve.
fn caption(result: &SweepResult) -> String {
    let space = match result.box_angstrom {
        Some([x, y, z]) => {
            format!(
                "box {x:.0} × {y:.0} × {z:.0} Å ({:.3} mM of bodies)",
                1e3 * result.concentration_molar
            )
        }
        None => "no periodic box".into(),
    };
    let headline = result.stability.headline();
    let replicas = match result.settings.replicas {
        1 => "one replica".into(),
        several => format!("{several} replicas (bars: standard deviation)"),
    };
    format!(
        "{} bodies, {space}, {replicas} of {} + {} sweeps, seed {}{}",
        result.bodies,
        result.settings.equilibration_sweeps,
        result.settings.sweeps,
        result.settings.seed,
        headline.map_or_else(String::new, |headline| format!("; {headline}"))
    )
}
