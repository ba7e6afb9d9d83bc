//! What kind of result a directory holds, told from the files in it.
//!
//! Several verbs have files of the same names. Without this one would write into the results of
//! another, or take them for its own of an older version.

use anyhow::{Result, bail};
use std::path::Path;

/// What `simulate` and `sweep` leave.
pub const SWEEP: &str = "a sweep";
/// What `lattice run` leaves.
pub const LATTICE_RUN: &str = "a lattice run";
/// What `lattice sweep` leaves.
pub const LATTICE_SWEEP: &str = "a lattice sweep";
/// What `framework` leaves.
pub const ELASTIC_CONSTANTS: &str = "elastic constants of a network";
/// What `framework tables` leaves.
pub const TABLES: &str = "the tables of a paper";
const TRAINING: &str = "a training";
const SEARCH: &str = "a search";
const VOXEL_SET: &str = "a voxel set";
const SIMULATION: &str = "one simulation of a sweep";

/// The kind of result, as in "holds *a sweep*"; none where there is none, or none that can be told.
fn kind(directory: &Path) -> Option<&'static str> {
    let is_there = |name: &str| directory.join(name).is_file();
    let table = |name: &str| -> Option<toml::Table> {
        std::fs::read_to_string(directory.join(name))
            .ok()?
            .parse::<toml::Table>()
            .ok()
    };
    if let Some(run) = table("run.toml") {
        let kinds = [
            ("salt_M", SWEEP),
            ("sweep", LATTICE_SWEEP),
            ("rows", LATTICE_RUN),
        ];
        return kinds
            .into_iter()
            .find(|(key, _)| run.contains_key(*key))
            .map(|(_, kind)| kind);
    }
    if let Some(settings) = table("settings.toml") {
        let kinds = [("base", SEARCH), ("training", TRAINING)];
        return kinds
            .into_iter()
            .find(|(key, _)| settings.contains_key(*key))
            .map(|(_, kind)| kind);
    }
    let kinds: [(&[&str], _); 4] = [
        (&["zarr.json"], VOXEL_SET),
        (&["result.json", "network.toml"], ELASTIC_CONSTANTS),
        (&["tables.json"], TABLES),
        (&["run.json", "checkpoint.bin"], SIMULATION),
    ];
    kinds
        .into_iter()
        .find(|(files, _)| files.iter().all(|file| is_there(file)))
        .map(|(_, kind)| kind)
}

/// Refuses a directory that holds another kind of result than `ours`.
///
/// # Errors
/// If it does.
pub fn refuse_other(directory: &Path, ours: &str) -> Result<()> {
    match kind(directory) {
        Some(other) if other != ours => bail!(
            "{} holds {other}; give another directory",
            directory.display()
        ),
        _ => Ok(()),
    }
}

/// Refuses the directory of a voxel set, for files that may lie beside any other result: a set is
/// replaced as a whole, with all that is in its directory.
///
/// # Errors
/// If it is one.
pub fn refuse_set(directory: &Path) -> Result<()> {
    match kind(directory) {
        Some(VOXEL_SET) => bail!(
            "{} holds {VOXEL_SET}; give another directory",
            directory.display()
        ),
        _ => Ok(()),
    }
}
