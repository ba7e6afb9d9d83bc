//! The state of a search: a record of each trial at each rung it has reached.
//!
//! The survivors follow from the records alone, so processes that train different trials
//! share nothing but the folder.
//!
//! ```text
//! DIR/trials/0007.bin      checkpoint
//! DIR/trials/0007-3.toml   the result of trial 7 after 3 epochs
//! ```

use crate::learning::tune::{Trial, TuneSettings};
use anyhow::{Context, Result};
use protomer_io::atomic::{remove_abandoned, write_atomically};
use protomer_learn::halving::Reached;
use protomer_results::keys;
use protomer_results::lock::{Hold, lock_file};
use std::fs::File;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The folder of the trials.
pub(crate) struct Records {
    folder: PathBuf,
}

/// The state of a search.
pub(crate) struct Standing {
    /// Trials still in the running, best first; in their original order before the first rung.
    pub running: Vec<Trial>,
    /// Eliminated trials, best first.
    pub ended: Vec<Trial>,
    /// The epochs of the next rung; `None` at the end.
    pub rung: Option<Range<usize>>,
    /// Indices into `running` of the trials that have not reached the next rung.
    pub behind: Vec<usize>,
    /// Total epochs of all records.
    pub epochs: u64,
}

impl Records {
    /// Opens the records of a search in a directory, and creates their folder.
    pub fn open(path: &Path) -> Result<Self> {
        let folder = path.join("trials");
        std::fs::create_dir_all(&folder)
            .with_context(|| format!("cannot create the directory {}", folder.display()))?;
        Ok(Self { folder })
    }

    /// Removes incomplete files left by killed processes. No other process may be at work.
    pub fn tidy(&self) -> Result<()> {
        Ok(remove_abandoned(&self.folder)?)
    }

    /// The folder of the records.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The checkpoint of a trial.
    pub fn checkpoint(&self, trial: &Trial) -> PathBuf {
        self.folder.join(format!("{:04}.bin", trial.number))
    }

    /// Locks a trial for as long as the file is open.
    pub fn hold(&self, trial: &Trial) -> Result<File> {
        let file = self.folder.join(format!(".{:04}.lock", trial.number));
        Ok(lock_file(&file, Hold::Alone)?)
    }

    fn path(&self, trial: &Trial, rung: usize) -> PathBuf {
        self.folder.join(format!("{:04}-{rung}.toml", trial.number))
    }

    /// Records the result of a trial at a rung.
    pub fn keep(&self, trial: &Trial, reached: &Reached, rung: usize) -> Result<()> {
        let text = toml::to_string(reached).context("cannot write the record of a trial")?;
        Ok(write_atomically(&self.path(trial, rung), |out| {
            out.write_all(text.as_bytes())
        })?)
    }

    /// The result of a trial at a rung, if it got that far.
    pub fn reached(&self, trial: &Trial, rung: usize) -> Result<Option<Reached>> {
        let path = self.path(trial, rung);
        let text = match protomer_io::input::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => {
                return Err(error).with_context(|| format!("cannot read {}", path.display()));
            }
        };
        Ok(Some(keys::from_toml(&path, &text)?))
    }

    /// The state of the search over these trials.
    pub fn standing(&self, settings: &TuneSettings, trials: &[Trial]) -> Result<Standing> {
        let plan = settings.halving()?;
        let standing = plan.standing(|number, rung| self.reached(&trials[number], rung))?;
        let trials_of = |numbers: Vec<(usize, Reached)>| {
            let mut selected_trials = Vec::with_capacity(numbers.len());
            for (number, reached) in numbers {
                selected_trials.push(Trial {
                    reached,
                    ..trials[number].clone()
                });
            }
            selected_trials
        };
        Ok(Standing {
            running: trials_of(standing.running),
            ended: trials_of(standing.ended),
            rung: standing.rung,
            behind: standing.behind,
            epochs: standing.epochs,
        })
    }
}
