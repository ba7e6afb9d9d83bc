//! Converts structures to a set of sparse voxel grids.
//!
//! ```text
//! manifest --each structure, in parallel--> work file SET.zarr.work --all done--> SET.zarr
//! ```
//!
//! Of each structure memory holds the line of the manifest, the hash of the file and the place in
//! the work file, about 160 bytes; besides, its warnings or why it was left out.
//!
//! | module | one idea |
//! |---|---|
//! | [`manifest`] | the list of structures and labels |
//! | [`settings`] | the settings of the grids |
//! | [`structure`] | one structure to one sample, or the reason for its exclusion |
//! | [`interface`] | a pose of two bodies to one sample |
//! | [`work`] | finished samples, stored until all are done |
//! | [`body_store`] | bodies made on the way |
//! | [`content`] | what becomes a set: samples and exclusions, one at a time |
//! | `part` | the structures that one process voxelises |
//! | `finished` | the content in the work file |
//! | [`set`] | writes samples to a zarr group |
//! | [`attributes`] | the attributes of a set |
//! | [`columns`] | the columns of the table of properties |
//! | `listed` | a list that is serialised item by item |
//! | [`identity`] | hashes of what sets and samples depend on |
//! | [`origin`] | the parts of manifests that a set contains or lacks |
//! | [`page`] | the page of a set |
//! | [`relatives`] | relatives in different clusters |
//! | [`row`] | a manifest entry with the hash of its file |
//! | [`statistics`] | statistics of the channels in the training part |
//! | [`mod@survey`] | how many structures will not fit, and what would take them |
//! | [`mod@merge`] | merges several sets into one |

pub mod attributes;
pub mod body_store;
pub mod columns;
pub mod content;
mod finished;
pub mod identity;
pub mod interface;
mod listed;
pub mod manifest;
pub mod merge;
pub mod origin;
pub mod page;
mod part;
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
