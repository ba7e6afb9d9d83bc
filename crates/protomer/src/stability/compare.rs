//! Several sweeps in one figure: which arrangement stays together over the larger range of salt?

use crate::plot::{Axis, Figure, Panel, Point, Series};
use anyhow::{Context, Result, bail};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The part of a sweep that is compared.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepCurve {
    /// Name in the legend: that of the directory.
    pub name: String,
    /// Salt (mol/L), mean and standard deviation of the radius of gyration (Å), of the surviving
    /// contacts.
    pub rows: Vec<[f64; 5]>,
}

/// Reads the curve of a finished sweep.
///
/// # Errors
/// If the directory holds no finished sweep.
pub fn read_curve(directory: &Path) -> Result<SweepCurve> {
    let path = directory.join("sweep.json");
    let text = std::fs::read_to_string(&path)
        .with_context(|| format!("cannot read {}; finish the sweep first", path.display()))?;
    let json: serde_json::Value =
        serde_json::from_str(&text).with_context(|| path.display().to_string())?;
    const KEYS: [&str; 5] = [
        "salt_M",
        "r_g_mean_angstrom",
        "r_g_sd_angstrom",
        "native_contacts_mean",
        "native_contacts_sd",
    ];
    let salts = json["salts"]
        .as_array()
        .with_context(|| format!("{} lists no salts", path.display()))?;
    let rows = salts
        .iter()
        .map(|row| KEYS.map(|key| row[key].as_f64().unwrap_or(f64::NAN)))
        .collect();
    let absolute = std::path::absolute(directory)?;
    let name = absolute
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .replace('_', " ");
    Ok(SweepCurve { name, rows })
}

/// What a comparison came to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CompareReport {
    /// The figure.
    pub figure: PathBuf,
    /// One curve per sweep.
    pub sweeps: Vec<ComparedSweep>,
}

/// A sweep of a comparison, a list entry per salt concentration.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparedSweep {
    /// Name in the legend.
    pub name: String,
    /// Salt concentration, mol/L.
    #[serde(rename = "salt_M")]
    pub salt_molar: Vec<f64>,
    /// Mean radius of gyration over replicas, Å.
    pub r_g_mean_angstrom: Vec<f64>,
    /// Standard deviation over replicas, Å.
    pub r_g_sd_angstrom: Vec<f64>,
    /// Mean surviving fraction of the contacts of the start; NaN where it had none.
    pub native_contacts_mean: Vec<f64>,
    /// Standard deviation over replicas.
    pub native_contacts_sd: Vec<f64>,
}

impl CompareReport {
    /// The report of a figure of these curves.
    pub fn of(figure: &Path, curves: &[SweepCurve]) -> Self {
        let sweep = |curve: &SweepCurve| {
            let column = |place: usize| curve.rows.iter().map(|row| row[place]).collect();
            ComparedSweep {
                name: curve.name.clone(),
                salt_molar: column(0),
                r_g_mean_angstrom: column(1),
                r_g_sd_angstrom: column(2),
                native_contacts_mean: column(3),
                native_contacts_sd: column(4),
            }
        };
        Self {
            figure: figure.to_owned(),
            sweeps: curves.iter().map(sweep).collect(),
        }
    }
}

/// The curves of finished sweeps.
///
/// # Errors
/// Without sweeps, or if one is not finished.
pub fn read_curves(directories: &[PathBuf]) -> Result<Vec<SweepCurve>> {
    if directories.is_empty() {
        bail!("name at least one sweep directory");
    }
    directories
        .iter()
        .map(|directory| read_curve(directory))
        .collect()
}

/// The figure of several sweeps.
pub fn figure(curves: &[SweepCurve], title: &str) -> Figure {
    let log = curves
        .iter()
        .flat_map(|curve| &curve.rows)
        .all(|row| row[0] > 0.0);
    let panel = |y: Axis, mean: usize| Panel {
        y,
        series: curves.iter().map(|curve| series(curve, mean)).collect(),
    };
    Figure {
        title: title.into(),
        caption: "mean and standard deviation over replicas".into(),
        x: if log {
            Axis::log("salt (mM)")
        } else {
            Axis::linear("salt (mM)")
        },
        panels: vec![
            panel(Axis::linear("radius of gyration (Å)"), 1),
            panel(
                Axis::linear("native contacts left").with_range(0.0, 1.05),
                3,
            ),
        ],
    }
}

fn series(curve: &SweepCurve, mean: usize) -> Series {
    let point = |row: &[f64; 5]| Point {
        x: 1e3 * row[0],
        y: row[mean],
        error: Some(row[mean + 1]),
    };
    Series {
        name: curve.name.clone(),
        points: curve.rows.iter().map(point).collect(),
        replicas: Vec::new(),
        line: true,
    }
}
