//! `checkpoint.bin`: the state of a run, with how much of its log and trajectory belongs to it.

use super::log::LogMark;
use anyhow::{Context, Result};
use protomer_io::atomic::write_atomically;
use protomer_io::container::Container;
use protomer_mc::Checkpoint;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What the container of a simulation says it holds.
pub const KIND: &str = "checkpoint";

/// A point from which a run goes on bit for bit.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunCheckpoint {
    /// Hash of everything that shapes the result.
    pub identity: String,
    /// The part of the log that belongs to this state.
    pub log: LogMark,
    /// Frames of the trajectory that belong to this state.
    pub trajectory_frames: u64,
    /// Cluster moves, and bodies they moved, at the last row of the log.
    pub cluster_moves_logged: (u64, u64),
    /// The simulation.
    pub simulation: Checkpoint,
}

/// The checkpoint of this kind at a path, if there is one.
///
/// # Errors
/// If there is one and it cannot be used: damaged, or of another version.
pub fn read_checkpoint<T: DeserializeOwned>(path: &Path, kind: &str) -> Result<Option<T>> {
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error).with_context(|| format!("cannot read {}", path.display())),
    };
    let name = path.display().to_string();
    let container = Container::from_bytes(&name, kind, &bytes).with_context(|| {
        format!("cannot continue {name}; restore it, or start anew with --force")
    })?;
    let checkpoint = serde_json::from_value(container.header).with_context(|| {
        format!("{name} was written by another version of protomer; start anew with --force")
    })?;
    Ok(Some(checkpoint))
}

/// Writes a checkpoint; the old one stays until the new one is complete.
///
/// # Errors
/// If the disk does not take it.
pub fn write_checkpoint<T: Serialize>(path: &Path, kind: &str, checkpoint: &T) -> Result<()> {
    let header = serde_json::to_value(checkpoint).context("the state cannot be written down")?;
    let bytes = Container::new(kind, header).to_bytes()?;
    write_atomically(path, |file| file.write_all(&bytes))?;
    Ok(())
}
