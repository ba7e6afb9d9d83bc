//! The slow, obvious twin of the factorisation: one row of L after the other, no supernodes.

use super::{SparseError, nested_dissection};

/// A pivot below this part of its diagonal entry counts as zero.
const SMALLEST_PIVOT: f64 = 1e-13;

/// L D Lᵀ of a symmetric positive definite matrix with a fixed pattern, by the up-looking method
/// (Davis, ACM Trans. Math. Softw. 31, 587 (2005)): row k of L solves L(1..k-1) y = A(1..k-1, k), D
/// and L follow by division.
#[derive(Debug, Clone)]
pub(super) struct UpLooking {
    /// Which unknown is eliminated at each step.
    order: Vec<usize>,
    /// Upper triangle of the permuted matrix by columns: rows, and where in the caller's list the
    /// number is.
    upper_starts: Vec<usize>,
    upper: Vec<(u32, u32)>,
    /// The elimination tree; the length of the list for roots.
    parent: Vec<u32>,
    /// L by columns.
    starts: Vec<usize>,
    rows: Vec<u32>,
    values: Vec<f64>,
    diagonal: Vec<f64>,
    inverse_diagonal: Vec<f64>,
    work: Workspace,
}

#[derive(Debug, Clone)]
struct Workspace {
    y: Vec<f64>,
    flag: Vec<u32>,
    pattern: Vec<u32>,
    filled: Vec<usize>,
    permuted: Vec<f64>,
}

impl UpLooking {
    /// Prepares for matrices of this dimension with entries at these places of the lower triangle
    /// (row ≥ column), each place once, every diagonal place among them. `places` says where each
    /// unknown is, for the order of elimination.
    pub(super) fn new(dimension: usize, entries: &[(usize, usize)], places: &[[f64; 3]]) -> Self {
        let mut neighbours = vec![Vec::new(); dimension];
        for &(row, column) in entries.iter().filter(|(row, column)| row != column) {
            neighbours[row].push(column);
            neighbours[column].push(row);
        }
        let order = nested_dissection(&neighbours, places);
        let mut position = vec![0_u32; dimension];
        for (step, unknown) in order.iter().enumerate() {
            position[*unknown] = step as u32;
        }
        let mut by_column: Vec<Vec<(u32, u32)>> = vec![Vec::new(); dimension];
        for (index, &(row, column)) in entries.iter().enumerate() {
            let (a, b) = (position[row], position[column]);
            by_column[a.max(b) as usize].push((a.min(b), index as u32));
        }
        let mut upper_starts = vec![0];
        let mut upper = Vec::with_capacity(entries.len());
        for mut column in by_column {
            column.sort_unstable();
            upper.extend(column);
            upper_starts.push(upper.len());
        }
        let (parent, counts) = elimination_tree(dimension, &upper_starts, &upper);
        let mut starts = vec![0; dimension + 1];
        for (column, count) in counts.iter().enumerate() {
            starts[column + 1] = starts[column] + count;
        }
        let size = starts[dimension];
        let work = Workspace {
            y: vec![0.0; dimension],
            flag: vec![u32::MAX; dimension],
            pattern: vec![0; dimension],
            filled: vec![0; dimension],
            permuted: vec![0.0; dimension],
        };
        Self {
            order,
            upper_starts,
            upper,
            parent,
            starts,
            rows: vec![0; size],
            values: vec![0.0; size],
            diagonal: vec![0.0; dimension],
            inverse_diagonal: vec![0.0; dimension],
            work,
        }
    }

    /// Entries of L below its diagonal.
    pub(super) fn fill(&self) -> usize {
        self.values.len()
    }

