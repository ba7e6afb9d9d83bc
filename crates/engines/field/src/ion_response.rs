//! Charge of the ions around a solute as a function of the potential.
//!
//! A salt of cations z₊ and anions -z₋ in the field of a solute has, in units in which the slope at
//! φ = 0 is one,
//!
//! N(φ) = (exp(z₋ φ) - exp(-z₊ φ)) / (z₊ + z₋),
//!
//! so that the charge density of the ions is -S N(φ), with S = Σ c z² over both ions. For a 1:1 salt N
//! is sinh φ. The excess osmotic pressure of the ions is kT S M(φ) with M' = N and M(0) = 0
//! (Sharp and Honig, J. Phys. Chem. 94, 7684 (1990)).

use crate::{FieldError, Result};

/// Response of the ions to the potential.
///
/// ```
/// use protomer_field::{DielectricModel, IonResponse, SaltValence};
/// use protomer_kernel::Electrolyte;
/// let linear = DielectricModel::new(Electrolyte::in_water(298.15, 0.1)?);
/// assert_eq!(linear.ion_response, IonResponse::Linear);
/// let response = IonResponse::Boltzmann(SaltValence::ONE_TO_ONE);
/// let exact = DielectricModel { ion_response: response, ..linear };
/// assert_ne!(exact, linear);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum IonResponse {
    /// Proportional to the potential: N(φ) = φ.
    #[default]
    Linear,
    /// By the Boltzmann factors of the ions of a salt.
    Boltzmann(SaltValence),
}

protomer_kernel::choices! {
    /// Kind of response of the ions, without the charges of the salt.
    pub enum IonModel, default Linear {
        /// Proportional to the potential: right where that is below about 1 kT/e.
        Linear = "linear",
        /// By Boltzmann factors: right also around highly charged bodies.
        Boltzmann = "boltzmann",
    }
}

impl IonModel {
    /// The response of the ions of a salt.
    ///
    /// ```
    /// use protomer_field::{IonModel, IonResponse, SaltValence};
    /// let salt = SaltValence::new(2, 1)?;
    /// assert_eq!(IonModel::Boltzmann.with(salt), IonResponse::Boltzmann(salt));
    /// assert_eq!(IonModel::Linear.with(salt), IonResponse::Linear);
    /// # Ok::<(), protomer_field::FieldError>(())
    /// ```
    pub fn with(self, salt: SaltValence) -> IonResponse {
        match self {
            Self::Linear => IonResponse::Linear,
            Self::Boltzmann => IonResponse::Boltzmann(salt),
        }
    }
}

/// Charges of the two ions of a salt.
///
/// ```
/// use protomer_field::SaltValence;
/// let magnesium_chloride = SaltValence::new(2, 1)?;
/// // Three ions per formula unit: I = ½ (1 · 2² + 2 · 1²) c.
/// assert!((magnesium_chloride.ionic_strength_molar(0.1) - 0.3).abs() < 1e-15);
/// // Anions gather at a positive potential: exp(φ) of them, exp(-2 φ) of the cations.
/// let charge = magnesium_chloride.charge(1.0);
/// assert!((charge - (1.0_f64.exp() - (-2.0_f64).exp()) / 3.0).abs() < 1e-15);
/// # Ok::<(), protomer_field::FieldError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SaltValence {
    cation: u8,
    anion: u8,
}

/// Largest exponent that is taken: beyond it single precision would overflow.
const LARGEST_EXPONENT: f64 = 80.0;

impl SaltValence {
    /// A salt of ions with one charge each.
    pub const ONE_TO_ONE: Self = Self {
        cation: 1,
        anion: 1,
    };

    /// A salt of cations and anions with these numbers of charges.
    ///
    /// ```
    /// use protomer_field::SaltValence;
    /// assert_eq!(SaltValence::new(1, 1)?, SaltValence::ONE_TO_ONE);
    /// assert!(SaltValence::new(0, 1).is_err() && SaltValence::new(2, 5).is_err());
    /// # Ok::<(), protomer_field::FieldError>(())
    /// ```
    ///
    /// # Errors
    /// [`FieldError::BadSetting`] unless both are from 1 to 4.
    pub fn new(cation: u8, anion: u8) -> Result<Self> {
        for value in [cation, anion] {
            if !(1..=4).contains(&value) {
                return Err(FieldError::BadSetting {
                    setting: "charge of an ion",
                    value: f64::from(value),
                    requirement: "1, 2, 3 or 4",
                });
            }
        }
        Ok(Self { cation, anion })
    }

