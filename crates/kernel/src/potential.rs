//! Radial pair potentials.

use crate::units::require;
use crate::{Conditions, Result};
use serde::{Deserialize, Serialize};

/// The screened Coulomb potential between point charges, cut and not shifted (Ramasubramani's thesis, eq. 3.1):
///
/// V(r) = λ_B Z_i Z_j exp(-κ r) / r for r < r_cut, and 0 beyond.
///
/// ```
/// use protomer_kernel::potential::Yukawa;
/// let yukawa = Yukawa::new(7.0, 1.0 / 9.6, 48.0)?;
/// assert!((yukawa.energy_kt(9.6) - 7.0 / 9.6 * (-1.0f64).exp()).abs() < 1e-15);
/// assert_eq!(yukawa.energy_kt(48.0), 0.0);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Yukawa {
    /// Bjerrum length λ_B, Å.
    pub bjerrum_length_angstrom: f64,
    /// Inverse Debye length κ, 1/Å; zero for a bare Coulomb potential.
    pub inverse_debye_length_per_angstrom: f64,
    /// Cut-off r_cut, Å; infinite for none.
    pub cutoff_angstrom: f64,
}

impl Yukawa {
    /// The potential with these lengths.
    ///
    /// # Errors
    /// [`KernelError::OutOfRange`](crate::KernelError::OutOfRange) unless the Bjerrum length and the cut-off are positive
    /// and the inverse Debye length is zero or positive.
    pub fn new(
        bjerrum_length_angstrom: f64,
        inverse_debye_length_per_angstrom: f64,
        cutoff_angstrom: f64,
    ) -> Result<Self> {
        let (bjerrum, kappa) = (bjerrum_length_angstrom, inverse_debye_length_per_angstrom);
        require("Bjerrum length in Å", bjerrum, "positive", bjerrum > 0.0)?;
        require("inverse Debye length in 1/Å", kappa, "zero or positive", kappa >= 0.0)?;
        if cutoff_angstrom != f64::INFINITY {
            require("cut-off in Å", cutoff_angstrom, "positive", cutoff_angstrom > 0.0)?;
        }
        Ok(Self { bjerrum_length_angstrom, inverse_debye_length_per_angstrom, cutoff_angstrom })
    }

    /// The potential under these conditions.
    ///
    /// # Errors
    /// As [`Yukawa::new`].
    pub fn from_conditions(conditions: &Conditions, cutoff_angstrom: f64) -> Result<Self> {
        let kappa = conditions.debye_length_angstrom().recip();
        Self::new(conditions.bjerrum_length_angstrom(), kappa, cutoff_angstrom)
    }

    /// Energy of two unit charges at this distance (Å), kT; multiply by the product of the charges.
    pub fn energy_kt(&self, distance_angstrom: f64) -> f64 {
        if distance_angstrom < self.cutoff_angstrom {
            let screening = (-self.inverse_debye_length_per_angstrom * distance_angstrom).exp();
            self.bjerrum_length_angstrom * screening / distance_angstrom
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_salt_it_is_coulomb() {
        let conditions = Conditions::new(298.15, 0.0, 7.0).unwrap();
        let coulomb = Yukawa::from_conditions(&conditions, f64::INFINITY).unwrap();
        assert_eq!(coulomb.inverse_debye_length_per_angstrom, 0.0);
        assert_eq!(coulomb.energy_kt(1000.0), conditions.bjerrum_length_angstrom() / 1000.0);
    }

    #[test]
    fn nonsense_is_refused() {
        for (bjerrum, kappa, cutoff) in
            [(0.0, 0.1, 48.0), (7.0, -0.1, 48.0), (7.0, 0.1, 0.0), (7.0, f64::NAN, 48.0), (7.0, 0.1, f64::NAN)]
        {
            assert!(Yukawa::new(bjerrum, kappa, cutoff).is_err(), "{bjerrum} {kappa} {cutoff}");
        }
    }
}
