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
    /// How samples are placed.
    pub variant: Variant,
    /// The channels the network sees.
    pub channels: &'static [&'static str],
    /// Whether clusters stay together in the split; samples are dealt out one by one otherwise.
    pub split_by_cluster: bool,
    /// How channels are scaled.
    pub scaling: ScalingMode,
    /// What must come out.
    pub expected: Expected,
}

/// The balanced accuracy on the test split that an experiment must have.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Expected {
    /// At least this.
    AtLeast(f64),
    /// That of guessing, within three standard errors: see [`Expected::verdict`].
    Chance,
}

/// Whether an experiment came out as expected.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Lowest balanced accuracy that would do.
    pub at_least: f64,
    /// Highest balanced accuracy that would do.
    pub at_most: f64,
    /// Balanced accuracy on the test split.
    pub balanced_accuracy: f64,
    /// Whether it lies between them.
    pub is_reached: bool,
}

impl Expected {
    /// Judges a balanced accuracy over `clusters` independent clusters of the test split, for
    /// `classes` classes.
    ///
    /// Guessing has the mean 1/K and, from N clusters of equal share, the standard error
    /// sqrt((1/K)(1 - 1/K)/N): a balanced accuracy is the mean of K recalls, each over N/K
    /// clusters. Samples of one cluster count as one.
    ///
    /// ```
    /// use protomer_learn::controls::Expected;
    /// assert!(Expected::Chance.verdict(0.56, 2, 100).is_reached);
    /// assert!(!Expected::Chance.verdict(0.7, 2, 100).is_reached);
    /// assert!(!Expected::AtLeast(0.95).verdict(0.94, 2, 100).is_reached);
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
        let is_reached = (at_least..=at_most).contains(&balanced_accuracy);
        Verdict {
            at_least,
            at_most,
            balanced_accuracy,
            is_reached,
        }
    }
}

impl Experiment {
    /// Its split of these samples.
    ///
    /// # Errors
    /// As [`Split::grouped`].
    pub fn split(
        &self,
        descriptions: &[Description],
        seed: u64,
        fractions: Fractions,
    ) -> Result<Split> {
        match self.split_by_cluster {
            true => Split::grouped(descriptions, seed, fractions),
            false => Split::random(descriptions, seed, fractions),
        }
    }
}

/// How much of it: sizes that reach the expected level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Samples in all.
    pub samples: usize,
    /// Voxels along each edge.
    pub size: usize,
    /// Passes over the training split.
    pub epochs: usize,
    /// Shares of training, validation and test.
    pub fractions: Fractions,
}

const ALL: &[&str] = &["shape", "potential", "hydropathy"];
const SHAPE: &[&str] = &["shape"];
const WITH_POTENTIAL: &[&str] = &["shape", "potential"];
const WITH_HYDROPATHY: &[&str] = &["shape", "hydropathy"];

const fn experiment(
    name: &'static str,
    channels: &'static [&'static str],
    expected: Expected,
) -> Experiment {
    let (variant, scaling) = (Variant::Usual, ScalingMode::Robust);
    Experiment {
        name,
        variant,
        channels,
        split_by_cluster: true,
        scaling,
        expected,
    }
}

impl Control {
    /// Its experiments, the main one first.
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
                let random = experiment("random-split", ALL, AtLeast(0.9));
                vec![
                    Experiment {
                        split_by_cluster: false,
                        ..random
                    },
                    experiment("split-by-cluster", ALL, Chance),
                ]
            }
            Self::Orientation => {
                let turned = experiment("turned", SHAPE, Chance);
                vec![
                    experiment("as-deposited", SHAPE, AtLeast(0.95)),
                    Experiment {
                        variant: Variant::Turned,
                        ..turned
                    },
                ]
            }
            Self::Size => {
                let filling = experiment("filling-the-box", SHAPE, Chance);
                vec![
                    experiment("fixed-scale", SHAPE, AtLeast(0.95)),
                    Experiment {
                        variant: Variant::FillingTheBox,
                        ..filling
                    },
                ]
            }
            Self::HeavyTails => {
                let raw = experiment("raw", WITH_POTENTIAL, Chance);
                vec![
                    experiment("robust", WITH_POTENTIAL, AtLeast(0.9)),
                    Experiment {
                        scaling: ScalingMode::Raw,
                        ..raw
                    },
                ]
            }
        }
    }

    /// The channels whose subsets an ablation trains.
    pub fn ablated(self) -> &'static [&'static str] {
        self.channels()
    }

    /// The network that its experiments train.
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

    /// How its experiments are trained: to the end, as it is known how long it takes.
    pub fn training(self, experiment: &Experiment, form: Form, seed: u64) -> TrainingSettings {
        TrainingSettings {
            epochs: self.plan(form).epochs,
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

    /// Sizes of the short and the full form.
    pub fn plan(self, form: Form) -> Plan {
        let plan = |samples, size, epochs, fractions| Plan {
            samples,
            size,
            epochs,
            fractions,
        };
        const LARGE: Fractions = Fractions {
            training: 0.7,
            validation: 0.1,
            test: 0.2,
        };
        const USUAL: Fractions = Fractions {
            training: 0.6,
            validation: 0.1,
            test: 0.3,
        };
        const HALVES: Fractions = Fractions {
            training: 0.5,
            validation: 0.1,
            test: 0.4,
        };
        match (self, form) {
            (Self::Shapes, Form::Short) => plan(1500, 16, 20, LARGE),
            (Self::Shapes, Form::Full) => plan(3000, 32, 20, LARGE),
            (Self::Assemblies, Form::Short) => plan(1500, 16, 20, LARGE),
            (Self::Assemblies, Form::Full) => plan(4000, 32, 25, LARGE),
            (Self::Identity, Form::Short) => plan(640, 16, 60, HALVES),
            (Self::Identity, Form::Full) => plan(960, 24, 80, HALVES),
            (Self::Permuted, Form::Short) => plan(640, 16, 12, HALVES),
            (Self::Permuted, Form::Full) => plan(1600, 24, 20, HALVES),
            (Self::Xor, Form::Short) => plan(800, 16, 20, USUAL),
            (Self::Xor, Form::Full) => plan(2000, 24, 25, USUAL),
            (Self::Patch, Form::Short) => plan(1000, 16, 20, USUAL),
            (_, Form::Short) => plan(600, 16, 12, USUAL),
            (_, Form::Full) => plan(1600, 24, 20, USUAL),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn experiments_are_named_apart_and_see_channels_that_exist() {
        for control in Control::ALL {
            let experiments = control.experiments();
            let names: BTreeSet<&str> = experiments
                .iter()
                .map(|experiment| experiment.name)
                .collect();
            assert_eq!(names.len(), experiments.len());
            for experiment in &experiments {
                assert!(
                    experiment
                        .channels
                        .iter()
                        .all(|channel| control.channels().contains(channel))
                );
            }
            for form in [Form::Short, Form::Full] {
                let plan = control.plan(form);
                let Fractions {
                    training,
                    validation,
                    test,
                } = plan.fractions;
                assert!(
                    (training + validation + test - 1.0).abs() < 1e-12
                        && (16..=32).contains(&plan.size)
                );
            }
        }
    }

    #[test]
    fn chance_is_as_wide_as_the_test_split_makes_it() {
        let verdict = Expected::Chance.verdict(0.5, 2, 400);
        assert!(
            (verdict.at_most - 0.575).abs() < 1e-12 && (verdict.at_least - 0.425).abs() < 1e-12
        );
        assert!(Expected::Chance.verdict(1.0, 2, 4).is_reached); // four clusters show nothing
    }
}
