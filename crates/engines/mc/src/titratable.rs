//! Titratable groups of a kind of body: charges that change, and the free energy of each state.
//!
//! Group i is charged (n_i = 1) or neutral. With g_i the free energy of its charged form at the pH where all other
//! groups are neutral, less that of its neutral form without tautomers, W_ij the interaction of two charged forms, t_i
//! half the free energy of the first of two neutral tautomers less that of the second, and w_ij what charged group j
//! adds to t_i, a state has the free energy in kT
//!
//! G(n) = Σ n_i g_i + Σ_{i<j} n_i n_j W_ij + Σ (1 - n_i) F(t_i + Σ_j n_j w_ij),
//! F(t) = -ln(p e⁻ᵗ + (1 - p) eᵗ),
//!
//! with p the share of the first tautomer in water (Bashford and Karplus, J. Phys. Chem. 95, 9556 (1991)).

use crate::charges::ChargeCloud;
use crate::{McError, Result};
use protomer_kernel::Vec3;

/// Two neutral forms of a group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tautomers {
    /// Share of the first form in water.
    pub first_share: f64,
    /// Half the free energy of the first form less that of the second, relative to water, kT.
    pub half_difference_kt: f64,
}

impl Tautomers {
    /// Free energy of the neutral form relative to water where other charges add to half the difference, kT.
    fn energy_kt(&self, field_kt: f64) -> f64 {
        let half_kt = self.half_difference_kt + field_kt;
        let lower = -half_kt.abs();
        // Taken relative to the lower of the two, so that nothing overflows.
        let first = self.first_share * (lower - half_kt).exp();
        let second = (1.0 - self.first_share) * (lower + half_kt).exp();
        lower - (first + second).ln()
    }
}

/// One titratable group.
#[derive(Debug, Clone, PartialEq)]
pub struct TitratableGroup {
    /// Changes of charge by index of the site, e: the charged less the neutral form.
    pub change_e: Vec<(usize, f64)>,
    /// Free energy of the charged form at the pH less that of the neutral one, all other groups neutral, kT.
    pub free_energy_kt: f64,
    /// Neutral forms, if there are two.
    pub tautomers: Option<Tautomers>,
}

/// Charges of a kind of body whose groups take up and lose protons.
///
/// ```
/// use protomer_kernel::Vec3;
/// use protomer_mc::titratable::{TitratableCharges, TitratableGroup};
/// // An acid of pKa 4 at pH 5, next to a fixed charge.
/// let acid = TitratableGroup {
///     change_e: vec![(1, -1.0)],
///     free_energy_kt: -10_f64.ln(),
///     tautomers: None,
/// };
/// let sites = [(Vec3::x(), 2.0), (-Vec3::x(), 0.0)];
/// let body = TitratableCharges::new(&sites, vec![acid], vec![0.0], vec![0.0])?;
/// assert_eq!(body.charges(&[true]).net_charge_e(), 1.0);
/// assert_eq!(body.start(), [true]);
/// # Ok::<(), protomer_mc::McError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct TitratableCharges {
    sites: Vec<(Vec3, f64)>,
    groups: Vec<TitratableGroup>,
    pair_kt: Vec<f64>,
    tautomer_pair_kt: Vec<f64>,
    sum_of_magnitudes_e: f64,
    radius_angstrom: f64,
}

