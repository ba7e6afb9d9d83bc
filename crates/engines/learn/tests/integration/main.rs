//! Integration tests of `protomer-learn`, one module per subject.

#![allow(
    clippy::print_stderr,
    clippy::unwrap_used,
    reason = "tests fail by panicking, and print figures"
)]

mod controls;
mod network;
mod network_blocks;
