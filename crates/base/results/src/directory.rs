//! A directory of results: its owner, and the files that may be removed.

use crate::keys::{from_toml, to_toml};
use crate::lock::{LOCK, lock};
use crate::settings::differences;
use crate::{Error, Execution, Hold, Record, Result, ResultKind, Settings};
use protomer_io::atomic::{remove_abandoned, write_atomically};
use serde::de::DeserializeOwned;
use std::fs::File;
use std::path::{Path, PathBuf};

/// The files of a verb in its directories.
#[derive(Debug, Clone)]
pub struct Layout {
    /// The kind of results; other kinds are refused.
    pub kind: ResultKind,
    /// The file with the resolved settings.
    pub settings: &'static str,
    /// All other files and folders that are written.
    pub results: &'static [&'static str],
    /// Whether a file or folder not listed in `results` is a result too.
    pub is_result: fn(&Path) -> bool,
}

/// A directory that this process works in, for the lifetime of this value.
///
/// ```
/// use protomer_results::{Execution, Layout, ResultKind, ResultsDirectory, Settings};
/// use serde::{Deserialize, Serialize};
///
/// #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
/// struct Walk {
///     seed: u64,
/// }
///
/// impl Settings for Walk {}
///
/// const LAYOUT: Layout = Layout {
///     kind: ResultKind::LatticeRun,
///     settings: "run.toml",
///     results: &["run.json", "log.csv", "checkpoint.bin"],
///     is_result: |_| false,
/// };
///
/// # let folder = tempfile::tempdir().unwrap();
/// let path = folder.path().join("walk");
/// let enter = |seed| {
///     ResultsDirectory::enter(&path, &LAYOUT, &Walk { seed }, "identity", &Execution::default())
/// };
/// drop(enter(1).unwrap());
/// drop(enter(1).unwrap());
/// assert!(enter(2).unwrap_err().to_string().contains("seed: 1 there, 2 here"));
/// ```
#[derive(Debug)]
pub struct ResultsDirectory {
    path: PathBuf,
    settings_are_new: bool,
    _lock: File,
}

impl ResultsDirectory {
    /// Creates the directory, or enters one that holds the same work: equal essential settings and
    /// equal identity. A new start removes earlier results first, and nothing else, because
    /// the directory may contain input files.
    ///
    /// # Errors
    /// If the directory holds something else, another process works in it, or a file cannot be
    /// written.
    pub fn enter<S: Settings>(
        path: &Path,
        layout: &Layout,
        settings: &S,
        identity: &str,
        execution: &Execution,
    ) -> Result<Self> {
        // Before the lock, which would itself write into a directory of another kind.
        make(path, layout)?;
        if execution.start_anew {
            require_ours::<S>(path, layout)?;
        }
        let lock = lock(path, Hold::Alone)?;
        // Alone in the directory: what earlier processes left half-written belongs to nobody.
        remove_abandoned(path)?;
        // Under the lock, so that nothing that is at work is removed.
        if execution.start_anew {
            remove_results(path, layout)?;
        }
        Self::claim(path, layout, settings, identity, lock)
    }

    /// Enters alongside other processes that do parts of the same work; each part locks what it
    /// works on.
    ///
    /// # Errors
    /// As [`enter`](Self::enter); also while a process has exclusive access, and for a new start.
    pub fn share<S: Settings>(
        path: &Path,
        layout: &Layout,
        settings: &S,
        identity: &str,
        execution: &Execution,
    ) -> Result<Self> {
        // Others may be at work with the earlier results.
        if execution.start_anew {
            return Err(Error::SharedStart(layout.kind.clone()));
        }
        make(path, layout)?;
        let lock = lock(path, Hold::Shared)?;
        Self::claim(path, layout, settings, identity, lock)
    }

    /// Refuses a directory with other settings before any costly work, even before the input is read.
    /// Writes nothing. [`enter`](Self::enter) checks the input as well.
    ///
    /// # Errors
    /// If the directory holds something else, or other settings without a new start.
    pub fn refuse_other_settings<S: Settings>(
        path: &Path,
        layout: &Layout,
        settings: &S,
        execution: &Execution,
    ) -> Result<()> {
        refuse_foreign(path, layout)?;
        if execution.start_anew {
            return Ok(());
        }
        match present_settings(path, layout)? {
            Some(present) => require_same_settings(path, layout, &present, settings),
            None => Ok(()),
        }
    }

