//! Integration tests of `protomer-shape-verbs`, one module per subject.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unwrap_used,
    reason = "tests fail by panicking"
)]

mod dynamics;
mod hard_bodies;
