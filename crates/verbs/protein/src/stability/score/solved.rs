//! Columns of the Poisson-Boltzmann equation and of the integrated K_D: those of `binding`.

use super::Measure;
use super::complex::Pose;
use super::geometry::PROBE_ANGSTROM;
use super::half_salt::{self, Dissociation};
use super::record::{ScoreRecord, number};
use super::settings::salt_in_heading;
use crate::stability::affinity::ERROR_KCAL_PER_MOL;
use crate::stability::binding::{Binding, BindingCondition, BindingSettings, binding};
use crate::stability::residues::ResidueName;
use anyhow::Result;
use protomer_body::Body;
use protomer_body::interface::{Partner, exposed_sites};
use protomer_kernel::units::{KILOJOULES_PER_KILOCALORIE, kilojoule_per_mol_per_kt};
use protomer_results::{End, Execution};
use serde_json::Value;

/// Adds the groups to a record.
///
/// # Errors
/// As [`binding`].
pub(super) fn measure(
    measures: &[Measure],
    (settings, concentration_molar): (&BindingSettings, f64),
    record: &mut ScoreRecord,
    execution: &Execution,
) -> Result<End<()>> {
    let settings = BindingSettings {
        integrates: measures.contains(&Measure::Kd),
        exchanges: measures.contains(&Measure::Exchange),
        ..settings.clone()
    };
    let End::Finished(found) = binding(&settings, execution)? else {
        return Ok(End::Stopped);
    };
    record.warn(found.warnings.iter().cloned());
    for measure in measures {
        let values = match measure {
            Measure::Slope => slope(&found),
            Measure::Kd => constants(&found, settings.temperature_kelvin),
            Measure::HalfSalt => {
                half_binding(&found, settings.temperature_kelvin, concentration_molar)
            }
            _ => exchange(&found, &Pose::read(&settings)?)?,
        };
        record.add(*measure, values);
    }
    Ok(End::Finished(()))
}

fn slope(found: &Binding) -> Vec<(String, Value)> {
    vec![
        number(
            "d_ln_k_d_ln_salt",
            found.d_ln_k_d_ln_salt.unwrap_or(f64::NAN),
        ),
        number(
            "d_ln_k_d_ln_salt_error",
            found.d_ln_k_d_ln_salt_error.unwrap_or(f64::NAN),
        ),
    ]
}

/// K_D = exp(ΔG° / RT) of the calibrated energy, and the integrated constant, at each salt.
fn constants(found: &Binding, temperature_kelvin: f64) -> Vec<(String, Value)> {
    let kcal_per_mol = kilojoule_per_mol_per_kt(temperature_kelvin) / KILOJOULES_PER_KILOCALORIE;
    let of_salt = |condition: &BindingCondition| {
        let salt = salt_in_heading(condition.salt_molar);
        let delta_g = condition.delta_g_kcal_per_mol;
        let optional = |value: Option<f64>| value.unwrap_or(f64::NAN);
        [
            number(format!("delta_g_kcal_per_mol_{salt}"), delta_g),
            number(format!("kd_molar_{salt}"), (delta_g / kcal_per_mol).exp()),
            number(
                format!("integrated_log10_kd_molar_{salt}"),
                optional(condition.log10_kd_molar),
            ),
            number(
                format!("integrated_log10_kd_error_{salt}"),
                optional(condition.log10_kd_error),
            ),
        ]
    };
    found.conditions.iter().flat_map(of_salt).collect()
}

/// The salt of half binding, from the calibrated energy at each salt.
fn half_binding(
    found: &Binding,
    temperature_kelvin: f64,
    concentration_molar: f64,
) -> Vec<(String, Value)> {
    let kcal_per_mol = kilojoule_per_mol_per_kt(temperature_kelvin) / KILOJOULES_PER_KILOCALORIE;
    let constants: Vec<Dissociation> = found
        .conditions
        .iter()
        .map(|condition| Dissociation {
            salt_molar: condition.salt_molar,
            ln_kd: condition.delta_g_kcal_per_mol / kcal_per_mol,
        })
        .collect();
    half_salt::columns(
        &constants,
        ERROR_KCAL_PER_MOL / kcal_per_mol,
        concentration_molar,
    )
}

/// The exchange that strengthens the complex most, of residues that still touch the solvent.
///
/// # Errors
/// If the surface of the complex cannot be made.
fn exchange(found: &Binding, pose: &Pose) -> Result<Vec<(String, Value)>> {
    let bodies = pose.partners.bodies.each_ref().map(AsRef::as_ref);
    let exposed = exposed_residues(bodies)?;
    let rows = found.exchanges.iter().flatten();
    let mut touching = rows.filter(|row| exposed.contains(&row.name));
    // The rows are sorted, the one that strengthens most first.
    let best = touching.next().filter(|row| row.energy_change_kt < 0.0);
    Ok(vec![
        (
            "best_exchange".to_owned(),
            best.map_or(Value::Null, |row| Value::from(row.mutation.clone())),
        ),
        number(
            "best_exchange_kt",
            best.map_or(f64::NAN, |row| row.energy_change_kt),
        ),
    ])
}

/// Residues whose side chain touches the solvent in the complex.
fn exposed_residues(bodies: [&Body; 2]) -> Result<Vec<ResidueName>> {
    let exposed = exposed_sites(bodies.map(Partner::in_file), PROBE_ANGSTROM)?;
    let mut names = Vec::new();
    for (body, sites) in bodies.iter().zip(&exposed) {
        for site in sites {
            let site = &body.sites[*site];
            let is_side_chain = !matches!(&*site.atom_name, "N" | "CA" | "C" | "O" | "OXT");
            if let (true, Some(residue)) = (is_side_chain, site.residue) {
                names.push(ResidueName::from_body(body, residue as usize));
            }
        }
    }
    Ok(names)
}
