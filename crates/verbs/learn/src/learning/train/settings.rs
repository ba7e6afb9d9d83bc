//! The settings of a training: `settings.toml`.

use super::weights::WeightSource;
use crate::learning::labels::LabelSource;
use anyhow::Result;
use protomer_learn::block::BlockSettings;
use protomer_learn::controls::{Control, Experiment, Form, Plan, Variant};
use protomer_learn::network::{GlobalPooling, NetworkSettings};
use protomer_learn::normal::OUTPUTS;
use protomer_learn::split::Fractions;
use protomer_learn::targets::Target;
use protomer_learn::training::{Loss, TrainingSettings};
use protomer_results::{Settings, keys};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The source of the samples.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Source {
    /// A set on disk.
    Set {
        /// The zarr group.
        path: PathBuf,
        /// Digest of the content, to detect changes.
        digest: String,
    },
    /// A synthetic set.
    Control {
        /// Name of the control.
        name: Control,
        /// Form of the control.
        variant: Variant,
        /// Total number of samples.
        samples: usize,
        /// Voxels along each edge.
        size: usize,
        /// Seed of the samples.
        seed: u64,
    },
}

/// Sets with the same content are equal, whatever their path. So a training continues after its
/// set has been moved, or on a machine that mounts it elsewhere.
impl PartialEq for Source {
    fn eq(&self, other: &Self) -> bool {
        let control = |source: &Self| match source {
            Self::Control {
                name,
                variant,
                samples,
                size,
                seed,
            } => Some((*name, *variant, *samples, *size, *seed)),
            Self::Set { .. } => None,
        };
        match (self, other) {
            (Self::Set { digest, .. }, Self::Set { digest: other, .. }) => digest == other,
            _ => control(self).is_some() && control(self) == control(other),
        }
    }
}

impl Source {
    /// The digest of a set on the disk; empty for a synthetic one.
    pub fn digest(&self) -> &str {
        match self {
            Self::Set { digest, .. } => digest,
            Self::Control { .. } => "",
        }
    }

    /// The path of a set; empty for a synthetic one.
    pub fn path(&self) -> &Path {
        match self {
            Self::Set { path, .. } => path,
            Self::Control { .. } => Path::new(""),
        }
    }

    fn without_path(&self) -> Self {
        match self {
            Self::Set { digest, .. } => Self::Set {
                path: PathBuf::new(),
                digest: digest.clone(),
            },
            control => control.clone(),
        }
    }
}

protomer_kernel::choices! {
    /// Unit in which samples are divided into training, validation and test parts.
    pub enum SplitBy, default Cluster {
        /// Whole clusters: relatives are never on both sides.
        Cluster = "cluster",
        /// Single samples: scores above those of a split by cluster measure leakage.
        Sample = "sample",
    }
}

/// Settings of one training. The same settings give the same weights on any number of threads.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainSettings {
    /// The quantity to predict.
    pub target: Target,
    /// Classes with fewer samples are merged into one class.
    pub least_samples: usize,
    /// Number of classes that numbers are cut into; [`Self::NUMBER_CLASSES`] if it is not given.
    /// Only for the target [`Target::Number`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub number_classes: Option<usize>,
    /// The unit of the split.
    pub split_by: SplitBy,
    /// Seed of the split; by default that of the training. Settings found by a search keep the
    /// split of the search: another split could test samples on which they were chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub split_seed: Option<u64>,
    /// Share of the clusters of the training part to train on, for a learning curve; all for `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub training_share: Option<f64>,
    /// Exchanges of labels in the permutation test.
    pub permutations: usize,
    /// Whether predictions are averaged over the 24 rotations of the cube.
    pub rotations: bool,
    /// The pooling after the last block.
    pub pooling: GlobalPooling,
    /// The source of the samples.
    pub source: Source,
    /// The table that the labels come from; by default those of the set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub labels: Option<LabelSource>,
    /// The trained network that the weights start from; by default fresh ones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weights_from: Option<WeightSource>,
    /// Shares of the parts.
    pub fractions: Fractions,
    /// Channels, scaling and the loop.
    pub training: TrainingSettings,
    /// The blocks of the network, first to last.
    pub blocks: Vec<BlockSettings>,
}

