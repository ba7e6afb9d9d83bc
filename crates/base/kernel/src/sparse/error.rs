//! The error type of factorisations.

/// Errors of a factorisation.
///
/// ```
/// use protomer_kernel::sparse::{LdlFactor, SparseError};
/// let mut factor = LdlFactor::new(2, &[(0, 0), (1, 0), (1, 1)], &[[0.0; 3]; 2]);
/// let singular = factor.factor(&[1.0, 1.0, 1.0]);
/// assert!(matches!(singular, Err(SparseError::Dependent { .. })));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SparseError {
    /// A pivot that is not safely positive: the row depends on others.
    #[error("row {row} depends linearly on other rows (pivot {pivot:e})")]
    Dependent {
        /// The row, in the caller's numbering.
        row: usize,
        /// The pivot, relative to the diagonal entry.
        pivot: f64,
    },
    /// A number that is not finite.
    #[error("row {row} has an entry that is not finite")]
    NotFinite {
        /// The row, in the caller's numbering.
        row: usize,
    },
}
