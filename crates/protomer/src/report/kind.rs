//! What a directory holds, from the files in it.

use crate::keys;
use crate::lattice::settings::LatticeSettings;
use crate::run::RunSettings;
use crate::train::TrainSettings;
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
    /// A training.
    Training(Box<TrainSettings>),
}

/// Tells the kind of a directory.
///
/// # Errors
/// If it is none of these, or its settings cannot be read.
pub fn of(directory: &Path) -> Result<Kind> {
    let is_there = |name: &str| directory.join(name).is_file();
    if !directory.is_dir() {
        bail!("{} is no directory; give one that protomer wrote its results into", directory.display());
    }
    if is_there("run.toml") {
        return of_run(&directory.join("run.toml"));
    }
    if is_there("settings.toml") && !is_there("trials.csv") && !directory.join("trials").exists() {
        return Ok(Kind::Training(Box::new(TrainSettings::read(&directory.join("settings.toml"))?)));
    }
    if is_there("result.json") && is_there("network.toml") {
        return Ok(Kind::Framework);
    }
    if is_there("log.csv") && is_there("checkpoint.bin") {
        bail!("{} is one simulation of a directory further up; give the one that holds run.toml", directory.display());
    }
    bail!(
        "{} holds no results that can be shown; give the directory of a simulate, a sweep, a lattice run, a lattice sweep, \
         a framework or a train command",
        directory.display()
    )
}

/// Lattices count squares, everything else has a salt.
fn of_run(path: &Path) -> Result<Kind> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let table: toml::Table = keys::from_toml(path, &text)?;
    if !table.contains_key("rows") {
        return Ok(Kind::MonteCarlo(Box::new(keys::from_toml(path, &text)?)));
    }
    let settings: Box<LatticeSettings> = Box::new(keys::from_toml(path, &text)?);
    Ok(if settings.sweep.is_some() { Kind::LatticeSweep(settings) } else { Kind::Lattice(settings) })
}
