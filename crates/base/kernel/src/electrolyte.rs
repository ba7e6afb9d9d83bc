//! The salt solution between charges: temperature, permittivity, salt, and the two lengths that
//! follow from them.
//!
//! Bjerrum length: λ_B = e² / (4π ε₀ ε_r k_B T). Debye length: κ⁻¹ with κ² = e² Σ c_i Z_i² / (ε_r
//! ε₀ k_B T), which for a 1:1 salt of concentration c is κ² = 8π λ_B N_A c (Debye-Hückel;
//! Ramasubramani's thesis, eq. 3.2).

use crate::error::require;
use crate::units::{
    BOLTZMANN_JOULE_PER_KELVIN, ELEMENTARY_CHARGE_COULOMB, NUMBER_DENSITY_PER_MOLAR,
    VACUUM_PERMITTIVITY_FARAD_PER_METRE,
};
use crate::{Result, null};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A 1:1 salt dissolved in a solvent of uniform permittivity.
///
/// Every stage of a calculation takes its screening from here, so that no two stages can disagree
/// about the salt. The Bjerrum and Debye lengths follow from temperature, permittivity and salt; a
/// stated length replaces the one derived.
///
/// ```
/// use protomer_kernel::Electrolyte;
/// let saline = Electrolyte::in_water(298.15, 0.1)?;
/// assert!((saline.bjerrum_length_angstrom() - 7.16).abs() < 0.01);
/// assert!((saline.debye_length_angstrom() - 9.61).abs() < 0.02);
///
/// let stated = saline.with_bjerrum_length(7.0)?.with_debye_length(9.6)?;
/// assert_eq!(stated.bjerrum_length_angstrom(), 7.0);
/// assert_eq!(stated.debye_length_angstrom(), 9.6);
/// assert_eq!(stated.salt_molar(), None);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Electrolyte {
    #[serde(rename = "temperature_K")]
    temperature_kelvin: f64,
    #[serde(rename = "salt_M")]
    salt_molar: Option<f64>,
    relative_permittivity: f64,
    bjerrum_length_angstrom: f64,
    #[serde(deserialize_with = "null::as_infinity")]
    debye_length_angstrom: f64,
}

impl Electrolyte {
    /// A salt (mol/L) in a solvent of this relative permittivity.
    ///
    /// ```
    /// use protomer_kernel::Electrolyte;
    /// let ethanol = Electrolyte::new(298.15, 0.0, 24.3)?;
    /// assert!((ethanol.bjerrum_length_angstrom() - 23.06).abs() < 0.01);
    /// assert!(Electrolyte::new(298.15, -0.1, 24.3).is_err());
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// [`KernelError::OutOfRange`](crate::KernelError::OutOfRange) unless the temperature is
    /// positive, the salt zero or positive, and the permittivity at least 1.
    pub fn new(
        temperature_kelvin: f64,
        salt_molar: f64,
        relative_permittivity: f64,
    ) -> Result<Self> {
        let (temperature, salt, permittivity) =
            (temperature_kelvin, salt_molar, relative_permittivity);
        require(
            "temperature in K",
            temperature,
            "positive",
            temperature > 0.0,
        )?;
        require(
            "salt concentration in mol/L",
            salt,
            "zero or positive",
            salt >= 0.0,
        )?;
        require(
            "relative permittivity",
            permittivity,
            "at least 1",
            permittivity >= 1.0,
        )?;
        let bjerrum = bjerrum_length_angstrom(temperature, permittivity);
        Ok(Self {
            temperature_kelvin,
            salt_molar: Some(salt),
            relative_permittivity,
            bjerrum_length_angstrom: bjerrum,
            debye_length_angstrom: debye_length_angstrom(bjerrum, salt),
        })
    }

    /// A salt (mol/L) in water, whose permittivity follows from the temperature
    /// ([`water_permittivity`]).
    ///
    /// ```
    /// use protomer_kernel::Electrolyte;
    /// let saline = Electrolyte::in_water(310.15, 0.15)?;
    /// assert!((saline.relative_permittivity() - 74.15).abs() < 0.01);
    /// assert!(Electrolyte::in_water(200.0, 0.15).is_err(), "ice");
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// [`KernelError::OutOfRange`](crate::KernelError::OutOfRange) for a temperature outside
    /// 273.15-373.15 K or a negative salt concentration.
    pub fn in_water(temperature_kelvin: f64, salt_molar: f64) -> Result<Self> {
        let permittivity = water_permittivity(temperature_kelvin)?;
        Self::new(temperature_kelvin, salt_molar, permittivity)
    }

