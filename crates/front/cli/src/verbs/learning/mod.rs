//! The verbs of learning, and those of the voxel sets it learns from.
//!
//! They are a feature, `learning`, on by default. candle, zarrs, blosc and what they bring are
//! compiled only for them: 120 of 267 crates (`cargo tree -p protomer-cli -e no-dev`, with and
//! without `--no-default-features`).

mod labels;
mod predict;
mod train;
mod tune;

use super::voxels;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Subcommand;

/// A verb of learning with its flags.
#[derive(Debug, Subcommand)]
pub enum LearningVerb {
    Train(Box<train::TrainArgs>),
    Predict(predict::PredictArgs),
    Tune(Box<tune::TuneArgs>),
    Voxelize(voxels::voxelize::VoxelizeArgs),
    Merge(voxels::merge::MergeArgs),
}

impl LearningVerb {
    /// Runs the verb.
    pub fn run(&self, front: &Front) -> Result<Reply> {
        match self {
            Self::Train(args) => args.run(front),
            Self::Predict(args) => args.run(front),
            Self::Tune(args) => args.run(front),
            Self::Voxelize(args) => args.run(front),
            Self::Merge(args) => args.run(front),
        }
    }
}