impl TitratableCharges {
    /// A kind of body from its sites (position in Å, charge in e with all groups neutral), its groups, the interactions of
    /// charged forms and those of half the tautomer difference (row) with charged forms, both `groups × groups` in kT.
    ///
    /// # Errors
    /// [`McError::BadSystem`] for a group of a site that does not exist, a number that is not finite, and tables of
    /// another size.
    pub fn new(
        sites: &[(Vec3, f64)],
        groups: Vec<TitratableGroup>,
        pair_kt: Vec<f64>,
        tautomer_pair_kt: Vec<f64>,
    ) -> Result<Self> {
        let squared = groups.len() * groups.len();
        let changes = || groups.iter().flat_map(|group| &group.change_e);
        let problem = if pair_kt.len() != squared || tautomer_pair_kt.len() != squared {
            "tables of interactions of another size than the number of its groups squared"
        } else if changes().any(|(site, _)| *site >= sites.len()) {
            "a titratable group of a site that does not exist"
        } else if !changes()
            .map(|(_, charge_e)| charge_e)
            .chain(groups.iter().map(|group| &group.free_energy_kt))
            .chain(pair_kt.iter().chain(&tautomer_pair_kt))
            .all(|number| number.is_finite())
        {
            "titratable groups with numbers that are not finite"
        } else {
            let fixed_e: f64 = sites.iter().map(|(_, charge_e)| charge_e.abs()).sum();
            let changed_e: f64 = changes().map(|(_, charge_e)| charge_e.abs()).sum();
            let distances = sites.iter().map(|(place, _)| place.norm());
            return Ok(Self {
                sum_of_magnitudes_e: fixed_e + changed_e,
                radius_angstrom: distances.fold(0.0, f64::max),
                sites: sites.to_vec(),
                groups,
                pair_kt,
                tautomer_pair_kt,
            });
        };
        Err(McError::BadSystem(format!("a body has {problem}")))
    }

    /// Number of groups.
    pub fn len(&self) -> usize {
        self.groups.len()
    }

    /// Whether there are no groups.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// Upper limit of the sum of the magnitudes of the charges in any state, e.
    pub(crate) fn sum_of_magnitudes_e(&self) -> f64 {
        self.sum_of_magnitudes_e
    }

    /// Radius of the sphere around the body's origin that encloses all sites, Å.
    pub(crate) fn radius_angstrom(&self) -> f64 {
        self.radius_angstrom
    }

    /// The state in which each group has the form that is the more stable with all others neutral.
    pub fn start(&self) -> Vec<bool> {
        let charged = self.groups.iter().map(|group| {
            let neutral_kt = group.tautomers.map_or(0.0, |forms| forms.energy_kt(0.0));
            group.free_energy_kt < neutral_kt
        });
        charged.collect()
    }

    /// Free energy of a state, kT.
    pub fn energy_kt(&self, states: &[bool]) -> f64 {
        let of_charged = |table: &[f64], group: usize, until: usize| -> f64 {
            let row = &table[group * self.len()..][..until];
            let charged = row.iter().zip(states).filter(|(_, state)| **state);
            charged.map(|(energy_kt, _)| energy_kt).sum()
        };
        let mut energy_kt = 0.0;
        for (index, group) in self.groups.iter().enumerate() {
            if states[index] {
                energy_kt += group.free_energy_kt + of_charged(&self.pair_kt, index, index);
            } else if let Some(forms) = group.tautomers {
                let field_kt = of_charged(&self.tautomer_pair_kt, index, self.len());
                energy_kt += forms.energy_kt(field_kt);
            }
        }
        energy_kt
    }

    /// The charges in a state.
    pub fn charges(&self, states: &[bool]) -> ChargeCloud {
        let mut sites = self.sites.clone();
        for (group, is_charged) in self.groups.iter().zip(states) {
            if *is_charged {
                for (site, charge_e) in &group.change_e {
                    sites[*site].1 += charge_e;
                }
            }
        }
        ChargeCloud::new(&sites)
    }

    /// Charges that some groups add when they reach these states from the others.
    pub(crate) fn change(&self, groups: &[usize], states: &[bool]) -> ChargeCloud {
        let mut charges = Vec::new();
        for group in groups {
            let sign = if states[*group] { 1.0 } else { -1.0 };
            for (site, charge_e) in &self.groups[*group].change_e {
                charges.push((self.sites[*site].0, sign * charge_e));
            }
        }
        ChargeCloud::new(&charges)
    }
}
