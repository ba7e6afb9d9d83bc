//! Three-dimensional convolution on the processor, sample by sample, on slices.
//!
//! | module | one idea |
//! |---|---|
//! | `geometry` | shapes, and weights in the order the kernels want |
//! | `lanes` | one kernel for AVX-512, AVX2 and any other processor |
//! | `padded` | grids with zeros around them, and where a sparse one holds anything |
//! | `forward` | forward pass with bias, ReLU and pooling |
//! | `dense` | gradient of the weights from all gradients of the outputs |
//! | `sparse` | gradients of weights and input from the few that pooling leaves |
//! | `buffers` | memory that is used again |
//!
//! The gradient of the input from all gradients of the outputs is a forward pass with the weights
//! turned round (`Geometry::pack_transposed`).
//!
//! Kernels check the lengths of their buffers before they touch them, and panic if these do not
//! fit: that would be a mistake in this crate, and reading on would be worse. Users meet
//! [`crate::block`], which returns errors.

pub(crate) mod buffers;
pub(crate) mod dense;
pub(crate) mod forward;
pub(crate) mod geometry;
pub(crate) mod lanes;
pub(crate) mod padded;
pub(crate) mod sparse;

pub(crate) use geometry::Geometry;
pub use lanes::Level;
