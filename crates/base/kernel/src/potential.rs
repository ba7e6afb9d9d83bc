//! Radial pair potentials.

use crate::error::require;
use crate::{Electrolyte, Result};
use serde::{Deserialize, Serialize};

/// The screened Coulomb potential between point charges,
///
/// V(r) = λ_B Z_i Z_j exp(-κ r) / r,
///
/// or, with a cut-off, the same for r < r_cut and 0 beyond, not shifted (Ramasubramani's thesis,
/// eq. 3.1).
///
/// ```
/// use protomer_kernel::potential::Yukawa;
/// let yukawa = Yukawa::uncut(7.0, 1.0 / 9.6)?;
/// assert!((yukawa.energy_kt(9.6) - 7.0 / 9.6 * (-1.0f64).exp()).abs() < 1e-15);
/// assert!(yukawa.energy_kt(48.0) > 0.0);
///
/// let cut = Yukawa::new(7.0, 1.0 / 9.6, 48.0)?;
/// assert_eq!(cut.energy_kt(48.0), 0.0);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Yukawa {
    /// Bjerrum length λ_B, Å.
    pub bjerrum_length_angstrom: f64,
    /// Inverse Debye length κ, 1/Å; zero for a bare Coulomb potential.
    pub inverse_debye_length_per_angstrom: f64,
    /// Cut-off r_cut, Å; infinite for none, and then left out where the potential is written down.
    #[serde(default = "no_cutoff", skip_serializing_if = "is_no_cutoff")]
    pub cutoff_angstrom: f64,
}

fn no_cutoff() -> f64 {
    f64::INFINITY
}

fn is_no_cutoff(angstrom: &f64) -> bool {
    *angstrom == f64::INFINITY
}

impl Yukawa {
    /// The potential with these lengths.
    ///
    /// ```
    /// use protomer_kernel::potential::Yukawa;
    /// let cut = Yukawa::new(7.0, 0.1, 30.0)?;
    /// assert!(cut.energy_kt(29.9) > 0.0 && cut.energy_kt(30.0) == 0.0);
    /// assert!(Yukawa::new(7.0, 0.1, -30.0).is_err());
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// [`KernelError::OutOfRange`](crate::KernelError::OutOfRange) unless the Bjerrum length and
    /// the cut-off are positive and the inverse Debye length is zero or positive.
    pub fn new(
        bjerrum_length_angstrom: f64,
        inverse_debye_length_per_angstrom: f64,
        cutoff_angstrom: f64,
    ) -> Result<Self> {
        let bjerrum = bjerrum_length_angstrom;
        let kappa = inverse_debye_length_per_angstrom;
        require("Bjerrum length in Å", bjerrum, "positive", bjerrum > 0.0)?;
        require(
            "inverse Debye length in 1/Å",
            kappa,
            "zero or positive",
            kappa >= 0.0,
        )?;
        if cutoff_angstrom != f64::INFINITY {
            require(
                "cut-off in Å",
                cutoff_angstrom,
                "positive",
                cutoff_angstrom > 0.0,
            )?;
        }
        Ok(Self {
            bjerrum_length_angstrom,
            inverse_debye_length_per_angstrom,
            cutoff_angstrom,
        })
    }

    /// The potential with these lengths and without a cut-off.
    ///
    /// ```
    /// use protomer_kernel::potential::Yukawa;
    /// let coulomb = Yukawa::uncut(7.0, 0.0)?;
    /// assert_eq!((coulomb.energy_kt(14.0), coulomb.is_cut()), (0.5, false));
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Yukawa::new`].
    pub fn uncut(
        bjerrum_length_angstrom: f64,
        inverse_debye_length_per_angstrom: f64,
    ) -> Result<Self> {
        Self::new(
            bjerrum_length_angstrom,
            inverse_debye_length_per_angstrom,
            f64::INFINITY,
        )
    }

    /// Whether the potential has a cut-off.
    ///
    /// ```
    /// use protomer_kernel::potential::Yukawa;
    /// assert!(Yukawa::new(7.0, 0.1, 50.0)?.is_cut());
    /// assert!(!Yukawa::new(7.0, 0.1, f64::INFINITY)?.is_cut());
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn is_cut(&self) -> bool {
        self.cutoff_angstrom.is_finite()
    }

