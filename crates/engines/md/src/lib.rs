//! Contact dynamics of convex bodies.
//!
//! | module | one idea |
//! |---|---|
//! | [`pair`] | the interaction of two bodies: energy, force and torques, in three forms |
//! | [`near`] | the same, fast, for pairs that are looked at step after step |
//! | [`added`] | energies of pairs and of heights in addition to the contacts |
//! | [`body`] | parts, mass and moments of a kind of body |
//! | [`state`] | where bodies are and how they move |
//! | [`start`] | how they begin |
//! | [`neighbours`] | pairs that can feel each other soon |
//! | [`rotation`] | the free rotation of a body |
//! | [`bath`] | ensembles |
//! | [`barostat`] | trials of the volume |
//! | [`engine`] | steps |
//! | [`drift`] | how well the energy is kept |
//!
//! Energies are in units of ε, lengths in the unit of the shapes, the density of bodies is one.

pub mod added;
pub mod barostat;
pub mod bath;
pub mod body;
pub mod drift;
pub mod engine;
mod error;
pub mod near;
pub mod neighbours;
pub mod pair;
pub mod rotation;
pub mod start;
pub mod state;

pub use error::{Error, Result};
