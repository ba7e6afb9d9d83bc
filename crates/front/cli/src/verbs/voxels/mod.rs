//! The verbs of voxels.

pub mod merge;
pub mod voxelize;
