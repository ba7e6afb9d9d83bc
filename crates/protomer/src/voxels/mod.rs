//! Structures to a set of sparse voxel grids.
//!
//! ```text
//! manifest --each structure, in parallel--> work file SET.zarr.work --all done--> SET.zarr
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`manifest`] | which structures, and what is known of them |
//! | [`settings`] | what to make of each |
//! | [`structure`] | one structure to one sample, or the reason why not |
//! | [`work`] | finished samples, kept until all are done |
//! | [`set`] | samples to a zarr group |
//! | [`identity`] | what sets and samples depend on, hashed |
//! | [`origin`] | what a set has of its manifests, and what it lacks |
//! | [`relatives`] | relatives in different clusters |
//! | [`row`] | a line of a manifest, wherever it stands by now |
//! | [`statistics`] | what values its channels have in the training part |
//! | [`mod@merge`] | several sets to one |

pub mod identity;
pub mod manifest;
pub mod merge;
pub mod origin;
pub mod relatives;
pub mod row;
pub mod samples;
pub mod set;
pub mod settings;
pub mod statistics;
pub mod structure;
mod voxelize;
pub mod work;

pub use settings::{Fit, Spacing, VoxelizeSettings};
pub use voxelize::{State, VoxelizeReport, open_set, voxelize, work_path};
