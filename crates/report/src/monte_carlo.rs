//! The page of a sweep over salt, or of a single simulation.

use super::html::{definitions, millimolar, paragraph, significant, significant_or_dash, table};
use super::page::{Page, Section};
use super::scenes::{Collected, collect};
use super::verdict::Verdict;
use super::{companions, data, figures, mesh_view, provenance, residues, traces};
use anyhow::Result;
use protomer::stability::run::replica_directory;
use protomer::stability::run::{EnergyMode, RunSettings, Start, Starts};
use protomer_results::Record;
use protomer_results::keys::read_json_if_present;
use serde_json::Value;
use std::path::Path;

/// The page of a directory with these settings.
///
/// # Errors
/// If a file is damaged, or `assembly` is not what the results were made from.
pub fn page(directory: &Path, settings: &RunSettings, assembly: Option<&Path>) -> Result<Page> {
    let record = Record::read(directory)?;
    let result: Option<Value> = read_json_if_present(&directory.join("sweep.json"))?;
    let periodic_box = result
        .as_ref()
        .and_then(|result| serde_json::from_value(result["box_angstrom"].clone()).ok());
    let mut collected = collect(directory, settings, record.as_ref(), periodic_box, assembly)?;
    let (held, not_shown) = residues::collect(directory, record.as_ref());
    collected.notes.extend(not_shown);
    if let (Some(held), Some(assembly), Some(shown)) =
        (&held, &collected.assembly, &mut collected.shown)
    {
        held.colour(assembly, shown);
    }
    let simulations = simulations(directory, settings)?;
    let mut problems: Vec<String> = provenance::unfinished(record.as_ref())
        .into_iter()
        .collect();
    problems.extend(
        simulations
            .iter()
            .filter_map(|simulation| simulation.problem(settings)),
    );
    problems.extend(collected.notes.iter().cloned());
    let mut sections = vec![results(directory, settings, result.as_ref())?];
    sections.extend(
        collected
            .shown
            .as_ref()
            .map(|shown| mesh_view::section(shown, &bodies_table(&collected))),
    );
    if let Some(held) = &held {
        sections.push(held.section()?);
    }
    sections.extend(companions::sections(directory)?);
    sections.push(conditions(settings, result.as_ref(), &collected)?);
    sections.push(simulations_section(&simulations, settings));
    let seed = vec![("seed", settings.seed.to_string())];
    sections.push(provenance::section(
        directory,
        "run.toml",
        record.as_ref(),
        seed,
    )?);
    let single = settings.simulations() == 1;
    Ok(Page {
        title: format!(
            "{}: {}",
            if single { "Simulation" } else { "Salt sweep" },
            provenance::name(directory)
        ),
        subtitle: subtitle(settings),
        verdict: Some(verdict(result.as_ref())),
        problems,
        sections,
    })
}

