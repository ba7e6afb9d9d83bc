//! Integration tests of `protomer-field`, one module per subject.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "tests fail by panicking, and print figures"
)]

mod analytic;
mod effective_charges;
mod solvent_response;
#[path = "../../../../../tests/test_data.rs"]
mod test_data;
mod titration;
mod voxels;
