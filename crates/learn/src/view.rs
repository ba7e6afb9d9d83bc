//! Some samples and some channels of a set, perhaps under other labels.

use crate::sample::{Description, SampleSource, SparseGrid};
use crate::{LearnError, Result};

/// A part of a set that looks like a set.
///
/// ```
/// use protomer_learn::{SampleSource, View, controls::{Control, Variant}};
/// let set = Control::Charge.samples(Variant::Usual, 6, 16, 1);
/// let view = View::new(&set).with_channels(&["potential"])?;
/// assert_eq!(view.voxels(0)?.channels, 1);
/// assert!(view.with_channels(&["charge"]).is_err());
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
#[derive(Clone)]
pub struct View<'a> {
    source: &'a dyn SampleSource,
    /// Places of the channels in the source.
    channels: Vec<usize>,
    names: Vec<String>,
    /// Places of the samples in the source.
    samples: Vec<usize>,
    descriptions: Vec<Description>,
}

impl std::fmt::Debug for View<'_> {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            out,
            "View of {} samples, channels {:?}",
            self.samples.len(),
            self.names
        )
    }
}

impl<'a> View<'a> {
    /// All of a set.
    pub fn new(source: &'a dyn SampleSource) -> Self {
        let names = source.channels().to_vec();
        let descriptions = source.descriptions().to_vec();
        Self {
            source,
            channels: (0..names.len()).collect(),
            names,
            samples: (0..descriptions.len()).collect(),
            descriptions,
        }
    }

    /// The same with these channels only, in this order. A voxel stays occupied although the
    /// channels that are left may all be zero in it.
    ///
    /// # Errors
    /// [`LearnError::Settings`] for a channel that the source lacks or that is named twice; it
    /// lists what there is.
    pub fn with_channels<S: AsRef<str>>(&self, names: &[S]) -> Result<Self> {
        let all = self.source.channels();
        let mut channels = Vec::with_capacity(names.len());
        for name in names.iter().map(AsRef::as_ref) {
            match all.iter().position(|channel| channel == name) {
                Some(place) if !channels.contains(&place) => channels.push(place),
                Some(_) => {
                    return Err(LearnError::Settings(format!(
                        "the channel '{name}' is named twice"
                    )));
                }
                None => {
                    let all = all.join(", ");
                    return Err(LearnError::Settings(format!(
                        "there is no channel '{name}'; choose among: {all}"
                    )));
                }
            }
        }
        if channels.is_empty() {
            return Err(LearnError::Settings(format!(
                "no channel is named; choose among: {}",
                all.join(", ")
            )));
        }
        let names = names.iter().map(|name| name.as_ref().to_owned()).collect();
        Ok(Self {
            channels,
            names,
            ..self.clone()
        })
    }

    /// The same with labels by a rule; samples to which it gives none are left out.
    #[must_use]
    pub fn relabelled(&self, label: impl Fn(&Description) -> Option<String>) -> Self {
        let kept =
            self.samples
                .iter()
                .zip(&self.descriptions)
                .filter_map(|(sample, description)| {
                    label(description).map(|label| {
                        (
                            *sample,
                            Description {
                                label,
                                ..description.clone()
                            },
                        )
                    })
                });
        let (samples, descriptions) = kept.unzip();
        Self {
            samples,
            descriptions,
            ..self.clone()
        }
    }
}

impl SampleSource for View<'_> {
    fn size(&self) -> usize {
        self.source.size()
    }

    fn channels(&self) -> &[String] {
        &self.names
    }

    fn descriptions(&self) -> &[Description] {
        &self.descriptions
    }

    fn made_with(&self) -> Option<&serde_json::Value> {
        self.source.made_with()
    }

    fn file_sha256(&self, sample: usize) -> &str {
        self.samples
            .get(sample)
            .map_or("", |sample| self.source.file_sha256(*sample))
    }

    fn voxels(&self, sample: usize) -> Result<SparseGrid> {
        let missing = || LearnError::Sample {
            name: format!("{sample}"),
            reason: "there is no such sample".into(),
        };
        let grid = self
            .source
            .voxels(*self.samples.get(sample).ok_or_else(missing)?)?;
        let count = grid.index.len();
        let mut values = Vec::with_capacity(self.channels.len() * count);
        for channel in &self.channels {
            let reason = || format!("channel {channel} of {} is missing", grid.channels);
            let of_channel = grid.values.get(channel * count..(channel + 1) * count);
            let name = || self.descriptions[sample].name.clone();
            values.extend_from_slice(of_channel.ok_or_else(|| LearnError::Sample {
                name: name(),
                reason: reason(),
            })?);
        }
        Ok(SparseGrid {
            size: grid.size,
            channels: self.channels.len(),
            index: grid.index,
            values,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::InMemory;

    fn set() -> InMemory {
        let grid = |i: usize| SparseGrid {
            size: 2,
            channels: 3,
            index: vec![1, 4],
            values: (0..6).map(|k| (10 * i + k) as f32).collect(),
        };
        let describe = |i: usize| Description {
            name: format!("s{i}"),
            label: format!("{}", i % 2),
            ..Description::default()
        };
        InMemory {
            size: 2,
            channels: ["a", "b", "c"].map(String::from).to_vec(),
            descriptions: (0..4).map(describe).collect(),
            grids: (0..4).map(grid).collect(),
        }
    }

    #[test]
    fn channels_and_samples_are_the_named_ones() {
        let set = set();
        let view = View::new(&set).with_channels(&["c", "a"]).unwrap();
        let odd =
            view.relabelled(|description| (description.label == "1").then(|| "odd".to_owned()));
        assert_eq!(
            odd.descriptions()
                .iter()
                .map(|d| d.name.as_str())
                .collect::<Vec<_>>(),
            ["s1", "s3"]
        );
        assert_eq!(odd.voxels(1).unwrap().values, [34.0, 35.0, 30.0, 31.0]);
        assert_eq!(odd.channels(), ["c", "a"]);
        assert!(odd.voxels(2).is_err());
    }

    #[test]
    fn a_wrong_channel_is_told_the_right_ones() {
        let set = set();
        let error = |names: &[&str]| {
            View::new(&set)
                .with_channels(names)
                .unwrap_err()
                .to_string()
        };
        assert!(error(&["d"]).contains("'d'") && error(&["d"]).contains("a, b, c"));
        assert!(error(&["a", "a"]).contains("twice") && error(&[]).contains("no channel"));
    }
}
