//! Columns of the model's energy for the pose, by terms.

use super::complex::Pose;
use super::record::number;
use super::settings::salt_in_heading;
use crate::stability::binding::BindingSettings;
use crate::stability::binding::fast::FastInteraction;
use anyhow::Result;
use serde_json::Value;

/// Energies at each salt, and whether the hard bodies overlap.
///
/// # Errors
/// If the bodies cannot be placed, or the response of the solvent cannot be solved.
pub(super) fn columns(pose: &Pose, settings: &BindingSettings) -> Result<Vec<(String, Value)>> {
    let fast = FastInteraction::new(&pose.partners, settings)?;
    let medium = settings.medium();
    let mut columns = vec![("overlap".to_owned(), Value::from(fast.overlaps()?))];
    for salt_molar in &settings.salt_molar {
        let interaction = medium.interaction(Some(*salt_molar))?;
        let energy = fast.in_medium(&interaction)?.energy()?;
        let salt = salt_in_heading(*salt_molar);
        columns.push(number(format!("energy_kt_{salt}"), energy.total_kt()));
        for (term, term_kt) in &energy.terms_kt {
            columns.push(number(format!("{term}_kt_{salt}"), *term_kt));
        }
    }
    Ok(columns)
}
