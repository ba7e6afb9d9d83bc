//! Where a search stands: which trials reached which rung, and who goes on from there.
//!
//! A trial that reached a rung has a record of it, and who goes on follows from the records alone.
//! So processes that train different trials share nothing but the folder.
//!
//! ```text
//! DIR/trials/0007.bin      checkpoint
//! DIR/trials/0007-3.toml   what trial 7 had reached after 3 epochs
//! ```

use crate::learning::tune::{Trial, TuneSettings, kept};
use anyhow::{Context, Result};
use protomer_io::atomic::{remove_abandoned, write_atomically};
use protomer_results::keys;
use protomer_results::lock::{Hold, lock_file};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The folder of the trials.
pub(crate) struct Records {
    folder: PathBuf,
}

/// What a trial had reached at a rung.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Record {
    epochs: usize,
    validation_loss_nats: Option<f64>,
    validation_balanced_accuracy: Option<f64>,
}

/// Where a search stands.
pub(crate) struct Standing {
    /// Trials that are not out, best first; in their order before the first rung.
    pub running: Vec<Trial>,
    /// Trials that are, best first.
    pub ended: Vec<Trial>,
    /// The epochs to the rung that some have not reached; none at the end.
    pub rung: Option<Range<usize>>,
    /// Places in `running` of those who have not.
    pub behind: Vec<usize>,
    /// Epochs of all records.
    pub epochs: u64,
}

impl Records {
    /// The records of a search in a directory, which is made.
    pub fn open(path: &Path) -> Result<Self> {
        let folder = path.join("trials");
        std::fs::create_dir_all(&folder)
            .with_context(|| format!("cannot make the directory {}", folder.display()))?;
        Ok(Self { folder })
    }

    /// Removes what killed processes left half written; no other process may be at work.
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

    /// Writes down where a trial stands at a rung.
    pub fn keep(&self, trial: &Trial, rung: usize) -> Result<()> {
        let Trial {
            epochs,
            validation_loss_nats,
            validation_balanced_accuracy,
            ..
        } = *trial;
        let record = Record {
            epochs,
            validation_loss_nats,
            validation_balanced_accuracy,
        };
        let text =
            toml::to_string(&record).context("the record of a trial cannot be written down")?;
        Ok(write_atomically(&self.path(trial, rung), |out| {
            out.write_all(text.as_bytes())
        })?)
    }

    /// A trial as it stood at a rung, if it reached it.
    pub fn of(&self, trial: &Trial, rung: usize) -> Result<Option<Trial>> {
        let path = self.path(trial, rung);
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => {
                return Err(error).with_context(|| format!("cannot read {}", path.display()));
            }
        };
        let Record {
            epochs,
            validation_loss_nats,
            validation_balanced_accuracy,
        } = keys::from_toml(&path, &text)?;
        Ok(Some(Trial {
            epochs,
            validation_loss_nats,
            validation_balanced_accuracy,
            ..trial.clone()
        }))
    }

    /// Where the search of these trials stands.
    pub fn standing(&self, settings: &TuneSettings, trials: &[Trial]) -> Result<Standing> {
        let mut standing = Standing {
            running: trials.to_vec(),
            ended: Vec::new(),
            rung: None,
            behind: Vec::new(),
            epochs: 0,
        };
        let mut before = 0;
        for rung in settings.rungs() {
            let reached = standing.running.iter().map(|trial| self.of(trial, rung));
            let reached = reached.collect::<Result<Vec<Option<Trial>>>>()?;
            standing.behind = (0..reached.len())
                .filter(|place| reached[*place].is_none())
                .collect();
            standing.epochs += ((reached.len() - standing.behind.len()) * (rung - before)) as u64;
            let Some(mut trials) = reached.into_iter().collect::<Option<Vec<Trial>>>() else {
                standing.rung = Some(before..rung);
                return Ok(standing);
            };
            trials.sort_by(|a, b| a.loss().total_cmp(&b.loss()).then(a.number.cmp(&b.number)));
            let on = if rung == settings.epochs {
                trials.len()
            } else {
                kept(trials.len())
            };
            // Losers of later rounds stand before those of earlier ones.
            standing.ended.splice(0..0, trials.split_off(on));
            (standing.running, before) = (trials, rung);
        }
        Ok(standing)
    }
}