    /// Factors the matrix with these numbers, in the order of the entries given at the start.
    ///
    /// # Errors
    /// [`SparseError::Dependent`] names the row whose pivot vanishes; [`SparseError::NotFinite`] a
    /// row with a number that is not finite. The factor must not be used then.
    pub(super) fn factor(&mut self, numbers: &[f64]) -> Result<(), SparseError> {
        let n = self.order.len();
        let Workspace {
            y,
            flag,
            pattern,
            filled,
            ..
        } = &mut self.work;
        flag.fill(u32::MAX);
        filled.copy_from_slice(&self.starts[..n]);
        for k in 0..n {
            let mut top = n;
            flag[k] = k as u32;
            let mut own = 0.0;
            for &(row, index) in &self.upper[self.upper_starts[k]..self.upper_starts[k + 1]] {
                let number = numbers[index as usize];
                if row as usize == k {
                    own = number;
                    continue;
                }
                y[row as usize] = number;
                // Walk up the tree: the pattern of row k of L.
                let (mut i, mut length) = (row, 0);
                while flag[i as usize] != k as u32 {
                    pattern[length] = i;
                    length += 1;
                    flag[i as usize] = k as u32;
                    i = self.parent[i as usize];
                }
                while length > 0 {
                    top -= 1;
                    length -= 1;
                    pattern[top] = pattern[length];
                }
            }
            let mut pivot = own;
            for &column in &pattern[top..n] {
                let i = column as usize;
                let yi = y[i];
                y[i] = 0.0;
                let (start, end) = (self.starts[i], filled[i]);
                for (row, value) in self.rows[start..end].iter().zip(&self.values[start..end]) {
                    y[*row as usize] -= value * yi;
                }
                let entry = yi * self.inverse_diagonal[i];
                pivot -= entry * yi;
                self.rows[end] = k as u32;
                self.values[end] = entry;
                filled[i] += 1;
            }
            let positive = pivot.is_finite() && pivot > SMALLEST_PIVOT * own;
            if !positive {
                y.fill(0.0);
                let row = self.order[k];
                let dependent = SparseError::Dependent {
                    row,
                    pivot: pivot / own,
                };
                return Err(if pivot.is_finite() {
                    dependent
                } else {
                    SparseError::NotFinite { row }
                });
            }
            self.diagonal[k] = pivot;
            self.inverse_diagonal[k] = 1.0 / pivot;
        }
        Ok(())
    }

    /// Replaces b by the solution x of the last matrix factored.
    pub(super) fn solve(&mut self, b: &mut [f64]) {
        let n = self.order.len();
        let x = &mut self.work.permuted;
        for (target, unknown) in x.iter_mut().zip(&self.order) {
            *target = b[*unknown];
        }
        for column in 0..n {
            let value = x[column];
            let range = self.starts[column]..self.starts[column + 1];
            for (row, entry) in self.rows[range.clone()].iter().zip(&self.values[range]) {
                x[*row as usize] -= entry * value;
            }
        }
        for column in (0..n).rev() {
            let range = self.starts[column]..self.starts[column + 1];
            let mut value = x[column] * self.inverse_diagonal[column];
            for (row, entry) in self.rows[range.clone()].iter().zip(&self.values[range]) {
                value -= entry * x[*row as usize];
            }
            x[column] = value;
        }
        for (value, unknown) in x.iter().zip(&self.order) {
            b[*unknown] = *value;
        }
    }

    /// ln det A of the last matrix factored.
    pub(super) fn log_determinant(&self) -> f64 {
        self.diagonal.iter().map(|pivot| pivot.ln()).sum()
    }
}

/// The parent of each column in the elimination tree, and the number of entries below the diagonal
/// of each column of L.
fn elimination_tree(
    dimension: usize,
    starts: &[usize],
    upper: &[(u32, u32)],
) -> (Vec<u32>, Vec<usize>) {
    let none = dimension as u32;
    let mut parent = vec![none; dimension];
    let mut flag = vec![u32::MAX; dimension];
    let mut counts = vec![0; dimension];
    for k in 0..dimension {
        flag[k] = k as u32;
        for &(row, _) in &upper[starts[k]..starts[k + 1]] {
            let mut i = row as usize;
            while flag[i] != k as u32 {
                if parent[i] == none {
                    parent[i] = k as u32;
                }
                counts[i] += 1;
                flag[i] = k as u32;
                i = parent[i] as usize;
            }
        }
    }
    (parent, counts)
}
