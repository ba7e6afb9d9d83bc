//! The directory of a run or a sweep of lattices: whose it is, who works in it, what of it may be removed.

use super::settings::LatticeSettings;
use crate::keys;
use crate::run::{RunRecord, lock};
use anyhow::{Context, Result, bail};
use protomer_io::atomic::{sha256_hex, write_atomically};
use std::fs::File;
use std::path::{Path, PathBuf};

/// The resolved settings; also what tells a directory of protomer from any other.
const SETTINGS: &str = "run.toml";

/// A directory that this process alone works in, for as long as this lives.
#[derive(Debug)]
pub struct LatticeDirectory {
    path: PathBuf,
    _lock: File,
}

impl LatticeDirectory {
    /// Makes the directory, or enters one that holds the same run. `start_anew` removes an earlier run first: the files of
    /// `results`, which may end in `*`.
    ///
    /// # Errors
    /// If the directory holds something else, another process works in it, or the disk refuses.
    pub fn enter(path: &Path, settings: &LatticeSettings, results: &[&str], start_anew: bool) -> Result<Self> {
        if path.is_file() {
            bail!("{} is a file; give a directory for the results", path.display());
        }
        std::fs::create_dir_all(path).with_context(|| format!("cannot make the directory {}", path.display()))?;
        if start_anew && !path.join(SETTINGS).exists() && !is_empty(path)? {
            bail!("{} is no run directory of protomer, so --force leaves it alone; choose another", path.display());
        }
        let directory = Self { path: path.to_owned(), _lock: lock(path)? };
        if start_anew {
            directory.remove(results)?;
        }
        directory.claim(settings)?;
        Ok(directory)
    }

    fn claim(&self, settings: &LatticeSettings) -> Result<()> {
        let file = self.path.join(SETTINGS);
        match std::fs::read_to_string(&file) {
            Ok(text) => {
                let present = keys::from_toml::<LatticeSettings>(&file, &text)?;
                if present.without_length() != settings.without_length() {
                    bail!(
                        "{} holds a run with other settings; choose another directory, or start anew with --force",
                        self.path.display()
                    );
                }
                if present == *settings {
                    return Ok(());
                }
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            Err(error) => return Err(error).with_context(|| format!("cannot read {}", file.display())),
        }
        let text = to_toml(settings)?;
        write_atomically(&file, |out| out.write_all(text.as_bytes()))?;
        Ok(())
    }

    /// The settings go last: a removal that was cut short can be repeated.
    fn remove(&self, results: &[&str]) -> Result<()> {
        for name in results.iter().chain([&SETTINGS]) {
            let path = self.path.join(name);
            let removed = if path.is_dir() { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) };
            match removed {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                    return Err(error).with_context(|| format!("cannot remove {}", path.display()));
                }
                _ => {}
            }
        }
        Ok(())
    }
}

fn is_empty(path: &Path) -> Result<bool> {
    let mut entries = path.read_dir().with_context(|| format!("cannot read the directory {}", path.display()))?;
    Ok(entries.next().is_none())
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
    let file = if path.is_dir() { path.join(SETTINGS) } else { path.to_owned() };
    let text = std::fs::read_to_string(&file).with_context(|| format!("cannot read {}", file.display()))?;
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
pub fn record(verb: &str, identity: &str, exit_reason: &str, details: serde_json::Value) -> RunRecord {
    RunRecord {
        version: env!("CARGO_PKG_VERSION").into(),
        verb: verb.into(),
        identity: identity.into(),
        input_sha256: String::new(),
        exit_reason: exit_reason.into(),
        details,
    }
}