    /// The distance (Å) beyond which charges whose magnitudes multiply to `charge_product` (e²) hold
    /// less than `energy_kt`: the cut-off, or the root of λ_B Z_i Z_j exp(-κ r)/r = E. Infinite for
    /// the bare Coulomb potential.
    ///
    /// ```
    /// use protomer_kernel::potential::Yukawa;
    /// let yukawa = Yukawa::uncut(7.0, 1.0 / 9.6)?;
    /// let reach = yukawa.reach_angstrom(600.0, 1e-6);
    /// assert!((600.0 * yukawa.energy_kt(reach) / 1e-6 - 1.0).abs() < 1e-6);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn reach_angstrom(&self, charge_product: f64, energy_kt: f64) -> f64 {
        let kappa = self.inverse_debye_length_per_angstrom;
        if charge_product == 0.0 {
            return 0.0;
        }
        if self.is_cut() || kappa == 0.0 {
            return self.cutoff_angstrom;
        }
        // With y = κ r: y + ln y = ln(κ λ_B Z_i Z_j / E), by Newton's method in ln y, whose
        // left-hand side is convex.
        let target = (kappa * self.bjerrum_length_angstrom * charge_product / energy_kt).ln();
        let mut logarithm = if target > 1.0 { target.ln() } else { target };
        for _ in 0..30 {
            let y = logarithm.exp();
            logarithm -= (y + logarithm - target) / (y + 1.0);
        }
        logarithm.exp() / kappa
    }

    /// The potential in this electrolyte.
    ///
    /// ```
    /// use protomer_kernel::{Electrolyte, potential::Yukawa};
    /// let saline = Electrolyte::in_water(298.15, 0.1)?;
    /// let yukawa = Yukawa::in_electrolyte(&saline, 5.0 * saline.debye_length_angstrom())?;
    /// assert_eq!(yukawa.bjerrum_length_angstrom, saline.bjerrum_length_angstrom());
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Yukawa::new`].
    pub fn in_electrolyte(electrolyte: &Electrolyte, cutoff_angstrom: f64) -> Result<Self> {
        let bjerrum = electrolyte.bjerrum_length_angstrom();
        let kappa = electrolyte.inverse_debye_length_per_angstrom();
        Self::new(bjerrum, kappa, cutoff_angstrom)
    }

    /// Energy of two unit charges at this distance (Å), kT; multiply by the product of the charges.
    ///
    /// ```
    /// use protomer_kernel::potential::Yukawa;
    /// let coulomb = Yukawa::uncut(7.0, 0.0)?;
    /// assert_eq!(2.0 * -3.0 * coulomb.energy_kt(21.0), -2.0, "charges of 2 and -3");
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
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
        let water = Electrolyte::in_water(298.15, 0.0).unwrap();
        let coulomb = Yukawa::in_electrolyte(&water, f64::INFINITY).unwrap();
        assert_eq!(coulomb.inverse_debye_length_per_angstrom, 0.0);
        assert_eq!(
            coulomb.energy_kt(1000.0),
            water.bjerrum_length_angstrom() / 1000.0
        );
    }

    #[test]
    fn lengths_out_of_range_are_refused() {
        for (bjerrum, kappa, cutoff) in [
            (0.0, 0.1, 48.0),
            (7.0, -0.1, 48.0),
            (7.0, 0.1, 0.0),
            (7.0, f64::NAN, 48.0),
            (7.0, 0.1, f64::NAN),
        ] {
            assert!(
                Yukawa::new(bjerrum, kappa, cutoff).is_err(),
                "{bjerrum} {kappa} {cutoff}"
            );
        }
    }
}
