//! Controls: synthetic sets for which it is known what a network must learn, and what it must not.
//!
//! A positive control shows that a channel carries its signal through the whole pipeline; a
//! negative one, that nothing else does: no leak through the split, no scale or orientation that
//! gives the answer away. Each control is one or more [`Experiment`]s on sets that
//! [`Control::samples`] makes, and each experiment states its [`Expected`] level beforehand.
//!
//! | module | one idea |
//! |---|---|
//! | `raster` | solids on a grid of voxels |
//! | `solids`, `blob`, `assemblies` | named solids, unions of balls, rings of copies |
//! | `protein` | a blob with charges and hydropathy |
//! | `sample` | each control's samples, labels and clusters |
//! | `experiment` | what is trained on what, and what must come out |

mod assemblies;
mod blob;
mod experiment;
mod protein;
mod raster;
mod sample;
mod solids;

pub use experiment::{Expected, Experiment, Plan, Verdict};

use crate::Result;
use crate::error::refuse;
use crate::sample::InMemory;
use protomer_kernel::setting::Choices;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

protomer_kernel::choices! {
    /// A synthetic set with a known answer.
    ///
    /// ```
    /// use protomer_learn::SampleSource;
    /// use protomer_learn::controls::{Control, Variant};
    ///
    /// let control = Control::named("charge")?;
    /// let set = control.samples(Variant::Usual, 6, 16, 1);
    /// assert_eq!(set.channels(), ["shape", "potential", "hydropathy"]);
    /// assert_eq!(set.descriptions()[0].label, "positive");
    /// # Ok::<(), protomer_learn::LearnError>(())
    /// ```
    pub enum Control {
        /// Kind of a solid.
        Shapes = "shapes",
        /// Sign of the net charge.
        Charge = "charge",
        /// Hydrophobic share of the surface.
        Patch = "patch",
        /// Whether charge and hydropathy of a patch have the same sign.
        Xor = "xor",
        /// Number of copies about an axis.
        Assemblies = "assemblies",
        /// Labels dealt out at random.
        Permuted = "permuted",
        /// Identity of the protein.
        Identity = "identity",
        /// Orientation in which the protein was deposited.
        Orientation = "orientation",
        /// Number of residues.
        Size = "size",
        /// The charge control with outliers among the potentials.
        HeavyTails = "heavy-tails",
    }
}

/// Short or full form of a control.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// Short form for tests: seconds to a minute.
    Short,
    /// Full form for validation: finer grids and more samples.
    Full,
}

/// Placement of the samples of a control.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// Placement that the control prescribes.
    #[default]
    Usual,
    /// Samples turned at random instead of as deposited.
    Turned,
    /// Samples scaled so that each fills the box.
    FillingTheBox,
}

impl Control {
    /// The control of this name.
    ///
    /// # Errors
    /// [`LearnError::Settings`](crate::LearnError::Settings) lists the controls there are.
    pub fn named(name: &str) -> Result<Self> {
        Self::from_name(name).map_or_else(
            || {
                let names: Vec<&str> = Self::CHOICES.iter().map(|choice| choice.name).collect();
                refuse(format!(
                    "there is no control '{name}'; choose one of: {}",
                    names.join(", ")
                ))
            },
            Ok,
        )
    }

