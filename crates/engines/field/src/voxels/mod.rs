//! A structure as a cubic grid of voxels: where its surface is, and which values it has there.
//!
//! ```text
//! atoms, residues --turned and centred--> surface --> occupied voxels --> channels
//! channels: shape, solid, potential, hydropathy, spacing
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`lattice`] | a cubic grid about the origin |
//! | [`orientation`] | how a structure is turned before it is laid on the grid |
//! | [`shell`] | which voxels the surface passes through |
//! | [`hydropathy`] | hydropathy indices, averaged around a place |
//! | `outer` | the potential on the surface, continued from the solvent |
//! | [`interface`] | two bodies in one box about their interface |
//! | [`channels`] | all of it: atoms in, sparse values out |

pub mod channels;
pub mod hydropathy;
pub mod interface;
pub mod lattice;
pub mod orientation;
mod outer;
pub mod shell;

pub use channels::{
    Channel, PotentialModel, VoxelAtom, VoxelSettings, Voxels, voxelise, voxelise_within,
};
pub use lattice::Lattice;
pub use orientation::Orientation;
