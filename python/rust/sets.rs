//! The parts of a set of voxels, as `train` would make them.

use crate::errors::ConfigError;
use protomer_learn::number_classes::NumberClasses;
use protomer_learn::split::{Fractions, Split};
use protomer_learn::targets::{Classes, Target, number};
use protomer_learn::{Description, LearnError};
use pyo3::prelude::*;

/// The samples of training, validation and test part. `labels` and `clusters` have an entry per
/// sample; samples without a label are in no part.
#[pyfunction]
#[pyo3(signature = (labels, clusters, *, numbers, least_samples, number_classes, by_cluster, seed, fractions))]
#[allow(clippy::too_many_arguments)]
pub fn parts(
    labels: Vec<String>,
    clusters: Vec<String>,
    numbers: bool,
    least_samples: usize,
    number_classes: usize,
    by_cluster: bool,
    seed: u64,
    fractions: [f64; 3],
) -> PyResult<[Vec<usize>; 3]> {
    let question = Question {
        numbers,
        least_samples,
        number_classes,
    };
    let [training, validation, test] = fractions;
    let fractions = Fractions {
        training,
        validation,
        test,
    };
    let refused = |error: LearnError| ConfigError::new_err(error.to_string());
    question
        .split(&labels, &clusters, by_cluster, seed, fractions)
        .map_err(refused)
}

/// Classes that a split deals out.
struct Question {
    numbers: bool,
    least_samples: usize,
    number_classes: usize,
}

impl Question {
    fn classes(&self, labels: &[&str]) -> Result<Classes, LearnError> {
        if !self.numbers {
            return Classes::from_labels(labels, Target::Label, self.least_samples);
        }
        let numbers = labels.iter().map(|label| number(label));
        let numbers = numbers.collect::<Result<Vec<f64>, _>>()?;
        let classes = NumberClasses::from_numbers(&numbers, self.number_classes)?;
        Ok(Classes::of_numbers(&numbers, &classes))
    }

    fn split(
        &self,
        labels: &[String],
        clusters: &[String],
        by_cluster: bool,
        seed: u64,
        fractions: Fractions,
    ) -> Result<[Vec<usize>; 3], LearnError> {
        let has_class = |label: &str| !label.is_empty() && (!self.numbers || number(label).is_ok());
        let pairs = labels.iter().zip(clusters).enumerate();
        let samples: Vec<_> = pairs
            .filter(|(_, (label, _))| has_class(label.as_str()))
            .collect();
        let of_kept: Vec<&str> = samples
            .iter()
            .map(|(_, (label, _))| label.as_str())
            .collect();
        let classes = self.classes(&of_kept)?;
        let describe =
            |((sample, (_, cluster)), class): (&(usize, (&String, &String)), &usize)| Description {
                name: sample.to_string(),
                label: classes.names[*class].clone(),
                cluster: (*cluster).clone(),
                ..Description::default()
            };
        let descriptions: Vec<Description> =
            samples.iter().zip(&classes.labels).map(describe).collect();
        let split = match by_cluster {
            true => Split::grouped(&descriptions, seed, fractions)?,
            false => Split::random(&descriptions, seed, fractions)?,
        };
        let places = |part: Vec<usize>| -> Vec<usize> {
            part.iter().map(|place| samples[*place].0).collect()
        };
        Ok([
            places(split.training),
            places(split.validation),
            places(split.test),
        ])
    }
}
