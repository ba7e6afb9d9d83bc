//! `trained_on.json`: which structures a network has seen, so that none of them is scored as if it
//! were new.

use super::run::Prepared;
use anyhow::{Context, Result};
use protomer_io::atomic::write_atomically;
use protomer_learn::SampleSource;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The file's name in the directory of a training.
pub const TRAINED_ON: &str = "trained_on.json";

/// The samples from which a network was made.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainedOn {
    /// Weights were fitted to these.
    pub training: Vec<Seen>,
    /// Epoch and temperature were chosen on these.
    pub validation: Vec<Seen>,
}

/// A structure that a network has seen.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Seen {
    /// Its name in the set.
    pub name: String,
    /// Its cluster.
    pub cluster: String,
    /// SHA-256 of its file.
    pub sha256: String,
}

impl TrainedOn {
    /// The samples of a training.
    pub fn of(prepared: &Prepared) -> Self {
        let part = |samples: &[usize]| {
            let mut seen = Vec::with_capacity(samples.len());
            for sample in samples {
                let known = &prepared.descriptions[*sample];
                seen.push(Seen {
                    name: known.name.clone(),
                    cluster: known.cluster.clone(),
                    sha256: prepared.view.file_sha256(*sample).to_owned(),
                });
            }
            seen
        };
        Self {
            training: part(&prepared.split.training),
            validation: part(&prepared.split.validation),
        }
    }

    /// Reads them from the directory of a training. `None` if an earlier version trained there.
    ///
    /// # Errors
    /// Names the file that is damaged.
    pub fn read(directory: &Path) -> Result<Option<Self>> {
        let path = directory.join(TRAINED_ON);
        let bytes = match std::fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => {
                return Err(error).with_context(|| format!("cannot read {}", path.display()));
            }
        };
        let damaged = || {
            let name = path.display();
            format!(
                "{name} is damaged; remove it and repeat the train command, which writes it anew"
            )
        };
        serde_json::from_slice(&bytes)
            .map(Some)
            .with_context(damaged)
    }

    /// Writes them into the directory of a training.
    ///
    /// # Errors
    /// If the disk is full.
    pub fn write(&self, directory: &Path) -> Result<()> {
        let bytes =
            serde_json::to_vec(self).context("what was trained on cannot be written down")?;
        Ok(write_atomically(&directory.join(TRAINED_ON), |file| {
            file.write_all(&bytes)
        })?)
    }

    /// All of both parts.
    pub fn samples(&self) -> impl Iterator<Item = &Seen> {
        self.training.iter().chain(&self.validation)
    }
}
