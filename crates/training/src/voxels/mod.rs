//! Converts structures to a set of sparse voxel grids.
//!
//! ```text
//! manifest --each structure, in parallel--> work file SET.zarr.work --all done--> SET.zarr
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`manifest`] | the list of structures and labels |
//! | [`settings`] | the settings of the grids |
//! | [`structure`] | one structure to one sample, or the reason for its exclusion |
//! | [`work`] | finished samples, stored until all are done |
//! | [`set`] | writes samples to a zarr group |
//! | [`identity`] | hashes of what sets and samples depend on |
//! | [`origin`] | the parts of manifests that a set contains or lacks |
//! | [`relatives`] | relatives in different clusters |
//! | [`row`] | a manifest entry with the hash of its file |
//! | [`statistics`] | statistics of the channels in the training part |
//! | [`mod@survey`] | how many structures will not fit, and what would take them |
//! | [`mod@merge`] | merges several sets into one |

pub mod identity;
pub mod manifest;
pub mod merge;
pub mod origin;
pub mod records;
pub mod relatives;
pub mod row;
pub mod samples;
pub mod set;
pub mod settings;
pub mod statistics;
pub mod structure;
pub mod survey;
mod voxelize;
pub mod work;

pub use settings::{Fit, Spacing, VoxelizeSettings};
pub use voxelize::{State, VoxelizeReport, open_set, voxelize, work_path};
