//! What energies cost, estimated before a run: the choice between the direct sum and levels.

use crate::stability::run::EnergyMode;
use serde::Serialize;

/// Processor time of one pair of charges in the direct sum, s.
const CHARGE_PAIR_SECONDS: f64 = 1.1e-9;
/// Processor time of a trial move by levels without partners, s.
const LEVELS_MOVE_SECONDS: f64 = 20e-6;
/// Processor time of each partner in a trial move by levels, s.
const LEVELS_PARTNER_SECONDS: f64 = 4e-6;
/// Processor time of each further image of a partner, s.
const LEVELS_IMAGE_SECONDS: f64 = 1.7e-6;
/// Processor time of a table for each charge, s.
const TABLE_CHARGE_SECONDS: f64 = 0.7e-3;
/// Processor time of a table for each potential of a charge at a point, s.
const TABLE_EVALUATION_SECONDS: f64 = 1.0e-9;

/// Processor time of a run's energies at one salt concentration, s: estimates from measurements of
/// this program, good to a factor of about two.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct EnergyCosts {
    /// Time of all moves with direct sums.
    pub direct_seconds: f64,
    /// Time to make the tables of energies by levels, unless they are in the cache.
    pub tables_seconds: f64,
    /// Time of all moves with energies by levels.
    pub levels_seconds: f64,
}

impl EnergyCosts {
    /// Estimates the costs from the number of charges of each type and the potentials that its
    /// table takes ([`evaluations`](protomer_mc::energy::levels::Table::evaluations)), the type of
    /// each body, the number of images (one or more) of a partner that a body meets, and the number
    /// of trial moves.
    ///
    /// ```
    /// use protomer_protein_verbs::stability::run::{EnergyCosts, EnergyMode};
    /// let few_charges = EnergyCosts::estimate(&[(20, 1e8)], &[0, 0], 1.0, 1e6);
    /// assert_eq!(few_charges.fastest(), EnergyMode::Direct);
    /// let all_charges = EnergyCosts::estimate(&[(3000, 2e10)], &[0; 16], 1.0, 1e6);
    /// assert_eq!(all_charges.fastest(), EnergyMode::Calibrated);
    /// ```
    pub fn estimate(
        types: &[(usize, f64)],
        kinds: &[usize],
        images: f64,
        trial_moves: f64,
    ) -> Self {
        let of_bodies = || kinds.iter().map(|kind| types[*kind].0 as f64);
        let bodies = kinds.len().max(1) as f64;
        let (sum, squares) = of_bodies().fold((0.0, 0.0), |(sum, squares), charges| {
            (sum + charges, squares + charges * charges)
        });
        // Each body's trial meets the charges of all others.
        let charge_pairs_per_move = images * (sum * sum - squares) / bodies;
        let tables = types.iter().map(|(charges, evaluations)| {
            *charges as f64 * TABLE_CHARGE_SECONDS + evaluations * TABLE_EVALUATION_SECONDS
        });
        let levels_partner = LEVELS_PARTNER_SECONDS + LEVELS_IMAGE_SECONDS * (images - 1.0);
        let levels_move = LEVELS_MOVE_SECONDS + levels_partner * (bodies - 1.0);
        Self {
            direct_seconds: trial_moves * charge_pairs_per_move * CHARGE_PAIR_SECONDS,
            tables_seconds: tables.sum(),
            levels_seconds: trial_moves * levels_move,
        }
    }

    /// The mode that needs the least time among those with the decisions of the direct sum.
    pub fn fastest(&self) -> EnergyMode {
        match self.direct_seconds <= self.tables_seconds + self.levels_seconds {
            true => EnergyMode::Direct,
            false => EnergyMode::Calibrated,
        }
    }
}
