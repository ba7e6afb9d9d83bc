//! Physical constants and the conditions of a simulation.
//!
//! Bjerrum length: λ_B = e² / (4π ε₀ ε_r k_B T). Debye length: κ⁻¹ with κ² = e² Σ c_i Z_i² / (ε_r
//! ε₀ k_B T), which for a 1:1 salt of concentration c is κ² = 8π λ_B N_A c (Debye-Hückel;
//! Ramasubramani's thesis, eq. 3.2).

use crate::{KernelError, Result};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Elementary charge, C (exact, SI 2019).
pub const ELEMENTARY_CHARGE_COULOMB: f64 = 1.602_176_634e-19;
/// Boltzmann constant, J/K (exact, SI 2019).
pub const BOLTZMANN_JOULE_PER_KELVIN: f64 = 1.380_649e-23;
/// Avogadro constant, 1/mol (exact, SI 2019).
pub const AVOGADRO_PER_MOL: f64 = 6.022_140_76e23;
/// Vacuum permittivity, F/m (CODATA 2022).
pub const VACUUM_PERMITTIVITY_FARAD_PER_METRE: f64 = 8.854_187_818_8e-12;

/// Particles per Å³ at a concentration of 1 mol/L.
pub const NUMBER_DENSITY_PER_MOLAR: f64 = AVOGADRO_PER_MOL * 1e-27;

/// The conditions every stage of a calculation shares, so that no two stages can disagree about the
/// salt.
///
/// ```
/// use protomer_kernel::Conditions;
/// let conditions = Conditions::new(298.15, 0.1, 7.4)?;
/// assert!((conditions.debye_length_angstrom() - 9.61).abs() < 0.02);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Conditions {
    /// Absolute temperature, K.
    #[serde(rename = "temperature_K")]
    pub temperature_kelvin: f64,
    /// Concentration of a 1:1 salt, mol/L.
    #[serde(rename = "salt_M")]
    pub salt_molar: f64,
    /// pH at which the charges were assigned.
    pub ph: f64,
    /// Relative permittivity of the solvent.
    pub relative_permittivity: f64,
}

impl Conditions {
    /// Conditions in water: the permittivity follows from the temperature ([`water_permittivity`]).
    ///
    /// # Errors
    /// [`KernelError::OutOfRange`] for a temperature outside 273.15-373.15 K, a negative salt
    /// concentration or a pH that is not a number.
    pub fn new(temperature_kelvin: f64, salt_molar: f64, ph: f64) -> Result<Self> {
        let relative_permittivity = water_permittivity(temperature_kelvin)?;
        Self::with_permittivity(temperature_kelvin, salt_molar, ph, relative_permittivity)
    }

    /// Conditions with a stated relative permittivity.
    ///
    /// # Errors
    /// [`KernelError::OutOfRange`] names the first quantity that makes no sense.
    pub fn with_permittivity(
        temperature_kelvin: f64,
        salt_molar: f64,
        ph: f64,
        relative_permittivity: f64,
    ) -> Result<Self> {
        require(
            "temperature in K",
            temperature_kelvin,
            "positive",
            temperature_kelvin > 0.0,
        )?;
        require(
            "salt concentration in mol/L",
            salt_molar,
            "zero or positive",
            salt_molar >= 0.0,
        )?;
        require("pH", ph, "a finite number", true)?;
        require(
            "relative permittivity",
            relative_permittivity,
            "at least 1",
            relative_permittivity >= 1.0,
        )?;
        Ok(Self {
            temperature_kelvin,
            salt_molar,
            ph,
            relative_permittivity,
        })
    }

    /// Bjerrum length λ_B in Å: the distance at which two unit charges interact with 1 kT.
    pub fn bjerrum_length_angstrom(&self) -> f64 {
        let permittivity = VACUUM_PERMITTIVITY_FARAD_PER_METRE * self.relative_permittivity;
        let thermal_energy = BOLTZMANN_JOULE_PER_KELVIN * self.temperature_kelvin;
        ELEMENTARY_CHARGE_COULOMB.powi(2) / (4.0 * PI * permittivity * thermal_energy) * 1e10
    }

    /// Debye screening length κ⁻¹ in Å; infinite without salt.
    pub fn debye_length_angstrom(&self) -> f64 {
        let ions = NUMBER_DENSITY_PER_MOLAR * self.salt_molar;
        (8.0 * PI * self.bjerrum_length_angstrom() * ions)
            .sqrt()
            .recip()
    }

    /// The thermal energy of one mole, k_B T N_A in kJ/mol: what one kT is worth.
    pub fn kilojoule_per_mol_per_kt(&self) -> f64 {
        BOLTZMANN_JOULE_PER_KELVIN * self.temperature_kelvin * AVOGADRO_PER_MOL * 1e-3
    }
}

/// Relative permittivity of liquid water at atmospheric pressure, 0-100 °C:
/// ε = 87.740 - 0.40008 t + 9.398e-4 t² - 1.410e-6 t³, t in °C
/// (Malmberg and Maryott, J. Res. Natl. Bur. Stand. 56, 1 (1956)).
///
/// # Errors
/// [`KernelError::OutOfRange`] outside 273.15-373.15 K.
///
/// ```
/// let permittivity = protomer_kernel::units::water_permittivity(298.15)?;
/// assert!((permittivity - 78.30).abs() < 0.01);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
pub fn water_permittivity(temperature_kelvin: f64) -> Result<f64> {
    let liquid = (273.15..=373.15).contains(&temperature_kelvin);
    require(
        "temperature of water in K",
        temperature_kelvin,
        "within 273.15 to 373.15",
        liquid,
    )?;
    let t = temperature_kelvin - 273.15;
    Ok(87.740 + t * (-0.40008 + t * (9.398e-4 - t * 1.410e-6)))
}

/// `Ok` if `value` is finite and `holds`, otherwise the error that names the quantity.
pub(crate) fn require(
    quantity: &'static str,
    value: f64,
    requirement: &'static str,
    holds: bool,
) -> Result<()> {
    if value.is_finite() && holds {
        Ok(())
    } else {
        Err(KernelError::OutOfRange {
            quantity,
            value,
            requirement,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_agree_with_the_textbook_values() {
        let conditions = Conditions::with_permittivity(298.15, 0.1, 7.0, 78.54).unwrap();
        assert!((conditions.bjerrum_length_angstrom() - 7.135).abs() < 2e-3);
        // The reference electrostatics (water 78.54, 298.15 K) state kappa = 0.1039255 1/Å at 0.1
        // mol/L.
        assert!((conditions.debye_length_angstrom().recip() - 0.103_925_5).abs() < 2e-5);
        assert!((conditions.kilojoule_per_mol_per_kt() - 2.4789).abs() < 1e-3);
    }

    #[test]
    fn no_salt_means_no_screening() {
        let conditions = Conditions::new(298.15, 0.0, 7.0).unwrap();
        assert_eq!(conditions.debye_length_angstrom(), f64::INFINITY);
    }

    #[test]
    fn nonsense_is_refused_by_name() {
        for (t, salt, ph) in [
            (-1.0, 0.1, 7.0),
            (298.15, -0.1, 7.0),
            (298.15, 0.1, f64::NAN),
            (500.0, 0.1, 7.0),
        ] {
            assert!(Conditions::new(t, salt, ph).is_err(), "{t} {salt} {ph}");
        }
    }
}
