//! A structure as a cubic grid of voxels: where its surface is, and what it carries there.
//!
//! ```text
//! atoms, residues --turned and centred--> surface --> occupied voxels --> shape, solid, potential, hydropathy in each
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`lattice`] | a cubic grid about the origin |
//! | [`orientation`] | how a structure is turned before it is laid on the grid |
//! | [`shell`] | which voxels the surface passes through |
//! | [`hydropathy`] | Kyte-Doolittle indices around a place |
//! | [`channels`] | all of it: atoms in, sparse values out |

pub mod channels;
pub mod hydropathy;
pub mod lattice;
pub mod orientation;
pub mod shell;

pub use channels::{Channel, PotentialModel, VoxelAtom, VoxelSettings, Voxels, voxelise};
pub use lattice::Lattice;
pub use orientation::Orientation;
