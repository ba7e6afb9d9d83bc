//! `run.json`: what was run, on what, by which version, and how it ended.

use crate::interrupt::Interrupt;
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
    /// How it ended: `done`, `stopped`, or the error in words; `running` until then.
    pub exit_reason: String,
    /// Everything else worth knowing.
    pub details: serde_json::Value,
}

/// The name of the record in a run directory.
const FILE_NAME: &str = "run.json";
/// Where the details of a stopped run say what stopped it.
const STOPPED_BY: &str = "stopped_by";

impl RunRecord {
    /// Whether it came to its end.
    pub fn is_done(&self) -> bool {
        self.exit_reason == "done"
    }

    /// The error that ended it, in words.
    pub fn error(&self) -> Option<&str> {
        Some(self.exit_reason.as_str())
            .filter(|reason| !["done", "stopped", "running"].contains(reason))
    }

    /// What stopped it, if it was stopped and that is known.
    pub fn stopper(&self) -> Option<&str> {
        self.details
            .get(STOPPED_BY)?
            .as_str()
            .filter(|_| self.exit_reason == "stopped")
    }

    /// The same record, with what stopped the run.
    #[must_use]
    pub fn stopped_by(mut self, interrupt: &Interrupt) -> Self {
        if !self.details.is_object() {
            self.details = serde_json::json!({});
        }
        self.details[STOPPED_BY] = interrupt.reason().into();
        self
    }

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
