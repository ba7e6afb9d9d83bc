//! Integration tests of `protomer-results`, one module per subject.

#![allow(clippy::panic, clippy::unwrap_used, reason = "tests fail by panicking")]

mod life;
mod walk;
