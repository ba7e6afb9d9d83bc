//! Two-dimensional crystals of rigid squares joined by rods, and rod-and-hinge frameworks.
//!
//! | module | one idea |
//! |---|---|
//! | [`framework`] | periodic networks of springs and hinges: elastic constants, mechanisms, loads |
//! | [`lattice`] | rigid impenetrable squares whose corners are joined by massless rigid rods: their dynamics |
//! | [`analysis`] | what their motion shows: modes, synchronisation, strain, chaos, and the exact coherent orbit |
//!
//! The lattice lives in reduced units: the half-diagonal of a square is 1, its mass is 1, and time
//! is what follows when velocities are of order one. A scale in Å is recorded where a lattice was
//! made from a body.

pub mod analysis;
mod error;
pub mod framework;
pub mod lattice;

pub use error::{CrystalError, Result};
