//! The verb `framework` and its answer: constants and curves as text, moduli against direction as a
//! figure.

use super::curve::{self, Curve};
use super::figure::polar_figure;
use super::report::{Analytic, Report, Settings, analyse};
use super::{directory, network_file, tables};
use anyhow::{Result, bail};
use protomer_common::answer::{Answer, columns};
use protomer_common::output_file::write_once;
use protomer_linkage::framework::analytic::Honeycomb;
use protomer_linkage::framework::{Framework, StressKind};
use protomer_plot::Figure;
use protomer_results::ResultKind;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// A network and the analysis to perform.
#[derive(Debug, Clone)]
pub struct Analysis {
    /// The network.
    pub network: Framework,
    /// Name of the network in the results.
    pub name: String,
    /// Parameters of the network if it is a honeycomb, for the closed formulas.
    pub honeycomb: Option<Honeycomb>,
    /// Settings of the analysis.
    pub settings: Settings,
    /// The loads to apply one after another.
    pub load: Option<LoadSettings>,
    /// File to which the network is written as TOML.
    pub network_file: Option<PathBuf>,
    /// The directory of the results.
    pub output: Option<PathBuf>,
}

/// Loads along an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadSettings {
    /// The axis: x, y or z.
    pub axis: String,
    /// The stresses, GPa; negative values are compressive.
    pub stresses_gpa: Vec<f64>,
    /// The reference area of the stress.
    pub kind: StressKind,
}

impl Analysis {
    /// Analyses the network, loads it, and writes the requested files; `force` allows overwriting.
    ///
    /// # Errors
    /// If the network is invalid, has no equilibrium under a load, or a file cannot be written.
    pub fn run(&self, force: bool) -> Result<Report> {
        if let Some(path) = &self.network_file {
            write_once(
                path,
                &network_file::to_toml(&self.network, &self.name),
                force,
            )?;
        }
        let (placed, mut report) = analyse(&self.network, &self.name, &self.settings)?;
        let gpa = report.gpa_per_kcal_mol_angstrom3;
        if let (Some(honeycomb), None) = (&self.honeycomb, self.settings.relax) {
            report.analytic = Some(Analytic::from_honeycomb(honeycomb, gpa));
        }
        let mut loaded = None;
        if let Some(load) = &self.load {
            let (curve, last) =
                curve::load(&placed, &load.axis, &load.stresses_gpa, load.kind, gpa)?;
            report.curve = Some(curve);
            loaded = Some(last);
        }
        if let Some(folder) = &self.output {
            let states = match &self.load {
                Some(load) => curve::states(&placed, load, gpa)?,
                None => Vec::new(),
            };
            let files = directory::files(&report, &placed, loaded.as_ref(), &states)?;
            directory::write(folder, ResultKind::ElasticConstants, &files, force)?;
        }
        Ok(report)
    }
}

impl Answer for Report {
    fn text(&self) -> String {
        let [head, tail] = self.describe();
        let moduli = columns(&self.moduli_rows());
        let curve = self.curve.as_ref().map(describe_curve);
        let curve = curve.map_or_else(String::new, |curve| format!("\n\n{curve}"));
        format!("{head}\n\n{moduli}\n\n{tail}{curve}")
    }

    fn figure(&self) -> Option<Figure> {
        polar_figure(self)
    }
}

fn describe_curve(curve: &Curve) -> String {
    let kind = match curve.stress_kind {
        StressKind::Nominal => "nominal",
        StressKind::Cauchy => "Cauchy",
    };
    let table = match curve.rows() {
        Ok(rows) => columns(&rows),
        Err(error) => error.to_string(),
    };
    format!("loaded along {} ({kind} stress):\n{table}", curve.axis)
}

/// The tables of the paper, recomputed.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(transparent)]
pub struct PaperTables {
    rows: Vec<tables::Row>,
}

impl PaperTables {
    /// Computes the tables and, if a directory is given, writes them there.
    ///
    /// # Errors
    /// If a file already exists and `force` is not set, or cannot be written.
    pub fn compute(output: Option<&Path>, force: bool) -> Result<Self> {
        let tables = Self {
            rows: tables::rows()?,
        };
        if let Some(folder) = output {
            let json = serde_json::to_string_pretty(&tables)? + "\n";
            let files = [
                ("tables.json".to_owned(), json.into_bytes()),
                ("tables.txt".to_owned(), (tables.text() + "\n").into_bytes()),
            ];
            directory::write(folder, ResultKind::FrameworkTables, &files, force)?;
        }
        Ok(tables)
    }
}

impl Answer for PaperTables {
    fn text(&self) -> String {
        let described = tables::describe(&self.rows);
        let parts: Vec<String> = described
            .into_iter()
            .map(|(title, lines)| format!("{title}\n{}\n", columns(&lines)))
            .collect();
        format!("{}\n{}", parts.join("\n"), tables::legend(&self.rows))
    }
}

/// Parses the number of cells along each cell vector: `2x2`, or one number for all directions.
///
/// # Errors
/// If the text is malformed, or does not match the dimension of the network.
///
/// ```
/// use protomer_linkage_verbs::frameworks::answer::cell_counts;
/// assert_eq!(cell_counts("2x3", 2)?, [2, 3]);
/// assert_eq!(cell_counts("4", 3)?, [4, 4, 4]);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn cell_counts(text: &str, dimension: usize) -> Result<Vec<usize>> {
    let counts: Result<Vec<usize>, _> = text
        .split('x')
        .map(|count| count.trim().parse::<usize>())
        .collect();
    match counts.as_deref() {
        Ok([one]) => Ok(vec![*one; dimension]),
        Ok(several) if several.len() == dimension => Ok(several.to_vec()),
        Ok(_) => bail!(
            "--cells is '{text}'; the network has {dimension} dimensions, so give {dimension} counts"
        ),
        Err(_) => bail!("--cells is '{text}'; write it like 2x2"),
    }
}