    /// The same salt with a stated Bjerrum length (Å). Where the Debye length follows from the salt,
    /// it follows from this Bjerrum length.
    ///
    /// ```
    /// use protomer_kernel::Electrolyte;
    /// let saline = Electrolyte::in_water(298.15, 0.1)?;
    /// let doubled = saline.with_bjerrum_length(2.0 * saline.bjerrum_length_angstrom())?;
    /// let ratio = saline.debye_length_angstrom() / doubled.debye_length_angstrom();
    /// assert!((ratio - 2.0_f64.sqrt()).abs() < 1e-12);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// [`KernelError::OutOfRange`](crate::KernelError::OutOfRange) unless the length is positive
    /// and finite.
    pub fn with_bjerrum_length(self, angstrom: f64) -> Result<Self> {
        require("Bjerrum length in Å", angstrom, "positive", angstrom > 0.0)?;
        let debye_length_angstrom = match self.salt_molar {
            Some(salt) => debye_length_angstrom(angstrom, salt),
            None => self.debye_length_angstrom,
        };
        Ok(Self {
            bjerrum_length_angstrom: angstrom,
            debye_length_angstrom,
            ..self
        })
    }

    /// The same solvent with a stated Debye length (Å) instead of a salt concentration; infinite
    /// for no screening.
    ///
    /// ```
    /// use protomer_kernel::Electrolyte;
    /// let stated = Electrolyte::in_water(298.15, 0.1)?.with_debye_length(20.0)?;
    /// assert_eq!(stated.inverse_debye_length_per_angstrom(), 0.05);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// [`KernelError::OutOfRange`](crate::KernelError::OutOfRange) unless the length is positive.
    pub fn with_debye_length(self, angstrom: f64) -> Result<Self> {
        if angstrom != f64::INFINITY {
            require("Debye length in Å", angstrom, "positive", angstrom > 0.0)?;
        }
        Ok(Self {
            salt_molar: None,
            debye_length_angstrom: angstrom,
            ..self
        })
    }

    /// Absolute temperature, K.
    ///
    /// ```
    /// use protomer_kernel::Electrolyte;
    /// let cold = Electrolyte::in_water(278.15, 0.1)?;
    /// assert_eq!(cold.temperature_kelvin(), 278.15);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn temperature_kelvin(&self) -> f64 {
        self.temperature_kelvin
    }

    /// Concentration of the 1:1 salt, mol/L; `None` where the Debye length was stated instead.
    ///
    /// ```
    /// use protomer_kernel::Electrolyte;
    /// let saline = Electrolyte::in_water(298.15, 0.1)?;
    /// assert_eq!(saline.salt_molar(), Some(0.1));
    /// assert_eq!(saline.with_debye_length(9.6)?.salt_molar(), None);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn salt_molar(&self) -> Option<f64> {
        self.salt_molar
    }

    /// Relative permittivity of the solvent.
    ///
    /// ```
    /// use protomer_kernel::Electrolyte;
    /// let [cold, warm] = [278.15, 310.15].map(|kelvin| Electrolyte::in_water(kelvin, 0.1));
    /// assert!(cold?.relative_permittivity() > warm?.relative_permittivity(), "heat disorders water");
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn relative_permittivity(&self) -> f64 {
        self.relative_permittivity
    }

    /// Bjerrum length λ_B in Å: the distance at which two unit charges interact with 1 kT.
    ///
    /// ```
    /// use protomer_kernel::Electrolyte;
    /// let water = Electrolyte::in_water(298.15, 0.1)?;
    /// assert!((water.bjerrum_length_angstrom() - 7.15).abs() < 0.02);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn bjerrum_length_angstrom(&self) -> f64 {
        self.bjerrum_length_angstrom
    }

    /// Bjerrum length l = λ_B ε_r of the vacuum in Å, which takes the permittivity of each place as
    /// a divisor.
    ///
    /// ```
    /// use protomer_kernel::Electrolyte;
    /// let water = Electrolyte::in_water(298.15, 0.0)?;
    /// assert!((water.vacuum_bjerrum_length_angstrom() - 560.4).abs() < 0.1);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn vacuum_bjerrum_length_angstrom(&self) -> f64 {
        self.bjerrum_length_angstrom * self.relative_permittivity
    }

    /// Debye screening length κ⁻¹ in Å; infinite without salt.
    ///
    /// ```
    /// use protomer_kernel::Electrolyte;
    /// let [dilute, salty] = [0.01, 0.04].map(|molar| Electrolyte::in_water(298.15, molar));
    /// let ratio = dilute?.debye_length_angstrom() / salty?.debye_length_angstrom();
    /// assert!((ratio - 2.0).abs() < 1e-12, "four times the salt screens twice as fast");
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn debye_length_angstrom(&self) -> f64 {
        self.debye_length_angstrom
    }

    /// Inverse Debye length κ in 1/Å; zero without salt.
    ///
    /// ```
    /// use protomer_kernel::Electrolyte;
    /// let water = Electrolyte::in_water(298.15, 0.0)?;
    /// assert_eq!(water.inverse_debye_length_per_angstrom(), 0.0);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn inverse_debye_length_per_angstrom(&self) -> f64 {
        self.debye_length_angstrom.recip()
    }
}

