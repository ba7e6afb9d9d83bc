//! What other verbs left in the directory of a run: `scattering` and `reweight`, each in its folder.

use super::html::{paragraph, significant_or_dash, table};
use super::page::Section;
use super::{data, figures};
use anyhow::Result;
use protomer::scattering::FOLDER as SCATTERING;
use protomer::stability::reweighting::FOLDER as REWEIGHTING;
use protomer_results::keys::read_json_if_present;
use serde_json::Value;
use std::path::Path;

/// The sections for the results that are there.
///
/// # Errors
/// If a file is damaged.
pub fn sections(directory: &Path) -> Result<Vec<Section>> {
    let mut sections = Vec::new();
    let folder = directory.join(REWEIGHTING);
    if let Some(result) = read(&folder.join("reweighting.json"))? {
        sections.push(reweighting(&folder, &result)?);
    }
    let folder = directory.join(SCATTERING);
    if let Some(result) = read(&folder.join("scattering.json"))? {
        sections.push(scattering(&folder, &result)?);
    }
    Ok(sections)
}

fn read(path: &Path) -> Result<Option<Value>> {
    Ok(read_json_if_present(path)?)
}

fn rows<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().map_or(&[], Vec::as_slice)
}

fn millimolar(molar: &Value, digits: usize) -> String {
    significant_or_dash(molar.as_f64().map(|molar| 1e3 * molar), digits)
}

fn with_error(estimate: &Value, digits: usize) -> String {
    let mean = significant_or_dash(estimate["mean"].as_f64(), digits);
    match estimate["error"].as_f64() {
        Some(error) => format!("{mean} ± {}", significant_or_dash(Some(error), 2)),
        None => mean,
    }
}

fn scattering(folder: &Path, result: &Value) -> Result<Section> {
    let head = [
        "salt (mM)",
        "frames",
        "bodies per cluster",
        "hydrodynamic radius (Å)",
    ];
    let mut lines = Vec::new();
    for state in rows(result, "states") {
        lines.push(vec![
            millimolar(&state["salt_M"], 4),
            state["frames"].to_string(),
            with_error(&state["mean_cluster_size"], 4),
            with_error(&state["hydrodynamic_radius_angstrom"], 4),
        ]);
    }
    let mut html = paragraph(
        "Hydrodynamic radii as dynamic light scattering averages them; S(q) between the centres, and I(q) \
         beside P(q), which it would be without interactions.",
    );
    html += &table(&head.map(str::to_owned), &lines);
    let curves = data::of_file(folder, "scattering.csv")?;
    html += &figures::of_file(folder, "scattering.svg", "What scattering sees", &curves)?;
    html += &data::of_file(folder, "clusters.csv")?;
    Ok(Section::new("What scattering sees", html))
}

fn reweighting(folder: &Path, result: &Value) -> Result<Section> {
    let is_equilibrated = result["equilibrated"].as_bool();
    let mut html = paragraph(match is_equilibrated {
        Some(false) => "Not equilibrated, as the sweep says, so there is no half salt.",
        _ => {
            "All frames of the sweep together, weighted to every salt, and to other concentrations of \
             bodies by mass action."
        }
    });
    let head = [
        "bodies (mM)",
        "half of the contacts left (mM salt)",
        "half of the bodies bound (mM salt)",
    ];
    let half = |half: &Value| match half["interval_M"].as_array().map(Vec::as_slice) {
        Some([low, high]) => format!(
            "{} (95 %: {} to {})",
            millimolar(&half["salt_M"], 3),
            millimolar(low, 3),
            millimolar(high, 3)
        ),
        _ => millimolar(&half["salt_M"], 3),
    };
    let mut lines = Vec::new();
    for curve in rows(result, "concentrations") {
        lines.push(vec![
            millimolar(&curve["concentration_M"], 3),
            half(&curve["half_salt"]),
            half(&curve["half_bound_salt"]),
        ]);
    }
    html += &table(&head.map(str::to_owned), &lines);
    let curves = data::of_file(folder, "reweighting.csv")?;
    html += &figures::of_file(
        folder,
        "reweighting.svg",
        "Stability from all frames",
        &curves,
    )?;
    Ok(Section::new("Curves from all frames", html))
}
