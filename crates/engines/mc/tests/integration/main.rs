//! Integration tests of `protomer-mc`, one module per subject.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "tests fail by panicking, and print figures"
)]

mod averages;
mod bad_input;
mod certified;
mod common;
mod continuation;
mod depletants;
mod levels;
mod many_bodies;
mod pair;
mod parts;
mod regulation;
mod scattering;
mod terms;
#[path = "../../../../../tests/test_data.rs"]
mod test_data;
mod three_ways;
mod two_bodies;
