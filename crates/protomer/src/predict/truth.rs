//! The true class of each sample of a set, and whether training has seen it.

use super::trained::Trained;
use crate::train::{Prepared, Source};
use anyhow::Result;
use protomer_learn::SampleSource;
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

/// What is known of the samples of a set besides what a network says.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Whether the network was trained on this very set.
    pub is_training_set: bool,
    /// The number of the class of each sample; none where its label is none of the network's classes.
    pub classes: Vec<Option<usize>>,
    /// The part each sample belonged to; none in another set than that of the training.
    pub parts: Vec<Option<Part>>,
}

impl Part {
    /// As tables have it.
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
        let Split { training, validation, test } = &prepared.split;
        let parts = [(training, Part::Training), (validation, Part::Validation), (test, Part::Test)];
        let part_of: BTreeMap<usize, Part> =
            parts.into_iter().flat_map(|(samples, part)| samples.iter().map(move |sample| (*sample, part))).collect();
        // Samples without a class are not among those prepared; names are unique.
        let known: BTreeMap<&str, usize> =
            prepared.descriptions.iter().enumerate().map(|(place, known)| (known.name.as_str(), place)).collect();
        let place = |name: &str| known.get(name).copied();
        let names = || set.descriptions().iter().map(|known| known.name.as_str());
        Ok(Self {
            is_training_set: true,
            classes: names().map(|name| prepared.classes.labels.get(place(name)?).copied()).collect(),
            parts: names().map(|name| part_of.get(&place(name)?).copied()).collect(),
        })
    }

    /// Labels that are a class under the target of the training.
    fn of_other(trained: &Trained, set: &dyn SampleSource) -> Self {
        let names = &trained.model.card.classes;
        let class = |label: &str| {
            let class = trained.settings.target.of(label).ok()?;
            names.iter().position(|name| *name == class)
        };
        Self {
            is_training_set: false,
            classes: set.descriptions().iter().map(|known| class(&known.label)).collect(),
            parts: vec![None; set.descriptions().len()],
        }
    }

    /// Whether a sample may be scored: its class is known and training has not seen it.
    pub fn may_be_scored(&self, sample: usize) -> bool {
        let part = self.parts.get(sample).copied().flatten();
        let fresh = if self.is_training_set { part == Some(Part::Test) } else { true };
        fresh && self.classes.get(sample).copied().flatten().is_some()
    }
}

/// A set that was moved is still the same.
fn is_same(trained: &Source, present: &Source) -> bool {
    match (trained, present) {
        (Source::Set { digest: trained, .. }, Source::Set { digest: present, .. }) => trained == present,
        _ => false,
    }
}
