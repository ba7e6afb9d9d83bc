//! The pages of voxel sets, trainings and searches. A build without the feature `learning` has
//! none of them, and neither the tensors nor the sets behind them.

mod training;
mod tune;
mod voxel_channels;
mod voxel_set;

use crate::page::Page;
use anyhow::{Result, bail};
use protomer_learn_verbs::learning::train::TrainSettings;
use protomer_learn_verbs::learning::tune::TuneSettings;
use protomer_learn_verbs::voxels::work_path;
use protomer_results::ResultKind;
use protomer_results::keys::read_toml;
use std::path::Path;

/// The kind of results of learning in a directory.
#[derive(Debug)]
pub enum Learning {
    /// A training.
    Training(Box<TrainSettings>),
    /// A search for settings of a training.
    Search(Box<TuneSettings>),
    /// A set of voxels.
    VoxelSet,
}

impl Learning {
    /// Reads the settings of results of this kind; [`None`] for a kind that is not learning.
    ///
    /// # Errors
    /// If the settings cannot be read.
    pub fn read(kind: &ResultKind, directory: &Path) -> Result<Option<Self>> {
        let settings = directory.join("settings.toml");
        Ok(Some(match kind {
            ResultKind::Training => Self::Training(Box::new(read_toml(&settings)?)),
            ResultKind::Search => Self::Search(Box::new(read_toml(&settings)?)),
            ResultKind::VoxelSet => Self::VoxelSet,
            _ => return Ok(None),
        }))
    }

    /// The page of these results.
    ///
    /// # Errors
    /// If a file of the directory is missing or damaged.
    pub fn page(&self, directory: &Path) -> Result<Page> {
        match self {
            Self::Training(settings) => training::page(directory, settings),
            Self::Search(settings) => tune::page(directory, settings),
            Self::VoxelSet => voxel_set::page(directory),
        }
    }
}

/// Refuses the name of a set that `voxelize` has not finished.
///
/// # Errors
/// If there is such a set.
pub fn require_complete_set(directory: &Path) -> Result<()> {
    if work_path(directory).is_file() {
        let name = directory.display();
        bail!(
            "the set {name} is not complete yet; the same 'protomer voxelize' command continues it"
        );
    }
    Ok(())
}
