//! From what a user states (salt, temperature, permittivity, or the lengths themselves) to the
//! Yukawa potential.

use anyhow::{Result, bail};
use protomer_kernel::Conditions;
use serde::{Deserialize, Serialize};

/// The cut-off where none is stated, in Debye lengths: the potential has fallen to e⁻⁵/5 of its
/// strength at one Debye length, and no pair of unit charges beyond it holds more than a few
/// thousandths of a kT.
pub const CUTOFF_IN_DEBYE_LENGTHS: f64 = 5.0;

/// Everything of the medium that stays the same while the salt varies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Medium {
    /// Temperature, K.
    #[serde(rename = "temperature_K")]
    pub temperature_kelvin: f64,
    /// Relative permittivity; that of water at the temperature where none is stated.
    pub relative_permittivity: Option<f64>,
    /// A Bjerrum length that overrides temperature and permittivity, Å.
    pub bjerrum_length_angstrom: Option<f64>,
    /// A Debye length that overrides the salt, Å.
    pub debye_length_angstrom: Option<f64>,
    /// Cut-off, Å; five Debye lengths where none is stated.
    pub cutoff_angstrom: Option<f64>,
}

impl Default for Medium {
    fn default() -> Self {
        Self {
            temperature_kelvin: 298.15,
            relative_permittivity: None,
            bjerrum_length_angstrom: None,
            debye_length_angstrom: None,
            cutoff_angstrom: None,
        }
    }
}

/// The Yukawa potential of one salt concentration, with what it was derived from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interaction {
    /// Temperature, K.
    #[serde(rename = "temperature_K")]
    pub temperature_kelvin: f64,
    /// Salt concentration, mol/L; `None` where the Debye length was given instead.
    #[serde(rename = "salt_M")]
    pub salt_molar: Option<f64>,
    /// Relative permittivity.
    pub relative_permittivity: f64,
    /// Bjerrum length, Å.
    pub bjerrum_length_angstrom: f64,
    /// Debye length, Å.
    pub debye_length_angstrom: f64,
    /// Cut-off, Å.
    pub cutoff_angstrom: f64,
}

impl Medium {
    /// The interaction at a salt concentration (mol/L); the salt may be left out if the Debye
    /// length is stated.
    ///
    /// # Errors
    /// Names the quantity that is missing or makes no sense.
    pub fn interaction(&self, salt_molar: Option<f64>) -> Result<Interaction> {
        let salt_for_length = salt_molar.unwrap_or(0.0);
        // The pH shapes the bodies, not the medium; any value serves here.
        let conditions = match self.relative_permittivity {
            Some(permittivity) => Conditions::with_permittivity(
                self.temperature_kelvin,
                salt_for_length,
                7.0,
                permittivity,
            )?,
            None => Conditions::new(self.temperature_kelvin, salt_for_length, 7.0)?,
        };
        let bjerrum_length_angstrom = self
            .bjerrum_length_angstrom
            .unwrap_or(conditions.bjerrum_length_angstrom());
        let debye_length_angstrom = match (self.debye_length_angstrom, salt_molar) {
            (Some(length), _) => length,
            (None, Some(salt)) => debye_length(bjerrum_length_angstrom, salt),
            (None, None) => bail!(
                "neither the salt nor the Debye length is known; add --salt 100mM or --debye 9.6A"
            ),
        };
        let cutoff_angstrom = match self.cutoff_angstrom {
            Some(cutoff) => cutoff,
            None if debye_length_angstrom.is_finite() => {
                CUTOFF_IN_DEBYE_LENGTHS * debye_length_angstrom
            }
            None => {
                bail!("without salt the interaction has no range; state one, such as --cutoff 100A")
            }
        };
        for (name, value) in [
            ("Bjerrum length", bjerrum_length_angstrom),
            ("cut-off", cutoff_angstrom),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                bail!("the {name} is {value} Å; it must be a finite length of zero or more");
            }
        }
        if debye_length_angstrom.is_nan() || debye_length_angstrom <= 0.0 {
            bail!("the Debye length is {debye_length_angstrom} Å; it must be positive");
        }
        Ok(Interaction {
            temperature_kelvin: self.temperature_kelvin,
            salt_molar: if self.debye_length_angstrom.is_some() {
                None
            } else {
                salt_molar
            },
            relative_permittivity: conditions.relative_permittivity,
            bjerrum_length_angstrom,
            debye_length_angstrom,
            cutoff_angstrom,
        })
    }
}

/// κ² = 8π λ_B N_A c for a 1:1 salt, so that a stated Bjerrum length carries through to the
/// screening.
fn debye_length(bjerrum_length_angstrom: f64, salt_molar: f64) -> f64 {
    let ions = protomer_kernel::units::NUMBER_DENSITY_PER_MOLAR * salt_molar;
    (8.0 * std::f64::consts::PI * bjerrum_length_angstrom * ions)
        .sqrt()
        .recip()
}

impl Interaction {
    /// κ = 1 / Debye length, 1/Å; zero without salt.
    pub fn inverse_debye_length_per_angstrom(&self) -> f64 {
        self.debye_length_angstrom.recip()
    }

    /// One line that says what was used.
    pub fn describe(&self) -> String {
        let salt = self.salt_molar.map_or_else(
            || "stated screening".into(),
            |salt| format!("{:.4} M salt", salt),
        );
        format!(
            "{salt}, {} K, relative permittivity {:.2}, Bjerrum length {:.3} Å, Debye length {:.3} Å, cut-off {:.1} Å",
            self.temperature_kelvin,
            self.relative_permittivity,
            self.bjerrum_length_angstrom,
            self.debye_length_angstrom,
            self.cutoff_angstrom
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stated_lengths_win() {
        let medium = Medium {
            bjerrum_length_angstrom: Some(7.0),
            debye_length_angstrom: Some(9.6),
            cutoff_angstrom: Some(48.0),
            ..Medium::default()
        };
        let interaction = medium.interaction(None).unwrap();
        assert_eq!(
            (
                interaction.bjerrum_length_angstrom,
                interaction.debye_length_angstrom
            ),
            (7.0, 9.6)
        );
        assert_eq!(interaction.cutoff_angstrom, 48.0);
    }

    #[test]
    fn salt_gives_the_debye_length_of_the_kernel() {
        let interaction = Medium::default().interaction(Some(0.1)).unwrap();
        let conditions = Conditions::new(298.15, 0.1, 7.0).unwrap();
        assert!(
            (interaction.debye_length_angstrom - conditions.debye_length_angstrom()).abs() < 1e-12
        );
        assert!(
            (interaction.cutoff_angstrom - 5.0 * interaction.debye_length_angstrom).abs() < 1e-12
        );
    }

    #[test]
    fn what_is_missing_is_named() {
        assert!(
            Medium::default()
                .interaction(None)
                .unwrap_err()
                .to_string()
                .contains("--salt")
        );
        assert!(
            Medium::default()
                .interaction(Some(0.0))
                .unwrap_err()
                .to_string()
                .contains("--cutoff")
        );
        assert!(
            Medium::default()
                .interaction(Some(-0.1))
                .unwrap_err()
                .to_string()
                .contains("salt")
        );
    }
}
