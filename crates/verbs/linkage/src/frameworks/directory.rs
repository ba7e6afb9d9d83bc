//! The files of a result. Existing files are overwritten only on request.

use super::curve::Curve;
use super::drawing::{self, LoadedNetwork};
use super::figure::polar_figure;
use super::film::film;
use super::network_file;
use super::report::{FILE, Report};
use anyhow::{Context, Result};
use protomer_common::output_file::refuse_to_overwrite;
use protomer_io::atomic::{sha256_hex, write_bytes};
use protomer_io::csv::{Cell, Table};
use protomer_linkage::framework::Framework;
use protomer_results::{Exit, Record, ResultKind, Work};
use std::path::Path;

/// A file name in the directory, and the content.
pub type NamedFile = (String, Vec<u8>);

/// The moving picture, which is drawn from the other files and so is no part of their identity.
const FILM: &str = "deformation.svg";

/// All files of a report: `result.json`, `network.toml`, `stiffness.csv`, `polar.csv`, `polar.svg`,
/// `polar.png`, `drawing.svg`, `curve.csv`, `deformation.svg`; those of the polar plot, the curve and
/// the film only if they exist.
///
/// # Errors
/// If a figure cannot be drawn.
pub fn files(
    report: &Report,
    unloaded: &Framework,
    loaded: Option<&Framework>,
    states: &[Framework],
) -> Result<Vec<NamedFile>> {
    let mut files = Vec::new();
    let mut add = |name: &str, bytes: Vec<u8>| files.push((name.to_owned(), bytes));
    add(
        FILE,
        (serde_json::to_string_pretty(report)? + "\n").into_bytes(),
    );
    add(
        "network.toml",
        network_file::to_toml(unloaded, &report.network).into_bytes(),
    );
    add(
        "stiffness.csv",
        stiffness_table(report)?.to_csv()?.into_bytes(),
    );
    if !report.polar.is_empty() {
        let mut table = Table::new(["angle_deg", "e_gpa", "nu"]);
        for direction in &report.polar {
            table.push([
                direction.angle_deg.into(),
                direction.e_gpa.into(),
                direction.nu.into(),
            ])?;
        }
        add("polar.csv", table.to_csv()?.into_bytes());
    }
    if let Some(figure) = polar_figure(report) {
        add("polar.svg", figure.to_svg()?.into_bytes());
        add("polar.png", figure.to_png()?);
    }
    if let Some(curve) = &report.curve {
        add("curve.csv", curve.table()?.to_csv()?.into_bytes());
    }
    add("drawing.svg", draw(report, unloaded, loaded).into_bytes());
    if let Some(curve) = &report.curve
        && let Some(last) = curve.points.last()
        && let Some(film) = film(
            &report.network,
            &format!(
                "from no load to {:.4} GPa along {} (nominal) and back",
                last.nominal_gpa, curve.axis
            ),
            states,
        )
    {
        add(FILM, film.into_bytes());
    }
    Ok(files)
}

fn draw(report: &Report, unloaded: &Framework, loaded: Option<&Framework>) -> String {
    let under = |curve: &Curve| -> Option<(String, usize, bool)> {
        let last = curve.points.last()?;
        let axis = super::axes(report.dimension)
            .iter()
            .position(|name| *name == curve.axis)?;
        let label = format!(
            "under {:.4} GPa along {} (Cauchy; nominal {:.4} GPa)",
            last.cauchy_gpa, curve.axis, last.nominal_gpa
        );
        Some((label, axis, last.cauchy_gpa < 0.0))
    };
    let under = report.curve.as_ref().and_then(under);
    let loaded = loaded
        .zip(under.as_ref())
        .map(|(network, (label, axis, pushed))| LoadedNetwork {
            network,
            axis: *axis,
            pushed: *pushed,
            label,
        });
    drawing::svg(&report.network, unloaded, loaded)
}

fn stiffness_table(report: &Report) -> Result<Table> {
    let head = ["kind", "strain"]
        .into_iter()
        .chain(report.strain_order.iter().map(String::as_str));
    let mut table = Table::new(head);
    for (kind, matrix) in [
        ("relaxed_gpa", &report.c_gpa),
        ("clamped_gpa", &report.c_clamped_gpa),
    ] {
        for (name, row) in report.strain_order.iter().zip(matrix) {
            let first: [Cell; 2] = [kind.into(), name.as_str().into()];
            table.push(
                first
                    .into_iter()
                    .chain(row.iter().map(|value| (*value).into())),
            )?;
        }
    }
    Ok(table)
}

/// Writes files into a folder, which is created if necessary, together with the record of their
/// kind. Each file is written atomically.
///
/// # Errors
/// If a file already exists and `force` is not set, the folder holds another kind of result,
/// or a file cannot be written.
pub fn write(folder: &Path, kind: ResultKind, files: &[NamedFile], force: bool) -> Result<()> {
    kind.refuse_other(folder)?;
    for (name, _) in files {
        refuse_to_overwrite(&folder.join(name), force)?;
    }
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot create the folder {}", folder.display()))?;
    for (name, bytes) in files {
        write_bytes(&folder.join(name), bytes)?;
    }
    // Frameworks are never continued, so the hash of the results is their identity.
    let results = files.iter().filter(|(name, _)| name != FILM);
    let everything: Vec<u8> = results.flat_map(|(_, bytes)| bytes.clone()).collect();
    let work = Work {
        kind,
        verb: "framework",
        identity: sha256_hex(&everything),
        input_sha256: String::new(),
    };
    Ok(Record::new(&work, Exit::Done).write(folder)?)
}
