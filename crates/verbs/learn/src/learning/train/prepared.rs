//! A set ready for training.

use super::settings::{SplitBy, TrainSettings};
use anyhow::{Result, bail};
use protomer_learn::number_classes::NumberClasses;
use protomer_learn::sample::{Description, SampleSource};
use protomer_learn::scaling::{Quarantined, screen};
use protomer_learn::split::{Split, family_weights, labels_in_one_cluster};
use protomer_learn::targets::{Classes, LabelCount, Target, number};
use protomer_learn::view::View;

/// A set ready for training: samples with a class, classes, split.
#[derive(Debug)]
pub struct Prepared<'a> {
    /// The samples that have a class.
    pub view: View<'a>,
    /// Descriptions of the samples, with the class as label.
    pub descriptions: Vec<Description>,
    /// Classes of the samples.
    pub classes: Classes,
    /// Numbers of the samples, if it is a number that is predicted.
    pub numbers: Option<Numbers>,
    /// The split, without samples that cannot be read.
    pub split: Split,
    /// Samples left out.
    pub quarantined: Vec<Quarantined>,
    /// Labels too rare for a separate class, merged into "other".
    pub other_labels: Vec<LabelCount>,
    /// Classes confined to one cluster, if clusters stay together.
    pub single_cluster_classes: Vec<String>,
}

/// Labels that are numbers, and the classes that they are cut into.
#[derive(Debug, Clone, PartialEq)]
pub struct Numbers {
    /// The number of each sample.
    pub of_samples: Vec<f64>,
    /// The classes. Their bounds are those of all samples, as the split deals out classes; each stands for
    /// the mean of its training samples.
    pub classes: NumberClasses,
}

impl Numbers {
    fn from_labels(labels: &[&str], count: Option<usize>) -> Result<Self> {
        let of_samples = labels.iter().map(|label| number(label));
        let of_samples = of_samples.collect::<Result<Vec<f64>, _>>()?;
        let count = count.unwrap_or(TrainSettings::NUMBER_CLASSES);
        let classes = NumberClasses::from_numbers(&of_samples, count)?;
        Ok(Self {
            of_samples,
            classes,
        })
    }

    /// The same numbers, with the means of the training part.
    fn fitted(mut self, training: &[usize], descriptions: &[Description]) -> Self {
        let weights = family_weights(descriptions);
        let weighted = |sample: &usize| (self.of_samples[*sample], weights[*sample]);
        let weighted: Vec<(f64, f64)> = training.iter().map(weighted).collect();
        self.classes = self.classes.with_means_of(&weighted);
        self
    }
}

impl<'a> Prepared<'a> {
    /// Applies target and split to a set.
    ///
    /// # Errors
    /// If fewer than two classes remain, or there are too few clusters for the split.
    pub fn new(settings: &TrainSettings, set: &'a dyn SampleSource) -> Result<Self> {
        let target = settings.target;
        let mut quarantined = without_class(target, set);
        let view = View::new(set).relabelled(|description| {
            target
                .read(&description.label)
                .ok()
                .filter(|class| !class.is_empty())
        });
        let labels: Vec<&str> = view
            .descriptions()
            .iter()
            .map(|description| description.label.as_str())
            .collect();
        let example = quarantined
            .first()
            .map(|bad| format!(" ({} has none: {})", bad.name, bad.reason));
        let example = example.unwrap_or_default();
        let numbers = match target {
            Target::Number if labels.is_empty() => bail!(
                "none of the {} samples has a number{example}; make a set with numbers as labels, or \
                 take another --target",
                set.descriptions().len()
            ),
            Target::Number => Some(Numbers::from_labels(&labels, settings.number_classes)?),
            _ => None,
        };
        let classes = match &numbers {
            Some(numbers) => Classes::of_numbers(&numbers.of_samples, &numbers.classes),
            None => Classes::from_labels(&labels, Target::Label, settings.least_samples)?,
        };
        if classes.names.len() < 2 {
            bail!(
                "{} of {} samples have a class{example}, and there are {} classes of at least {} samples; \
                 two are needed: take more samples, another --target, or a smaller --least-samples",
                labels.len(),
                set.descriptions().len(),
                classes.names.len(),
                settings.least_samples
            );
        }
        let other_labels = classes.joined(&labels);
        let mut descriptions = view.descriptions().to_vec();
        for (sample, class) in descriptions.iter_mut().zip(&classes.labels) {
            sample.label.clone_from(&classes.names[*class]);
        }
        let single_cluster_classes = match settings.split_by {
            SplitBy::Cluster => labels_in_one_cluster(&descriptions),
            SplitBy::Sample => Vec::new(),
        };
        let single_cluster_classes = single_cluster_classes
            .into_iter()
            .map(String::from)
            .collect();
        let seed = settings.split_seed.unwrap_or(settings.training.seed);
        let split = match settings.split_by {
            SplitBy::Cluster => Split::grouped(&descriptions, seed, settings.fractions)?,
            SplitBy::Sample => Split::random(&descriptions, seed, settings.fractions)?,
        };
        let mut part = |samples: &[usize]| {
            let (good, bad) = screen(&view, samples);
            quarantined.extend(bad);
            good
        };
        let training = match settings.training_share {
            Some(share) => split.share_of_training(&descriptions, share, seed)?,
            None => split.training.clone(),
        };
        let split = Split {
            training: part(&training),
            validation: part(&split.validation),
            test: part(&split.test),
        };
        check_parts(&split, &quarantined)?;
        let numbers = numbers.map(|numbers| numbers.fitted(&split.training, &descriptions));
        Ok(Self {
            view,
            descriptions,
            classes,
            numbers,
            split,
            quarantined,
            other_labels,
            single_cluster_classes,
        })
    }
}

/// The samples without a class under a target, and why.
fn without_class(target: Target, set: &dyn SampleSource) -> Vec<Quarantined> {
    let mut without = Vec::new();
    for (sample, description) in set.descriptions().iter().enumerate() {
        let reason = match target.read(&description.label) {
            Ok(class) if class.is_empty() => "it has no label".to_owned(),
            Ok(_) => continue,
            Err(error) => error.to_string(),
        };
        without.push(Quarantined {
            sample,
            name: description.name.clone(),
            reason,
        });
    }
    without
}

/// Refuses a split with an empty part.
fn check_parts(split: &Split, quarantined: &[Quarantined]) -> Result<()> {
    for (part, samples) in [
        ("training", &split.training),
        ("validation", &split.validation),
        ("test", &split.test),
    ] {
        if samples.is_empty() {
            let why = quarantined.first().map_or_else(
                || "give it a share with --fractions, or take more clusters".to_owned(),
                |bad| {
                    format!(
                        "{} samples cannot be used, such as {}: {}",
                        quarantined.len(),
                        bad.name,
                        bad.reason
                    )
                },
            );
            bail!("the {part} part has no samples: {why}");
        }
    }
    Ok(())
}
