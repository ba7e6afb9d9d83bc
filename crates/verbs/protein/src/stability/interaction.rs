//! From what a user states (salt, temperature, permittivity, or the lengths themselves) to the
//! screened Coulomb potential between charges.

use anyhow::{Result, bail};
use protomer_common::range;
use protomer_kernel::Electrolyte;
use protomer_kernel::electrolyte::water_permittivity;
use protomer_kernel::potential::Yukawa;
use serde::{Deserialize, Serialize};

/// Settings of the interaction that stay the same while the salt varies.
///
/// ```
/// use protomer_protein_verbs::stability::interaction::InteractionSettings;
/// let warm = InteractionSettings { temperature_kelvin: 310.15, ..InteractionSettings::default() };
/// let electrolyte = warm.interaction(Some(0.15))?.electrolyte;
/// assert!((electrolyte.relative_permittivity() - 74.15).abs() < 0.01);
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct InteractionSettings {
    /// Temperature, K.
    #[serde(rename = "temperature_K")]
    pub temperature_kelvin: f64,
    /// Relative permittivity; that of water at the temperature where none is stated.
    pub relative_permittivity: Option<f64>,
    /// A Bjerrum length that overrides temperature and permittivity, Å.
    pub bjerrum_length_angstrom: Option<f64>,
    /// A Debye length that overrides the salt, Å.
    pub debye_length_angstrom: Option<f64>,
    /// Cut-off, Å, with energies summed directly; none where `None`.
    pub cutoff_angstrom: Option<f64>,
    /// Reach of the interaction, stated in the settings of every run without a cut-off. Earlier
    /// versions cut by default, and their runs, which do not state it, cannot be continued with
    /// another interaction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub definition: Option<Definition>,
}

/// Reach of the interaction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Definition {
    /// Charges at all distances.
    #[serde(rename = "no cut-off")]
    NoCutOff,
}

/// Parts of two bodies between which the contact gap is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ContactDefinition {
    /// The surfaces. Earlier versions measured from the vertices of one mesh to the other surface,
    /// and their runs, which state no definition, cannot be continued: contacts before and after
    /// would not be the same quantity.
    #[serde(rename = "between surfaces")]
    BetweenSurfaces,
}

impl Default for InteractionSettings {
    fn default() -> Self {
        Self {
            temperature_kelvin: 298.15,
            relative_permittivity: None,
            bjerrum_length_angstrom: None,
            debye_length_angstrom: None,
            cutoff_angstrom: None,
            definition: None,
        }
    }
}

/// The screened Coulomb interaction at one salt concentration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ScreenedCoulomb {
    /// Electrolyte that screens the charges.
    #[serde(flatten)]
    pub electrolyte: Electrolyte,
    /// Cut-off, Å; infinite for none, which JSON has as null.
    #[serde(deserialize_with = "protomer_kernel::null::as_infinity")]
    pub cutoff_angstrom: f64,
}

impl InteractionSettings {
    /// The interaction at a salt concentration (mol/L); the salt may be left out if the Debye
    /// length is stated.
    ///
    /// ```
    /// use protomer_protein_verbs::stability::interaction::InteractionSettings;
    /// let settings = InteractionSettings::default();
    /// assert!(settings.interaction(None).is_err(), "the salt is missing");
    /// let stated = InteractionSettings { debye_length_angstrom: Some(9.6), ..settings };
    /// assert_eq!(stated.interaction(None)?.electrolyte.debye_length_angstrom(), 9.6);
    /// # Ok::<(), anyhow::Error>(())
    /// ```
    ///
    /// # Errors
    /// Names the quantity that is missing or out of range.
    pub fn interaction(&self, salt_molar: Option<f64>) -> Result<ScreenedCoulomb> {
        self.check(salt_molar)?;
        Ok(ScreenedCoulomb {
            electrolyte: self.electrolyte(salt_molar)?,
            cutoff_angstrom: self.cutoff_angstrom.unwrap_or(f64::INFINITY),
        })
    }

    /// Refuses numbers outside their ranges, by the keys of a configuration.
    fn check(&self, salt_molar: Option<f64>) -> Result<()> {
        range::TEMPERATURE.require("temperature_K", self.temperature_kelvin)?;
        for (key, range, value) in [
            ("salt_M", range::SALT, salt_molar),
            (
                "relative_permittivity",
                range::PERMITTIVITY,
                self.relative_permittivity,
            ),
            (
                "bjerrum_length_angstrom",
                range::BJERRUM_LENGTH,
                self.bjerrum_length_angstrom,
            ),
            (
                "debye_length_angstrom",
                range::DEBYE_LENGTH,
                self.debye_length_angstrom,
            ),
            ("cutoff_angstrom", range::CUT_OFF, self.cutoff_angstrom),
        ] {
            if let Some(value) = value {
                range.require(key, value)?;
            }
        }
        Ok(())
    }

