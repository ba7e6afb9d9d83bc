//! The page of an equilibrium.

use super::answer::shown;
use super::result::{StabilityResult, listed};
use anyhow::Result;
use protomer_common::page::{Contents, Part, Section, Verdict, significant, significant_or_dash};
use protomer_results::{Record, keys};
use std::path::Path;

/// Contents of the page of a directory.
///
/// # Errors
/// If a file is damaged.
pub fn contents(directory: &Path, _: Option<&Record>) -> Result<Contents> {
    let mut contents = Contents::new("Equilibrium");
    let result: Option<StabilityResult> =
        keys::read_json_if_present(&directory.join("stability.json"))?;
    let Some(result) = result else {
        return Ok(contents);
    };
    let species: Vec<String> = result
        .species
        .iter()
        .map(|species| format!("{} {}", species.bodies, species.name))
        .collect();
    contents.subtitle = species.join(" and ");
    let answer = match &*result.equilibrated {
        "yes" => Some(true),
        "no" => Some(false),
        _ => None,
    };
    contents.verdict = Some(Verdict::equilibrated(answer, &result.equilibration));
    let picture = Part::picture("stability.svg", "Whole assemblies", Some("stability.csv"));
    let parts = vec![
        Part::Paragraph(format!("{}.", capitalised(&result.headline()))),
        picture,
        yields(&result),
    ];
    contents.add(Section::new("Results", parts));
    let way = format!("{}: {}.", capitalised(&result.way), result.reason);
    let parts = vec![
        Part::Paragraph(way),
        parts_of(&result),
        Part::file("parts.csv"),
    ];
    contents.add(Section::new("Parts", parts));
    if !result.warnings.is_empty() {
        let warnings = result.warnings.iter().cloned();
        contents.add(Section::new(
            "Warnings",
            warnings.map(Part::Paragraph).collect(),
        ));
    }
    Ok(contents)
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

fn yields(result: &StabilityResult) -> Part {
    let columns = vec![
        "pH",
        "salt (M)",
        "bodies (M)",
        "yield",
        "±",
        "free bodies",
        "half yield at (M)",
    ];
    let mut rows = Vec::new();
    for row in &result.conditions {
        for mixture in &row.mixtures {
            rows.push(vec![
                significant_or_dash(row.ph, 3),
                significant(row.salt_molar, 3),
                significant(mixture.concentration_molar, 3),
                format!("{:.3}", mixture.whole),
                format!("{:.3}", mixture.whole_error),
                format!("{:.3}", result.free_share(&mixture.shares)),
                significant_or_dash(row.half_concentration_molar, 2),
            ]);
        }
    }
    Part::Table { columns, rows }
}

/// Parts at the first condition.
fn parts_of(result: &StabilityResult) -> Part {
    let columns = vec![
        "part",
        "bodies",
        "symmetry",
        "free energy (kT)",
        "±",
        "mean energy (kT)",
        "share",
    ];
    let mut rows = Vec::new();
    if let Some(first) = result.conditions.first() {
        for (number, (part, found)) in result.parts.iter().zip(&first.parts).enumerate() {
            rows.push(vec![
                part.name.clone(),
                listed(&part.bodies),
                part.symmetry_number.to_string(),
                shown(found.free_energy_kt, |kt| format!("{kt:.1}")),
                shown(found.free_energy_error_kt, |kt| format!("{kt:.1}")),
                shown(found.mean_energy_kt, |kt| format!("{kt:.1}")),
                format!("{:.3}", first.mixtures[0].shares[number]),
            ]);
        }
    }
    Part::Table { columns, rows }
}
