//! The program and the library behind it, a module for each verb or idea. They are one test program,
//! because each test program links the whole project again.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // a test fails by panicking

mod bench;
mod candidates;
#[path = "../common/mod.rs"]
mod common;
mod directories;
mod disk_cache;
mod effective;
mod energies;
mod equilibrium;
mod fluid;
mod framework;
mod inputs;
mod killed;
mod names;
mod numbers;
mod predict;
mod protons;
mod report;
mod residues;
mod score;
mod states;
mod sweep;
mod titrate;
mod train;
mod tune;
mod voxelize;
mod writing;
