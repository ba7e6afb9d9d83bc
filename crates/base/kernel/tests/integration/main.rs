//! Integration tests of `protomer-kernel`, one module per subject.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unwrap_used,
    reason = "tests fail by panicking"
)]

mod exact_overlap;
mod overlap;
mod overlap_support;
mod separation;
mod swept;
mod zero_density;
