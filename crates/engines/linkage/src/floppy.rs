//! Symmetric sparse systems A x = b whose matrix may be singular, for a b that does no work on its
//! null space, as loads and rods do none on floppy motions.
//!
//! A + s 1 is factored once, and refinement takes the shift s out again:
//!
//! ```text
//! x ← x + (A + s 1)⁻¹ (b - A x)
//! ```
//!
//! It converges on what is not floppy, by s/(λ + s) a round, and never touches what is but by rounding:
//! floppy parts of x are off by the rounding of b over s.

use nalgebra::{DMatrix, DVector};
use protomer_kernel::sparse::{LdlFactor, SparseError};

/// Shift added to the diagonal, in parts of the largest diagonal entry.
const SHIFT: f64 = 1e-9;
/// Rounds of refinement that take the shift out again.
const MOST_REFINEMENTS: usize = 60;
/// Refinement ends when this share of the right-hand side is left.
const RESOLVED: f64 = 1e-13;
/// Refinement also ends when a round leaves more than this share of the error before it.
const STALLED: f64 = 0.9;

/// Entries of a lower triangle, by row and column.
pub(crate) type Entries = [(usize, usize)];

/// A positive semidefinite matrix, ready to be solved.
pub(crate) struct FloppySystem {
    entries: Vec<(usize, usize)>,
    numbers: Vec<f64>,
    factor: LdlFactor,
}

impl FloppySystem {
    /// Factors a matrix with these numbers at these entries. `places` says where each unknown is in
    /// space.
    ///
    /// # Errors
    /// [`SparseError::Dependent`] for a matrix that is not positive semidefinite,
    /// [`SparseError::NotFinite`] for numbers that are not finite.
    pub fn new(
        entries: Vec<(usize, usize)>,
        numbers: Vec<f64>,
        places: &[[f64; 3]],
    ) -> Result<Self, SparseError> {
        let mut factor = LdlFactor::new(places.len(), &entries, places);
        let shift = SHIFT * largest_on_diagonal(&entries, &numbers);
        factor.factor(&with_shift(&entries, &numbers, shift))?;
        Ok(Self {
            entries,
            numbers,
            factor,
        })
    }

    /// The solution x of A x = b without a part in the null space.
    pub fn solve(&mut self, b: &DVector<f64>) -> DVector<f64> {
        let mut x = DVector::zeros(b.len());
        let mut residual = b.clone();
        let mut before = f64::INFINITY;
        for _ in 0..MOST_REFINEMENTS {
            let size = residual.norm();
            // Resolved, or no better than the round before.
            if size <= RESOLVED * b.norm() || size > STALLED * before {
                break;
            }
            before = size;
            let mut correction = residual.as_slice().to_vec();
            self.factor.solve(&mut correction);
            x += DVector::from_vec(correction);
            // With the unshifted matrix: the shift is taken out bit by bit.
            residual = b - multiply(&self.entries, &self.numbers, &x);
        }
        x
    }
}

/// A matrix with a shift on its diagonal.
pub(crate) fn with_shift(entries: &Entries, values: &[f64], shift: f64) -> Vec<f64> {
    let mut shifted = values.to_vec();
    for ((row, column), value) in entries.iter().zip(&mut shifted) {
        if row == column {
            *value += shift;
        }
    }
    shifted
}

fn largest_on_diagonal(entries: &Entries, values: &[f64]) -> f64 {
    let mut largest = 0.0_f64;
    for ((row, column), value) in entries.iter().zip(values) {
        if row == column {
            largest = largest.max(value.abs());
        }
    }
    largest
}

fn multiply(entries: &Entries, values: &[f64], x: &DVector<f64>) -> DVector<f64> {
    let mut product = DVector::zeros(x.len());
    for (&(row, column), value) in entries.iter().zip(values) {
        product[row] += value * x[column];
        if row != column {
            product[column] += value * x[row];
        }
    }
    product
}

/// The whole matrix, from its lower triangle.
pub(crate) fn dense(entries: &Entries, values: &[f64], dimension: usize) -> DMatrix<f64> {
    let mut dense = DMatrix::zeros(dimension, dimension);
    for (&(row, column), value) in entries.iter().zip(values) {
        dense[(row, column)] = *value;
        dense[(column, row)] = *value;
    }
    dense
}
