//! Loads the network of a directory, or says what to do if there is none.

use crate::learning::labels::{LABELS, LabelTable};
use crate::learning::train::{MODEL, Metrics, SETTINGS, Source, TrainSettings, TrainedOn};
use anyhow::{Context, Result, bail};
use protomer_kernel::setting::Choices;
use protomer_learn::targets::number;
use protomer_learn::training::Model;
use std::path::{Path, PathBuf};

/// A finished training on a set.
#[derive(Debug)]
pub struct Trained {
    /// The settings of the training.
    pub settings: TrainSettings,
    /// The network with its scaling and classes.
    pub model: Model,
    /// The structures that the network has seen; `None` if it was trained by an earlier version,
    /// which did not record them.
    pub training_structures: Option<TrainedOn>,
    /// The labels of the training, if they came from a table.
    pub labels: Option<LabelTable>,
}

impl Trained {
    /// The training of a directory.
    ///
    /// # Errors
    /// If it holds something else, a control, or an unfinished training.
    pub fn read(directory: &Path) -> Result<Self> {
        let shown = directory.display();
        let is_there = |name: &str| directory.join(name).exists();
        if !directory.is_dir() {
            bail!(
                "{shown} is not a directory; give the one that protomer train wrote its results \
                 into"
            );
        }
        if is_there("trials.csv") || is_there("trials") {
            bail!(
                "{shown} holds a search, which keeps no network; train the best settings with protomer \
                 train SET.zarr --config {shown}/best.toml -o RUN, and give RUN"
            );
        }
        if !is_there(SETTINGS) {
            return Err(match training_below(directory, 2) {
                Some(below) => anyhow::anyhow!(
                    "{shown} is not the directory of a training, but contains some; give one of \
                     them, such as {}",
                    below.display()
                ),
                None => anyhow::anyhow!(
                    "{shown} holds no training; give the directory that protomer train wrote into"
                ),
            });
        }
        let settings = TrainSettings::read(&directory.join(SETTINGS)).with_context(|| {
            format!(
                "{shown} does not hold a training of this version; give another directory, or \
                 train again"
            )
        })?;
        if let Source::Control { name, .. } = settings.source {
            bail!(
                "{shown} holds the control {}, whose network has seen synthetic voxels only; give \
                 the directory of a training on a set (protomer train SET.zarr -o RUN)",
                name.name()
            );
        }
        if !is_there(MODEL) || Metrics::read(directory)?.is_none() {
            bail!("the training in {shown} is not finished; the same train command continues it");
        }
        let path = directory.join(MODEL);
        let bytes = protomer_io::input::read(&path)
            .with_context(|| format!("cannot read {}", path.display()))?;
        let model = Model::from_bytes(&bytes)
            .with_context(|| format!("{} is damaged; train again with --force", path.display()))?;
        let labels = match settings.labels {
            Some(_) => Some(LabelTable::read(&directory.join(LABELS), None)?),
            None => None,
        };
        Ok(Self {
            labels,
            settings,
            model,
            training_structures: TrainedOn::read(directory)?,
        })
    }
}

impl Trained {
    /// The class of a label under the target of the training, if it is one of the network's.
    pub fn class_of(&self, label: &str) -> Option<usize> {
        let card = &self.model.card;
        match &card.number_classes {
            Some(classes) => number(label).ok().map(|number| classes.class_of(number)),
            None => {
                let class = self.settings.target.read(label).ok()?;
                card.classes.iter().position(|name| *name == class)
            }
        }
    }
}

/// The first training at most `levels` levels below, such as those of an ablation
/// (`ablation/CHANNELS/seed_N`).
fn training_below(directory: &Path, levels: usize) -> Option<PathBuf> {
    let mut folders = Vec::new();
    for entry in std::fs::read_dir(directory).ok()?.flatten() {
        let path = entry.path();
        if path.is_dir() {
            folders.push(path);
        }
    }
    folders.sort();
    for path in &folders {
        if path.join(SETTINGS).is_file() && path.join(MODEL).is_file() {
            return Some(path.clone());
        }
    }
    if levels < 2 {
        return None;
    }
    let mut below = folders.iter().map(|path| training_below(path, levels - 1));
    below.find_map(|training| training)
}
