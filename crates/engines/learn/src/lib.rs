//! Voxel data sets and a small three-dimensional convolutional network: what do shape, charge and
//! hydropathy predict?
//!
//! ```text
//! samples --split by cluster--> training, validation, test
//!         --scaled, turned--> network --> scores compared with baselines
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`sample`] | a sparse voxel grid, what is known of it, and where samples come from |
//! | [`view`] | some samples of a set, perhaps under other labels |
//! | [`split`] | parts that keep clusters together; weights of families |
//! | [`targets`] | space groups and what is coarser |
//! | [`number_classes`] | numbers as ordered classes |
//! | [`scaling`] | channels brought to comparable sizes; samples that cannot be used |
//! | [`augmentation`] | the 24 rotations of the cube, exact |
//! | [`operations`] | convolution, pooling and normalisation of grids on any device |
//! | [`block`] | convolution, normalisation, ReLU and pooling as one |
//! | [`network`] | blocks, global pooling, a linear layer |
//! | [`loss`] | cross entropy |
//! | [`normal`] | a number with its spread, and the loss of both |
//! | [`optimiser`] | Adam |
//! | [`device`] | where networks are computed |
//! | [`training`] | the loop, its checkpoints, and trained models |
//! | [`scores`], [`calibration`] | how good probabilities are, and how honest |
//! | [`number_scores`] | how near predicted numbers come to the true ones |
//! | [`baselines`], [`logistic`], [`ridge`] | what is predicted without a network |
//! | [`bootstrap`], [`permutation`] | intervals over clusters; could it be chance? |
//! | [`advantage`] | whether the network is better than the best baseline |
//! | [`predictions`], [`evaluation`] | all of this for the test part |
//! | [`ablation`] | what each channel brings |
//! | [`trial`], [`halving`] | a search for settings: what is drawn, and who goes on |
//! | [`novelty`] | which samples of another set are new to a network |
//! | [`controls`] | synthetic sets with known answers |
//!
//! This crate reads and writes no files: samples come through [`sample::SampleSource`], weights
//! leave as tensors.

pub mod ablation;
pub mod advantage;
pub mod augmentation;
pub mod baselines;
pub mod block;
pub mod bootstrap;
pub mod calibration;
pub mod controls;
pub mod device;
mod error;
pub mod evaluation;
pub mod halving;
pub mod logistic;
pub mod loss;
pub mod network;
pub mod normal;
pub mod novelty;
pub mod number_classes;
pub mod number_scores;
mod numbers;
pub mod operations;
pub mod optimiser;
pub mod permutation;
pub mod predictions;
pub mod ridge;
pub mod sample;
pub mod scaling;
pub mod scores;
pub mod split;
pub mod targets;
pub mod training;
pub mod trial;
pub mod view;

pub use block::BlockSettings;
pub use candle_core::Device;
pub use error::{LearnError, Result};
pub use loss::cross_entropy;
pub use network::{GlobalPooling, Network, NetworkSettings};
pub use optimiser::{Adam, AdamSettings};
pub use sample::{Description, InMemory, SampleSource, SparseGrid};
pub use view::View;
