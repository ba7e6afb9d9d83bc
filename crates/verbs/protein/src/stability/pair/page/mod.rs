//! The page of the thermodynamics of two bodies.

pub(crate) mod surfaces;

use super::{ConditionResult, PairResult, figure};
use anyhow::Result;
use protomer_common::page::{Contents, Part, Section, significant, significant_or_dash};
use protomer_results::{Record, keys};
use std::path::Path;

/// Contents of the page of a directory.
///
/// # Errors
/// If a file is damaged.
pub fn contents(directory: &Path, record: Option<&Record>) -> Result<Contents> {
    let mut contents = Contents::new("Two bodies");
    let result: Option<PairResult> = keys::read_json_if_present(&directory.join("pair.json"))?;
    let Some(result) = result else {
        return Ok(contents);
    };
    let [first, second] = &result.bodies;
    contents.subtitle = format!("{first} and {second}");
    let mut parts = vec![Part::picture(
        "pair.svg",
        "Virial coefficient",
        Some("pair.csv"),
    )];
    parts.extend(figure::map(&result).map(|map| Part::Map(Box::new(map))));
    parts.push(virial_coefficients(&result.conditions));
    contents.add(Section::new("Results", parts));
    let mean_force = Part::Figure(Box::new(figure::against_distance(&result)), None);
    contents.add(Section::new("Potential of mean force", vec![mean_force]));
    contents.add(Section::new("Bound poses", vec![poses(&result.conditions)]));
    let surfaces = surfaces::collect(directory, record, &result)?;
    contents.sections.extend(surfaces.section);
    contents.problems.extend(surfaces.notes);
    Ok(contents)
}

fn virial_coefficients(conditions: &[ConditionResult]) -> Part {
    let columns = vec![
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
    Part::Table { columns, rows }
}

fn poses(conditions: &[ConditionResult]) -> Part {
    let columns = vec!["pH", "salt (M)", "pose", "energy (kT)", "position (Å)"];
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
        true => Part::Paragraph("No pose has a negative energy.".into()),
        false => Part::Table { columns, rows },
    }
}
