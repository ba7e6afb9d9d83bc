//! Voxel data sets and a small three-dimensional convolutional network: what do shape, charge and hydropathy predict?
//!
//! ```text
//! samples --split by cluster--> training, validation, test --normalised, turned--> network --> scores beside baselines
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`controls`] | synthetic sets with known answers |
//! | [`sample`] | a sparse voxel grid, what is known of it, and where samples come from |
//!
//! This crate reads and writes no files: samples come through [`sample::SampleSource`], weights leave as tensors.

pub mod controls;
mod error;
pub mod sample;

pub use error::{LearnError, Result};
pub use sample::{Description, InMemory, SampleSource, SparseGrid};
