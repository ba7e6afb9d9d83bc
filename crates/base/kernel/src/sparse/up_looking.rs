//! The slow, obvious twin of the factorisation: one row of L after the other, no supernodes.

use super::error::SparseError;
use super::ordering::nested_dissection;

/// Smallest pivot, as a part of its diagonal entry; smaller ones count as zero.
const SMALLEST_PIVOT: f64 = 1e-13;

/// The factorisation L D Lᵀ of a symmetric positive definite matrix by the up-looking method
/// (Davis, ACM Trans. Math. Softw. 31, 587 (2005)): row k of L solves L(1..k-1) y = A(1..k-1, k); D
/// and L follow by division.
#[derive(Debug, Clone)]
pub(super) struct UpLooking {
    /// The unknown that is eliminated at each step.
    order: Vec<usize>,
    /// The entries (column, index) of each row of the permuted lower triangle.
    rows: Vec<Vec<(usize, usize)>>,
    /// L by columns: (row, number), rows ascending.
    columns: Vec<Vec<(usize, f64)>>,
    diagonal: Vec<f64>,
}

impl UpLooking {
    /// Prepares for matrices as [`LdlFactor::new`](super::LdlFactor::new) does.
    pub(super) fn new(dimension: usize, entries: &[(usize, usize)], places: &[[f64; 3]]) -> Self {
        let mut neighbours = vec![Vec::new(); dimension];
        for &(row, column) in entries.iter().filter(|(row, column)| row != column) {
            neighbours[row].push(column);
            neighbours[column].push(row);
        }
        let order = nested_dissection(&neighbours, places);
        let mut position = vec![0; dimension];
        for (step, unknown) in order.iter().enumerate() {
            position[*unknown] = step;
        }
        let mut rows = vec![Vec::new(); dimension];
        for (index, &(row, column)) in entries.iter().enumerate() {
            let (a, b) = (position[row], position[column]);
            rows[a.max(b)].push((a.min(b), index));
        }
        Self {
            order,
            rows,
            columns: vec![Vec::new(); dimension],
            diagonal: vec![0.0; dimension],
        }
    }

    /// Entries of L below its diagonal that are not zero.
    pub(super) fn fill(&self) -> usize {
        self.columns.iter().map(Vec::len).sum()
    }

    /// Factors the matrix with these numbers, in the order of the entries given at the start.
    ///
    /// # Errors
    /// [`SparseError::Dependent`] names the row whose pivot vanishes; [`SparseError::NotFinite`] a
    /// row with a number that is not finite.
    pub(super) fn factor(&mut self, numbers: &[f64]) -> Result<(), SparseError> {
        for column in &mut self.columns {
            column.clear();
        }
        for k in 0..self.order.len() {
            let mut y = vec![0.0; k + 1];
            for &(column, index) in &self.rows[k] {
                y[column] = numbers[index];
            }
            let diagonal = y[k];
            let mut pivot = diagonal;
            for column in 0..k {
                if y[column] == 0.0 {
                    continue;
                }
                for &(row, number) in &self.columns[column] {
                    y[row] -= number * y[column];
                }
                let entry = y[column] / self.diagonal[column];
                pivot -= entry * y[column];
                self.columns[column].push((k, entry));
            }
            let row = self.order[k];
            if !pivot.is_finite() {
                return Err(SparseError::NotFinite { row });
            }
            if pivot <= SMALLEST_PIVOT * diagonal {
                let pivot = pivot / diagonal;
                return Err(SparseError::Dependent { row, pivot });
            }
            self.diagonal[k] = pivot;
        }
        Ok(())
    }

    /// Replaces b by the solution x for the last matrix factored.
    pub(super) fn solve(&self, b: &mut [f64]) {
        let mut x: Vec<f64> = self.order.iter().map(|unknown| b[*unknown]).collect();
        for (column, entries) in self.columns.iter().enumerate() {
            for (row, number) in entries {
                x[*row] -= number * x[column];
            }
        }
        for (column, entries) in self.columns.iter().enumerate().rev() {
            x[column] /= self.diagonal[column];
            for (row, number) in entries {
                x[column] -= number * x[*row];
            }
        }
        for (value, unknown) in x.iter().zip(&self.order) {
            b[*unknown] = *value;
        }
    }

    /// The logarithm ln det A of the determinant of the last matrix factored.
    pub(super) fn log_determinant(&self) -> f64 {
        self.diagonal.iter().map(|pivot| pivot.ln()).sum()
    }
}
