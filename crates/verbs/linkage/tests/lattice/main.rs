//! Lattices in their directories: continued bit for bit, what trajectories and pages hold, what is
//! refused.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr
)]

#[path = "../common/mod.rs"]
mod common;
mod replays;
mod runs;
mod settings;
mod support;
mod sweeps;
#[path = "../../../../../tests/test_data.rs"]
mod test_data;