    fn electrolyte(&self, salt_molar: Option<f64>) -> Result<Electrolyte> {
        let permittivity = match self.relative_permittivity {
            Some(permittivity) => permittivity,
            None => water_permittivity(self.temperature_kelvin)?,
        };
        // Without a salt the Debye length must be stated, and replaces this zero.
        let salt = salt_molar.unwrap_or(0.0);
        let mut electrolyte = Electrolyte::new(self.temperature_kelvin, salt, permittivity)?;
        if let Some(length) = self.bjerrum_length_angstrom {
            electrolyte = electrolyte.with_bjerrum_length(length)?;
        }
        match (self.debye_length_angstrom, salt_molar) {
            (Some(length), _) => Ok(electrolyte.with_debye_length(length)?),
            (None, Some(_)) => Ok(electrolyte),
            (None, None) => bail!(
                "neither the salt nor the Debye length is known; add --salt 100mM or --debye 9.6A"
            ),
        }
    }
}

impl ScreenedCoulomb {
    /// The pair potential.
    ///
    /// ```
    /// use protomer_protein_verbs::stability::interaction::InteractionSettings;
    /// let settings = InteractionSettings { cutoff_angstrom: Some(48.0), ..InteractionSettings::default() };
    /// let yukawa = settings.interaction(Some(0.1))?.yukawa()?;
    /// assert_eq!((yukawa.cutoff_angstrom, yukawa.energy_kt(48.0)), (48.0, 0.0));
    /// # Ok::<(), anyhow::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a length is out of range.
    pub fn yukawa(&self) -> Result<Yukawa> {
        Ok(Yukawa::in_electrolyte(
            &self.electrolyte,
            self.cutoff_angstrom,
        )?)
    }

    /// Description of the interaction in one line.
    pub fn describe(&self) -> String {
        let electrolyte = &self.electrolyte;
        let salt = match electrolyte.salt_molar() {
            Some(salt) => format!("{salt:.4} M salt"),
            None => "stated screening".to_owned(),
        };
        format!(
            "{salt}, {} K, relative permittivity {:.2}, Bjerrum length {:.3} Å, \
             Debye length {:.3} Å, {}",
            electrolyte.temperature_kelvin(),
            electrolyte.relative_permittivity(),
            electrolyte.bjerrum_length_angstrom(),
            electrolyte.debye_length_angstrom(),
            self.definition()
        )
    }

    /// Cut-off of the interaction, in words.
    ///
    /// ```
    /// use protomer_protein_verbs::stability::interaction::InteractionSettings;
    /// let words = |cutoff_angstrom| {
    ///     let settings = InteractionSettings { cutoff_angstrom, ..InteractionSettings::default() };
    ///     settings.interaction(Some(0.1)).map(|interaction| interaction.definition())
    /// };
    /// assert_eq!(words(None)?, "no cut-off");
    /// assert_eq!(words(Some(48.0))?, "cut at 48 Å, not shifted");
    /// # Ok::<(), anyhow::Error>(())
    /// ```
    pub fn definition(&self) -> String {
        match self.cutoff_angstrom.is_finite() {
            true => format!("cut at {} Å, not shifted", self.cutoff_angstrom),
            false => "no cut-off".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stated_lengths_win() {
        let settings = InteractionSettings {
            bjerrum_length_angstrom: Some(7.0),
            debye_length_angstrom: Some(9.6),
            cutoff_angstrom: Some(48.0),
            ..InteractionSettings::default()
        };
        for salt in [None, Some(0.1)] {
            let ScreenedCoulomb {
                electrolyte,
                cutoff_angstrom,
            } = settings.interaction(salt).unwrap();
            assert_eq!(electrolyte.bjerrum_length_angstrom(), 7.0);
            assert_eq!(electrolyte.debye_length_angstrom(), 9.6);
            assert_eq!(electrolyte.salt_molar(), None);
            assert_eq!(cutoff_angstrom, 48.0);
        }
    }

    #[test]
    fn salt_gives_the_debye_length_of_the_kernel() {
        let interaction = InteractionSettings::default()
            .interaction(Some(0.1))
            .unwrap();
        let electrolyte = Electrolyte::in_water(298.15, 0.1).unwrap();
        assert_eq!(interaction.electrolyte, electrolyte);
        assert_eq!(interaction.cutoff_angstrom, f64::INFINITY);
    }

    #[test]
    fn the_json_form_is_flat() {
        let settings = InteractionSettings {
            relative_permittivity: Some(78.5),
            bjerrum_length_angstrom: Some(7.0),
            debye_length_angstrom: Some(9.6),
            cutoff_angstrom: Some(48.0),
            ..InteractionSettings::default()
        };
        let json = serde_json::to_string(&settings.interaction(None).unwrap()).unwrap();
        let expected = "{\"temperature_K\":298.15,\"salt_M\":null,\"relative_permittivity\":78.5,\
                        \"bjerrum_length_angstrom\":7.0,\"debye_length_angstrom\":9.6,\
                        \"cutoff_angstrom\":48.0}";
        assert_eq!(json, expected);
    }

    #[test]
    fn what_is_missing_is_named() {
        for (salt, named) in [(None, "--salt"), (Some(-0.1), "salt")] {
            let error = InteractionSettings::default()
                .interaction(salt)
                .unwrap_err();
            assert!(error.to_string().contains(named), "{error}");
        }
    }
}
