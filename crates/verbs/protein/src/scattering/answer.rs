//! The answer: text, tables, figure.

use anyhow::Result;
use protomer_common::answer::{Answer, columns, heading};
use protomer_io::csv::{Cell, Table};
use protomer_kernel::null;
use protomer_mc::contributions::Mean;
use protomer_mc::scattering::experiment;
use protomer_plot::{Axis, Figure, Panel, Point, Series};
use protomer_results::keys::read_json_if_present;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Cluster sizes that the text lists.
const MOST_SIZES: usize = 8;

/// Name of the file of the report.
pub(super) const FILE: &str = "scattering.json";

/// Report on the scattering of an assembly or a trajectory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ScatteringReport {
    /// Version of the program.
    pub version: String,
    /// Number of bodies.
    pub bodies: usize,
    /// Share of the frames at the beginning of each trajectory that was left out.
    pub skipped_share: f64,
    /// Whether the wave vectors are those of a periodic box.
    pub is_periodic: bool,
    /// The settings of the experiment.
    pub settings: experiment::Settings,
    /// Properties of each kind of body by itself.
    pub kinds: Vec<BodyRow>,
    /// Averages at each salt concentration, or of the assembly.
    pub states: Vec<StateRow>,
    /// Warnings about the averages.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

/// A kind of body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodyRow {
    /// Name of the body.
    pub name: String,
    /// Hydrodynamic radius of one body, Å.
    pub hydrodynamic_radius_angstrom: f64,
    /// P(q) at the wave numbers of the curves, 1 at q = 0.
    pub form_factor: Vec<f64>,
}

/// One salt concentration, averaged over frames and replicas.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StateRow {
    /// Salt concentration, mol/L; null for an assembly.
    #[serde(rename = "salt_M")]
    pub salt_molar: Option<f64>,
    /// Number of replicas.
    pub replicas: usize,
    /// Frames of all replicas.
    pub frames: usize,
    /// Bodies per cluster.
    pub mean_cluster_size: Mean,
    /// Size of the cluster of a body, averaged over bodies.
    pub weighted_cluster_size: Mean,
    /// Hydrodynamic radius as dynamic light scattering averages it, Å: Σ I / Σ (I/R) over clusters. The
    /// mean is not a number, null in JSON, if all clusters are endless.
    pub hydrodynamic_radius_angstrom: Mean,
    /// Second cumulant over the square of the first; null if all clusters are endless.
    pub polydispersity: Option<f64>,
    /// Clusters per frame that touch their own image, and count neither for radius nor polydispersity.
    pub endless_clusters: f64,
    /// The distribution of sizes.
    pub cluster_sizes: Vec<SizeRow>,
    /// S(q), P(q) and I(q).
    pub curve: Vec<CurveRow>,
}

/// Clusters of one size.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SizeRow {
    /// Bodies of such a cluster.
    pub bodies: usize,
    /// Mean number of such clusters in a frame.
    pub clusters: f64,
    /// Standard error of the number of clusters; null for one frame.
    pub clusters_error: Option<f64>,
    /// Fraction of the bodies that are in such clusters.
    pub fraction_of_bodies: f64,
    /// Standard error of the fraction; null for one frame.
    pub fraction_error: Option<f64>,
}

/// One wave number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CurveRow {
    /// Wave number, Å⁻¹; in a periodic box the mean of the wave vectors of a shell.
    pub q_per_angstrom: f64,
    /// S(q) between the origins of the bodies.
    #[serde(deserialize_with = "null::as_nan")]
    pub structure_factor: f64,
    /// Standard error of S(q); null for one frame.
    pub structure_factor_error: Option<f64>,
    /// P(q) of the bodies, weighted with their squared volumes.
    pub form_factor: f64,
    /// I(q) of all bodies over the sum of their squared volumes.
    #[serde(deserialize_with = "null::as_nan")]
    pub intensity: f64,
    /// Standard error of I(q); null for one frame.
    pub intensity_error: Option<f64>,
}

impl Answer for ScatteringReport {
    fn text(&self) -> String {
        let mut lines = vec![self.what_was_measured()];
        let mut rows = vec![heading([
            "salt (M)",
            "frames",
            "bodies per cluster",
            "R_h (Å)",
            "±",
            "share of bodies in clusters of 1, 2, ...",
        ])];
        for state in &self.states {
            let radius = state.hydrodynamic_radius_angstrom;
            rows.push(vec![
                state
                    .salt_molar
                    .map_or("-".into(), |salt| format!("{salt:.4}")),
                state.frames.to_string(),
                format!("{:.2}", state.mean_cluster_size.mean),
                match radius.mean.is_finite() {
                    true => format!("{:.2}", radius.mean),
                    false => "-".into(),
                },
                radius
                    .error
                    .map_or("-".into(), |error| format!("{error:.2}")),
                shares(&state.cluster_sizes),
            ]);
        }
        lines.push(columns(&rows));
        for kind in &self.kinds {
            let radius = kind.hydrodynamic_radius_angstrom;
            lines.push(format!("{} alone: R_h {radius:.2} Å", kind.name));
        }
        if self.states.iter().any(|state| state.endless_clusters > 0.0) {
            lines.push(
                "some clusters go through the whole box: they have no radius, and are left out of R_h"
                    .into(),
            );
        }
        lines.join("\n")
    }

