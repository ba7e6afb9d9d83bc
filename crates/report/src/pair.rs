//! The page of the thermodynamics of two bodies.

use super::html::{paragraph, significant, significant_or_dash, table};
use super::page::{Page, Section};
use super::{data, figures, pair_surfaces, provenance};
use anyhow::Result;
use protomer::stability::pair::{ConditionResult, PairResult, figure};
use protomer_results::{Record, keys};
use std::path::Path;

/// The page of a directory.
///
/// # Errors
/// If a file is damaged.
pub fn page(directory: &Path) -> Result<Page> {
    let record = Record::read(directory)?;
    let mut problems: Vec<String> = provenance::unfinished(record.as_ref())
        .into_iter()
        .collect();
    let provenance = provenance::section(directory, "run.toml", record.as_ref(), Vec::new())?;
    let result: Option<PairResult> = keys::read_json_if_present(&directory.join("pair.json"))?;
    let (mut subtitle, mut sections) = ("Not finished".into(), Vec::new());
    if let Some(result) = &result {
        let [first, second] = &result.bodies;
        subtitle = format!("{first} and {second}");
        let csv = data::of_file(directory, "pair.csv")?;
        let mut html = figures::of_file(directory, "pair.svg", "Virial coefficient", &csv)?;
        if let Some(map) = figure::map(result) {
            html += &figures::map(&map)?;
        }
        html += &virial_coefficients(&result.conditions);
        sections.push(Section::new("Results", html));
        let mean_force = figures::drawn(&figure::against_distance(result), "")?;
        sections.push(Section::new("Potential of mean force", mean_force));
        sections.push(Section::new("Bound poses", poses(&result.conditions)));
        let surfaces = pair_surfaces::collect(directory, record.as_ref(), result)?;
        sections.extend(surfaces.section);
        problems.extend(surfaces.notes);
    }
    sections.push(provenance);
    Ok(Page {
        title: format!("Two bodies: {}", provenance::name(directory)),
        subtitle,
        verdict: None,
        problems,
        sections,
    })
}

fn virial_coefficients(conditions: &[ConditionResult]) -> String {
    let head = [
        "pH",
        "salt (M)",
        "B2 (Å³)",
        "± (Å³)",
        "surfaces alone (Å³)",
        "B22 (mol mL/g²)",
        "K_D (M)",
        "net charges (e)",
    ];
    let mut rows = Vec::new();
    for condition in conditions {
        let [first, second] = condition.net_charge_e;
        rows.push(vec![
            significant_or_dash(condition.ph, 3),
            significant_or_dash(condition.salt_molar, 3),
            significant(condition.b2_angstrom3, 4),
            significant(condition.b2_error_angstrom3, 2),
            significant(condition.b2_hard_angstrom3, 4),
            significant_or_dash(condition.b22_mol_ml_per_g2, 3),
            significant_or_dash(condition.kd_molar, 3),
            format!("{first:+.1}, {second:+.1}"),
        ]);
    }
    table(&head.map(str::to_owned), &rows)
}

fn poses(conditions: &[ConditionResult]) -> String {
    let head = ["pH", "salt (M)", "pose", "energy (kT)", "position (Å)"];
    let mut rows = Vec::new();
    for condition in conditions {
        for (number, pose) in condition.poses.iter().enumerate() {
            let [x, y, z] = pose.position_angstrom;
            rows.push(vec![
                significant_or_dash(condition.ph, 3),
                significant_or_dash(condition.salt_molar, 3),
                (number + 1).to_string(),
                format!("{:.2}", pose.energy_kt),
                format!("{x:.1}, {y:.1}, {z:.1}"),
            ]);
        }
    }
    match rows.is_empty() {
        true => paragraph("No pose has a negative energy."),
        false => table(&head.map(str::to_owned), &rows),
    }
}
