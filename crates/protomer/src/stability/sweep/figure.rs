//! The figure of a sweep: radius of gyration and surviving contacts against salt, with
//! individual replicas.

use super::table::{ReplicaResult, SaltRow, SweepResult};
use anyhow::Result;
use protomer_plot::{Axis, Figure, Panel, Point, Series};
use std::path::Path;

/// Writes `sweep.svg` and `sweep.png` into a directory.
///
/// # Errors
/// If a figure cannot be drawn or written.
pub fn write(result: &SweepResult, directory: &Path) -> Result<()> {
    let figure = figure(result);
    figure.write_svg(&directory.join("sweep.svg"))?;
    figure.write_png(&directory.join("sweep.png"))?;
    Ok(())
}

/// The figure of a sweep.
pub fn figure(result: &SweepResult) -> Figure {
    let r_g = Panel {
        y: Axis::linear("radius of gyration (Å)"),
        series: vec![series(
            result,
            "mean over replicas ± standard deviation",
            |row| (row.r_g_mean_angstrom, row.r_g_sd_angstrom),
            |replica| Some(replica.r_g_angstrom.mean),
        )],
    };
    let native = Panel {
        y: Axis::linear("native contacts left").with_range(0.0, 1.05),
        series: vec![series(
            result,
            "fraction of the contacts of the start",
            |row| (row.native_contacts_mean, row.native_contacts_sd),
            |replica| replica.native_contacts.as_ref().map(|summary| summary.mean),
        )],
    };
    let has_contacts = result
        .salts
        .iter()
        .all(|row| row.native_contacts_mean.is_finite());
    // Zero salt cannot be shown on a logarithmic axis.
    let log = result.salts.len() > 1 && result.salts.iter().all(|row| row.salt_molar > 0.0);
    let x = if log {
        Axis::log("salt (mM)")
    } else {
        Axis::linear("salt (mM)")
    };
    Figure {
        title: "Stability against salt".into(),
        caption: caption(result),
        x,
        panels: if has_contacts {
            vec![r_g, native]
        } else {
            vec![r_g]
        },
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
    format!(
        "{} bodies, {space}, {} replicas of {} + {} sweeps, seed {}",
        result.bodies,
        result.settings.replicas,
        result.settings.equilibration_sweeps,
        result.settings.sweeps,
        result.settings.seed
    )
}

fn series(
    result: &SweepResult,
    name: &str,
    mean: fn(&SaltRow) -> (f64, f64),
    of_replica: fn(&ReplicaResult) -> Option<f64>,
) -> Series {
    let millimolar = |row: &SaltRow| 1e3 * row.salt_molar;
    let points = result.salts.iter().map(|row| {
        let (y, deviation) = mean(row);
        Point {
            x: millimolar(row),
            y,
            error: (row.replicas > 1).then_some(deviation),
        }
    });
    let replicas = result
        .salts
        .iter()
        .zip(&result.replicas)
        .flat_map(|(row, replicas)| {
            replicas
                .iter()
                .filter_map(of_replica)
                .map(move |y| [millimolar(row), y])
        });
    Series {
        name: name.into(),
        points: points.collect(),
        replicas: replicas.collect(),
        line: true,
    }
}
