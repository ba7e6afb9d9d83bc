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
//! | [`operations`] | convolution, pooling and normalisation of grids on any device |
//! | [`block`] | convolution, normalisation, ReLU and pooling as one |
//! | [`network`] | blocks, global pooling, a linear layer |
//! | [`loss`] | cross entropy |
//! | [`optimiser`] | Adam |
//! | [`view`] | some samples and channels of a set |
//!
//! This crate reads and writes no files: samples come through [`sample::SampleSource`], weights leave as tensors.

pub mod block;
pub mod controls;
mod error;
pub mod loss;
pub mod network;
pub mod operations;
pub mod optimiser;
pub mod sample;
pub mod view;

pub use block::BlockSettings;
pub use error::{LearnError, Result};
pub use loss::cross_entropy;
pub use network::{GlobalPooling, Network, NetworkSettings};
pub use optimiser::{Adam, AdamSettings};
pub use sample::{Description, InMemory, SampleSource, SparseGrid};
pub use view::View;