/// Verdict of the sweep on its equilibrium.
fn verdict(result: Option<&Value>) -> Verdict {
    let Some(result) = result else {
        return Verdict::equilibrated(None, "there is no result yet");
    };
    let reason = result["equilibration"].as_str();
    let reason = reason.unwrap_or("an earlier version, which did not compare starts, ran this");
    Verdict::equilibrated(result["equilibrated"].as_bool(), reason)
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

fn results(directory: &Path, settings: &RunSettings, result: Option<&Value>) -> Result<Section> {
    let table = data::of_file(directory, "sweep.csv")?;
    let mut html = match result {
        None => paragraph(
            "There is no result yet: the table and the curve are written when all simulations are done.",
        ),
        // A curve through one point is useless.
        Some(result) if settings.salt_molar.len() == 1 => averages(result, settings) + &table,
        Some(_) => figures::of_file(directory, "sweep.svg", "Stability against salt", &table)?,
    };
    html += &paragraph(&format!("The model: {}.", settings.what_attracts()));
    if let Some((figure, rows)) = traces::traces(directory, settings)? {
        html += &figures::drawn(&figure, &data::data("traces.csv", &rows.to_csv()?)?)?;
    }
    Ok(Section::new("Results", html))
}

/// The results at a single salt concentration, those of each start apart.
fn averages(result: &Value, settings: &RunSettings) -> String {
    let replicas: Vec<(u32, &Value)> = (0..)
        .zip(result["replicas"][0].as_array().into_iter().flatten())
        .collect();
    let groups: Vec<(&str, Vec<&Value>)> = match settings.starts {
        Starts::Both => [
            ("from the assembly", Start::Assembly),
            ("from a fluid", Start::Fluid),
        ]
        .map(|(name, start)| {
            let ours = replicas
                .iter()
                .filter(|(number, _)| settings.starts.of_replica(*number) == start);
            (name, ours.map(|(_, replica)| *replica).collect())
        })
        .into(),
        Starts::Assembly | Starts::Fluid => {
            let all = replicas.iter().map(|(_, replica)| *replica);
            vec![("average", all.collect())]
        }
    };
    let mut head = vec![String::new()];
    head.extend(groups.iter().map(|(name, _)| (*name).to_owned()));
    let mut rows = Vec::new();
    for (label, key) in AVERAGES {
        let mut row = vec![label.to_owned()];
        row.extend(groups.iter().map(|(_, replicas)| average(replicas, key)));
        rows.push(row);
    }
    table(&head, &rows)
}

/// Names of the averaged quantities, with their keys in the result of a replica.
const AVERAGES: [(&str, &str); 8] = [
    ("radius of gyration (Å)", "r_g_angstrom"),
    ("native contacts left", "native_contacts"),
    ("pairs of bodies in contact", "contacts"),
    ("bodies that touch another", "bound_fraction"),
    ("bodies in the largest cluster", "largest_cluster"),
    ("energy (kT)", "energy_kT"),
    ("accepted translations", "translation_acceptance"),
    ("accepted rotations", "rotation_acceptance"),
];

/// The mean over replicas with its standard error, from the errors of the replicas.
fn average(replicas: &[&Value], key: &str) -> String {
    let count = replicas.len() as f64;
    let (mut sum, mut squares) = (0.0, 0.0);
    for replica in replicas {
        let value = &replica[key];
        let Some(mean) = value["mean"].as_f64().or(value.as_f64()) else {
            return significant_or_dash(None, 0);
        };
        sum += mean;
        squares += value["standard_error"]
            .as_f64()
            .map_or(f64::NAN, |error| error * error);
    }
    let mean = significant(sum / count, 5);
    match squares.sqrt() / count {
        error if error.is_finite() => format!("{mean} ± {}", significant(error, 2)),
        _ => mean,
    }
}

fn bodies_table(collected: &Collected) -> String {
    let Some(assembly) = &collected.assembly else {
        return String::new();
    };
    let head = [
        "body",
        "copies",
        "net charge (e)",
        "charges",
        "triangles",
        "volume (Å³)",
        "made from",
    ]
    .map(str::to_owned);
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
    table(&head, &rows)
}

fn conditions(
    settings: &RunSettings,
    result: Option<&Value>,
    collected: &Collected,
) -> Result<Section> {
    let mut rows = vec![("periodic box (Å)", periodic_box(result, collected))];
    let concentration = result.and_then(|result| result["concentration_M"].as_f64());
    if let Some(concentration) = concentration
        && concentration > 0.0
    {
        rows.push((
            "concentration of bodies",
            format!("{} mM", significant(1e3 * concentration, 4)),
        ));
    }
    rows.push((
        "temperature",
        format!("{} K", settings.medium.temperature_kelvin),
    ));
    rows.push((
        "contact",
        format!("surfaces closer than {} Å", settings.contact_gap_angstrom),
    ));
    rows.push((
        "cluster moves per sweep",
        settings.cluster_moves_per_sweep.to_string(),
    ));
    if settings.binding_moves_per_sweep > 0 {
        rows.push((
            "moves per sweep that form and dissolve contacts",
            settings.binding_moves_per_sweep.to_string(),
        ));
    }
    let head = [
        "salt (mM)",
        "relative permittivity",
        "Bjerrum length (Å)",
        "Debye length (Å)",
        "cut-off (Å)",
    ];
    let mut lines = Vec::new();
    for salt in &settings.salt_molar {
        let interaction = settings.medium.interaction(Some(*salt))?;
        let lengths = [
            interaction.electrolyte.relative_permittivity(),
            interaction.electrolyte.bjerrum_length_angstrom(),
            interaction.electrolyte.debye_length_angstrom(),
            interaction.cutoff_angstrom,
        ];
        let mut line = vec![millimolar(*salt)];
        line.extend(lengths.map(|length| significant(length, 5)));
        lines.push(line);
    }
    Ok(Section::new(
        "Conditions",
        definitions(&rows) + &table(&head.map(str::to_owned), &lines),
    ))
}

/// The edges of the box in words.
fn periodic_box(result: Option<&Value>, collected: &Collected) -> String {
    let mut lengths = Vec::new();
    match (&collected.assembly, result) {
        (Some(assembly), _) => {
            for length in assembly.box_angstrom().into_iter().flatten() {
                lengths.push(length.to_string());
            }
        }
        (None, Some(result)) => {
            for length in result["box_angstrom"].as_array().into_iter().flatten() {
                lengths.push(length.to_string());
            }
        }
        (None, None) => return "not known until all simulations are done".into(),
    }
    match lengths.as_slice() {
        [] => "none".into(),
        lengths => lengths.join(" × "),
    }
}

/// One simulation, from its record.
struct Simulation {
    salt_molar: f64,
    replica: u32,
    record: Option<Record>,
}

fn simulations(directory: &Path, settings: &RunSettings) -> Result<Vec<Simulation>> {
    let mut simulations = Vec::new();
    for salt_molar in settings.salt_molar.iter().copied() {
        for replica in 0..settings.replicas {
            let record = Record::read(&replica_directory(directory, salt_molar, replica))?;
            simulations.push(Simulation {
                salt_molar,
                replica,
                record,
            });
        }
    }
    Ok(simulations)
}

impl Simulation {
    fn sweeps_done(&self) -> u64 {
        match &self.record {
            Some(record) => record.done.unwrap_or(0),
            None => 0,
        }
    }

    /// An acceptance ratio of the record, or a dash.
    fn accepted(&self, kind: &str) -> String {
        let accepted = self
            .record
            .as_ref()
            .map(|record| &record.details["acceptance"][kind]);
        significant_or_dash(accepted.and_then(Value::as_f64), 3)
    }

    fn problem(&self, settings: &RunSettings) -> Option<String> {
        let (done, total) = (self.sweeps_done(), settings.total_sweeps());
        let progress = format!(" after {done} of {total} sweeps");
        let problem = match provenance::problem_of_part(self.record.as_ref(), &progress) {
            Some(problem) => problem,
            // Finished, but extended since.
            None if done < total => format!("not finished{progress}"),
            None => return None,
        };
        Some(format!(
            "{} mM, replica {}: {problem}",
            millimolar(self.salt_molar),
            self.replica
        ))
    }
}

fn simulations_section(simulations: &[Simulation], settings: &RunSettings) -> Section {
    let head = [
        "salt (mM)",
        "replica",
        "ended",
        "sweeps",
        "translations accepted",
        "rotations accepted",
    ];
    let mut rows = Vec::new();
    for simulation in simulations {
        rows.push(vec![
            millimolar(simulation.salt_molar),
            simulation.replica.to_string(),
            provenance::ended(simulation.record.as_ref()).to_owned(),
            format!(
                "{} of {}",
                simulation.sweeps_done(),
                settings.total_sweeps()
            ),
            simulation.accepted("translation_acceptance"),
            simulation.accepted("rotation_acceptance"),
        ]);
    }
    Section::new("Simulations", table(&head.map(str::to_owned), &rows))
}
