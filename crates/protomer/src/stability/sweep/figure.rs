//! The figure of a sweep: radius of gyration, surviving contacts and bound bodies against salt, with
//! individual replicas.

use super::result::SweepResult;
use super::series;
use crate::stability::run::RunSettings;
use anyhow::Result;
use protomer_plot::{Axis, Figure, Panel, Point, Series};
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
    let mut r_g = named("mean over replicas ± standard deviation");
    let mut native = named("fraction of the contacts of the start");
    let mut bound = named("fraction of the bodies");
    let (mut all_have_contacts, mut all_have_salt) = (true, true);
    let mut all_have_bound = true;
    for (row, replicas) in result.salts.iter().zip(&result.replicas) {
        let x = 1e3 * row.salt_molar;
        let has_spread = row.replicas > 1;
        r_g.points.push(Point {
            x,
            y: row.r_g_mean_angstrom,
            error: has_spread.then_some(row.r_g_sd_angstrom),
        });
        native.points.push(Point {
            x,
            y: row.native_contacts_mean,
            error: has_spread.then_some(row.native_contacts_sd),
        });
        bound.points.push(Point {
            x,
            y: row.bound_fraction_mean,
            error: has_spread.then_some(row.bound_fraction_sd),
        });
        for replica in replicas {
            r_g.replicas.push([x, replica.r_g_angstrom.mean]);
            if let Some(fraction) = &replica.native_contacts {
                native.replicas.push([x, fraction.mean]);
            }
            if let Some(fraction) = &replica.bound_fraction {
                bound.replicas.push([x, fraction.mean]);
            }
        }
        all_have_bound &= row.bound_fraction_mean.is_finite();
        all_have_contacts &= row.native_contacts_mean.is_finite();
        all_have_salt &= row.salt_molar > 0.0;
    }
    let mut panels = vec![Panel {
        y: Axis::linear("radius of gyration (Å)"),
        series: vec![r_g],
    }];
    if all_have_contacts {
        panels.push(Panel {
            y: Axis::linear("native contacts left").with_range(0.0, 1.05),
            series: vec![native],
        });
    }
    if all_have_bound {
        panels.push(Panel {
            y: Axis::linear("bodies that touch another").with_range(0.0, 1.05),
            series: vec![bound],
        });
    }
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

/// A line without points.
fn named(name: &str) -> Series {
    Series {
        name: name.into(),
        points: Vec::new(),
        replicas: Vec::new(),
        line: true,
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
        several => format!("{several} replicas"),
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
