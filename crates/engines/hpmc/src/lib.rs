//! Monte Carlo of many hard bodies.
//!
//! ```text
//! Shape + rounding --HardBody--> bodies --start--> System --sweeps--> samples: Z, free volumes, insertions
//! UnitCell --Crystal--> System --springs of rising strength--> free energy of a crystal
//! free volume theory --common_tangent--> coexisting packing fractions
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | [`body`] | a hard body, ready for tests of overlap |
//! | [`mixture`] | kinds of bodies, and which body is of which |
//! | `ellipsoids` | whether two ellipsoids overlap |
//! | [`pieces`] | convex pieces, and bodies made of several of them |
//! | [`reservoir`] | kinds of depletants |
//! | [`box_moves`] | changes of the box at constant pressure |
//! | [`system`] | bodies in a periodic box, and proposals of moves |
//! | `trial` | one trial move |
//! | [`crystal`] | unit cells, by name or of one's own, and crystals made of them |
//! | [`start`] | the start of a run |
//! | [`field`] | potentials that act on each body: gravity |
//! | [`potential`] | energies of pairs of bodies |
//! | [`compression`] | the pressure by trial compressions |
//! | [`heights`] | bodies between walls |
//! | [`depletants`] | implicit penetrable hard spheres, sampled exactly |
//! | [`simulation`] | equilibration, production, samples |
//! | [`static_free_volume`] | the free volume of depletants in a crystal that does not move |
//! | [`symmetry`] | the rotations that leave a body as it is, and what holds its orientation |
//! | [`einstein`] | bodies on springs, and their free energy |
//! | [`frenkel_ladd`] | the free energy of a crystal, by springs of falling strength |
//! | [`equation_of_state`] | free energies of fluids by integration |
//! | [`polynomial`] | polynomials fitted to measured values, as smooth as their errors allow |
//! | [`measured_phase`] | free energies of phases from what simulations measured |
//! | [`tangent`] | coexistence by common tangents |
//! | [`free_volume_theory`] | phases of spheres and depletants by theory |
//! | [`virial`] | virial coefficients without a closed form |
//!
//! Bodies have two dimensions or three, the constant `D`. Lengths are in the unit of the shape, energies
//! in kT.

pub mod body;
pub mod box_moves;
pub mod compression;
pub mod crystal;
pub mod depletants;
pub mod einstein;
mod ellipsoids;
pub mod equation_of_state;
mod error;
pub mod field;
pub mod free_volume_theory;
pub mod frenkel_ladd;
mod grid;
pub mod heights;
pub mod measured_phase;
pub mod mixture;
pub mod pieces;
pub mod polynomial;
pub mod potential;
pub mod reservoir;
pub mod simulation;
pub mod start;
pub mod static_free_volume;
pub mod symmetry;
pub mod system;
pub mod tangent;
mod trial;
pub mod virial;

pub use error::{Error, Result};
