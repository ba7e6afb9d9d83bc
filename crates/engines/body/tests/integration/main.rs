//! Integration tests of `protomer-body`, one module per subject.

#![allow(
    clippy::panic,
    clippy::print_stderr,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "tests fail by panicking, and print figures"
)]

mod cofactors;
mod common;
mod small;
mod solids;
mod structure_bundled;
mod structure_fuzz;
mod structure_identity;
mod structure_selection;
mod structure_shared;
mod structure_treatment;
mod structure_write;
mod surface_analytic;
mod surface_excluded;
mod surface_reference;
#[path = "../../../../../tests/test_data.rs"]
mod test_data;
