//! The directory of a run or a sweep of lattices: whose it is, who works in it, what of it may be
//! removed.

use super::settings::LatticeSettings;
use crate::keys;
use crate::run::{Layout, ResultsDirectory, RunRecord};
use anyhow::{Context, Result};
use protomer_io::atomic::sha256_hex;
use std::path::Path;

/// The resolved settings.
const SETTINGS: &str = "run.toml";

/// Makes the directory, or enters one that holds the same work, whose length may differ;
/// [`ResultsDirectory::enter`] tells the rest. `holds` and `results` are as in [`Layout`].
///
/// # Errors
/// If the directory holds something else, another process works in it, or the disk refuses.
pub fn enter(
    path: &Path,
    settings: &LatticeSettings,
    holds: &'static str,
    results: &[&str],
    start_anew: bool,
) -> Result<ResultsDirectory> {
    let layout = Layout {
        settings: SETTINGS,
        holds,
        results,
        is_result: |_| false,
    };
    let continues =
        |present: &LatticeSettings| Ok(present.without_length() == settings.without_length());
    ResultsDirectory::enter(path, layout, settings, start_anew, continues)
}

/// The settings as TOML.
///
/// # Errors
/// If they cannot be written down.
pub fn to_toml(settings: &LatticeSettings) -> Result<String> {
    toml::to_string_pretty(settings).context("the settings cannot be written down")
}

/// The settings of a directory or of a file.
///
/// # Errors
/// Names the file, the line and the key.
pub fn read_settings(path: &Path) -> Result<LatticeSettings> {
    let file = if path.is_dir() {
        path.join(SETTINGS)
    } else {
        path.to_owned()
    };
    let text = std::fs::read_to_string(&file)
        .with_context(|| format!("cannot read {}", file.display()))?;
    keys::from_toml(&file, &text)
}

/// SHA-256 of everything that shapes a result but its length.
///
/// # Errors
/// If the settings cannot be written down.
pub fn identity(settings: &LatticeSettings) -> Result<String> {
    Ok(sha256_hex(to_toml(&settings.without_length())?.as_bytes()))
}

/// The record of a run.
pub fn record(
    verb: &str,
    identity: &str,
    exit_reason: &str,
    details: serde_json::Value,
) -> RunRecord {
    RunRecord {
        version: env!("CARGO_PKG_VERSION").into(),
        verb: verb.into(),
        identity: identity.into(),
        input_sha256: String::new(),
        exit_reason: exit_reason.into(),
        details,
    }
}