    /// Path of the directory.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the settings were written on entry: the work is new, or has been extended.
    pub fn settings_are_new(&self) -> bool {
        self.settings_are_new
    }

    /// Writes the settings, or checks those of the directory.
    fn claim<S: Settings>(
        path: &Path,
        layout: &Layout,
        settings: &S,
        identity: &str,
        lock: File,
    ) -> Result<Self> {
        // Under the lock: nobody else can write settings in between.
        let present = present_settings(path, layout)?;
        if let Some(present) = &present {
            require_same(path, layout, present, settings, identity)?;
        }
        // Longer settings of the same work are written too: they say how far it is to go.
        let settings_are_new = present.as_ref() != Some(settings);
        if settings_are_new {
            let text = to_toml("the settings", settings)?;
            let file = path.join(layout.settings);
            write_atomically(&file, |out| out.write_all(text.as_bytes()))?;
        }
        Ok(Self {
            path: path.to_owned(),
            settings_are_new,
            _lock: lock,
        })
    }
}

/// The settings of a directory, if it has any.
fn present_settings<S: Settings>(path: &Path, layout: &Layout) -> Result<Option<S>> {
    let file = path.join(layout.settings);
    let text = match protomer_io::input::read_to_string(&file) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(Error::file("read", &file)(error)),
    };
    let settings = from_toml(&file, &text).map_err(|source| Error::OtherVersion {
        path: path.to_owned(),
        kind: layout.kind.clone(),
        source: Box::new(source),
    })?;
    Ok(Some(settings))
}

/// Refuses the directory of other work: other settings, other input, or settings that
/// cannot continue the existing ones.
fn require_same<S: Settings>(
    path: &Path,
    layout: &Layout,
    present: &S,
    settings: &S,
    identity: &str,
) -> Result<()> {
    require_same_settings(path, layout, present, settings)?;
    // Settings can be equal and the input another: the identity covers both.
    if let Some(record) = Record::read(path)? {
        record.require(identity, &layout.kind, path)?;
    }
    match settings.objection(present) {
        Some(reason) => Err(Error::NoContinuation {
            path: path.to_owned(),
            reason,
        }),
        None => Ok(()),
    }
}

/// Refuses the directory of other settings.
fn require_same_settings<S: Settings>(
    path: &Path,
    layout: &Layout,
    present: &S,
    settings: &S,
) -> Result<()> {
    // Essential settings only: what may change when work continues is not compared.
    let (stored, requested) = (present.essential(), settings.essential());
    if stored != requested {
        return Err(Error::OtherSettings {
            path: path.to_owned(),
            holds: match present.name() {
                Some(name) => name.into(),
                None => layout.kind.to_string(),
            },
            differences: differences(&stored, &requested)?,
        });
    }
    Ok(())
}

/// Creates the directory if necessary. Nothing is written into one that holds another kind of
/// result, not even a lock.
fn make(path: &Path, layout: &Layout) -> Result<()> {
    // Nothing was written yet if this is refused.
    refuse_foreign(path, layout)?;
    std::fs::create_dir_all(path).map_err(Error::file("create the directory", path))
}

/// Refuses a file, and a directory with another kind of result.
fn refuse_foreign(path: &Path, layout: &Layout) -> Result<()> {
    if path.is_file() {
        return Err(Error::NotADirectory(path.to_owned()));
    }
    layout.kind.refuse_other(path)
}

/// Refuses a directory that holds files but no results of this kind. Other kinds may have a
/// settings file of the same name.
fn require_ours<S: DeserializeOwned>(path: &Path, layout: &Layout) -> Result<()> {
    let file = path.join(layout.settings);
    let is_foreign = if file.exists() {
        protomer_io::input::read_to_string(&file)
            .map_or(true, |text| from_toml::<S>(&file, &text).is_err())
    } else {
        // The lock file alone is no content: a start that failed leaves it.
        entries(path)?.iter().any(|entry| !entry.ends_with(LOCK))
    };
    if is_foreign {
        return Err(Error::Foreign {
            path: path.to_owned(),
            kind: layout.kind.clone(),
        });
    }
    Ok(())
}

