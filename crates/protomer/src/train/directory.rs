//! The directory of a training or a search: whose it is, who works in it, what of it may be removed.

use crate::keys;
use crate::run::lock;
use anyhow::{Context, Result, bail};
use protomer_io::atomic::write_atomically;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::File;
use std::path::{Path, PathBuf};

/// The resolved settings; also what tells a directory of protomer from any other.
const SETTINGS: &str = "settings.toml";
/// Held while a process works in the directory.
const LOCK: &str = ".lock";

/// A directory that this process alone works in, for as long as this lives.
#[derive(Debug)]
pub struct TrainDirectory {
    path: PathBuf,
    _lock: File,
}

impl TrainDirectory {
    /// Makes the directory, or enters one that holds the same settings. `start_anew` removes earlier results first: the
    /// files and folders of `results`, nothing else.
    ///
    /// # Errors
    /// If the directory holds something else, another process works in it, or the disk refuses.
    pub fn enter<T>(path: &Path, settings: &T, results: &[&str], start_anew: bool) -> Result<Self>
    where
        T: Serialize + DeserializeOwned + PartialEq,
    {
        if path.is_file() {
            bail!("{} is a file; give a directory for the results", path.display());
        }
        std::fs::create_dir_all(path).with_context(|| format!("cannot make the directory {}", path.display()))?;
        if start_anew && !path.join(SETTINGS).exists() && !is_empty(path)? {
            bail!("{} is no directory of a training, so --force leaves it alone; choose another", path.display());
        }
        let directory = Self { path: path.to_owned(), _lock: lock(path)? };
        if start_anew {
            directory.remove(results)?;
        }
        directory.claim(settings)?;
        Ok(directory)
    }

    fn claim<T>(&self, settings: &T) -> Result<()>
    where
        T: Serialize + DeserializeOwned + PartialEq,
    {
        let file = self.path.join(SETTINGS);
        match std::fs::read_to_string(&file) {
            Ok(text) if keys::from_toml::<T>(&file, &text)? == *settings => return Ok(()),
            Ok(_) => bail!(
                "{} holds results of other settings; choose another directory, or start anew with --force",
                self.path.display()
            ),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            Err(error) => return Err(error).with_context(|| format!("cannot read {}", file.display())),
        }
        let text = toml::to_string_pretty(settings).context("the settings cannot be written down")?;
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
    let entries = path.read_dir().with_context(|| format!("cannot read the directory {}", path.display()))?;
    Ok(entries.flatten().all(|entry| entry.file_name() == LOCK))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, Serialize, Deserialize, PartialEq)]
    #[serde(deny_unknown_fields)]
    struct Some {
        seed: u64,
    }

    #[test]
    fn only_the_same_settings_may_go_on_and_only_results_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run");
        let enter = |seed, anew| TrainDirectory::enter(&path, &Some { seed }, &["history.csv", "sub"], anew);
        drop(enter(1, false).unwrap());
        drop(enter(1, false).unwrap());
        assert!(enter(2, false).unwrap_err().to_string().contains("--force"));
        for file in ["history.csv", "mine.txt"] {
            std::fs::write(path.join(file), "").unwrap();
        }
        std::fs::create_dir_all(path.join("sub/deeper")).unwrap();
        drop(enter(2, true).unwrap());
        assert!(!path.join("history.csv").exists() && !path.join("sub").exists() && path.join("mine.txt").exists());
        let foreign = TrainDirectory::enter(folder.path(), &Some { seed: 1 }, &[], true).unwrap_err().to_string();
        assert!(foreign.contains("leaves it alone"));
    }
}
