//! Integration tests of `protomer-linkage`, one module per subject.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    clippy::unwrap_used,
    reason = "tests fail by panicking, and print figures"
)]

mod analysis;
mod cell;
mod collisions;
mod collisions_paper;
mod collisions_reference;
mod common;
mod framework;
mod framework_ribs;
mod grima;
mod long_runs;
mod potentials;
mod reference;
#[path = "../../../../../tests/test_data.rs"]
mod test_data;
mod thermostat;