fn remove_results(path: &Path, layout: &Layout) -> Result<()> {
    for entry in entries(path)? {
        if (layout.is_result)(&entry) {
            remove(&entry)?;
        }
    }
    // The settings are removed last, so that an interrupted removal can be repeated.
    for name in layout.results.iter().chain([&layout.settings]) {
        remove(&path.join(name))?;
    }
    Ok(())
}

fn entries(path: &Path) -> Result<Vec<PathBuf>> {
    let entries = path.read_dir().and_then(|entries| {
        entries
            .map(|entry| entry.map(|entry| entry.path()))
            .collect()
    });
    entries.map_err(Error::file("read the directory", path))
}

/// Removes a file or a folder if it exists.
fn remove(path: &Path) -> Result<()> {
    let removed = if path.is_dir() {
        std::fs::remove_dir_all(path)
    } else {
        std::fs::remove_file(path)
    };
    // What is not there need not be removed.
    match removed {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(Error::file("remove", path)(error))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::{Deserialize, Serialize};

    #[derive(Debug, Clone, Serialize, Deserialize, PartialEq)]
    #[serde(deny_unknown_fields)]
    struct Steps {
        seed: u64,
        length: u64,
    }

    impl Settings for Steps {
        fn essential(&self) -> Self {
            Self {
                length: 0,
                ..self.clone()
            }
        }

        fn objection(&self, present: &Self) -> Option<String> {
            let is_shorter = self.length < present.length;
            is_shorter.then(|| "is meant to be longer; ask for more".into())
        }
    }

    const LAYOUT: Layout = Layout {
        kind: ResultKind::LatticeRun,
        settings: "settings.toml",
        results: &["history.csv", "sub"],
        is_result: |path| path.ends_with("other"),
    };

    fn enter(path: &Path, seed: u64, length: u64, start_anew: bool) -> Result<ResultsDirectory> {
        let execution = Execution {
            start_anew,
            ..Execution::default()
        };
        ResultsDirectory::enter(path, &LAYOUT, &Steps { seed, length }, "me", &execution)
    }

    fn refusal(entered: Result<ResultsDirectory>) -> String {
        entered.unwrap_err().to_string()
    }

    #[test]
    fn only_the_same_work_may_go_on() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run");
        assert!(enter(&path, 1, 1, false).unwrap().settings_are_new());
        assert!(!enter(&path, 1, 1, false).unwrap().settings_are_new());
        assert!(enter(&path, 1, 2, false).unwrap().settings_are_new());
        assert!(refusal(enter(&path, 1, 1, false)).contains("is meant to be longer"));
        let other = refusal(enter(&path, 2, 2, false));
        assert!(
            other.contains("holds a lattice run with other settings (seed: 1 there, 2 here)"),
            "{other}"
        );
        let refused = |seed, start_anew| {
            let execution = Execution {
                start_anew,
                ..Execution::default()
            };
            ResultsDirectory::refuse_other_settings(
                &path,
                &LAYOUT,
                &Steps { seed, length: 2 },
                &execution,
            )
        };
        assert_eq!(refused(2, false).unwrap_err().to_string(), other);
        assert!(refused(2, true).is_ok() && refused(1, false).is_ok());
        let held = enter(&path, 1, 2, false).unwrap();
        assert!(refusal(enter(&path, 1, 2, false)).contains("another process"));
        drop(held);
        std::fs::write(path.join("run.json"), r#"{"kind": "sweep"}"#).unwrap();
        assert!(refusal(enter(&path, 1, 2, false)).contains("holds a sweep; give another"));
    }

    #[test]
    fn only_results_are_removed_and_only_from_directories_of_ours() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run");
        drop(enter(&path, 1, 1, false).unwrap());
        for file in ["history.csv", "other", "mine.txt"] {
            std::fs::write(path.join(file), "").unwrap();
        }
        std::fs::create_dir_all(path.join("sub/deeper")).unwrap();
        drop(enter(&path, 2, 2, true).unwrap());
        let is_left = |name: &str| path.join(name).exists();
        assert!(!is_left("history.csv") && !is_left("sub") && !is_left("other"));
        assert!(is_left("mine.txt"));
        assert!(refusal(enter(folder.path(), 1, 1, true)).contains("does not remove it"));
        std::fs::write(path.join("settings.toml"), "widths = [1, 2]").unwrap();
        assert!(refusal(enter(&path, 2, 2, true)).contains("does not remove it"));
    }
}
