//! A training that starts from the weights of another one.

use super::run::MODEL;
use super::settings::TrainSettings;
use super::trained_on::TrainedOn;
use anyhow::{Context, Result, bail};
use protomer_io::atomic::sha256_hex;
use protomer_learn::novelty::Seen;
use protomer_learn::training::Model;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The trained network that weights start from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WeightSource {
    /// The directory of the training.
    pub path: PathBuf,
    /// SHA-256 of its network.
    pub sha256: String,
}

/// A network to start from, and the structures that it has seen.
#[derive(Debug)]
pub struct Start {
    /// The network.
    pub model: Model,
    /// The structures of its training.
    pub trained_on: TrainedOn,
}

impl WeightSource {
    /// The network in the directory of a finished training.
    ///
    /// # Errors
    /// If there is none.
    pub fn in_directory(directory: &Path) -> Result<Self> {
        let path = directory
            .canonicalize()
            .with_context(|| format!("cannot read {}", directory.display()))?;
        let sha256 = sha256_hex(&bytes(&path)?);
        Ok(Self { path, sha256 })
    }

    /// The same network, wherever it lies.
    pub(super) fn without_path(&self) -> Self {
        Self {
            path: PathBuf::new(),
            ..self.clone()
        }
    }

    /// Reads the network and what it has seen.
    ///
    /// # Errors
    /// If it is not there any more, has changed, or the training did not record its structures.
    pub fn read(&self) -> Result<Start> {
        let shown = self.path.display();
        let bytes = bytes(&self.path)?;
        if sha256_hex(&bytes) != self.sha256 {
            bail!("the network in {shown} has changed since; train in another directory");
        }
        let model = Model::from_bytes(&bytes)
            .with_context(|| format!("the network in {shown} is damaged; train it again"))?;
        let Some(trained_on) = TrainedOn::read(&self.path)? else {
            bail!(
                "the training in {shown} did not record its structures; repeat its train command, which \
                 adds the record"
            );
        };
        Ok(Start { model, trained_on })
    }
}

fn bytes(directory: &Path) -> Result<Vec<u8>> {
    let path = directory.join(MODEL);
    protomer_io::input::read(&path).with_context(|| {
        format!(
            "cannot read the network {}; give the directory of a finished training",
            path.display()
        )
    })
}

impl TrainSettings {
    /// Starts from the network of another training, and takes over its shape, its channels and their
    /// scaling.
    ///
    /// # Errors
    /// If the directory holds no finished training.
    pub fn start_from(&mut self, directory: &Path) -> Result<()> {
        let source = WeightSource::in_directory(directory)?;
        let Start { model, .. } = source.read()?;
        self.blocks.clone_from(&model.card.network.blocks);
        self.pooling = model.card.network.pooling;
        self.training.channels.clone_from(&model.card.channels);
        self.training.scaling = model.card.scaling.mode;
        self.weights_from = Some(source);
        Ok(())
    }
}

impl TrainedOn {
    /// The structures in the form in which they are compared.
    pub(crate) fn seen(&self) -> Seen {
        let mut structures = Seen::default();
        for sample in self.samples() {
            structures.add(&sample.sha256, &sample.cluster);
        }
        structures
    }
}
