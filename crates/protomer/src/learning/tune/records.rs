//! Where a search stands: a record of each trial at each rung that it reached.
//!
//! Who goes on follows from the records alone. So processes that train different trials share
//! nothing but the folder.
//!
//! ```text
//! DIR/trials/0007.bin      checkpoint
//! DIR/trials/0007-3.toml   what trial 7 had reached after 3 epochs
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

/// Where a search stands.
pub(crate) struct Standing {
    /// Trials that are still in, best first; in their order before the first rung.
    pub running: Vec<Trial>,
    /// Trials that are out, best first.
    pub ended: Vec<Trial>,
    /// The epochs to the rung that some have not reached; `None` at the end.
    pub rung: Option<Range<usize>>,
    /// Places in `running` of those who have not.
    pub behind: Vec<usize>,
    /// Epochs of all records.
    pub epochs: u64,
}

impl Records {
    /// The records of a search in a directory. Makes their folder.
    pub fn open(path: &Path) -> Result<Self> {
        let folder = path.join("trials");
        std::fs::create_dir_all(&folder)
            .with_context(|| format!("cannot make the directory {}", folder.display()))?;
        Ok(Self { folder })
    }

    /// Removes what killed processes left half written. No other process may be at work.
    pub fn tidy(&self) -> Result<()> {
        Ok(remove_abandoned(&self.folder)?)
    }

    /// Where they are.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The checkpoint of a trial.
    pub fn checkpoint(&self, trial: &Trial) -> PathBuf {
        self.folder.join(format!("{:04}.bin", trial.number))
    }

    /// Holds a trial, for as long as the file lives.
    pub fn hold(&self, trial: &Trial) -> Result<File> {
        let file = self.folder.join(format!(".{:04}.lock", trial.number));
        Ok(lock_file(&file, Hold::Alone)?)
    }

    fn path(&self, trial: &Trial, rung: usize) -> PathBuf {
        self.folder.join(format!("{:04}-{rung}.toml", trial.number))
    }

    /// Writes down what a trial has reached at a rung.
    pub fn keep(&self, trial: &Trial, reached: &Reached, rung: usize) -> Result<()> {
        let text = toml::to_string(reached).context("cannot write the record of a trial")?;
        Ok(write_atomically(&self.path(trial, rung), |out| {
            out.write_all(text.as_bytes())
        })?)
    }

    /// What a trial had reached at a rung, if it came so far.
    pub fn of(&self, trial: &Trial, rung: usize) -> Result<Option<Reached>> {
        let path = self.path(trial, rung);
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => {
                return Err(error).with_context(|| format!("cannot read {}", path.display()));
            }
        };
        Ok(Some(keys::from_toml(&path, &text)?))
    }

    /// Where the search of these trials stands.
    pub fn standing(&self, settings: &TuneSettings, trials: &[Trial]) -> Result<Standing> {
        let plan = settings.halving()?;
        let standing = plan.standing(|number, rung| self.of(&trials[number], rung))?;
        let trials_of = |numbers: Vec<(usize, Reached)>| {
            let mut found = Vec::with_capacity(numbers.len());
            for (number, reached) in numbers {
                found.push(Trial {
                    reached,
                    ..trials[number].clone()
                });
            }
            found
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
