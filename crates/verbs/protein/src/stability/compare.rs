//! Several sweeps in one figure: which arrangement is stable over the wider range of salt?

use crate::file_kind::FileKind;
use crate::stability::sweep::result::SweepResult;
use crate::stability::sweep::table::SaltRow;
use anyhow::{Context, Result, bail};
use protomer_common::answer::Answer;
use protomer_common::output_file::write_once;
use protomer_plot::{Axis, Figure, Panel, Point, Series, literal};
use protomer_results::{ResultKind, keys};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Warning about the means of a sweep that is not equilibrated.
pub(crate) const NOT_ONE_STATE: &str =
    "the sweep is not equilibrated, so its means are over replicas in different states";

/// The result of a comparison.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CompareReport {
    /// The figure.
    pub figure: PathBuf,
    /// One curve per sweep.
    pub sweeps: Vec<ComparedSweep>,
    #[serde(skip)]
    title: String,
}

impl Answer for CompareReport {
    fn text(&self) -> String {
        let mut lines = vec![format!("figure: {}", self.figure.display())];
        for sweep in &self.sweeps {
            if sweep.equilibrated == Some(false) {
                lines.push(format!("{}: {NOT_ONE_STATE}", sweep.name));
            }
        }
        lines.join("\n")
    }

    fn figure(&self) -> Option<Figure> {
        let (mut r_g, mut native) = (Vec::new(), Vec::new());
        let mut all_have_salt = true;
        for sweep in &self.sweeps {
            r_g.push(sweep.series(&sweep.r_g_mean_angstrom, &sweep.r_g_sd_angstrom));
            native.push(sweep.series(&sweep.native_contacts_mean, &sweep.native_contacts_sd));
            all_have_salt &= sweep.salt_molar.iter().all(|salt| *salt > 0.0);
        }
        // Zero salt cannot be shown on a logarithmic axis.
        let x = match all_have_salt {
            true => Axis::log("salt (mM)"),
            false => Axis::linear("salt (mM)"),
        };
        let r_g = Panel {
            y: Axis::linear("radius of gyration (Å)"),
            series: r_g,
        };
        let native = Panel {
            y: Axis::linear("native contacts left").with_range(0.0, 1.05),
            series: native,
        };
        Some(Figure {
            title: self.title.clone(),
            caption: "mean and standard deviation over replicas".into(),
            x,
            panels: vec![r_g, native],
        })
    }
}

/// A sweep of a comparison, a list entry per salt concentration.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparedSweep {
    /// Name in the legend.
    pub name: String,
    /// Whether the runs from the assembly and from the fluid agree; `None` if that is not known.
    pub equilibrated: Option<bool>,
    /// Salt concentration, mol/L.
    #[serde(rename = "salt_M")]
    pub salt_molar: Vec<f64>,
    /// Mean radius of gyration over replicas, Å.
    pub r_g_mean_angstrom: Vec<f64>,
    /// Standard deviation of the radius of gyration over replicas, Å.
    pub r_g_sd_angstrom: Vec<f64>,
    /// Mean surviving fraction of the native contacts; NaN if there were none.
    pub native_contacts_mean: Vec<f64>,
    /// Standard deviation of the surviving fraction over replicas.
    pub native_contacts_sd: Vec<f64>,
}

impl ComparedSweep {
    /// The curve of a column with its standard deviations.
    fn series(&self, means: &[f64], deviations: &[f64]) -> Series {
        let mut points = Vec::new();
        for ((salt, mean), deviation) in self.salt_molar.iter().zip(means).zip(deviations) {
            points.push(Point {
                x: 1e3 * salt,
                y: *mean,
                error: Some(*deviation),
            });
        }
        Series {
            name: literal(&self.name),
            points,
            line: true,
            ..Series::default()
        }
    }
}

/// Draws several finished sweeps in one figure, a PNG or SVG file.
///
/// # Errors
/// If there are no sweeps, one is not finished, the figure has another extension, or exists with other
/// content and `force` is not set.
///
/// ```no_run
/// use protomer_protein_verbs::stability::compare::compare;
/// use std::path::Path;
/// let sweeps = ["dimer".into(), "ring".into()];
/// let report = compare(&sweeps, "Stability against salt", Path::new("compare.svg"), false)?;
/// assert_eq!(report.sweeps.len(), 2);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn compare(
    directories: &[PathBuf],
    title: &str,
    output: &Path,
    force: bool,
) -> Result<CompareReport> {
    if directories.is_empty() {
        bail!("name at least one sweep directory");
    }
    let sweeps = directories.iter().map(|directory| read_sweep(directory));
    let report = CompareReport {
        figure: output.to_owned(),
        sweeps: sweeps.collect::<Result<_>>()?,
        title: title.into(),
    };
    let figure = report.figure().unwrap_or_default();
    match output.extension().and_then(|ending| ending.to_str()) {
        Some("png") => write_once(output, &figure.to_png()?, force)?,
        Some("svg") => write_once(output, &figure.to_svg()?, force)?,
        _ => bail!(
            "{} ends in neither .png nor .svg; choose one of them",
            output.display()
        ),
    }
    Ok(report)
}

/// Reads the curves of a finished sweep.
fn read_sweep(directory: &Path) -> Result<ComparedSweep> {
    FileKind::Results(ResultKind::Sweep).require(directory)?;
    let path = directory.join("sweep.json");
    let text = protomer_io::input::read_to_string(&path)
        .with_context(|| format!("cannot read {}; finish the sweep first", path.display()))?;
    let sweep: SweepResult = keys::from_json(&path, text.as_bytes())?;
    let column = |value: fn(&SaltRow) -> f64| sweep.salts.iter().map(value).collect();
    let absolute = std::path::absolute(directory)?;
    let name = absolute.file_name().unwrap_or_default().to_string_lossy();
    Ok(ComparedSweep {
        name: name.replace('_', " "),
        equilibrated: sweep.stability.equilibrated,
        salt_molar: column(|row| row.salt_molar),
        r_g_mean_angstrom: column(|row| row.averages.r_g_angstrom.mean),
        r_g_sd_angstrom: column(|row| row.averages.r_g_angstrom.deviation),
        native_contacts_mean: column(|row| row.averages.native_contacts.mean),
        native_contacts_sd: column(|row| row.averages.native_contacts.deviation),
    })
}
