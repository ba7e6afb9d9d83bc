//! `trained_on.json`: the structures that a network has seen, so that none of them is scored as
//! new.

use super::prepared::Prepared;
use anyhow::{Context, Result};
use protomer_io::atomic::write_bytes;
use protomer_learn::SampleSource;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The file's name in the directory of a training.
pub const TRAINED_ON: &str = "trained_on.json";

/// The samples that a network was trained on.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainedOn {
    /// The samples that the weights were fitted to.
    pub training: Vec<Seen>,
    /// The samples on which epoch and temperature were chosen.
    pub validation: Vec<Seen>,
    /// The samples of the training that the weights started from.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub earlier: Vec<Seen>,
}

/// A structure seen by a network.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Seen {
    /// Name of the structure in the set.
    pub name: String,
    /// Cluster of the structure.
    pub cluster: String,
    /// SHA-256 of the file of the structure.
    pub sha256: String,
}

impl TrainedOn {
    /// The samples of a training.
    pub fn from_prepared(prepared: &Prepared) -> Self {
        let part = |samples: &[usize]| {
            let mut entries = Vec::with_capacity(samples.len());
            for sample in samples {
                let description = &prepared.descriptions[*sample];
                entries.push(Seen {
                    name: description.name.clone(),
                    cluster: description.cluster.clone(),
                    sha256: prepared.view.file_sha256(*sample).to_owned(),
                });
            }
            entries
        };
        Self {
            training: part(&prepared.split.training),
            validation: part(&prepared.split.validation),
            earlier: Vec::new(),
        }
    }

    /// Reads the file from the directory of a training. `None` if an earlier version ran the
    /// training.
    ///
    /// # Errors
    /// Names the damaged file.
    pub fn read(directory: &Path) -> Result<Option<Self>> {
        let path = directory.join(TRAINED_ON);
        let bytes = match protomer_io::input::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => {
                return Err(error).with_context(|| format!("cannot read {}", path.display()));
            }
        };
        let damaged = || {
            let name = path.display();
            format!(
                "{name} is damaged; remove it and repeat the train command, which writes it again"
            )
        };
        serde_json::from_slice(&bytes)
            .map(Some)
            .with_context(damaged)
    }

    /// Writes the file into the directory of a training.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, directory: &Path) -> Result<()> {
        let bytes = serde_json::to_vec(self)
            .context("the list of training samples cannot be serialised")?;
        Ok(write_bytes(&directory.join(TRAINED_ON), &bytes)?)
    }

    /// The samples of both parts, and of the training that the weights started from.
    pub fn samples(&self) -> impl Iterator<Item = &Seen> {
        let own = self.training.iter().chain(&self.validation);
        own.chain(&self.earlier)
    }
}