    /// Ionic strength ½ Σ c z² of the salt, mol/L, from the concentration of its formula units.
    ///
    /// ```
    /// use protomer_field::SaltValence;
    /// assert_eq!(SaltValence::ONE_TO_ONE.ionic_strength_molar(0.1), 0.1);
    /// // MgSO₄ has one ion of each kind: ½ (2² + 2²) c.
    /// assert_eq!(SaltValence::new(2, 2)?.ionic_strength_molar(0.5), 2.0);
    /// # Ok::<(), protomer_field::FieldError>(())
    /// ```
    pub fn ionic_strength_molar(self, concentration_molar: f64) -> f64 {
        let [cation, anion] = [self.cation, self.anion].map(f64::from);
        let divisor = f64::from(greatest_common_divisor(self.cation, self.anion));
        // A formula unit has z₋/g cations and z₊/g anions: ½ (z₋ z₊² + z₊ z₋²)/g.
        concentration_molar * (0.5 * cation * anion * (cation + anion) / divisor)
    }

    /// N(φ), for a potential in kT/e.
    ///
    /// ```
    /// use protomer_field::SaltValence;
    /// let charge = SaltValence::ONE_TO_ONE.charge(2.0);
    /// assert!((charge - 2.0_f64.sinh()).abs() < 1e-12);
    /// ```
    pub fn charge(self, potential: f64) -> f64 {
        let [of_cations, of_anions] = self.boltzmann_factors(potential);
        (of_anions - of_cations) / self.sum()
    }

    /// N'(φ).
    pub(crate) fn slope(self, potential: f64) -> f64 {
        let [of_cations, of_anions] = self.boltzmann_factors(potential);
        let [cation, anion] = [self.cation, self.anion].map(f64::from);
        (anion * of_anions + cation * of_cations) / self.sum()
    }

    /// ½ φ N(φ) - M(φ), the free energy of the ions beyond that of the linear response.
    pub(crate) fn excess_energy(self, potential: f64) -> f64 {
        // The difference of terms of order φ² is of order φ³ or φ⁴: below this it is rounding.
        if potential.abs() < 1e-3 {
            return 0.0;
        }
        let [of_cations, of_anions] = self.boltzmann_factors(potential);
        let [cation, anion] = [self.cation, self.anion].map(f64::from);
        let pressure = ((of_anions - 1.0) / anion + (of_cations - 1.0) / cation) / self.sum();
        0.5 * potential * self.charge(potential) - pressure
    }

    /// A potential, from that of the linear equation, at which Newton's iteration may start: the ions of
    /// a saturated cloud have the charge of the linear one.
    pub(crate) fn saturated(self, linear_potential: f64) -> f64 {
        let valence = match linear_potential > 0.0 {
            true => f64::from(self.anion),
            false => f64::from(self.cation),
        };
        let half_sum = 0.5 * self.sum();
        (half_sum * linear_potential).asinh() / valence.max(half_sum)
    }

    fn sum(self) -> f64 {
        f64::from(self.cation + self.anion)
    }

    /// exp(-z₊ φ) and exp(z₋ φ).
    fn boltzmann_factors(self, potential: f64) -> [f64; 2] {
        let exponents = [
            -f64::from(self.cation) * potential,
            f64::from(self.anion) * potential,
        ];
        exponents.map(|exponent| exponent.min(LARGEST_EXPONENT).exp())
    }
}

fn greatest_common_divisor(a: u8, b: u8) -> u8 {
    match b {
        0 => a,
        _ => greatest_common_divisor(b, a % b),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Derivatives by differences: N' of N, and N of M = ½ φ N - excess.
    #[test]
    fn charge_slope_and_pressure_belong_together() {
        for (cation, anion) in [(1, 1), (2, 1), (1, 2), (3, 1), (2, 2)] {
            let salt = SaltValence { cation, anion };
            let pressure = |x: f64| 0.5 * x * salt.charge(x) - salt.excess_energy(x);
            for potential in [-3.0, -0.5, 0.2, 2.0] {
                let step = 1e-5;
                let [low, high] = [potential - step, potential + step];
                let slope = (salt.charge(high) - salt.charge(low)) / (2.0 * step);
                assert!((slope / salt.slope(potential) - 1.0).abs() < 1e-8);
                let charge = (pressure(high) - pressure(low)) / (2.0 * step);
                assert!((charge / salt.charge(potential) - 1.0).abs() < 1e-6);
            }
            assert_eq!(salt.charge(0.0), 0.0);
            assert!((salt.slope(0.0) - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn ionic_strengths_are_those_of_the_textbook() {
        for (cation, anion, per_molar) in [(1, 1, 1.0), (2, 1, 3.0), (1, 2, 3.0), (2, 2, 4.0)] {
            let salt = SaltValence { cation, anion };
            assert_eq!(salt.ionic_strength_molar(0.5), 0.5 * per_molar);
        }
        assert!(SaltValence::new(0, 1).is_err());
        assert!(SaltValence::new(1, 5).is_err());
    }
}
