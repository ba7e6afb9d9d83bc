//! The true class of each sample of a set, and whether training has seen it.

use super::trained::Trained;
use crate::learning::train::{Prepared, Source, TrainedOn};
use anyhow::Result;
use protomer_learn::SampleSource;
use protomer_learn::novelty::Familiar;
use serde::Serialize;
use std::collections::BTreeMap;

/// The part of a training that a sample belonged to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Part {
    /// The part that the weights were fitted to.
    Training,
    /// The part on which epoch and temperature were chosen.
    Validation,
    /// The part that was reserved for the scores.
    Test,
}

/// Reasons why a sample is not scored in a set other than that of the training.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Unscored {
    /// The label of the sample is not a class of the network.
    NoClass,
    /// The file of the sample was in the training or the validation part.
    SameFile,
    /// The cluster of the sample was in the training or the validation part.
    SameCluster,
    /// The set does not record the file it was made from.
    FileUnknown,
    /// The training did not record the structures it used.
    TrainingUnknown,
}

impl Unscored {
    /// The reason in words, to follow a number of samples.
    pub fn words(self) -> &'static str {
        match self {
            Self::NoClass => "whose label is not a class of the network",
            Self::SameFile => "whose file was in the training or validation part",
            Self::SameCluster => "whose cluster was in the training or validation part",
            Self::FileUnknown => "whose source files the set does not record",
            Self::TrainingUnknown => {
                "that the network may have been trained on: an earlier version did not record \
                 this; repeat the train command to add the record"
            }
        }
    }
}

/// Classes of the samples of a set, and whether training has seen them.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Whether this is the set of the training.
    pub is_training_set: bool,
    /// The class index of each sample; `None` if its label is not a class of the network.
    pub classes: Vec<Option<usize>>,
    /// The part that each sample belonged to; `None` if this is not the set of the training.
    pub parts: Vec<Option<Part>>,
    /// Reason why each sample is not scored, if this is not the set of the training.
    pub unscored: Vec<Option<Unscored>>,
}

impl Part {
    /// Name of the part in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Training => "training",
            Self::Validation => "validation",
            Self::Test => "test",
        }
    }
}

impl Truth {
    /// Collects what is known about the set described by `source`.
    ///
    /// # Errors
    /// If the set of the training no longer yields the same classes.
    pub fn read(trained: &Trained, source: &Source, set: &dyn SampleSource) -> Result<Self> {
        if is_same(&trained.settings.source, source) {
            Self::of_training_set(trained, set)
        } else {
            Ok(Self::of_other(trained, set))
        }
    }

    /// Classes and split as in the training, rare classes merged.
    fn of_training_set(trained: &Trained, set: &dyn SampleSource) -> Result<Self> {
        let prepared = Prepared::new(&trained.settings, set)?;
        let mut part_of = vec![None; prepared.descriptions.len()];
        for (samples, part) in [
            (&prepared.split.training, Part::Training),
            (&prepared.split.validation, Part::Validation),
            (&prepared.split.test, Part::Test),
        ] {
            for sample in samples {
                part_of[*sample] = Some(part);
            }
        }
        // Prepared samples are those with a class, found by their unique names.
        let mut place_of = BTreeMap::new();
        for (place, description) in prepared.descriptions.iter().enumerate() {
            place_of.insert(description.name.as_str(), place);
        }
        let (mut classes, mut parts) = (Vec::new(), Vec::new());
        for sample in set.descriptions() {
            let place = place_of.get(sample.name.as_str()).copied();
            let labels = &prepared.classes.labels;
            classes.push(place.and_then(|place| labels.get(place)).copied());
            parts.push(place.and_then(|place| part_of[place]));
        }
        Ok(Self {
            is_training_set: true,
            unscored: vec![None; classes.len()],
            classes,
            parts,
        })
    }

    /// Keeps the labels that are classes under the target of the training. Samples seen in
    /// training are not scored.
    pub(super) fn of_other(trained: &Trained, set: &dyn SampleSource) -> Self {
        let training_samples = trained.training_structures.as_ref().map(TrainedOn::seen);
        let (mut classes, mut unscored) = (Vec::new(), Vec::new());
        for (sample, description) in set.descriptions().iter().enumerate() {
            let class = trained.class_of(&description.label);
            classes.push(class);
            unscored.push(match (class, &training_samples) {
                (None, _) => Some(Unscored::NoClass),
                (_, None) => Some(Unscored::TrainingUnknown),
                (_, Some(samples)) => samples
                    .familiar(set.file_sha256(sample), &description.cluster)
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

    /// Whether a sample may be scored: its class is known and it was not seen in training.
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

/// A set that has been moved is still the same set.
pub(super) fn is_same(trained: &Source, present: &Source) -> bool {
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
