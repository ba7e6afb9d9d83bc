//! Integration tests of `protomer-md`, one module per subject.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unwrap_used,
    reason = "tests fail by panicking"
)]

mod added;
mod common;
mod degenerate;
mod dynamics;
mod ellipsoids;
mod ensembles;
mod near;
mod pair;
mod poses;
