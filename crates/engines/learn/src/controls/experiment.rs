//! Experiments on the controls: what is trained on what, and what must come out.

use super::{Control, Form, Variant};
use crate::block::BlockSettings;
use crate::network::{GlobalPooling, NetworkSettings};
use crate::scaling::ScalingMode;
use crate::split::{Fractions, Split};
use crate::training::TrainingSettings;
use crate::{Description, Result};
use serde::{Deserialize, Serialize};

/// One training on the set of a control.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Experiment {
    /// A name, unique in the control; also that of its directory.
    pub name: &'static str,
    /// Placement of the samples.
    pub variant: Variant,
    /// The channels the network sees.
    pub channels: &'static [&'static str],
    /// Whether clusters stay together in the split. Otherwise samples are dealt out one by one.
    pub split_by_cluster: bool,
    /// Scaling of the channels.
    pub scaling: ScalingMode,
    /// Expected balanced accuracy.
    pub expected: Expected,
}

/// The balanced accuracy on the test part that an experiment must have.
///
/// ```
/// use protomer_learn::controls::Expected;
///
/// assert!(Expected::AtLeast(0.95).verdict(0.96, 2, 100).is_reached);
/// assert!(Expected::Chance.verdict(0.56, 2, 100).is_reached);
/// assert!(!Expected::Chance.verdict(0.7, 2, 100).is_reached);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Expected {
    /// A balanced accuracy of at least this.
    AtLeast(f64),
    /// The balanced accuracy of guessing, within three standard errors: see [`Expected::verdict`].
    Chance,
}

/// Whether an experiment came out as expected.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Smallest balanced accuracy that is accepted.
    pub at_least: f64,
    /// Largest balanced accuracy that is accepted.
    pub at_most: f64,
    /// Balanced accuracy on the test part.
    pub balanced_accuracy: f64,
    /// Whether the balanced accuracy lies between them.
    pub is_reached: bool,
}

impl Expected {
    /// Judges a balanced accuracy over `clusters` independent clusters of the test part, for
    /// `classes` classes.
    ///
    /// Guessing has the mean 1/K and, from N clusters of equal share, the standard error
    /// sqrt((1/K)(1 - 1/K)/N): a balanced accuracy is the mean of K recalls, each over N/K
    /// clusters. Samples of one cluster count as one.
    ///
    /// ```
    /// use protomer_learn::controls::Expected;
    /// assert!(Expected::AtLeast(0.9).verdict(0.95, 2, 100).is_reached);
    /// // The standard error of guessing is 0.05.
    /// let guessed = Expected::Chance.verdict(0.6, 2, 100);
    /// assert!(guessed.is_reached && (guessed.at_most - 0.65).abs() < 1e-12);
    /// assert!(!Expected::Chance.verdict(0.7, 2, 100).is_reached);
    /// ```
    pub fn verdict(self, balanced_accuracy: f64, classes: usize, clusters: usize) -> Verdict {
        let (at_least, at_most) = match self {
            Self::AtLeast(level) => (level, 1.0),
            Self::Chance => {
                let chance = 1.0 / classes.max(1) as f64;
                let error = (chance * (1.0 - chance) / clusters.max(1) as f64).sqrt();
                (
                    (chance - 3.0 * error).max(0.0),
                    (chance + 3.0 * error).min(1.0),
                )
            }
        };
        Verdict {
            at_least,
            at_most,
            balanced_accuracy,
            is_reached: (at_least..=at_most).contains(&balanced_accuracy),
        }
    }
}

impl Experiment {
    /// Splits these samples as the experiment prescribes.
    ///
    /// # Errors
    /// As for [`Split::grouped`].
    pub fn split(
        &self,
        descriptions: &[Description],
        seed: u64,
        fractions: Fractions,
    ) -> Result<Split> {
        if self.split_by_cluster {
            Split::grouped(descriptions, seed, fractions)
        } else {
            Split::random(descriptions, seed, fractions)
        }
    }
}

/// Sizes of an experiment that reach the expected level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Samples in all.
    pub samples: usize,
    /// Voxels along each edge.
    pub size: usize,
    /// Passes over the training part.
    pub epochs: usize,
    /// Shares of training, validation and test.
    pub fractions: Fractions,
}

impl Plan {
    const fn new(samples: usize, size: usize, epochs: usize, fractions: Fractions) -> Self {
        Self {
            samples,
            size,
            epochs,
            fractions,
        }
    }
}

