//! `run.json`: what was run, on what, by which version, and how it ended.

use crate::keys;
use anyhow::{Context, Result};
use protomer_io::atomic::write_atomically;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The record of a run or a sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Version of the program.
    pub version: String,
    /// The verb.
    pub verb: String,
    /// SHA-256 of the settings and the input: two runs with the same identity give the same result.
    pub identity: String,
    /// SHA-256 of the assembly and its bodies.
    pub input_sha256: String,
    /// How it ended: `done`, `stopped` or an error.
    pub exit_reason: String,
    /// Everything else worth knowing.
    pub details: serde_json::Value,
}

/// The name of the record in a run directory.
const FILE_NAME: &str = "run.json";

impl RunRecord {
    /// Writes the record into a directory.
    ///
    /// # Errors
    /// If the disk does not take it.
    pub fn write(&self, directory: &Path) -> Result<()> {
        let path = directory.join(FILE_NAME);
        let text = serde_json::to_string_pretty(self).context("run.json")?;
        write_atomically(&path, |file| writeln!(file, "{text}"))?;
        Ok(())
    }
}

/// The record of a directory, if there is one.
///
/// # Errors
/// If there is one and it cannot be read.
pub fn read_record(directory: &Path) -> Result<Option<RunRecord>> {
    let path = directory.join(FILE_NAME);
    match std::fs::read(&path) {
        Ok(bytes) => Ok(Some(keys::from_json(&path, &bytes)?)),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error).with_context(|| format!("cannot read {}", path.display())),
    }
}
