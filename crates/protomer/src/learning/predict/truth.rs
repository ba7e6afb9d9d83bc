//! The true class of each sample of a set, and whether training has seen it.

use super::trained::Trained;
use crate::learning::train::{Prepared, Source, TrainedOn};
use anyhow::Result;
use protomer_learn::SampleSource;
use protomer_learn::novelty::{Familiar, Seen};
use protomer_learn::split::Split;
use serde::Serialize;
use std::collections::BTreeMap;

/// The part of a training that a sample belonged to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Part {
    /// Weights were fitted to it.
    Training,
    /// Epoch and temperature were chosen on it.
    Validation,
    /// It was kept for the scores.
    Test,
}

/// Why a sample of another set than that of the training is not scored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Unscored {
    /// Its label is not a class of the network.
    NoClass,
    /// Its very file was in the training or the validation part.
    SameFile,
    /// Others of its cluster were.
    SameCluster,
    /// The set does not say which file it was made of.
    FileUnknown,
    /// What the network has seen was not written down.
    TrainingUnknown,
}

impl Unscored {
    /// In words, after a number of samples.
    pub fn words(self) -> &'static str {
        match self {
            Self::NoClass => "with a label that is no class of the network",
            Self::SameFile => "whose file was in the training or validation part",
            Self::SameCluster => "whose cluster was in the training or validation part",
            Self::FileUnknown => "of which the set does not say from which file they were made",
            Self::TrainingUnknown => {
                "that may have been trained on: an earlier version did not write down on what; \
                 repeat the train command, which does it now"
            }
        }
    }
}

/// What is known of the samples of a set besides what a network says.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Whether the network was trained on this very set.
    pub is_training_set: bool,
    /// The number of the class of each sample; `None` if its label is not a class of the network.
    pub classes: Vec<Option<usize>>,
    /// The part each sample belonged to; `None` in another set than that of the training.
    pub parts: Vec<Option<Part>>,
    /// In another set: why a sample is not scored.
    pub unscored: Vec<Option<Unscored>>,
}

impl Part {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Training => "training",
            Self::Validation => "validation",
            Self::Test => "test",
        }
    }
}

impl Truth {
    /// What is known of a set that settings would call `source`.
    ///
    /// # Errors
    /// If the set of the training no longer gives the classes it gave.
    pub fn of(trained: &Trained, source: &Source, set: &dyn SampleSource) -> Result<Self> {
        if is_same(&trained.settings.source, source) {
            Self::of_training_set(trained, set)
        } else {
            Ok(Self::of_other(trained, set))
        }
    }

    /// Classes and split as the training made them, rare classes joined.
    fn of_training_set(trained: &Trained, set: &dyn SampleSource) -> Result<Self> {
        let prepared = Prepared::new(&trained.settings, set)?;
        let Split {
            training,
            validation,
            test,
        } = &prepared.split;
        let parts = [
            (training, Part::Training),
            (validation, Part::Validation),
            (test, Part::Test),
        ];
        let part_of: BTreeMap<usize, Part> = parts
            .into_iter()
            .flat_map(|(samples, part)| samples.iter().map(move |sample| (*sample, part)))
            .collect();
        // Samples without a class are not among those prepared; names are unique.
        let known: BTreeMap<&str, usize> = prepared
            .descriptions
            .iter()
            .enumerate()
            .map(|(place, known)| (known.name.as_str(), place))
            .collect();
        let place = |name: &str| known.get(name).copied();
        let names = || set.descriptions().iter().map(|known| known.name.as_str());
        Ok(Self {
            is_training_set: true,
            classes: names()
                .map(|name| prepared.classes.labels.get(place(name)?).copied())
                .collect(),
            parts: names()
                .map(|name| part_of.get(&place(name)?).copied())
                .collect(),
            unscored: vec![None; set.descriptions().len()],
        })
    }

    /// Labels that are a class under the target of the training. Samples that the training has seen
    /// are not scored.
    fn of_other(trained: &Trained, set: &dyn SampleSource) -> Self {
        let names = &trained.model.card.classes;
        let seen = trained.seen.as_ref().map(seen);
        let (mut classes, mut unscored) = (Vec::new(), Vec::new());
        for (sample, known) in set.descriptions().iter().enumerate() {
            let class = trained.settings.target.of(&known.label).ok();
            let class = class.and_then(|class| names.iter().position(|name| *name == class));
            classes.push(class);
            unscored.push(match (class, &seen) {
                (None, _) => Some(Unscored::NoClass),
                (_, None) => Some(Unscored::TrainingUnknown),
                (_, Some(seen)) => seen
                    .familiar(set.file_sha256(sample), &known.cluster)
                    .map(Unscored::from),
            });
        }
        Self {
            is_training_set: false,
            parts: vec![None; classes.len()],
            classes,
            unscored,
        }
    }

    /// Whether a sample may be scored: its class is known and training has not seen it.
    pub fn may_be_scored(&self, sample: usize) -> bool {
        let part = self.parts.get(sample).copied().flatten();
        let why_not = self.unscored.get(sample).copied().flatten();
        let fresh = if self.is_training_set {
            part == Some(Part::Test)
        } else {
            why_not.is_none()
        };
        fresh && self.classes.get(sample).copied().flatten().is_some()
    }
}

impl From<Familiar> for Unscored {
    fn from(familiar: Familiar) -> Self {
        match familiar {
            Familiar::SameFile => Self::SameFile,
            Familiar::SameCluster => Self::SameCluster,
            Familiar::FileUnknown => Self::FileUnknown,
        }
    }
}

/// The samples of a training.
fn seen(trained_on: &TrainedOn) -> Seen {
    let mut seen = Seen::default();
    for sample in trained_on.samples() {
        seen.add(&sample.sha256, &sample.cluster);
    }
    seen
}

/// A set that was moved is still the same.
fn is_same(trained: &Source, present: &Source) -> bool {
    match (trained, present) {
        (
            Source::Set {
                digest: trained, ..
            },
            Source::Set {
                digest: present, ..
            },
        ) => trained == present,
        _ => false,
    }
}
