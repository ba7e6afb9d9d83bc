//! Two-dimensional crystals of rigid squares joined by rods, and rod-and-hinge frameworks.
//!
//! | module | one idea |
//! |---|---|
//! | [`framework`] | periodic networks of springs and hinges: elastic constants, mechanisms, loads |
//! | [`lattice`] | rigid impenetrable squares whose corners are joined by massless rigid rods: their dynamics |
//! | [`analysis`] | what their motion shows: modes, synchronisation, strain, chaos, and the exact coherent orbit |
//!
//! The lattice is described in reduced units: the half-diagonal of a square is 1, its mass is 1, and
//! the unit of time is the one in which velocities are of order one. Where a square stands for a
//! body, its half-diagonal is known in Å as well.

pub mod analysis;
mod error;
mod floppy;
pub mod framework;
pub mod lattice;
mod plane;

pub use error::{CrystalError, Result};