    /// Description of the label and of what the control shows.
    pub fn shows(self) -> &'static str {
        match self {
            Self::Shapes => {
                "sphere, box, tetrahedron, cylinder, torus or cross, of random size and \
                 orientation: shape reaches the network, and convolution, pooling and their \
                 gradients work"
            }
            Self::Charge => {
                "sign of the net charge: the potential carries it, and nothing else does"
            }
            Self::Patch => {
                "much or little of the surface hydrophobic: the hydropathy carries it, and nothing \
                 else does"
            }
            Self::Xor => {
                "whether charge and hydropathy of a patch have the same sign: no channel tells it \
                 alone, two together do"
            }
            Self::Assemblies => {
                "number of copies (1, 2, 3, 4, 6) of a blob about an axis, for blobs not seen in \
                 training: symmetry can be read from shape"
            }
            Self::Permuted => {
                "labels dealt out to the clusters at random: nothing can be learnt, and nothing \
                 leaks through a split by cluster"
            }
            Self::Identity => {
                "a label that follows only from which protein it is: a random split lets the \
                 network recognise proteins, a split by cluster does not"
            }
            Self::Orientation => {
                "rods deposited along an axis or along a diagonal: the deposited frame gives the \
                 label away, a random orientation does not"
            }
            Self::Size => {
                "more residues than the median or fewer: a fixed scale gives it away, filling the \
                 box does not"
            }
            Self::HeavyTails => {
                "the charge control with potentials up to 100 000 kT/e in one surface voxel in \
                 fifty: unscaled they drown the signal, robust scaling over the occupied voxels \
                 brings it back"
            }
        }
    }

    /// Names of the classes, sorted.
    pub fn classes(self) -> &'static [&'static str] {
        match self {
            Self::Shapes => &solids::SOLIDS,
            Self::Charge | Self::Permuted | Self::HeavyTails => &["negative", "positive"],
            Self::Patch | Self::Size => &["large", "small"],
            Self::Xor => &["agree", "disagree"],
            Self::Assemblies => &["C1", "C2", "C3", "C4", "C6"],
            Self::Identity => &["even", "odd"],
            Self::Orientation => &["along a diagonal", "along an axis"],
        }
    }

    /// Names of the channels of the control's sets.
    pub fn channels(self) -> &'static [&'static str] {
        match self {
            Self::Shapes | Self::Assemblies | Self::Orientation | Self::Size => &["shape"],
            _ => &["shape", "potential", "hydropathy"],
        }
    }

    /// Makes a set. It is always the same for the same arguments, on any number of threads.
    ///
    /// `size`: voxels along each edge, 16 to 32 make sense.
    pub fn samples(self, variant: Variant, samples: usize, size: usize, seed: u64) -> InMemory {
        let recipe = sample::Recipe {
            control: self,
            variant,
            samples,
            size,
            seed,
        };
        let (descriptions, grids) = (0..samples)
            .into_par_iter()
            .map(|number| recipe.sample(number))
            .unzip();
        InMemory {
            size,
            channels: self.channels().iter().map(ToString::to_string).collect(),
            descriptions,
            grids,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::{BTreeMap, BTreeSet};

    #[test]
    fn every_set_is_sound_balanced_and_the_same_again() {
        for &control in Control::ALL {
            // Whole numbers of proteins with 16 orientations each, in every number of classes.
            let count = 480;
            let set = control.samples(Variant::Usual, count, 16, 3);
            assert_eq!(set.grids.len(), count);
            let mut labels = BTreeMap::<&str, usize>::new();
            for (description, grid) in set.descriptions.iter().zip(&set.grids) {
                grid.check().unwrap();
                assert_eq!((grid.size, grid.channels), (16, control.channels().len()));
                assert!(
                    grid.index.len() > 20,
                    "{} {}",
                    control.name(),
                    grid.index.len()
                );
                *labels.entry(&description.label).or_default() += 1;
            }
            let classes: Vec<&str> = labels.keys().copied().collect();
            assert_eq!(classes, control.classes(), "{}", control.name());
            assert!(
                labels.values().all(|n| *n == count / classes.len()),
                "{} {labels:?}",
                control.name()
            );
            let names: BTreeSet<&str> = set.descriptions.iter().map(|d| d.name.as_str()).collect();
            assert_eq!(names.len(), count);
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(1)
                .build()
                .unwrap();
            let again = pool.install(|| control.samples(Variant::Usual, count, 16, 3));
            assert_eq!(again.grids, set.grids);
            assert_eq!(again.descriptions, set.descriptions);
            assert_ne!(
                control.samples(Variant::Usual, 6, 16, 4).grids,
                set.grids[..6]
            );
        }
    }

    #[test]
    fn names_lead_back_and_a_wrong_one_is_told_the_right_ones() {
        for &control in Control::ALL {
            assert_eq!(Control::named(control.name()).unwrap(), control);
            assert_eq!(serde_json::to_value(control).unwrap(), control.name());
        }
        let error = Control::named("shape").unwrap_err().to_string();
        assert!(
            error.contains("'shape'")
                && error.contains("shapes, charge, patch")
                && error.contains("heavy-tails")
        );
    }

    /// Sum over the occupied voxels of one channel.
    fn sum(set: &InMemory, sample: usize, channel: usize) -> f64 {
        let grid = &set.grids[sample];
        let count = grid.index.len();
        grid.values[channel * count..(channel + 1) * count]
            .iter()
            .map(|v| f64::from(*v))
            .sum::<f64>()
            / count as f64
    }

    #[test]
    fn the_signal_is_where_it_should_be() {
        let count = 200;
        let agreement = |control: Control, variant, guess: &dyn Fn(&InMemory, usize) -> bool| {
            let set = control.samples(variant, count, 16, 5);
            let first = control.classes()[0];
            let hits = (0..count)
                .filter(|i| guess(&set, *i) == (set.descriptions[*i].label == first))
                .count();
            hits as f64 / count as f64
        };
        // The mean of a channel over the surface tells the charge and the patch; in two channels,
        // the product does.
        assert!(
            agreement(Control::Charge, Variant::Usual, &|set, i| sum(set, i, 1)
                < 0.0)
                > 0.95
        );
        assert!(
            agreement(Control::Patch, Variant::Usual, &|set, i| sum(set, i, 2)
                > 0.0)
                > 0.9
        );
        assert!(
            agreement(Control::Xor, Variant::Usual, &|set, i| sum(set, i, 1)
                * sum(set, i, 2)
                > 0.0)
                > 0.9
        );
        for channel in [1, 2] {
            let alone = agreement(Control::Xor, Variant::Usual, &|set, i| {
                sum(set, i, channel) > 0.0
            });
            assert!((alone - 0.5).abs() < 0.12, "{alone}");
        }
        // Outliers take the sign of the mean away.
        let outliers = agreement(Control::HeavyTails, Variant::Usual, &|set, i| {
            sum(set, i, 1) < 0.0
        });
        assert!(outliers < 0.65, "{outliers}");
        // Size is the volume, unless the box is filled.
        let large = |set: &InMemory, i: usize| {
            let volume: f64 = set.grids[i].values.iter().map(|v| f64::from(*v)).sum();
            volume > 0.11 * 14f64.powi(3) / 4.0
        };
        assert!(agreement(Control::Size, Variant::Usual, &large) > 0.95);
        let filling = agreement(Control::Size, Variant::FillingTheBox, &large);
        assert!((filling - 0.5).abs() < 0.12, "{filling}");
    }

    #[test]
    fn clusters_are_what_they_should_be() {
        let clusters = |control: Control| {
            let set = control.samples(Variant::Usual, 240, 16, 1);
            let mut labels = BTreeMap::<String, BTreeSet<String>>::new();
            for description in set.descriptions {
                labels
                    .entry(description.cluster)
                    .or_default()
                    .insert(description.label);
            }
            labels
        };
        assert_eq!(clusters(Control::Charge).len(), 240);
        // All rings of a blob are one cluster; all orientations of a protein have one label.
        assert!(
            clusters(Control::Assemblies)
                .values()
                .all(|labels| labels.len() == 5)
        );
        for (control, count) in [(Control::Permuted, 60), (Control::Identity, 15)] {
            let clusters = clusters(control);
            assert!(clusters.len() == count && clusters.values().all(|labels| labels.len() == 1));
        }
    }
}
