/// Why an interaction cannot be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The repulsion diverges at contact.
    #[error("the bodies touch or overlap, where the repulsion is infinite; move them apart")]
    Overlap,
    /// A polygon and a polyhedron.
    #[error("one body has two dimensions and the other three; give both the same number")]
    MixedDimensions,
}

/// The result of an operation on bodies.
pub type Result<T> = std::result::Result<T, Error>;
