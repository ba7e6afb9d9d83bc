//! What a directory holds, from the files in it.

use crate::keys;
use crate::lattice::settings::LatticeSettings;
use crate::run::RunSettings;
use crate::train::TrainSettings;
use crate::tune::TuneSettings;
use crate::voxelize::work_path;
use anyhow::{Context, Result, bail};
use std::path::Path;

/// What a directory holds.
#[derive(Debug)]
pub enum Kind {
    /// A simulation of bodies, or a sweep of such.
    MonteCarlo(Box<RunSettings>),
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

/// Tells the kind of a directory.
///
/// # Errors
/// If it is none of these, or its settings cannot be read.
pub fn of(directory: &Path) -> Result<Kind> {
    let is_there = |name: &str| directory.join(name).is_file();
    if !directory.is_dir() {
        if work_path(directory).is_file() {
            let name = directory.display();
            bail!(
                "the set {name} is not complete yet; the same 'protomer voxelize' command goes on"
            );
        }
        bail!(
            "{} is no directory; give one that protomer wrote its results into",
            directory.display()
        );
    }
    if is_there("run.toml") {
        return of_run(&directory.join("run.toml"));
    }
    if is_there("settings.toml") {
        return of_settings(directory);
    }
    if is_there("result.json") && is_there("network.toml") {
        return Ok(Kind::Framework);
    }
    if is_there("tables.json") {
        return Ok(Kind::FrameworkTables);
    }
    if is_there("zarr.json") {
        return Ok(Kind::VoxelSet);
    }
    if is_there("log.csv") && is_there("checkpoint.bin") {
        bail!(
            "{} is one simulation of a directory further up; give the one that holds run.toml",
            directory.display()
        );
    }
    bail!(
        "{} holds no results that can be shown; give the directory of a simulate, sweep, lattice run, lattice sweep, \
         framework, train, tune or voxelize command",
        directory.display()
    )
}

/// Lattices count squares, everything else has a salt.
fn of_run(path: &Path) -> Result<Kind> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let table: toml::Table = keys::from_toml(path, &text)?;
    if !table.contains_key("rows") {
        return Ok(Kind::MonteCarlo(Box::new(keys::from_toml(path, &text)?)));
    }
    let settings: Box<LatticeSettings> = Box::new(keys::from_toml(path, &text)?);
    Ok(if settings.sweep.is_some() {
        Kind::LatticeSweep(settings)
    } else {
        Kind::Lattice(settings)
    })
}

/// A search has settings of a training in its own.
fn of_settings(directory: &Path) -> Result<Kind> {
    let path = directory.join("settings.toml");
    if !directory.join("trials").is_dir() && !directory.join("trials.csv").is_file() {
        return Ok(Kind::Training(Box::new(TrainSettings::read(&path)?)));
    }
    let text = std::fs::read_to_string(&path)
        .with_context(|| format!("cannot read {}", path.display()))?;
    Ok(Kind::Tune(Box::new(keys::from_toml(&path, &text)?)))
}
