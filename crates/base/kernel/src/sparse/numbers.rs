//! What a factorisation fills and a solution uses: the numbers of one matrix.

use super::front::{BLOCK, LANES};

/// All values that change from matrix to matrix.
#[derive(Debug, Clone)]
pub(super) struct Numbers {
    /// The tiles of all fronts.
    pub values: Vec<f64>,
    /// The pivots D, and their inverses.
    pub pivots: Vec<f64>,
    pub inverse: Vec<f64>,
    /// Left-overs that fronts pass to their parents.
    pub left_overs: Vec<f64>,
    /// Four rows of D Lᵀ.
    pub packed: Vec<[f64; BLOCK]>,
    /// A right-hand side in the order of elimination, and the part of it that a front sees.
    pub permuted: Vec<f64>,
    pub front_values: Vec<[f64; LANES]>,
    /// Sums of a back substitution, lane by lane.
    pub sums: Vec<[f64; LANES]>,
}
