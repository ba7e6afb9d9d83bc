//! Structures as voxel sets, and networks trained on them.
//!
//! ```text
//! manifest --voxelize--> voxel set --train--> run directory with weights --predict--> scores
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`voxels`] | sparse voxel grids of structures, as samples for training |
//! | [`learning`] | networks: training, search for settings, prediction |
//!
//! The grids are made by `protomer-field`; the networks are in `protomer-learn`.

pub mod learning;
pub mod voxels;
