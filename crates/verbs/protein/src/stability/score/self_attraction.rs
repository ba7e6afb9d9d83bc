//! B22 of each body with copies of itself: whether the parts of a complex attract or repel their own kind.

use super::ScoreSettings;
use super::complex::Pose;
use super::record::number;
use super::settings::salt_in_heading;
use crate::bodies::body_file;
use crate::stability::model::Model;
use crate::stability::pair::{Energies, PairBodies, PairRunSettings, run_pair};
use anyhow::{Context, Result};
use protomer_results::{End, Execution};
use serde_json::Value;
use std::path::Path;

/// Wanted standard error of B₂, relative to the larger of |B₂| and its hard part: enough for a sign.
const RELATIVE_ERROR: f64 = 0.2;
/// Most directions of a body at one salt.
const MOST_DIRECTIONS: u64 = 4096;
/// A sign is certain beyond this many standard errors.
const CERTAIN: f64 = 2.0;

/// B22 and its sign for both bodies at each salt; the pairs are kept in the directory of the complex.
///
/// # Errors
/// As [`run_pair`].
pub(super) fn columns(
    pose: &Pose,
    settings: &ScoreSettings,
    directory: &Path,
    execution: &Execution,
) -> Result<End<Vec<(String, Value)>>> {
    let run = run_settings(settings);
    let mut columns = Vec::new();
    std::fs::create_dir_all(directory)
        .with_context(|| format!("cannot create the folder {}", directory.display()))?;
    for (role, body) in ["receptor", "ligand"].iter().zip(&pose.partners.bodies) {
        let file = directory.join(format!("{role}.body"));
        body_file::write(&file, body)?;
        let bodies = PairBodies::read(&file, None, &run)?;
        let place = directory.join(format!("{role}_pair"));
        let End::Finished(found) = run_pair(&bodies, &run, &place, execution)? else {
            return Ok(End::Stopped);
        };
        for condition in &found.conditions {
            let salt = salt_in_heading(condition.salt_molar.unwrap_or(0.0));
            let value = condition.b22_mol_ml_per_g2.unwrap_or(f64::NAN);
            let error = condition.b22_error_mol_ml_per_g2.unwrap_or(f64::NAN);
            columns.push(number(format!("{role}_b22_mol_ml_per_g2_{salt}"), value));
            columns.push(number(
                format!("{role}_b22_error_mol_ml_per_g2_{salt}"),
                error,
            ));
            columns.push((
                format!("{role}_with_itself_{salt}"),
                Value::from(sign(condition.b2_angstrom3, condition.b2_error_angstrom3)),
            ));
        }
    }
    Ok(End::Finished(columns))
}

/// The model of proteins in solution, whose surfaces meet anywhere; the thesis for scores by the thesis.
fn run_settings(settings: &ScoreSettings) -> PairRunSettings {
    let model = match settings.model {
        Model::Natural1 => Model::Solution1,
        other => other,
    };
    let mut run = PairRunSettings {
        salt_molar: settings.salt_molar.clone(),
        solute: model.solvent_response(),
        contacts: model.contacts(),
        energies: match model.solvent_response() {
            Some(_) => Energies::Response,
            None => Energies::Bare,
        },
        ..PairRunSettings::default()
    };
    run.medium.temperature_kelvin = settings.temperature_kelvin;
    run.sampling.seed = settings.seed;
    run.sampling.relative_error = RELATIVE_ERROR;
    run.sampling.most_directions = MOST_DIRECTIONS;
    run
}

fn sign(b2_angstrom3: f64, error_angstrom3: f64) -> &'static str {
    match b2_angstrom3 {
        value if value > CERTAIN * error_angstrom3 => "repels",
        value if value < -CERTAIN * error_angstrom3 => "attracts",
        _ => "uncertain",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sign_needs_two_standard_errors() {
        assert_eq!(sign(3.0, 1.0), "repels");
        assert_eq!(sign(-3.0, 1.0), "attracts");
        assert_eq!(sign(-1.0, 1.0), "uncertain");
    }

    #[test]
    fn parts_are_judged_by_the_model_for_solutions() {
        let run = run_settings(&ScoreSettings::default());
        assert_eq!(run.contacts, Model::Solution1.contacts());
        assert_eq!(run.energies, Energies::Response);
        assert!(run.check().is_ok());
    }
}
