//! Integration tests of `protomer-io`, one module per subject.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unwrap_used,
    reason = "tests fail by panicking"
)]

mod common;
mod container;
mod gsd;
mod large;
mod meshes;
mod points;
#[cfg(feature = "zarr")]
mod zarr;
