//! What can go wrong.

/// The errors of this crate.
#[derive(Debug, thiserror::Error)]
pub enum ConvolutionError {
    /// No kernel of this edge is compiled.
    #[error("a kernel of edge {0}: take 1, 3 or 5")]
    Kernel(usize),
    /// No channels, no outputs or no voxels.
    #[error("a convolution of nothing: {0:?}")]
    Empty(crate::Geometry),
    /// More voxels than a grid can have.
    #[error("{0:?} voxels are too many for one grid")]
    TooLarge([usize; 3]),
}

/// Short for this crate's results.
pub type Result<T> = std::result::Result<T, ConvolutionError>;
