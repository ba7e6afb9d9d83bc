//! A directory of results: whose it is, who works in it, and what of it may be removed.

use super::contents::refuse_other;
use crate::keys;
use anyhow::{Context, Result, bail};
use protomer_io::atomic::{remove_abandoned, write_atomically};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

/// Held while a process works in the directory.
const LOCK: &str = ".lock";

/// What a verb keeps in its directories.
#[derive(Debug, Clone, Copy)]
pub struct Layout<'a> {
    /// The file of the resolved settings; also what tells a directory of this kind from any other.
    pub settings: &'static str,
    /// What the directory holds, as in "holds *a sweep* with other settings": one of the kinds of
    /// `contents`, for which anything else there is another one.
    pub holds: &'static str,
    /// Every other file and folder that is written beside the settings.
    pub results: &'a [&'a str],
    /// Whether a file or folder that `results` does not name is a result too.
    pub is_result: fn(&Path) -> bool,
}

/// Who else may work in a directory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hold {
    /// Nobody.
    Alone,
    /// Others that share it as well.
    Shared,
}

/// A directory that this process works in, for as long as this lives.
#[derive(Debug)]
pub struct ResultsDirectory {
    path: PathBuf,
    settings_are_new: bool,
    _lock: File,
}

impl ResultsDirectory {
    /// Makes the directory, or enters one whose settings `continues` accepts as those of the same
    /// work; it is asked even where they are equal, because the work may hang on more than
    /// settings. `start_anew` removes earlier results first, and nothing else: the directory may
    /// hold its input as well.
    ///
    /// # Errors
    /// If the directory holds something else, another process works in it, or the disk refuses.
    pub fn enter<S>(
        path: &Path,
        layout: Layout,
        settings: &S,
        start_anew: bool,
        continues: impl Fn(&S) -> Result<bool>,
    ) -> Result<Self>
    where
        S: Serialize + DeserializeOwned + PartialEq,
    {
        make(path, layout)?;
        if start_anew {
            require_ours::<S>(path, layout)?;
        }
        let mut directory = Self {
            path: path.to_owned(),
            settings_are_new: false,
            _lock: lock(path, Hold::Alone)?,
        };
        remove_abandoned(path)?;
        if start_anew {
            directory.remove_results(layout)?;
        }
        directory.settings_are_new = directory.claim(layout, settings, continues)?;
        Ok(directory)
    }

    /// Enters beside other processes that do parts of the same work; each part locks what it works
    /// on.
    ///
    /// # Errors
    /// As [`enter`](Self::enter); also while a process has the directory alone, and if it is to
    /// `start_anew`.
    pub fn share<S>(
        path: &Path,
        layout: Layout,
        settings: &S,
        start_anew: bool,
        continues: impl Fn(&S) -> Result<bool>,
    ) -> Result<Self>
    where
        S: Serialize + DeserializeOwned + PartialEq,
    {
        if start_anew {
            bail!(
                "a part of {} cannot start anew, other parts may be at work; remove the directory, or leave out --force",
                layout.holds
            );
        }
        make(path, layout)?;
        let mut directory = Self {
            path: path.to_owned(),
            settings_are_new: false,
            _lock: lock(path, Hold::Shared)?,
        };
        directory.settings_are_new = directory.claim(layout, settings, continues)?;
        Ok(directory)
    }

    /// Whether the settings were written by this entry: the work begins, or is to be longer than
    /// before.
    pub fn settings_are_new(&self) -> bool {
        self.settings_are_new
    }

