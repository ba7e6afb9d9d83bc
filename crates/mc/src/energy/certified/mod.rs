//! Energies as intervals, at a fraction of the direct sum's cost.
//!
//! The direct sum Σ Z_i q_j f(r_ij) θ(r_cut - r_ij) is split in three (see `split.rs`):
//!
//! * near pairs, one by one in double precision (`near.rs`);
//! * the smooth rest of one body's potential, tabulated as polynomials in cubes (`field.rs`,
//!   `sampling.rs`);
//! * the step at the cut-off, by moments and by comparison of the pairs that straddle it
//!   (`window.rs`).
//!
//! What is proven and what is measured: the rounding of the sums is bounded term by term; on which
//! side of the cut-off a pair lies is decided in double precision wherever single precision could
//! be wrong. The error of a cube's polynomial is its largest residual at the 512 samples in it and
//! on its faces times a safety factor of two, and what one charge may hide between samples; that is
//! a measured bound, not a proven one. So is the relative error of near pairs' kernel, which tests
//! hold against the portable one. The test `intervals_of_large_bodies_contain_the_direct_sum` asks
//! of 100 pairs of bodies with 3000 charges each, near contact and apart, that the error is below a
//! tenth of its bound.
#![allow(
    clippy::needless_range_loop,
    reason = "a lane runs through several arrays at once"
)]

mod field;
mod leaves;
mod model;
mod near;
mod pair;
mod sampling;
mod split;
mod storage;
mod window;

pub use model::{CertifiedSum, Counts};
pub use pair::{ChargeTable, EnergyInterval};
