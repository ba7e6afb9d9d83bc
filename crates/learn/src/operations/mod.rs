//! The operations of the network on grids, (sample, channel, depth, height, width), on any device.
//!
//! [`portable`] composes them of the tensor library's own operations; that is the route on devices
//! other than the processor, and the twin of the fused route of [`crate::block`] in the tests.
//! Pooling picks the first of equal values, through an index and a gather: the tensor library's
//! reductions give the gradient to every one of equal values.

pub mod portable;

pub use portable::{
    average_pool3d, convolution3d, global_average_pool, global_maximum_pool, group_norm, max_pool3d,
};
