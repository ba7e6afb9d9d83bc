//! The kind of results in a directory, with their settings.

use anyhow::{Result, bail};
use protomer::file_kind::FileKind;
use protomer::stability::run::RunSettings;
use protomer_lattices::lattice::settings::LatticeSettings;
use protomer_results::ResultKind;
use protomer_results::keys::read_toml;
use protomer_training::learning::train::TrainSettings;
use protomer_training::learning::tune::TuneSettings;
use protomer_training::voxels::work_path;
use std::path::Path;

/// The kind of results in a directory.
#[derive(Debug)]
pub enum Kind {
    /// A simulation of bodies, or a sweep of simulations.
    MonteCarlo(Box<RunSettings>),
    /// The thermodynamics of two bodies.
    Pair,
    /// A run of a lattice.
    Lattice(Box<LatticeSettings>),
    /// A sweep of lattices.
    LatticeSweep(Box<LatticeSettings>),
    /// The elastic constants of a network.
    Framework,
    /// The tables of a paper on networks.
    FrameworkTables,
    /// A training.
    Training(Box<TrainSettings>),
    /// A search for settings of a training.
    Tune(Box<TuneSettings>),
    /// A set of voxels.
    VoxelSet,
}

/// Determines the kind of results in a directory.
///
/// # Errors
/// If it holds none of these, or its settings cannot be read.
pub fn of(directory: &Path) -> Result<Kind> {
    if !directory.is_dir() {
        if work_path(directory).is_file() {
            let name = directory.display();
            bail!(
                "the set {name} is not complete yet; the same 'protomer voxelize' command continues it"
            );
        }
        FileKind::Results(ResultKind::Sweep).require(directory)?;
        bail!(
            "{} is not a directory; give one that protomer wrote its results into",
            directory.display()
        );
    }
    let settings = |name: &str| directory.join(name);
    Ok(match ResultKind::of(directory) {
        Some(ResultKind::Sweep) => Kind::MonteCarlo(Box::new(read_toml(&settings("run.toml"))?)),
        Some(ResultKind::Pair) => Kind::Pair,
        Some(ResultKind::LatticeRun) => Kind::Lattice(Box::new(read_toml(&settings("run.toml"))?)),
        Some(ResultKind::LatticeSweep) => {
            Kind::LatticeSweep(Box::new(read_toml(&settings("run.toml"))?))
        }
        Some(ResultKind::ElasticConstants) => Kind::Framework,
        Some(ResultKind::FrameworkTables) => Kind::FrameworkTables,
        Some(ResultKind::Training) => {
            Kind::Training(Box::new(read_toml(&settings("settings.toml"))?))
        }
        Some(ResultKind::Search) => Kind::Tune(Box::new(read_toml(&settings("settings.toml"))?)),
        Some(ResultKind::VoxelSet) => Kind::VoxelSet,
        Some(ResultKind::Simulation) => bail!(
            "{} is one simulation of a sweep; give the directory of the sweep, which holds run.toml",
            directory.display()
        ),
        Some(ResultKind::PairCondition) => bail!(
            "{} is one condition of a pair; give the directory of the pair, which holds run.toml",
            directory.display()
        ),
        Some(ResultKind::HardBodies | ResultKind::Other(_)) | None => bail!(
            "{} holds no results that a report can show; give the directory of a simulate, sweep, pair, \
             lattice run, lattice sweep, framework, train, tune or voxelize command",
            directory.display()
        ),
    })
}
