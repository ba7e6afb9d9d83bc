//! The one error type of this crate.

/// What can go wrong in the kernels.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum KernelError {
    /// A physical quantity outside the range in which its equation holds.
    #[error("{quantity} is {value}; it must be {requirement}")]
    OutOfRange {
        /// The quantity with its unit, as a user would name it.
        quantity: &'static str,
        /// The value given.
        value: f64,
        /// What is accepted.
        requirement: &'static str,
    },
    /// A mesh that does not bound a solid.
    #[error("the mesh is not a closed, outward-oriented surface: {0}")]
    BadMesh(String),
}

/// The result of a kernel operation.
pub type Result<T> = std::result::Result<T, KernelError>;
