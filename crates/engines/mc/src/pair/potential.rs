//! The terms of the energy of two bodies: screened charges, attraction between residues.

use crate::Result;
use crate::beads::BeadCloud;
use crate::charges::ChargeCloud;
use crate::energy::levels::Table;
use crate::energy::terms::{PairPotential, Term};
use crate::energy::{ContactPotential, SitePotential, pair_energy_kt};
use crate::error::require;
use protomer_kernel::Vec3;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::potential::Yukawa;
use std::f64::consts::PI;
use std::sync::Arc;

/// Fewer charges are summed directly.
const FEW_CHARGES: usize = 40;

/// Attraction between residues.
#[derive(Debug, Clone)]
pub struct Contacts {
    potential: ContactPotential,
    first: BeadCloud,
    second: BeadCloud,
}

impl Contacts {
    /// The residues of two bodies under a potential.
    pub fn new(potential: ContactPotential, first: &BeadCloud, second: &BeadCloud) -> Self {
        Self {
            potential,
            first: first.clone(),
            second: second.clone(),
        }
    }
}

impl PairPotential for Contacts {
    fn term(&self) -> Term {
        Term::Contacts
    }

    fn energy_kt(&self, second_in_first: &RelativePose) -> f64 {
        self.potential
            .energy_kt(&self.first, &self.second, second_in_first)
    }

    fn shares(&self, second_in_first: &RelativePose, take: &mut dyn FnMut(usize, &Vec3, f64)) {
        self.pair_shares(second_in_first, &mut |first, second, energy_kt| {
            take(0, first, energy_kt);
            take(1, second, energy_kt);
        });
    }

    fn pair_shares(&self, second_in_first: &RelativePose, take: &mut dyn FnMut(&Vec3, &Vec3, f64)) {
        let inverse = second_in_first.inverse();
        self.potential
            .for_each_pair(&self.first, &self.second, second_in_first, |pair| {
                // Back into the frame of the second body, where its residues have fixed places.
                let second = inverse.transform_point(&pair.second);
                take(&pair.first, &second, pair.energy_kt);
            });
    }

    fn reach_angstrom(&self, _: f64) -> f64 {
        // The cut-off is exact, whatever the energy.
        let radii = self.first.radius_angstrom() + self.second.radius_angstrom();
        radii + self.potential.cutoff_angstrom()
    }

    fn tail_angstrom3(&self, _: f64) -> f64 {
        0.0
    }
}

/// Screened charges, U = λ_B Σ q_k q_l exp(-κ r)/r.
///
/// ```
/// use protomer_kernel::{Vec3, potential::Yukawa};
/// use protomer_mc::charges::ChargeCloud;
/// use protomer_mc::pair::Charged;
/// let ion = ChargeCloud::new(&[(Vec3::zeros(), 1.0)]);
/// assert!(Charged::new(Yukawa::uncut(7.0, 0.1)?, &ion, &ion).is_ok());
/// assert!(Charged::new(Yukawa::uncut(7.0, 0.0)?, &ion, &ion).is_err(), "no screening");
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Charged {
    yukawa: Yukawa,
    first: ChargeCloud,
    second: ChargeCloud,
    tables: Option<[Arc<Table>; 2]>,
}

impl Charged {
    /// The charges of two bodies under a potential.
    ///
    /// # Errors
    /// [`McError::BadSetting`](crate::McError::BadSetting) without screening: the integrals then do not converge.
    pub fn new(yukawa: Yukawa, first: &ChargeCloud, second: &ChargeCloud) -> Result<Self> {
        let kappa = yukawa.inverse_debye_length_per_angstrom;
        require(
            "inverse Debye length in 1/Å",
            kappa,
            "positive, because the virial coefficient of unscreened charges has \
                              no value; add salt",
            kappa > 0.0 || yukawa.is_cut(),
        )?;
        Ok(Self {
            yukawa,
            first: first.clone(),
            second: second.clone(),
            tables: None,
        })
    }

    /// The same with tables of the potential, which give the energy to some 10⁻⁴ kT; those of one
    /// body twice where both are the same. Direct sums are kept where they cost less.
    pub fn with_tables(self, are_equal: bool) -> Self {
        let Some(reach) = self.table_reach_angstrom() else {
            return self;
        };
        // Beyond its reach the table gives no value, and the direct sum steps in.
        let table = |charges: &ChargeCloud| Arc::new(Table::new(charges, &self.yukawa, reach));
        let first = table(&self.first);
        let second = match are_equal {
            true => Arc::clone(&first),
            false => table(&self.second),
        };
        self.with_shared_tables([first, second])
    }

