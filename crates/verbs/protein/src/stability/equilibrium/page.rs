//! The page of an equilibrium.

use super::answer::shown;
use super::assembly;
use super::result::{StabilityResult, listed};
use crate::assemblies::assembly_file::Assembly;
use crate::stability::run::RunSettings;
use crate::stability::sweep::page::bodies::{MOST_VERTICES, coloured};
use anyhow::Result;
use protomer_common::page::scene::Scene;
use protomer_common::page::{Contents, Part, Section, Verdict, significant, significant_or_dash};
use protomer_results::{Record, keys};
use std::path::Path;

/// Most bodies of an assembly that is shown.
const MOST_BODIES: usize = 256;

/// Contents of the page of a directory.
///
/// # Errors
/// If a file is damaged.
pub fn contents(directory: &Path, record: Option<&Record>) -> Result<Contents> {
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
    match record.map(|record| assembly::of_record(directory, record)) {
        Some(Ok(found)) => contents.add(bodies(&found, &result)),
        Some(Err(error)) => contents
            .problems
            .push(format!("The bodies are not shown: {error:#}")),
        None => {}
    }
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

/// The assembly, coloured by potential and hydropathy.
fn bodies(found: &Assembly, result: &StabilityResult) -> Section {
    let run = RunSettings {
        salt_molar: result.settings.salt_molar.clone(),
        ..result.settings.run()
    };
    let mut shown = coloured(&found.bodies, &run);
    let vertices: usize = shown
        .meshes
        .iter()
        .map(|shown| shown.mesh.vertices.len())
        .sum();
    if vertices > MOST_VERTICES || found.len() > MOST_BODIES {
        let note = "The assembly is larger than a page can show; export draws it elsewhere.";
        return Section::new("Assembly", vec![Part::Paragraph(note.into())]);
    }
    shown.scenes.push(Scene {
        name: "the assembly".into(),
        bodies: found
            .kinds
            .iter()
            .copied()
            .zip(found.poses.iter().copied())
            .collect(),
        colouring: None,
        film: None,
    });
    Section::new("Assembly", vec![Part::Scenes(shown)])
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
