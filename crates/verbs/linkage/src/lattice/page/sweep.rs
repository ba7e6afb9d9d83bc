//! The page of a sweep: its figures, the first run that can be played, and how the runs ended.

use super::{animation, conditions, with_settings};
use crate::lattice::settings::LatticeSettings;
use crate::lattice::sweep::{Task, tasks};
use anyhow::Result;
use protomer_common::page::{Contents, Part, Section, significant};
use protomer_results::Record;
use protomer_results::keys::read_toml;
use std::path::Path;

/// The figures of a sweep: file, title.
const SWEEP_FIGURES: [(&str, &str); 12] = [
    ("poisson.svg", "Poisson's ratio against rod length"),
    ("synchronisation.svg", "Synchronisation against rod length"),
    (
        "checkerboard.svg",
        "The checkerboard mode against rod length",
    ),
    ("spread.svg", "Spread of the angles against κ"),
    ("phase_differences.svg", "Phase differences"),
    ("strains.svg", "Strain against strain"),
    ("crossings.svg", "Passages through the open state"),
    (
        "lyapunov.svg",
        "Maximal Lyapunov exponent against rod length",
    ),
    ("orbits.svg", "Phase space of the checkerboard mode"),
    (
        "correlation.svg",
        "Correlation of the sides to which squares close",
    ),
    ("domains.svg", "Domains against rod length"),
    ("indices.svg", "Synchronisation indices between squares"),
];

/// Contents of the page of a directory.
///
/// # Errors
/// If a file is damaged.
pub fn contents(directory: &Path, _: Option<&Record>) -> Result<Contents> {
    let settings: LatticeSettings = read_toml(&directory.join("run.toml"))?;
    let tasks = tasks(&settings, directory)?;
    let mut contents = with_settings("Sweep of lattices", &settings);
    contents.subtitle += &format!("; {} runs", tasks.len());
    contents.add(results(directory));
    let mut rows = Vec::new();
    for task in &tasks {
        let record = Record::read(&task.directory)?;
        rows.push(row(task, record.as_ref()));
        contents.problems.extend(problem(task, record.as_ref()));
    }
    let mut runs = tasks.iter();
    match runs.find_map(|task| animation(&task.directory, &task.settings).ok()) {
        Some(section) => contents.add(section),
        None => contents.problems.push(
            "No run can be played: none has frames; run with --trajectory-every 50 or so".into(),
        ),
    }
    contents.add(conditions(&settings));
    let columns = vec!["r0", "κ", "seed", "ended"];
    contents.add(Section::new("Runs", vec![Part::Table { columns, rows }]));
    Ok(contents)
}

fn results(directory: &Path) -> Section {
    let drawn = SWEEP_FIGURES
        .iter()
        .filter(|(file, _)| directory.join(file).is_file());
    let mut parts: Vec<Part> = drawn
        .map(|(file, title)| Part::picture(file, title, None))
        .collect();
    if parts.is_empty() {
        let note = "There are no figures yet: they are drawn when all runs are done.";
        parts.push(Part::Paragraph(note.into()));
    }
    parts.extend(
        [
            "lattice.csv",
            "runs.csv",
            "crossings.csv",
            "correlation.csv",
        ]
        .map(Part::file),
    );
    Section::new("Results", parts)
}

/// Values of the axes of a sweep at a run.
fn axes_of(task: &Task) -> [String; 2] {
    [task.settings.r0, task.settings.kappa].map(|x| significant(x, 6))
}

fn row(task: &Task, record: Option<&Record>) -> Vec<String> {
    let [r0, kappa] = axes_of(task);
    let ended = record.map_or("–", |record| record.exit.word());
    vec![r0, kappa, task.settings.seed.to_string(), ended.to_owned()]
}

fn problem(task: &Task, record: Option<&Record>) -> Option<String> {
    let [r0, kappa] = axes_of(task);
    let steps = record.and_then(|record| record.done);
    let progress = steps.map_or_else(String::new, |steps| format!(" after {steps} steps"));
    let problem = Record::problem_of_part(record, &progress)?;
    Some(format!(
        "r0 = {r0}, κ = {kappa}, seed {}: {problem}",
        task.settings.seed
    ))
}
