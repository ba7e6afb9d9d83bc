//! Integration tests of `protomer-hpmc`, one module per subject.

#![allow(clippy::unwrap_used, reason = "tests fail by panicking")]

mod box_moves;
mod common;
mod few_bodies;
mod fields;
mod fluids;
mod free_energy;
mod mixtures;
mod pieces;
mod potentials;
mod static_free_volume;
mod theory;
mod virial;
