//! The page of a sweep over salt, or of a single simulation.
//!
//! | module | one idea |
//! |---|---|
//! | `averages` | the averages at a single salt concentration |
//! | `traces` | the logs as a figure |
//! | `bodies` | the bodies that are shown, and their positions |
//! | `conditions` | box, temperature, and the lengths of each salt |
//! | `simulations` | how each simulation ended |

mod averages;
pub(crate) mod bodies;
mod conditions;
mod simulations;
mod traces;

use super::result::SweepResult;
use crate::assemblies::assembly_file::Assembly;
use crate::stability::residues::page as residues;
use crate::stability::reweighting::page as reweighting;
use crate::stability::run::{EnergyMode, RunSettings};
use anyhow::Result;
use averages::averages;
use bodies::collect;
use protomer_common::page::{Contents, Part, Section, Verdict, millimolar, significant};
use protomer_kernel::setting::Choices;
use protomer_results::Record;
use protomer_results::keys::read_toml;
use std::path::Path;
use traces::traces;

/// Contents of the page of a directory; `assembly` replaces the file named in the record.
///
/// # Errors
/// If a file is damaged, or `assembly` is not what the results were made from.
pub fn contents(
    directory: &Path,
    record: Option<&Record>,
    assembly: Option<&Path>,
) -> Result<Contents> {
    let settings: RunSettings = read_toml(&directory.join("run.toml"))?;
    let result = SweepResult::read(directory)?;
    let result = result.as_ref();
    let mut contents = Contents::new(match settings.simulations() {
        1 => "Simulation",
        _ => "Salt sweep",
    });
    contents.subtitle = subtitle(&settings);
    contents.verdict = Some(verdict(result));
    contents.origin.more = vec![("seed", settings.seed.to_string())];
    let simulations = simulations::read(directory, &settings)?;
    let problems = simulations.iter();
    contents.problems = problems.filter_map(|one| one.problem(&settings)).collect();
    contents.add(results(directory, &settings, result)?);
    let assembly = add_bodies(
        &mut contents,
        directory,
        &settings,
        record,
        result,
        assembly,
    )?;
    contents.sections.extend(reweighting::section(directory)?);
    contents
        .sections
        .extend(crate::scattering::page::section(directory)?);
    contents.add(conditions::section(&settings, result, assembly.as_ref())?);
    contents.add(simulations::section(&simulations, &settings));
    Ok(contents)
}

/// Adds the bodies, coloured by what holds them, and the section that says what does. Returns the
/// assembly, if it was found.
fn add_bodies(
    contents: &mut Contents,
    directory: &Path,
    settings: &RunSettings,
    record: Option<&Record>,
    result: Option<&SweepResult>,
    assembly: Option<&Path>,
) -> Result<Option<Assembly>> {
    let periodic_box = result.and_then(|result| result.box_angstrom);
    let mut collected = collect(directory, settings, record, periodic_box, assembly)?;
    let (held, not_shown) = residues::collect(directory, record);
    contents.problems.append(&mut collected.notes);
    contents.problems.extend(not_shown);
    if let (Some(held), Some(assembly), Some(shown)) =
        (&held, &collected.assembly, &mut collected.shown)
    {
        held.colour(assembly, shown);
    }
    if let Some(shown) = collected.shown {
        let mut parts = vec![Part::Scenes(shown)];
        parts.extend(collected.assembly.as_ref().map(bodies_table));
        contents.add(Section::new("Bodies", parts));
    }
    contents.sections.extend(held.map(|held| held.section()));
    Ok(collected.assembly)
}

/// Verdict of the sweep on its equilibrium.
fn verdict(result: Option<&SweepResult>) -> Verdict {
    match result.map(|result| &result.stability) {
        None => Verdict::equilibrated(None, "there is no result yet"),
        Some(stability) => Verdict::equilibrated(stability.equilibrated, &stability.equilibration),
    }
}

fn subtitle(settings: &RunSettings) -> String {
    let salts: Vec<String> = settings
        .salt_molar
        .iter()
        .map(|salt| millimolar(*salt))
        .collect();
    format!(
        "Hard bodies with screened {}charges at {} mM salt; {} × {} sweeps after {} of equilibration; energies: {}",
        match settings.effective_charges {
            Some(_) => "effective ",
            None => "",
        },
        salts.join(", "),
        settings.replicas,
        settings.sweeps,
        settings.equilibration_sweeps,
        settings.energy.map_or("not chosen", EnergyMode::name)
    )
}

fn results(
    directory: &Path,
    settings: &RunSettings,
    result: Option<&SweepResult>,
) -> Result<Section> {
    let mut parts = match result {
        None => vec![Part::Paragraph(
            "There is no result yet: the table and the curve are written when all simulations are done."
                .into(),
        )],
        // A curve through one point is useless.
        Some(result) if settings.salt_molar.len() == 1 => {
            vec![averages(result, settings), Part::file("sweep.csv")]
        }
        Some(_) => vec![Part::picture(
            "sweep.svg",
            "Stability against salt",
            Some("sweep.csv"),
        )],
    };
    parts.push(Part::Paragraph(format!(
        "The model: {}.",
        settings.what_attracts()
    )));
    parts.extend(traces(directory, settings)?);
    Ok(Section::new("Results", parts))
}

fn bodies_table(assembly: &Assembly) -> Part {
    let columns = vec![
        "body",
        "copies",
        "net charge (e)",
        "charges",
        "triangles",
        "volume (Å³)",
        "made from",
    ];
    let mut rows = Vec::new();
    for (kind, body) in assembly.bodies.iter().enumerate() {
        let copies = assembly.kinds.iter().filter(|other| **other == kind);
        rows.push(vec![
            body.name.clone(),
            copies.count().to_string(),
            significant(body.net_charge_e(), 4),
            body.sites.len().to_string(),
            body.mesh.triangles.len().to_string(),
            significant(body.mass_properties.volume_angstrom3, 6),
            body.provenance.source.clone(),
        ]);
    }
    Part::Table { columns, rows }
}
