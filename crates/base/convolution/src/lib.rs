//! Three-dimensional convolution on the processor, sample by sample, on slices.
//!
//! | module | one idea |
//! |---|---|
//! | [`geometry`] | shapes, and weights in the order the kernels want |
//! | [`lanes`] | one kernel for AVX-512, AVX2 and any other processor |
//! | [`padded`] | grids with zeros around them, and where a sparse one holds anything |
//! | [`forward`] | forward pass with bias, ReLU and pooling |
//! | [`dense`] | gradient of the weights from all gradients of the outputs |
//! | [`sparse`] | gradients of weights and input from the few that pooling leaves |
//! | [`buffers`] | memory that is used again |
//!
//! The gradient of the input from all gradients of the outputs is a forward pass with the weights
//! turned round ([`Geometry::pack_transposed`]).
//!
//! A kernel is a value that borrows its buffers and runs on an instruction set, [`Level`]. Only
//! [`Geometry::check`] returns errors: kernels check the lengths of their buffers before they touch
//! them, and panic if these do not fit. That would be a mistake of the caller, and reading on would
//! be worse.
//!
//! The kernels are a separate crate because they cost 32 CPU-seconds to compile in the dev profile.
//! A crate with unit tests is compiled twice, for itself and for its tests; this one has none.

mod error;

pub mod buffers;
pub mod dense;
pub mod forward;
pub mod geometry;
pub mod lanes;
pub mod padded;
pub mod sparse;

pub use error::{ConvolutionError, Result};
pub use geometry::Geometry;
pub use lanes::Level;
