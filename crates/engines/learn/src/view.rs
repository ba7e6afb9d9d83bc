//! Some samples of a set, perhaps under other labels.

use crate::Result;
use crate::sample::{Description, SampleSource, SparseGrid, missing};
use std::fmt;

/// A part of a set that is a set itself.
///
/// ```
/// use protomer_learn::{Description, SampleSource, View};
/// use protomer_learn::controls::{Control, Variant};
///
/// let set = Control::Shapes.samples(Variant::Usual, 12, 16, 1);
/// let round = |sample: &Description| {
///     (sample.label == "sphere" || sample.label == "torus").then(|| "round".to_owned())
/// };
/// let view = View::new(&set).relabelled(round);
/// assert_eq!(view.descriptions().len(), 4);
/// assert_eq!(view.descriptions()[0].label, "round");
/// assert_eq!(view.voxels(0)?, set.voxels(3)?);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
#[derive(Clone)]
pub struct View<'a> {
    source: &'a dyn SampleSource,
    /// Places of the samples in the source.
    samples: Vec<usize>,
    descriptions: Vec<Description>,
}

impl fmt::Debug for View<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (some, all) = (self.samples.len(), self.source.descriptions().len());
        write!(out, "View of {some} among {all} samples")
    }
}

impl<'a> View<'a> {
    /// A view of a whole set.
    pub fn new(source: &'a dyn SampleSource) -> Self {
        let descriptions = source.descriptions().to_vec();
        Self {
            source,
            samples: (0..descriptions.len()).collect(),
            descriptions,
        }
    }

    /// The same samples under other labels. Those for which `label` returns `None` are left out.
    #[must_use]
    pub fn relabelled(&self, label: impl Fn(&Description) -> Option<String>) -> Self {
        let mut view = Self {
            source: self.source,
            samples: Vec::new(),
            descriptions: Vec::new(),
        };
        for (sample, description) in self.samples.iter().zip(&self.descriptions) {
            if let Some(label) = label(description) {
                view.samples.push(*sample);
                view.descriptions.push(Description {
                    label,
                    ..description.clone()
                });
            }
        }
        view
    }
}

impl SampleSource for View<'_> {
    fn size(&self) -> usize {
        self.source.size()
    }

    fn channels(&self) -> &[String] {
        self.source.channels()
    }

    fn descriptions(&self) -> &[Description] {
        &self.descriptions
    }

    fn voxels(&self, sample: usize) -> Result<SparseGrid> {
        match self.samples.get(sample) {
            Some(place) => self.source.voxels(*place),
            None => Err(missing(sample)),
        }
    }

    fn made_with(&self) -> Option<&serde_json::Value> {
        self.source.made_with()
    }

    fn file_sha256(&self, sample: usize) -> &str {
        let place = self.samples.get(sample);
        place.map_or("", |place| self.source.file_sha256(*place))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::InMemory;

    fn set() -> InMemory {
        let mut set = InMemory {
            size: 2,
            channels: vec!["a".into()],
            ..InMemory::default()
        };
        for number in 0..4 {
            set.descriptions.push(Description {
                name: format!("s{number}"),
                label: format!("{}", number % 2),
                ..Description::default()
            });
            set.grids.push(SparseGrid {
                size: 2,
                channels: 1,
                index: vec![number],
                values: vec![1.0],
            });
        }
        set
    }

    #[test]
    fn samples_are_the_chosen_ones_under_their_new_labels() {
        let set = set();
        let odd = View::new(&set).relabelled(|sample| (sample.label == "1").then(|| "odd".into()));
        let samples = odd.descriptions();
        assert_eq!([&*samples[0].name, &*samples[1].name], ["s1", "s3"]);
        assert_eq!([&*samples[0].label, &*samples[1].label], ["odd", "odd"]);
        assert_eq!(odd.voxels(1).unwrap().index, [3]);
        assert!(odd.voxels(2).is_err());
    }

    #[test]
    fn a_view_of_a_view_leads_back_to_the_set() {
        let set = set();
        let odd = View::new(&set).relabelled(|sample| (sample.label == "1").then(|| "odd".into()));
        let last = odd.relabelled(|sample| (sample.name == "s3").then(|| "last".into()));
        assert_eq!(last.voxels(0).unwrap().index, [3]);
        assert_eq!(last.descriptions()[0].label, "last");
    }
}
