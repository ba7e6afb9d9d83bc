//! Monte Carlo of many hard convex bodies.
//!
//! ```text
//! Shape + rounding --HardBody--> bodies --start--> System --sweeps--> samples: Z, free volumes, insertions
//! free volume theory --common_tangent--> coexisting packing fractions
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`body`] | a hard convex body, ready for tests of overlap |
//! | [`system`] | bodies in a periodic box, and trial moves |
//! | [`start`] | the start of a run |
//! | [`compression`] | the pressure by trial compressions |
//! | [`depletants`] | implicit penetrable hard spheres, sampled exactly |
//! | [`simulation`] | equilibration, production, samples |
//! | [`jet`] | numbers with two derivatives |
//! | [`tangent`] | coexistence by common tangents |
//! | [`free_volume_theory`] | phases of spheres and depletants by theory |
//!
//! Bodies have two dimensions or three, the constant `D`. Lengths are in the unit of the shape, energies
//! in kT.

pub mod body;
pub mod compression;
pub mod depletants;
mod error;
pub mod free_volume_theory;
mod grid;
pub mod jet;
pub mod simulation;
pub mod start;
pub mod system;
pub mod tangent;

pub use error::{Error, Result};
