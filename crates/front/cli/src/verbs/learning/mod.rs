//! The verbs of learning, and those of the voxel sets it learns from.
//!
//! They are a feature, `learning`, on by default. candle, zarrs, blosc and what they bring are
//! compiled only for them: 120 of 267 crates (`cargo tree -p protomer-cli -e no-dev`, with and
//! without `--no-default-features`).

mod labels;
pub mod predict;
pub mod train;
pub mod tune;