impl Settings for TrainSettings {
    /// Excludes the paths of the set and of the table of labels, which are identified by their
    /// content, and the end of the training: it may go on for more epochs.
    fn essential(&self) -> Self {
        // The defaults, so that the identity of a training with default epochs is what it was before
        // they could be raised.
        let TrainingSettings {
            epochs, patience, ..
        } = TrainingSettings::default();
        Self {
            source: self.source.without_path(),
            labels: self.labels.as_ref().map(LabelSource::without_path),
            weights_from: self.weights_from.as_ref().map(WeightSource::without_path),
            training: TrainingSettings {
                epochs,
                patience,
                ..self.training.clone()
            },
            ..self.clone()
        }
    }

    fn objection(&self, present: &Self) -> Option<String> {
        let (wanted, done) = (self.training.epochs, present.training.epochs);
        (wanted < done).then(|| {
            format!(
                "is a training of {done} epochs, which is more than {wanted}; ask for at least as many, or \
                 train in another directory"
            )
        })
    }
}

impl TrainSettings {
    /// The default of [`Self::number_classes`].
    pub const NUMBER_CLASSES: usize = 5;

    /// Reads settings from a file.
    ///
    /// # Errors
    /// Names the file, the line and the key.
    pub fn read(path: &Path) -> Result<Self> {
        Ok(keys::read_toml(path)?)
    }

    /// The network for a number of classes.
    pub fn network(&self, classes: usize) -> NetworkSettings {
        let blocks = self.blocks.clone();
        let outputs = match self.training.loss {
            Loss::CrossEntropy => classes,
            Loss::Normal => OUTPUTS,
        };
        NetworkSettings {
            channels: self.training.channels.len(),
            classes: outputs,
            blocks,
            pooling: self.pooling,
        }
    }

    /// The default settings for a set on disk with these channels.
    ///
    /// # Errors
    /// Never for the default settings.
    pub fn of_set(source: Source, channels: Vec<String>) -> Result<Self> {
        Ok(Self {
            target: Target::Label,
            least_samples: 10,
            number_classes: None,
            split_by: SplitBy::Cluster,
            split_seed: None,
            training_share: None,
            permutations: 1000,
            rotations: false,
            pooling: GlobalPooling::AverageAndMaximum,
            source,
            labels: None,
            weights_from: None,
            fractions: Fractions::default(),
            training: TrainingSettings {
                channels,
                seed: 1,
                ..TrainingSettings::default()
            },
            blocks: BlockSettings::chain(&[16, 32, 64], &[3], 8)?,
        })
    }

    /// The settings of one experiment of a control.
    pub fn of_control(control: Control, experiment: &Experiment, form: Form, seed: u64) -> Self {
        let Plan {
            samples,
            size,
            fractions,
            ..
        } = control.plan(experiment, form);
        let network = control.network(experiment, form);
        Self {
            target: Target::Label,
            least_samples: 1,
            number_classes: None,
            split_by: if experiment.split_by_cluster {
                SplitBy::Cluster
            } else {
                SplitBy::Sample
            },
            split_seed: None,
            training_share: None,
            permutations: 1000,
            rotations: false,
            pooling: network.pooling,
            source: Source::Control {
                name: control,
                variant: experiment.variant,
                samples,
                size,
                seed,
            },
            labels: None,
            weights_from: None,
            fractions,
            training: control.training(experiment, form, seed),
            blocks: network.blocks,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_is_what_it_holds_wherever_it_lies() {
        let set = |path: &str, digest: &str| Source::Set {
            path: path.into(),
            digest: digest.into(),
        };
        let control = |seed| Source::Control {
            name: Control::Charge,
            variant: Variant::Usual,
            samples: 10,
            size: 16,
            seed,
        };
        assert_eq!(set("here/a.zarr", "1"), set("there/b.zarr", "1"));
        assert_ne!(set("here/a.zarr", "1"), set("here/a.zarr", "2"));
        assert_eq!(control(1), control(1));
        assert_ne!(control(1), control(2));
        assert_ne!(set("a", "1"), control(1));
    }
}
