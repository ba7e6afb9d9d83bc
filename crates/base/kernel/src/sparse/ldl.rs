//! L and D of one matrix after another with the same pattern.

use super::error::SparseError;
use super::factorisation::{BadPivot, factor};
use super::front::LANES;
use super::numbers::Numbers;
use super::solution::solve;
use super::symbolic::Symbolic;

/// The factorisation L D Lᵀ of a symmetric positive definite matrix with a fixed pattern, by the
/// multifrontal method with supernodes (Duff and Reid, ACM Trans. Math. Softw. 9, 302 (1983)).
///
/// Results are the same on every processor, and do not depend on what was factored before.
///
/// ```
/// use protomer_kernel::sparse::LdlFactor;
/// // 4 x + y = 6, x + 3 y = 7
/// let mut factor = LdlFactor::new(2, &[(0, 0), (1, 0), (1, 1)], &[[0.0; 3]; 2]);
/// factor.factor(&[4.0, 1.0, 3.0])?;
/// let mut x = [6.0, 7.0];
/// factor.solve(&mut x);
/// assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 2.0).abs() < 1e-15);
/// # Ok::<(), protomer_kernel::sparse::SparseError>(())
/// ```
#[derive(Debug, Clone)]
pub struct LdlFactor {
    pub(super) symbolic: Symbolic,
    pub(super) numbers: Numbers,
}

impl LdlFactor {
    /// Prepares for matrices of this dimension with entries at these places of the lower triangle
    /// (row ≥ column). Each place is given once, and every place of the diagonal is among them.
    /// `places` says where each unknown is in space, for the order of elimination.
    pub fn new(dimension: usize, entries: &[(usize, usize)], places: &[[f64; 3]]) -> Self {
        let symbolic = Symbolic::new(dimension, entries, places);
        let numbers = Numbers {
            values: vec![0.0; symbolic.values_size],
            pivots: vec![0.0; dimension],
            inverse: vec![0.0; dimension],
            left_overs: vec![0.0; symbolic.left_size],
            packed: Vec::new(),
            permuted: vec![0.0; dimension],
            front_values: vec![[0.0; LANES]; symbolic.tallest],
            sums: Vec::new(),
        };
        Self { symbolic, numbers }
    }

    /// Number of unknowns.
    ///
    /// ```
    /// use protomer_kernel::sparse::LdlFactor;
    /// let factor = LdlFactor::new(2, &[(0, 0), (1, 0), (1, 1)], &[[0.0; 3]; 2]);
    /// assert_eq!(factor.dimension(), 2);
    /// ```
    pub fn dimension(&self) -> usize {
        self.symbolic.order.len()
    }

    /// Entries of L below its diagonal, including the zeros that fronts hold.
    pub fn fill(&self) -> usize {
        let mut entries = 0;
        for front in &self.symbolic.fronts {
            let columns = front.shape.columns;
            entries += columns * front.shape.below() + columns * (columns - 1) / 2;
        }
        entries
    }

    /// Multiplications (each with an addition) of one factorisation.
    pub fn multiplications(&self) -> f64 {
        let mut multiplications = 0.0;
        for front in &self.symbolic.fronts {
            for column in 1..=front.shape.columns {
                let below = (front.shape.height - column) as f64;
                multiplications += below * (below + 1.0) / 2.0;
            }
        }
        multiplications
    }

    /// Number of fronts.
    pub fn fronts(&self) -> usize {
        self.symbolic.fronts.len()
    }

    /// Factors the matrix with these numbers, in the order of the entries given at the start.
    ///
    /// ```
    /// use protomer_kernel::sparse::{LdlFactor, SparseError};
    /// let mut factor = LdlFactor::new(2, &[(0, 0), (1, 0), (1, 1)], &[[0.0; 3]; 2]);
    /// assert!(factor.factor(&[4.0, 1.0, 3.0]).is_ok());
    /// let refused = factor.factor(&[1.0, 1.0, 1.0]);
    /// assert!(matches!(refused, Err(SparseError::Dependent { .. })), "its rows are equal");
    /// ```
    ///
    /// # Errors
    /// [`SparseError::Dependent`] names the row whose pivot vanishes; [`SparseError::NotFinite`] a
    /// row with a number that is not finite. The factor must not be used then.
    pub fn factor(&mut self, numbers: &[f64]) -> Result<(), SparseError> {
        factor(&self.symbolic, &mut self.numbers, numbers).map_err(|bad| self.describe(bad))
    }

    fn describe(
        &self,
        BadPivot {
            step,
            pivot,
            diagonal,
        }: BadPivot,
    ) -> SparseError {
        let row = self.symbolic.order[step] as usize;
        if pivot.is_finite() && diagonal.is_finite() {
            let pivot = pivot / diagonal;
            SparseError::Dependent { row, pivot }
        } else {
            SparseError::NotFinite { row }
        }
    }

    /// Replaces b by the solution x for the last matrix factored.
    ///
    /// ```
    /// use protomer_kernel::sparse::LdlFactor;
    /// let mut factor = LdlFactor::new(2, &[(0, 0), (1, 1)], &[[0.0; 3]; 2]);
    /// factor.factor(&[2.0, 4.0])?;
    /// let mut b = [6.0, 8.0];
    /// factor.solve(&mut b);
    /// assert_eq!(b, [3.0, 2.0]);
    /// # Ok::<(), protomer_kernel::sparse::SparseError>(())
    /// ```
    pub fn solve(&mut self, b: &mut [f64]) {
        solve(&self.symbolic, &mut self.numbers, b);
    }

    /// The logarithm ln det A of the determinant of the last matrix factored.
    ///
    /// ```
    /// use protomer_kernel::sparse::LdlFactor;
    /// let mut factor = LdlFactor::new(2, &[(0, 0), (1, 0), (1, 1)], &[[0.0; 3]; 2]);
    /// factor.factor(&[4.0, 1.0, 3.0])?;
    /// assert!((factor.log_determinant() - 11.0_f64.ln()).abs() < 1e-14);
    /// # Ok::<(), protomer_kernel::sparse::SparseError>(())
    /// ```
    pub fn log_determinant(&self) -> f64 {
        self.numbers.pivots.iter().map(|pivot| pivot.ln()).sum()
    }
}
