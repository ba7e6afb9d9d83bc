//! Lattices of rigid squares and frameworks of rods and hinges, as runs, tables and figures.
//!
//! | module | one idea |
//! |---|---|
//! | [`lattice`] | lattices of rigid squares: runs, sweeps, pictures |
//! | [`frameworks`] | networks of rods and hinges: elastic constants, loads, figures |
//!
//! The mechanics is in `protomer-linkage`.

pub mod frameworks;
pub mod lattice;
