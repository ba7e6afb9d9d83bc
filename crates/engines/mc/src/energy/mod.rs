//! The seam between moves and energies.
//!
//! A model keeps the energy of every pair of bodies, so an old energy is never computed twice, and
//! it decides: the engine draws the random number first and asks "is the change below this
//! budget?". The direct sum answers by summing; a model with bounds may stop as soon as the answer
//! is certain.

pub mod certified;
mod direct;
mod far_energies;
mod far_field;
pub mod levels;
mod none;
mod pair_sum;
mod potential;
pub(crate) mod reach;
mod regulated;
mod residue_contacts;
pub mod terms;
mod with_terms;

pub use direct::DirectSum;
pub use far_field::FarField;
pub use none::NoCharges;
pub use pair_sum::pair_energy_kt;
pub(crate) use potential::SitePotential;
pub use residue_contacts::{BeadPair, ContactPotential};
pub use with_terms::{TermsByType, WithTerms};

use crate::sparse_rows::PairTable;
use crate::system::{Pair, System, Trial};
use crate::{McError, Result};
use protomer_kernel::pose::RelativePose;
use protomer_kernel::random::CounterRng;
use serde::{Deserialize, Serialize};

/// The energy of one pair of bodies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairEnergy {
    /// Index of the first body, the smaller.
    pub first: usize,
    /// Index of the second body.
    pub second: usize,
    /// Energy of the charges, kT.
    pub energy_kt: f64,
    /// Energy of the other terms, kT.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub terms_kt: f64,
    /// Whether the charges of the pair are out of each other's range.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_of_terms_only: bool,
    /// The second body in the frame of the first where the energy was computed, from models that
    /// may compute it again: a group that moves rigidly keeps its energies, while its relative
    /// poses drift by rounding.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub computed_at: Option<RelativePose>,
    /// Relative poses of the images beyond the first that count, where the energy was computed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub images_at: Vec<RelativePose>,
}

impl PairEnergy {
    /// An energy that nobody will compute again.
    pub(crate) fn new(first: usize, second: usize, energy_kt: f64) -> Self {
        Self {
            first,
            second,
            energy_kt,
            terms_kt: 0.0,
            is_of_terms_only: false,
            computed_at: None,
            images_at: Vec::new(),
        }
    }

    /// An energy that may be computed again with the images where they were.
    fn found_at(
        first: usize,
        second: usize,
        energy_kt: f64,
        mut images: impl Iterator<Item = RelativePose>,
    ) -> Self {
        Self {
            computed_at: images.next(),
            images_at: images.collect(),
            ..Self::new(first, second, energy_kt)
        }
    }

    /// The images with which the energy was computed; that of the pair as it stands where none is
    /// known.
    fn images(&self, pair: &Pair<'_>) -> impl Iterator<Item = RelativePose> + '_ {
        let nearest = self.computed_at.unwrap_or_else(|| pair.relative());
        std::iter::once(nearest).chain(self.images_at.iter().copied())
    }

    /// Energy of all terms, kT.
    pub fn total_kt(&self) -> f64 {
        self.energy_kt + self.terms_kt
    }
}

fn is_zero(energy_kt: &f64) -> bool {
    *energy_kt == 0.0
}

/// Keeps the pair energies of a system and decides on moves.
///
/// The engine proposes with [`accept`](EnergyModel::accept) or [`exceeds`](EnergyModel::exceeds)
/// (only for poses without overlap) and then either [`commit`](EnergyModel::commit)s or
/// [`reject`](EnergyModel::reject)s everything proposed since the last of the two. What a decision
/// answers must depend on the poses and the budget only.
pub trait EnergyModel: Send {
    /// The largest distance (Å) of two origins at which bodies of this system interact; zero if
    /// they never do.
    fn range_angstrom(&self, system: &System) -> f64;

    /// Variant of [`range_angstrom`](EnergyModel::range_angstrom) for a model that knows of a
    /// shorter range. Random numbers depend on the range, and may not depend on how energies are
    /// found.
    fn reach_angstrom(&self, system: &System) -> f64 {
        self.range_angstrom(system)
    }