    fn figure(&self) -> Option<Figure> {
        Some(self.drawn())
    }
}

impl ScatteringReport {
    /// Reads the report in a folder; `None` if there is none.
    ///
    /// # Errors
    /// If it is damaged.
    pub fn read(folder: &Path) -> protomer_results::Result<Option<Self>> {
        read_json_if_present(&folder.join(FILE))
    }

    fn what_was_measured(&self) -> String {
        let bodies = match self.bodies {
            1 => "1 body".into(),
            many => format!("{many} bodies"),
        };
        let waves = match self.is_periodic {
            true => "wave vectors of the periodic box",
            false => "all orientations",
        };
        match self.skipped_share {
            0.0 => format!("{bodies}, {waves}"),
            share => format!(
                "{bodies}, {waves}; the first {:.0} % of each trajectory are left out",
                100.0 * share
            ),
        }
    }

    /// The curves as a table.
    pub(super) fn curves(&self) -> Result<String> {
        let mut table = Table::new(vec![
            "salt_M",
            "q_per_angstrom",
            "structure_factor",
            "structure_factor_error",
            "form_factor",
            "intensity",
            "intensity_error",
        ]);
        for state in &self.states {
            for row in &state.curve {
                table.push(vec![
                    Cell::from(state.salt_molar),
                    row.q_per_angstrom.into(),
                    row.structure_factor.into(),
                    Cell::from(row.structure_factor_error),
                    row.form_factor.into(),
                    row.intensity.into(),
                    Cell::from(row.intensity_error),
                ])?;
            }
        }
        Ok(table.to_csv()?)
    }

    /// The distribution of cluster sizes as a table.
    pub(super) fn clusters(&self) -> Result<String> {
        let mut table = Table::new(vec![
            "salt_M",
            "bodies",
            "clusters",
            "clusters_error",
            "fraction_of_bodies",
            "fraction_error",
        ]);
        for state in &self.states {
            for row in &state.cluster_sizes {
                table.push(vec![
                    Cell::from(state.salt_molar),
                    row.bodies.into(),
                    row.clusters.into(),
                    Cell::from(row.clusters_error),
                    row.fraction_of_bodies.into(),
                    Cell::from(row.fraction_error),
                ])?;
            }
        }
        Ok(table.to_csv()?)
    }

    /// S(q) and I(q), a line for each state, and the P(q) that I(q) would be without interactions.
    pub(super) fn drawn(&self) -> Figure {
        let (mut structure, mut intensity) = (Vec::new(), Vec::new());
        for state in &self.states {
            let name = state
                .salt_molar
                .map_or(String::new(), |salt| format!("{} mM", 1e3 * salt));
            structure.push(series(&name, &state.curve, |row| {
                (row.structure_factor, row.structure_factor_error)
            }));
            intensity.push(series(&name, &state.curve, |row| {
                (row.intensity, row.intensity_error)
            }));
        }
        if let Some(state) = self.states.first() {
            intensity.push(series("P(q)", &state.curve, |row| (row.form_factor, None)));
        }
        Figure {
            title: "What scattering sees".into(),
            caption: self.what_was_measured(),
            x: Axis::linear("q (1/Å)"),
            panels: vec![
                Panel {
                    y: Axis::linear("S(q) of the centres"),
                    series: structure,
                },
                Panel {
                    y: Axis::log("I(q)"),
                    series: intensity,
                },
            ],
        }
    }
}

fn series(
    name: &str,
    curve: &[CurveRow],
    value: impl Fn(&CurveRow) -> (f64, Option<f64>),
) -> Series {
    let points = curve.iter().map(|row| {
        let (y, error) = value(row);
        Point {
            x: row.q_per_angstrom,
            y,
            error,
        }
    });
    Series {
        name: name.into(),
        // Zero cannot be shown on a logarithmic axis.
        points: points.filter(|point| point.y > 0.0).collect(),
        line: true,
        ..Series::default()
    }
}

fn shares(sizes: &[SizeRow]) -> String {
    let shown = sizes.iter().take(MOST_SIZES);
    let mut text: Vec<String> = shown
        .map(|row| format!("{:.2}", row.fraction_of_bodies))
        .collect();
    if sizes.len() > MOST_SIZES {
        text.push("...".into());
    }
    text.join(" ")
}
