//! The simulations of a sweep, from their records.

use crate::stability::run::{AcceptedFractions, RunSettings, replica_directory};
use anyhow::Result;
use protomer_common::page::{Part, Section, millimolar, significant_or_dash};
use protomer_results::Record;
use std::path::Path;

/// One simulation, from its record.
#[derive(Debug)]
pub struct Simulation {
    salt_molar: f64,
    replica: u32,
    record: Option<Record>,
}

/// The simulations of a sweep.
///
/// # Errors
/// If a record is damaged.
pub fn read(directory: &Path, settings: &RunSettings) -> Result<Vec<Simulation>> {
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

    /// Acceptance ratios of translations and rotations, or dashes.
    fn accepted(&self) -> [String; 2] {
        let accepted = self.record.as_ref().and_then(AcceptedFractions::recorded);
        [
            accepted.map(|accepted| accepted.translation_acceptance),
            accepted.map(|accepted| accepted.rotation_acceptance),
        ]
        .map(|ratio| significant_or_dash(ratio, 3))
    }

    /// Cause that kept the simulation from its end; `None` if it is finished.
    pub fn problem(&self, settings: &RunSettings) -> Option<String> {
        let (done, total) = (self.sweeps_done(), settings.total_sweeps());
        let progress = format!(" after {done} of {total} sweeps");
        let problem = match Record::problem_of_part(self.record.as_ref(), &progress) {
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

/// A row for each simulation.
pub fn section(simulations: &[Simulation], settings: &RunSettings) -> Section {
    let columns = vec![
        "salt (mM)",
        "replica",
        "ended",
        "sweeps",
        "translations accepted",
        "rotations accepted",
    ];
    let mut rows = Vec::new();
    for simulation in simulations {
        let ended = simulation.record.as_ref().map(|record| record.exit.word());
        let [translations, rotations] = simulation.accepted();
        rows.push(vec![
            millimolar(simulation.salt_molar),
            simulation.replica.to_string(),
            ended.unwrap_or("–").to_owned(),
            format!(
                "{} of {}",
                simulation.sweeps_done(),
                settings.total_sweeps()
            ),
            translations,
            rotations,
        ]);
    }
    Section::new("Simulations", vec![Part::Table { columns, rows }])
}