    /// Whether the box, if there is one, suits the interaction.
    ///
    /// # Errors
    /// Says which box would do.
    fn require_room(&self, _system: &System) -> Result<()> {
        Ok(())
    }

    /// Forgets everything and computes the energies of this system.
    ///
    /// # Errors
    /// [`McError::NonFiniteEnergy`] names a pair whose energy is not finite.
    fn reset(&mut self, system: &System) -> Result<()>;

    /// Takes the energies over from [`pairs`](EnergyModel::pairs) of the same system, so that a
    /// continued run makes the decisions of the uninterrupted one, bit for bit. A model whose
    /// energies are exact functions of the poses may compute them again instead.
    ///
    /// # Errors
    /// As [`reset`](EnergyModel::reset).
    fn restore(&mut self, system: &System, pairs: &[PairEnergy]) -> Result<()>;

    /// Whether the total energy would rise by less than `budget_kt` if the trial's body stood where
    /// the trial puts it. `partners` (ascending, without the body itself) holds every body in range
    /// of the new pose or of the present one, and may hold others.
    ///
    /// The Metropolis rule u < exp(-ΔU) is the question for a budget of -ln u.
    ///
    /// # Errors
    /// [`McError::NonFiniteEnergy`] names a pair whose energy is not finite.
    fn accept(&mut self, trial: &Trial<'_>, partners: &[usize], budget_kt: f64) -> Result<bool>;

    /// Whether the energy of the trial's body with this one partner would rise by more than
    /// `threshold_kt` (not negative): the bond of a geometric cluster move.
    ///
    /// # Errors
    /// As [`accept`](EnergyModel::accept).
    fn exceeds(&mut self, trial: &Trial<'_>, partner: usize, threshold_kt: f64) -> Result<bool>;

    /// Takes over the proposed poses of `bodies` (ascending), which moved as rigid groups: energies
    /// among them stay.
    fn commit(&mut self, bodies: &[usize]);

    /// Forgets everything proposed: nothing moved.
    fn reject(&mut self);

    /// The largest bound of a pair energy's error that was used so far, kT; zero for sums.
    fn error_bound_kt(&self, _system: &System) -> f64 {
        0.0
    }

    /// Basis of the decisions of a model that makes them by levels; `None` for other models.
    fn levels(&self) -> Option<LevelReport> {
        None
    }

    /// Memory of what was prepared for this model, bytes; shared tables count once per model.
    fn memory_bytes(&self) -> usize {
        0
    }

    /// The energies of all pairs in range, ascending by (first, second). The system is the one whose
    /// moves the model has followed; what it does not keep is computed again.
    fn pairs(&self, system: &System) -> Vec<PairEnergy>;

    /// The energy of these pairs of the bodies of the last [`reset`](EnergyModel::reset) at other
    /// poses, kT. A function of the poses alone; the model remembers nothing of it.
    ///
    /// # Errors
    /// As [`reset`](EnergyModel::reset).
    fn energy_elsewhere_kt(&self, system: &System, pairs: Pairs<'_>, effort: Effort)
    -> Result<f64>;

    /// Tries to change protons of a body at its place, and says whether it did. `partners` as in
    /// [`accept`](EnergyModel::accept). Models with fixed charges change nothing.
    ///
    /// # Errors
    /// As [`accept`](EnergyModel::accept).
    fn change_protons(
        &mut self,
        _system: &System,
        _body: usize,
        _partners: &[usize],
        _rng: &mut CounterRng,
    ) -> Result<bool> {
        Ok(false)
    }

    /// Titratable groups of each body, true where charged; empty for models with fixed charges.
    fn protonation(&self) -> &[Vec<bool>] {
        &[]
    }

    /// Takes over the [`protonation`](EnergyModel::protonation) of the same system, before
    /// [`restore`](EnergyModel::restore).
    ///
    /// # Errors
    /// [`McError::ForeignCheckpoint`] if the groups are others.
    fn take_protonation(&mut self, _system: &System, states: &[Vec<bool>]) -> Result<()> {
        require_fixed(states)
    }

    /// Net charge of each body, e; `None` for models with fixed charges.
    fn net_charges_e(&self) -> Option<Vec<f64>> {
        None
    }

    /// The energy of the system, kT, summed in the order of [`pairs`](EnergyModel::pairs).
    fn total_kt(&self, system: &System) -> f64 {
        // Not `sum`: that of no pairs is -0.
        let mut total = 0.0;
        for pair in self.pairs(system) {
            total += pair.total_kt();
        }
        total
    }
}

/// Basis of decisions by levels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum LevelReport {
    /// Report of [`Levels`](levels::Levels).
    Calibrated {
        /// Number of decisions at each level.
        decided_by_level: levels::Decided,
        /// The built-in comparison.
        calibration: levels::Calibration,
    },
    /// Report of [`Certified`](certified::Certified).
    Certified {
        /// Number of decisions at each level.
        decided_by_level: certified::DecidedByBounds,
    },
}

/// Accuracy with which an energy is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// Accuracy of 10⁻³ kT for a pair in contact.
    Quick,
    /// Accuracy of the direct sum.
    Full,
}

/// Distance from the threshold, kT, below which a rise of the energy is found with
/// [`Effort::Full`].
const MARGIN_KT: f64 = 0.01;

/// A rise of the energy that is to be compared with a threshold, kT: quickly, and again with the direct
/// sum where that could change the comparison.
pub(crate) fn compared_kt(
    threshold_kt: f64,
    rise_kt: impl Fn(Effort) -> Result<f64>,
) -> Result<f64> {
    // The quick error of a pair is about 10⁻³ kT, a tenth of the margin.
    let quick = rise_kt(Effort::Quick)?;
    match (quick - threshold_kt).abs() < MARGIN_KT {
        true => rise_kt(Effort::Full),
        false => Ok(quick),
    }
}

/// Pairs of bodies that count.
#[derive(Debug, Clone, Copy)]
pub enum Pairs<'a> {
    /// All pairs.
    All,
    /// Pairs with at least one of these bodies (ascending).
    With(&'a [usize]),
}

impl Pairs<'_> {
    fn count(&self, first: usize, second: usize) -> bool {
        match self {
            Pairs::All => true,
            Pairs::With(bodies) => {
                // Ascending by contract, so a bisection; groups may hold hundreds of bodies.
                bodies.binary_search(&first).is_ok() || bodies.binary_search(&second).is_ok()
            }
        }
    }
}

/// Refuses protons of a checkpoint for bodies with fixed charges.
fn require_fixed(states: &[Vec<bool>]) -> Result<()> {
    match states.is_empty() {
        true => Ok(()),
        false => Err(McError::ForeignCheckpoint(
            "its bodies have titratable groups, and these have fixed charges".into(),
        )),
    }
}

/// The sum of what `energy` says of these pairs of a system, kT.
fn sum_of_pairs(
    system: &System,
    pairs: Pairs<'_>,
    mut energy: impl FnMut(&Pair<'_>) -> Result<Option<f64>>,
) -> Result<f64> {
    let mut sum = 0.0;
    for first in 0..system.len() {
        for second in first + 1..system.len() {
            if pairs.count(first, second) {
                sum += energy(&system.pair(first, second))?.unwrap_or(0.0);
            }
        }
    }
    Ok(sum)
}

/// Results of `energy` for every pair of a system.
fn all_pairs<T: Clone>(
    system: &System,
    mut energy: impl FnMut(&Pair<'_>) -> Result<Option<T>>,
) -> Result<PairTable<T>> {
    let mut energies = PairTable::new(system.len());
    for first in 0..system.len() {
        for second in first + 1..system.len() {
            // Pairs out of range take no place in the table: it is sparse in large systems.
            if let Some(value) = energy(&system.pair(first, second))? {
                energies.set(first, second, value);
            }
        }
    }
    Ok(energies)
}

/// The energy if it is finite, otherwise the error that names the pair; the engine adds the step.
fn finite(first: usize, second: usize, energy_kt: f64) -> Result<f64> {
    if energy_kt.is_finite() {
        Ok(energy_kt)
    } else {
        Err(McError::NonFiniteEnergy {
            step: 0,
            first,
            second,
            energy_kt,
        })
    }
}
