//! Contact dynamics of convex bodies.
//!
//! | module | one idea |
//! |---|---|
//! | [`pair`] | the repulsion of two bodies: energy, force and torques, in three forms |
//!
//! Energies are in units of ε, lengths in the unit of the shapes.

mod error;
pub mod pair;

pub use error::{Error, Result};
