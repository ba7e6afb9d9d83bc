//! The settings of scores, as stored in `run.toml`.

use super::Measure;
use crate::stability::binding::BindingSettings;
use crate::stability::contacts::ContactTerm;
use crate::stability::model::Model;
use anyhow::{Result, bail};
use protomer_body::chemistry::StructureTitration;
use protomer_body::structure::SelectionSettings;
use protomer_common::range;
use protomer_results::Settings;
use serde::{Deserialize, Serialize};

/// Everything that shapes the scores of complexes, apart from the complexes.
///
/// ```
/// use protomer_protein_verbs::stability::score::{Measure, ScoreSettings};
/// let settings = ScoreSettings {
///     columns: vec![Measure::Area, Measure::Slope],
///     ..ScoreSettings::default()
/// };
/// assert!(settings.check().unwrap_err().to_string().contains("two salt concentrations"));
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ScoreSettings {
    /// Number of complexes.
    pub complexes: usize,
    /// Groups of columns.
    pub columns: Vec<Measure>,
    /// Salt concentrations, mol/L.
    #[serde(rename = "salt_M")]
    pub salt_molar: Vec<f64>,
    /// pH at which structure files are charged; the usual one for `None`, and for files with charges of their own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ph: Option<f64>,
    /// Titration of structure files at the first salt; pKa values in water for `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub titration: Option<StructureTitration>,
    /// Total concentration of each partner, mol/L, for the salt of half binding.
    #[serde(
        rename = "concentration_M",
        skip_serializing_if = "is_default_concentration"
    )]
    pub concentration_molar: f64,
    /// Temperature, K.
    #[serde(rename = "temperature_K")]
    pub temperature_kelvin: f64,
    /// Model of the interactions between the bodies.
    pub model: Model,
    /// Attraction between residues.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contacts: Option<ContactTerm>,
    /// Spacing of the fine grid of the Poisson-Boltzmann equation, Å.
    pub spacing_angstrom: f64,
    /// Seed of the random numbers of the integration.
    pub seed: u64,
    /// Selection of the atoms of structure files.
    pub selection: SelectionSettings,
}

impl Default for ScoreSettings {
    fn default() -> Self {
        let model = Model::Natural1;
        Self {
            complexes: 0,
            columns: Measure::CHEAP.to_vec(),
            salt_molar: vec![0.15],
            ph: None,
            titration: model.titration(),
            concentration_molar: Self::CONCENTRATION_MOLAR,
            temperature_kelvin: 298.15,
            model,
            contacts: model.contacts(),
            spacing_angstrom: BindingSettings::SPACING_ANGSTROM,
            seed: 1,
            selection: SelectionSettings::default(),
        }
    }
}

impl Settings for ScoreSettings {
    /// Further complexes and columns are added to those that are done.
    fn essential(&self) -> Self {
        Self {
            complexes: 0,
            columns: Vec::new(),
            ..self.clone()
        }
    }
}

/// Whether the concentration is left out of `run.toml`, as directories of earlier versions do.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde calls it so")]
fn is_default_concentration(concentration_molar: &f64) -> bool {
    *concentration_molar == ScoreSettings::CONCENTRATION_MOLAR
}

impl ScoreSettings {
    /// Default of [`Self::concentration_molar`].
    pub const CONCENTRATION_MOLAR: f64 = 1e-6;

    /// Refuses settings that make no sense.
    ///
    /// # Errors
    /// Names the setting and says what to give instead.
    pub fn check(&self) -> Result<()> {
        if self.columns.is_empty() {
            bail!("no columns are requested; add --columns energy,area");
        }
        if self.salt_molar.is_empty() {
            bail!("no salt concentration is given; add --salt 150mM");
        }
        if let Some(ph) = self.ph {
            range::PH.require("ph", ph)?;
        }
        if self.columns.contains(&Measure::Slope) && !self.has_two_salts() {
            bail!(
                "the column slope needs two salt concentrations; give them with --salt 50mM,500mM"
            );
        }
        if self.columns.contains(&Measure::HalfSalt) && !self.has_two_salts() {
            bail!(
                "the column half-salt needs two salt concentrations; give them with --salt 50mM..1M/4"
            );
        }
        if self.columns.iter().any(|measure| measure.is_solved()) {
            range::FINE_SPACING.require("spacing_angstrom", self.spacing_angstrom)?;
        }
        if let Some(contacts) = &self.contacts {
            contacts.potential(self.temperature_kelvin)?;
        }
        let medium = self.binding().medium();
        for salt_molar in &self.salt_molar {
            medium.interaction(Some(*salt_molar))?;
        }
        Ok(())
    }

    fn has_two_salts(&self) -> bool {
        let salted = || self.salt_molar.iter().filter(|salt| **salt > 0.0);
        salted().any(|salt| Some(salt) != salted().next())
    }

    /// The settings of `binding` for these scores, without files and chains.
    pub(super) fn binding(&self) -> BindingSettings {
        BindingSettings {
            model: self.model,
            contacts: self.contacts,
            selection: self.selection.clone(),
            ph: self.ph.into_iter().collect(),
            titration: self.titration,
            salt_molar: self.salt_molar.clone(),
            temperature_kelvin: self.temperature_kelvin,
            spacing_angstrom: self.spacing_angstrom,
            integrates: self.columns.contains(&Measure::Kd),
            exchanges: self.columns.contains(&Measure::Exchange),
            seed: self.seed,
            ..BindingSettings::default()
        }
    }
}

/// A salt concentration as the end of a heading, such as `150mM`.
///
/// ```text
/// 0.15 -> 150mM      0.094868 -> 94.868mM
/// ```
pub(super) fn salt_in_heading(salt_molar: f64) -> String {
    let millimolar = format!("{:.4}", 1e3 * salt_molar);
    let shortened = millimolar.trim_end_matches('0').trim_end_matches('.');
    format!("{shortened}mM")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn salts_in_headings_can_be_typed() {
        let cases = [
            (0.15, "150mM"),
            (0.094868, "94.868mM"),
            (1.0, "1000mM"),
            (0.0, "0mM"),
        ];
        for (salt_molar, words) in cases {
            assert_eq!(salt_in_heading(salt_molar), words);
        }
    }

    #[test]
    fn further_columns_are_the_same_work() {
        let few = ScoreSettings {
            columns: vec![Measure::Area],
            ..ScoreSettings::default()
        };
        assert_eq!(few.essential(), ScoreSettings::default().essential());
        let other = ScoreSettings {
            salt_molar: vec![0.1],
            ..ScoreSettings::default()
        };
        assert_ne!(other.essential(), ScoreSettings::default().essential());
    }
}