    /// Distance that the tables of both bodies should reach, Å; `None` where direct sums cost less.
    pub fn table_reach_angstrom(&self) -> Option<f64> {
        let charges = self.first.len().min(self.second.len());
        // Few charges are summed faster than looked up, and a table has no cut-off.
        if charges < FEW_CHARGES || self.yukawa.is_cut() {
            return None;
        }
        // Farther apart, energies are rarely requested, and summed directly.
        const ENOUGH_KT: f64 = 1e-3;
        let radii = self.first.radius_angstrom() + self.second.radius_angstrom();
        Some(self.reach_angstrom(ENOUGH_KT) + radii)
    }

    /// The same with tables that were made elsewhere: those of the first and of the second body.
    pub fn with_shared_tables(mut self, tables: [Arc<Table>; 2]) -> Self {
        self.tables = Some(tables);
        self
    }

    /// Σ |q| sinh(κs)/(κs) over charges at distances s of the origin: what bounds the potential far
    /// away, as the sum without the magnitudes gives its average over directions.
    fn magnitude_seen_from_afar_e(&self, cloud: &ChargeCloud) -> f64 {
        let mut sum = 0.0;
        for (place, charge) in cloud.iter() {
            sum += charge.abs() * self.amplification(place.norm());
        }
        sum
    }

    /// Σ q sinh(κs)/(κs): outside, exp(-κr)/r averaged over the directions of a charge is that of a
    /// charge at the centre times this factor.
    fn charge_seen_from_afar_e(&self, cloud: &ChargeCloud) -> f64 {
        let mut sum = 0.0;
        for (place, charge) in cloud.iter() {
            sum += charge * self.amplification(place.norm());
        }
        sum
    }

    fn amplification(&self, distance_angstrom: f64) -> f64 {
        let x = self.yukawa.inverse_debye_length_per_angstrom * distance_angstrom;
        // sinh(x)/x = 1 + x²/6 + ...: below 10⁻⁴ it is one to 2 · 10⁻⁹.
        if x < 1e-4 { 1.0 } else { x.sinh() / x }
    }
}

impl PairPotential for Charged {
    fn term(&self) -> Term {
        Term::Charges
    }

    fn energy_kt(&self, second_in_first: &RelativePose) -> f64 {
        if let Some([first, second]) = &self.tables {
            let energy_kt = first.energy_alone_kt(second, second_in_first);
            if let Some(energy_kt) = energy_kt {
                return energy_kt;
            }
        }
        pair_energy_kt(&self.yukawa, &self.first, &self.second, second_in_first)
    }

    fn shares(&self, second_in_first: &RelativePose, take: &mut dyn FnMut(usize, &Vec3, f64)) {
        // The direct sum, charge by charge: shares are for reports, not for moves.
        for (first_place, charge) in self.first.iter() {
            let mut energy_kt = 0.0;
            for (place, other) in self.second.iter() {
                let apart = (second_in_first.transform_point(&place) - first_place).norm();
                energy_kt += charge * other * self.yukawa.energy_kt(apart);
            }
            take(0, &first_place, energy_kt);
        }
        for (place, charge) in self.second.iter() {
            let moved_place = second_in_first.transform_point(&place);
            let mut energy_kt = 0.0;
            for (other_place, other) in self.first.iter() {
                energy_kt +=
                    charge * other * self.yukawa.energy_kt((moved_place - other_place).norm());
            }
            take(1, &place, energy_kt);
        }
    }

    fn reach_angstrom(&self, energy_kt: f64) -> f64 {
        let radii = self.first.radius_angstrom() + self.second.radius_angstrom();
        if let Some(cutoff) = self.yukawa.cutoff_angstrom() {
            return cutoff + radii;
        }
        let first = self.magnitude_seen_from_afar_e(&self.first);
        let second = self.magnitude_seen_from_afar_e(&self.second);
        // Directions that point at each other are at most exp(κ radius) against sinh(κs)/(κs).
        let spread = 1.0 + self.yukawa.inverse_debye_length_per_angstrom * radii;
        let product = first * second * spread;
        self.yukawa.reach_angstrom(product, energy_kt).max(radii)
    }

    fn tail_angstrom3(&self, distance_angstrom: f64) -> f64 {
        if self.yukawa.is_cut() {
            return 0.0;
        }
        let kappa = self.yukawa.inverse_debye_length_per_angstrom;
        let charges =
            self.charge_seen_from_afar_e(&self.first) * self.charge_seen_from_afar_e(&self.second);
        let x = kappa * distance_angstrom;
        // ∫ r² exp(-κr)/r dr from the distance on, by parts: (1 + x) exp(-x)/κ².
        let integral = (1.0 + x) * (-x).exp() / (kappa * kappa);
        -4.0 * PI * self.yukawa.bjerrum_length_angstrom * charges * integral
    }
}