    /// Writes down the settings, or checks those of the directory.
    fn claim<S>(
        &self,
        layout: Layout,
        settings: &S,
        continues: impl Fn(&S) -> Result<bool>,
    ) -> Result<bool>
    where
        S: Serialize + DeserializeOwned + PartialEq,
    {
        let file = self.path.join(layout.settings);
        match std::fs::read_to_string(&file) {
            Ok(text) => {
                let present = keys::from_toml::<S>(&file, &text).with_context(|| {
                    let (path, holds) = (self.path.display(), layout.holds);
                    format!(
                        "{path} does not hold {holds} of this version; choose another directory"
                    )
                })?;
                if !continues(&present)? {
                    return refuse(&self.path, layout, "settings");
                }
                if present == *settings {
                    return Ok(false);
                }
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            Err(error) => {
                return Err(error).with_context(|| format!("cannot read {}", file.display()));
            }
        }
        let text =
            toml::to_string_pretty(settings).context("the settings cannot be written down")?;
        write_atomically(&file, |out| out.write_all(text.as_bytes()))?;
        Ok(true)
    }

    fn remove_results(&self, layout: Layout) -> Result<()> {
        for path in entries(&self.path)?
            .iter()
            .filter(|path| (layout.is_result)(path))
        {
            remove(path)?;
        }
        // The settings go last: a removal that was cut short can be repeated.
        for name in layout.results.iter().chain([&layout.settings]) {
            remove(&self.path.join(name))?;
        }
        Ok(())
    }
}

/// Makes the directory if need be. Nothing is put into one that holds another kind of result, not
/// even a lock.
fn make(path: &Path, layout: Layout) -> Result<()> {
    if path.is_file() {
        bail!(
            "{} is a file; give a directory for the results",
            path.display()
        );
    }
    refuse_other(path, layout.holds)?;
    std::fs::create_dir_all(path)
        .with_context(|| format!("cannot make the directory {}", path.display()))
}

/// Says that a directory holds the same kind of results, but not these.
///
/// # Errors
/// Always.
pub fn refuse<T>(path: &Path, layout: Layout, what_differs: &str) -> Result<T> {
    bail!(
        "{} holds {} with other {what_differs}; choose another directory, or start anew with --force",
        path.display(),
        layout.holds
    )
}

/// Refuses a directory that holds something, but no results of this kind. Other kinds may have a
/// settings file of that name.
fn require_ours<S: DeserializeOwned>(path: &Path, layout: Layout) -> Result<()> {
    let file = path.join(layout.settings);
    let foreign = if file.exists() {
        std::fs::read_to_string(&file)
            .map_or(true, |text| keys::from_toml::<S>(&file, &text).is_err())
    } else {
        entries(path)?.iter().any(|entry| !entry.ends_with(LOCK))
    };
    if foreign {
        bail!(
            "{} does not hold {}, so --force leaves it alone; choose another",
            path.display(),
            layout.holds
        );
    }
    Ok(())
}

fn entries(path: &Path) -> Result<Vec<PathBuf>> {
    let context = || format!("cannot read the directory {}", path.display());
    let entries = path.read_dir().with_context(context)?;
    entries
        .map(|entry| Ok(entry.with_context(context)?.path()))
        .collect()
}

/// Removes a file or a folder if it is there.
fn remove(path: &Path) -> Result<()> {
    let removed = if path.is_dir() {
        std::fs::remove_dir_all(path)
    } else {
        std::fs::remove_file(path)
    };
    match removed {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(error).with_context(|| format!("cannot remove {}", path.display()))
        }
        _ => Ok(()),
    }
}

/// Locks the directory against other processes, where the file system can; for as long as the file
/// is open.
///
/// # Errors
/// If another process holds it, or the disk refuses.
pub fn lock(path: &Path, hold: Hold) -> Result<File> {
    lock_file(&path.join(LOCK), hold)
}

/// Locks what a file of its own stands for, as [`lock`] does a directory.
///
/// # Errors
/// As [`lock`].
pub fn lock_file(file: &Path, hold: Hold) -> Result<File> {
    let path = file.parent().unwrap_or(file);
    let file =
        File::create(file).with_context(|| format!("cannot write into {}", path.display()))?;
    let held = match hold {
        Hold::Alone => file.try_lock(),
        Hold::Shared => file.try_lock_shared(),
    };
    match held {
        Err(TryLockError::WouldBlock) => {
            bail!(
                "another process works in {}; wait for it, or choose another directory",
                path.display()
            )
        }
        // Some network file systems have no locks; that is no reason not to work on them.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, Serialize, Deserialize, PartialEq)]
    #[serde(deny_unknown_fields)]
    struct Settings {
        seed: u64,
        length: u64,
    }

    const LAYOUT: Layout = Layout {
        settings: "settings.toml",
        holds: "a run",
        results: &["history.csv", "sub"],
        is_result: |path| path.ends_with("other"),
    };

    #[test]
    fn only_the_same_work_may_go_on_and_only_results_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run");
        let enter = |seed, length, anew| {
            ResultsDirectory::enter(&path, LAYOUT, &Settings { seed, length }, anew, |present| {
                Ok(present.seed == seed)
            })
        };
        assert!(enter(1, 1, false).unwrap().settings_are_new());
        assert!(!enter(1, 1, false).unwrap().settings_are_new());
        assert!(enter(1, 2, false).unwrap().settings_are_new());
        assert!(
            enter(2, 2, false)
                .unwrap_err()
                .to_string()
                .contains("holds a run with other settings")
        );
        for file in ["history.csv", "other", "mine.txt"] {
            std::fs::write(path.join(file), "").unwrap();
        }
        std::fs::create_dir_all(path.join("sub/deeper")).unwrap();
        drop(enter(2, 2, true).unwrap());
        let left = |name: &str| path.join(name).exists();
        assert!(!left("history.csv") && !left("sub") && !left("other") && left("mine.txt"));
        let settings = Settings { seed: 1, length: 1 };
        let foreign = ResultsDirectory::enter(folder.path(), LAYOUT, &settings, true, |_| Ok(true))
            .unwrap_err();
        assert!(foreign.to_string().contains("leaves it alone"));
        std::fs::write(path.join("settings.toml"), "widths = [1, 2]").unwrap();
        assert!(
            enter(2, 2, true)
                .unwrap_err()
                .to_string()
                .contains("leaves it alone")
        );
        std::fs::write(path.join("settings.toml"), "seed = 2\nlength = 2").unwrap();
        let held = enter(2, 2, false).unwrap();
        assert!(
            enter(2, 2, false)
                .unwrap_err()
                .to_string()
                .contains("another process")
        );
        drop(held);
    }
}
