//! The directory of a sweep: whose it is, who works in it, and what of it may be removed.

use super::record::{RunRecord, read_record};
use super::settings::RunSettings;
use crate::keys;
use anyhow::{Context, Result, bail};
use protomer_io::atomic::write_atomically;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

/// The resolved settings; also what tells a directory of protomer from any other.
const SETTINGS: &str = "run.toml";
/// Every other file that a sweep writes beside the folders of its simulations.
const RESULTS: [&str; 5] = ["run.json", "sweep.csv", "sweep.json", "sweep.svg", "sweep.png"];
/// Held while a process works in the directory.
const LOCK: &str = ".lock";

/// A directory that this process alone works in, for as long as this lives.
#[derive(Debug)]
pub struct SweepDirectory {
    path: PathBuf,
    _lock: File,
}

impl SweepDirectory {
    /// Makes the directory, or enters one that holds the same sweep. `start_anew` removes an earlier sweep first.
    ///
    /// # Errors
    /// If the directory holds another sweep, another process works in it, or the disk refuses.
    pub fn enter(path: &Path, settings: &RunSettings, record: &RunRecord, start_anew: bool) -> Result<Self> {
        if path.is_file() {
            bail!("{} is a file; give a directory for the results", path.display());
        }
        std::fs::create_dir_all(path).with_context(|| format!("cannot make the directory {}", path.display()))?;
        if start_anew {
            require_ours(path)?;
        }
        let directory = Self { path: path.to_owned(), _lock: lock(path)? };
        if start_anew {
            directory.remove_results()?;
        }
        directory.claim(settings, record)?;
        Ok(directory)
    }

    /// Writes down the settings, or checks that those of the directory are the same but for a length that may grow.
    fn claim(&self, settings: &RunSettings, record: &RunRecord) -> Result<()> {
        let file = self.path.join(SETTINGS);
        match std::fs::read_to_string(&file) {
            Ok(text) => {
                let present = keys::from_toml::<RunSettings>(&file, &text)?;
                self.check_present(&present, settings, record)?;
                if present == *settings {
                    return Ok(());
                }
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            Err(error) => return Err(error).with_context(|| format!("cannot read {}", file.display())),
        }
        let text = toml::to_string_pretty(settings).context("the settings cannot be written down")?;
        write_atomically(&file, |out| out.write_all(text.as_bytes()))?;
        record.write(&self.path)
    }

    fn check_present(&self, present: &RunSettings, settings: &RunSettings, record: &RunRecord) -> Result<()> {
        let same_settings = present.without_length() == settings.without_length();
        let same_input = read_record(&self.path)?.is_none_or(|present| present.identity == record.identity);
        if !(same_settings && same_input) {
            bail!(
                "{} holds a sweep with other {}; choose another directory, or start anew with --force",
                self.path.display(),
                if same_settings { "input" } else { "settings" }
            );
        }
        if present.sweeps > settings.sweeps {
            bail!(
                "{} is meant to run to {} sweeps, which is more than {}; ask for at least as many, or choose another \
                 directory",
                self.path.display(),
                present.sweeps,
                settings.sweeps
            );
        }
        Ok(())
    }

    /// Removes what an earlier sweep wrote, and nothing else: the directory may hold its input as well.
    fn remove_results(&self) -> Result<()> {
        for entry in entries(&self.path)?.iter().filter(|entry| is_simulation(entry)) {
            std::fs::remove_dir_all(entry).with_context(|| format!("cannot remove {}", entry.display()))?;
        }
        // The settings go last: a removal that was cut short can be repeated.
        for name in RESULTS.iter().chain([&SETTINGS]) {
            let file = self.path.join(name);
            if file.exists() {
                std::fs::remove_file(&file).with_context(|| format!("cannot remove {}", file.display()))?;
            }
        }
        Ok(())
    }
}

/// Refuses a directory that holds something, but no sweep.
fn require_ours(path: &Path) -> Result<()> {
    let foreign = !path.join(SETTINGS).exists() && entries(path)?.iter().any(|entry| !entry.ends_with(LOCK));
    if foreign {
        bail!("{} is no run directory of protomer, so --force leaves it alone; choose another", path.display());
    }
    Ok(())
}

fn entries(path: &Path) -> Result<Vec<PathBuf>> {
    let context = || format!("cannot read the directory {}", path.display());
    let entries = path.read_dir().with_context(context)?;
    entries.map(|entry| Ok(entry.with_context(context)?.path())).collect()
}

/// Whether this is the folder of the simulations at one salt concentration.
fn is_simulation(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.starts_with("salt_") && name.ends_with('M') && path.join("replica_0").is_dir()
}

/// Locks the directory against other processes, where the file system can; for as long as the file is open.
///
/// # Errors
/// If another process holds it, or the disk refuses.
pub fn lock(path: &Path) -> Result<File> {
    let file = File::create(path.join(LOCK)).with_context(|| format!("cannot write into {}", path.display()))?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => {
            bail!("another process works in {}; wait for it, or choose another directory", path.display())
        }
        // Some network file systems have no locks; that is no reason not to work on them.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
    }
}