/// Bjerrum length λ_B = e² / (4π ε₀ ε_r k_B T).
fn bjerrum_length_angstrom(temperature_kelvin: f64, relative_permittivity: f64) -> f64 {
    let permittivity = VACUUM_PERMITTIVITY_FARAD_PER_METRE * relative_permittivity;
    let thermal_energy = BOLTZMANN_JOULE_PER_KELVIN * temperature_kelvin;
    ELEMENTARY_CHARGE_COULOMB.powi(2) / (4.0 * PI * permittivity * thermal_energy) * 1e10
}

/// Debye length κ⁻¹ with κ² = 8π λ_B N_A c; infinite without salt.
fn debye_length_angstrom(bjerrum_length_angstrom: f64, salt_molar: f64) -> f64 {
    let ions = NUMBER_DENSITY_PER_MOLAR * salt_molar;
    (8.0 * PI * bjerrum_length_angstrom * ions).sqrt().recip()
}

/// Relative permittivity of liquid water at atmospheric pressure, 0-100 °C:
/// ε = 87.740 - 0.40008 t + 9.398e-4 t² - 1.410e-6 t³, t in °C
/// (Malmberg and Maryott, J. Res. Natl. Bur. Stand. 56, 1 (1956)).
///
/// # Errors
/// [`KernelError::OutOfRange`](crate::KernelError::OutOfRange) outside 273.15-373.15 K.
///
/// ```
/// let permittivity = protomer_kernel::electrolyte::water_permittivity(298.15)?;
/// assert!((permittivity - 78.30).abs() < 0.01);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
pub fn water_permittivity(temperature_kelvin: f64) -> Result<f64> {
    let liquid = (273.15..=373.15).contains(&temperature_kelvin);
    let requirement = "within 273.15 to 373.15";
    require(
        "temperature of water in K",
        temperature_kelvin,
        requirement,
        liquid,
    )?;
    let t = temperature_kelvin - 273.15;
    Ok(87.740 + t * (-0.40008 + t * (9.398e-4 - t * 1.410e-6)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_agree_with_the_textbook_values() {
        let electrolyte = Electrolyte::new(298.15, 0.1, 78.54).unwrap();
        assert!((electrolyte.bjerrum_length_angstrom() - 7.135).abs() < 2e-3);
        // The reference electrostatics (water 78.54, 298.15 K) state kappa = 0.1039255 1/Å at 0.1
        // mol/L.
        let kappa = electrolyte.inverse_debye_length_per_angstrom();
        assert!((kappa - 0.103_925_5).abs() < 2e-5);
    }

    #[test]
    fn no_salt_means_no_screening() {
        let electrolyte = Electrolyte::in_water(298.15, 0.0).unwrap();
        assert_eq!(electrolyte.debye_length_angstrom(), f64::INFINITY);
        assert_eq!(electrolyte.inverse_debye_length_per_angstrom(), 0.0);
    }

    #[test]
    fn a_stated_bjerrum_length_carries_through_to_the_screening() {
        let derived = Electrolyte::in_water(298.15, 0.1).unwrap();
        let stated = derived.with_bjerrum_length(4.0 * derived.bjerrum_length_angstrom());
        let ratio = derived.debye_length_angstrom() / stated.unwrap().debye_length_angstrom();
        assert!((ratio - 2.0).abs() < 1e-12);
    }

    #[test]
    fn stated_lengths_hold_in_either_order() {
        let salt = Electrolyte::in_water(298.15, 0.1).unwrap();
        let one = salt
            .with_bjerrum_length(7.0)
            .unwrap()
            .with_debye_length(9.6)
            .unwrap();
        let other = salt
            .with_debye_length(9.6)
            .unwrap()
            .with_bjerrum_length(7.0)
            .unwrap();
        assert_eq!(one, other);
    }

    #[test]
    fn quantities_out_of_range_are_refused() {
        for (temperature, salt, permittivity) in [
            (-1.0, 0.1, 78.0),
            (298.15, -0.1, 78.0),
            (298.15, f64::NAN, 78.0),
            (298.15, 0.1, 0.5),
        ] {
            let electrolyte = Electrolyte::new(temperature, salt, permittivity);
            assert!(electrolyte.is_err(), "{temperature} {salt} {permittivity}");
        }
        assert!(Electrolyte::in_water(500.0, 0.1).is_err());
        let salt = Electrolyte::in_water(298.15, 0.1).unwrap();
        for length in [0.0, -1.0, f64::NAN] {
            assert!(salt.with_bjerrum_length(length).is_err(), "{length}");
            assert!(salt.with_debye_length(length).is_err(), "{length}");
        }
    }
}