const fn fractions(training: f64, validation: f64, test: f64) -> Fractions {
    Fractions {
        training,
        validation,
        test,
    }
}

const MOSTLY_TRAINING: Fractions = fractions(0.7, 0.1, 0.2);
const USUAL: Fractions = fractions(0.6, 0.1, 0.3);
const HALVES: Fractions = fractions(0.5, 0.1, 0.4);
/// Fractions for experiments where the number of clusters in the test part limits what can be told
/// from chance: test samples cost little, because the network sees them once.
const MOSTLY_TEST: Fractions = fractions(0.17, 0.03, 0.8);

const ALL: &[&str] = &["shape", "potential", "hydropathy"];
const SHAPE: &[&str] = &["shape"];
const WITH_POTENTIAL: &[&str] = &["shape", "potential"];
const WITH_HYDROPATHY: &[&str] = &["shape", "hydropathy"];

const fn experiment(
    name: &'static str,
    channels: &'static [&'static str],
    expected: Expected,
) -> Experiment {
    Experiment {
        name,
        variant: Variant::Usual,
        channels,
        split_by_cluster: true,
        scaling: ScalingMode::Robust,
        expected,
    }
}

impl Control {
    /// Experiments of the control, the main one first.
    ///
    /// ```
    /// use protomer_learn::controls::{Control, Expected};
    ///
    /// let [with, without] = &Control::Charge.experiments()[..] else { unreachable!() };
    /// assert_eq!(with.channels, ["shape", "potential"]);
    /// assert_eq!(without.channels, ["shape"]);
    /// assert_eq!(without.expected, Expected::Chance);
    /// ```
    pub fn experiments(self) -> Vec<Experiment> {
        use Expected::{AtLeast, Chance};
        match self {
            Self::Shapes => vec![experiment("shape", SHAPE, AtLeast(0.97))],
            Self::Charge => vec![
                experiment("with-potential", WITH_POTENTIAL, AtLeast(0.95)),
                experiment("shape-alone", SHAPE, Chance),
            ],
            Self::Patch => vec![
                experiment("with-hydropathy", WITH_HYDROPATHY, AtLeast(0.95)),
                experiment("shape-alone", SHAPE, Chance),
            ],
            Self::Xor => vec![
                experiment("all-channels", ALL, AtLeast(0.9)),
                experiment("with-potential", WITH_POTENTIAL, Chance),
                experiment("with-hydropathy", WITH_HYDROPATHY, Chance),
                experiment("shape-alone", SHAPE, Chance),
            ],
            Self::Assemblies => vec![experiment("shape", SHAPE, AtLeast(0.8))],
            Self::Permuted => vec![experiment("split-by-cluster", ALL, Chance)],
            Self::Identity => {
                let mut random = experiment("random-split", ALL, AtLeast(0.9));
                random.split_by_cluster = false;
                vec![random, experiment("split-by-cluster", ALL, Chance)]
            }
            Self::Orientation => {
                let mut rotated = experiment("turned", SHAPE, Chance);
                rotated.variant = Variant::Turned;
                vec![experiment("as-deposited", SHAPE, AtLeast(0.95)), rotated]
            }
            Self::Size => {
                let mut filling = experiment("filling-the-box", SHAPE, Chance);
                filling.variant = Variant::FillingTheBox;
                vec![experiment("fixed-scale", SHAPE, AtLeast(0.95)), filling]
            }
            Self::HeavyTails => {
                let mut raw = experiment("raw", WITH_POTENTIAL, Chance);
                raw.scaling = ScalingMode::Raw;
                vec![experiment("robust", WITH_POTENTIAL, AtLeast(0.9)), raw]
            }
        }
    }

    /// The network that an experiment of the control trains.
    pub fn network(self, experiment: &Experiment, form: Form) -> NetworkSettings {
        // Recognising forty proteins takes a network that can remember.
        let (first, groups) = match (self, form) {
            (Self::Identity, _) => (16, Some(4)),
            (_, Form::Short) => (8, None),
            (_, Form::Full) => (16, None),
        };
        let block = |i: usize| BlockSettings {
            width: first << i,
            kernel: 3,
            groups,
            pool: true,
        };
        NetworkSettings {
            channels: experiment.channels.len(),
            classes: self.classes().len(),
            blocks: (0..3).map(block).collect(),
            pooling: GlobalPooling::AverageAndMaximum,
        }
    }

