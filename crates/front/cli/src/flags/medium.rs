//! The medium's flags, shared by every verb that computes an energy.

use anyhow::Result;
use clap::Args;
use protomer_common::{quantity, range};
use protomer_protein_verbs::stability::interaction::{InteractionSettings, ScreenedCoulomb};
use protomer_protein_verbs::stability::run::EnergyMode;

/// Medium between the bodies.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Medium")]
pub struct MediumArgs {
    /// Temperature, K [default: 298.15].
    #[arg(long, allow_hyphen_values = true, value_parser = range::TEMPERATURE.read(quantity::temperature_kelvin))]
    pub temperature: Option<f64>,
    /// Relative permittivity; that of water at the temperature if omitted.
    #[arg(long, value_parser = range::PERMITTIVITY.number())]
    pub permittivity: Option<f64>,
    /// Bjerrum length (such as 7.0A), instead of temperature and permittivity.
    #[arg(long, allow_hyphen_values = true, conflicts_with = "permittivity", value_parser = range::BJERRUM_LENGTH.read(quantity::length_angstrom))]
    pub bjerrum: Option<f64>,
    /// Debye length (such as 9.6A), instead of a salt concentration.
    #[arg(long, allow_hyphen_values = true, value_parser = range::DEBYE_LENGTH.read(quantity::length_angstrom))]
    pub debye: Option<f64>,
    /// Cut-off distance, for comparison with calculations that have one; energies are then summed
    /// directly. No cut-off if omitted.
    #[arg(long, allow_hyphen_values = true, value_parser = range::CUT_OFF.read(quantity::length_angstrom))]
    pub cutoff: Option<f64>,
}

impl MediumArgs {
    /// The medium described by the flags.
    pub fn medium(&self) -> InteractionSettings {
        let mut medium = InteractionSettings::default();
        self.override_in(&mut medium);
        medium
    }

    /// Overrides `medium` with the given flags.
    pub fn override_in(&self, medium: &mut InteractionSettings) {
        medium.temperature_kelvin = self.temperature.unwrap_or(medium.temperature_kelvin);
        medium.relative_permittivity = self.permittivity.or(medium.relative_permittivity);
        medium.bjerrum_length_angstrom = self.bjerrum.or(medium.bjerrum_length_angstrom);
        medium.debye_length_angstrom = self.debye.or(medium.debye_length_angstrom);
        medium.cutoff_angstrom = self.cutoff.or(medium.cutoff_angstrom);
    }
}

/// The medium at one salt concentration.
#[derive(Debug, Clone, Args)]
pub struct ConditionArgs {
    /// Concentration of a 1:1 salt, such as 100mM or 0.1M.
    #[arg(long, value_parser = quantity::salt_molar, allow_hyphen_values = true)]
    pub salt: Option<f64>,
    #[command(flatten)]
    pub medium: MediumArgs,
}

impl ConditionArgs {
    /// The interaction described by the flags.
    pub fn interaction(&self) -> Result<ScreenedCoulomb> {
        self.medium.medium().interaction(self.salt)
    }

    /// The interaction for energies of this mode. Hard bodies need no salt.
    pub fn interaction_for(&self, energy: EnergyMode) -> Result<ScreenedCoulomb> {
        let salt = match energy {
            EnergyMode::None => self.salt.or(Some(0.0)),
            _ => self.salt,
        };
        self.medium.medium().interaction(salt)
    }
}