    /// Settings of the training of an experiment: it goes to the last epoch, because the number of
    /// epochs that it takes is known.
    pub fn training(self, experiment: &Experiment, form: Form, seed: u64) -> TrainingSettings {
        TrainingSettings {
            epochs: self.plan(experiment, form).epochs,
            learning_rate: 3e-3,
            batch: 16,
            patience: Some(1_000_000),
            channels: experiment
                .channels
                .iter()
                .map(|name| (*name).to_owned())
                .collect(),
            scaling: experiment.scaling,
            seed,
            ..TrainingSettings::default()
        }
    }

    /// Sizes of an experiment in the short and the full form.
    pub fn plan(self, experiment: &Experiment, form: Form) -> Plan {
        let by_cluster = experiment.split_by_cluster;
        match (self, form) {
            (Self::Shapes | Self::Assemblies, Form::Short) => {
                Plan::new(1500, 16, 20, MOSTLY_TRAINING)
            }
            (Self::Shapes, Form::Full) => Plan::new(3000, 32, 20, MOSTLY_TRAINING),
            (Self::Assemblies, Form::Full) => Plan::new(4000, 32, 25, MOSTLY_TRAINING),
            // As many samples train as with a random split, about 20 and 30 proteins.
            (Self::Identity, Form::Short) if by_cluster => Plan::new(1920, 16, 60, MOSTLY_TEST),
            (Self::Identity, Form::Full) if by_cluster => Plan::new(2880, 24, 80, MOSTLY_TEST),
            (Self::Identity, Form::Short) => Plan::new(640, 16, 60, HALVES),
            (Self::Identity, Form::Full) => Plan::new(960, 24, 80, HALVES),
            (Self::Permuted, Form::Short) => Plan::new(640, 16, 12, HALVES),
            (Self::Permuted, Form::Full) => Plan::new(1600, 24, 20, HALVES),
            (Self::Xor, Form::Short) => Plan::new(800, 16, 20, USUAL),
            (Self::Xor, Form::Full) => Plan::new(2000, 24, 25, USUAL),
            (Self::Patch, Form::Short) => Plan::new(1000, 16, 20, USUAL),
            (_, Form::Short) => Plan::new(600, 16, 12, USUAL),
            (_, Form::Full) => Plan::new(1600, 24, 20, USUAL),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::setting::Choices;
    use std::collections::BTreeSet;

    #[test]
    fn experiments_are_named_apart_and_see_channels_that_exist() {
        for &control in Control::ALL {
            let experiments = control.experiments();
            let names: BTreeSet<&str> = experiments.iter().map(|one| one.name).collect();
            assert_eq!(names.len(), experiments.len());
            for experiment in &experiments {
                let exists = |channel| control.channels().contains(channel);
                assert!(experiment.channels.iter().all(exists));
                for form in [Form::Short, Form::Full] {
                    let plan = control.plan(experiment, form);
                    let shares = plan.fractions;
                    let sum = shares.training + shares.validation + shares.test;
                    assert!((sum - 1.0).abs() < 1e-12 && (16..=32).contains(&plan.size));
                }
            }
        }
    }

    #[test]
    fn identity_tests_so_many_proteins_that_chance_is_narrow() {
        let [random, by_cluster] = &Control::Identity.experiments()[..] else {
            panic!("two experiments")
        };
        for form in [Form::Short, Form::Full] {
            let plan = Control::Identity.plan(by_cluster, form);
            let set = Control::Identity.samples(Variant::Usual, plan.samples, 16, 1);
            let split = by_cluster
                .split(&set.descriptions, 1, plan.fractions)
                .unwrap();
            // The training is as long as that of the random split.
            let of_random = Control::Identity.plan(random, form);
            let expected = of_random.fractions.training * of_random.samples as f64;
            assert!((split.training.len() as f64 / expected - 1.0).abs() < 0.1);
            let clusters: BTreeSet<&str> = split
                .test
                .iter()
                .map(|sample| &*set.descriptions[*sample].cluster)
                .collect();
            let verdict = Expected::Chance.verdict(0.5, 2, clusters.len());
            assert!(
                verdict.at_least > 0.34 && verdict.at_most < 0.66,
                "{verdict:?}"
            );
        }
    }

    #[test]
    fn chance_is_as_wide_as_the_test_split_makes_it() {
        let verdict = Expected::Chance.verdict(0.5, 2, 400);
        assert!((verdict.at_most - 0.575).abs() < 1e-12);
        assert!((verdict.at_least - 0.425).abs() < 1e-12);
        // Four clusters show nothing.
        assert!(Expected::Chance.verdict(1.0, 2, 4).is_reached);
    }
}
