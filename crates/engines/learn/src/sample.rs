//! Samples: a sparse voxel grid, and what is known of it.

use crate::error::damaged;
use crate::{LearnError, Result};
use serde::{Deserialize, Serialize};

/// The occupied voxels of a cubic grid, with one value per channel in each.
///
/// ```
/// use protomer_learn::SparseGrid;
///
/// let grid = SparseGrid {
///     size: 4,
///     channels: 2,
///     index: vec![5, 9],
///     values: vec![1.0, 1.0, -0.5, 0.25],
/// };
/// let mut dense = vec![0.0; 2 * 64];
/// grid.write_dense(&mut dense)?;
/// assert_eq!((dense[5], dense[64 + 9]), (1.0, 0.25));
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SparseGrid {
    /// Voxels along each edge.
    pub size: usize,
    /// Number of channels.
    pub channels: usize,
    /// Occupied voxels, ascending: (z size + y) size + x.
    pub index: Vec<u32>,
    /// Values, channel by channel, each in the order of `index`.
    pub values: Vec<f32>,
}

impl SparseGrid {
    /// Overwrites `dense`, (channel, z, y, x), with the grid.
    ///
    /// # Errors
    /// [`LearnError::Sample`] if the grid is damaged or `dense` does not hold channels x size³
    /// numbers.
    pub fn write_dense(&self, dense: &mut [f32]) -> Result<()> {
        self.check()?;
        let voxels = self.size.pow(3);
        if dense.len() != self.channels * voxels {
            return Err(damaged(format!(
                "{} channels of {voxels} voxels do not fit into {} numbers",
                self.channels,
                dense.len()
            )));
        }
        dense.fill(0.0);
        for (channel, dense) in dense.chunks_exact_mut(voxels.max(1)).enumerate() {
            for (index, value) in self.index.iter().zip(self.of_channel(channel)) {
                dense[*index as usize] = *value;
            }
        }
        Ok(())
    }

    /// The values of a channel; empty if there is no such channel.
    pub(crate) fn of_channel(&self, channel: usize) -> &[f32] {
        let count = self.index.len();
        let values = self.values.get(channel * count..(channel + 1) * count);
        values.unwrap_or_default()
    }

    /// Checks that shapes agree, indices ascend inside the grid, and every value is finite.
    ///
    /// ```
    /// use protomer_learn::SparseGrid;
    /// let grid = SparseGrid { size: 2, channels: 1, index: vec![1, 7], values: vec![0.5, 0.5] };
    /// assert!(grid.check().is_ok());
    /// assert!(SparseGrid { index: vec![1, 8], ..grid.clone() }.check().is_err(), "there are 8 voxels");
    /// assert!(SparseGrid { values: vec![0.5], ..grid }.check().is_err(), "a value is missing");
    /// ```
    ///
    /// # Errors
    /// [`LearnError::Sample`] says what is wrong.
    pub fn check(&self) -> Result<()> {
        let (voxels, count) = (self.size.pow(3), self.index.len());
        if self.values.len() != self.channels * count {
            return Err(damaged(format!(
                "{} values for {count} voxels",
                self.values.len()
            )));
        }
        let ascend = self.index.windows(2).all(|pair| pair[0] < pair[1]);
        let inside = self
            .index
            .last()
            .is_none_or(|last| (*last as usize) < voxels);
        if !ascend || !inside {
            return Err(damaged("voxel indices do not ascend inside the grid"));
        }
        if let Some(place) = self.values.iter().position(|value| !value.is_finite()) {
            let channel = place / count.max(1);
            return Err(damaged(format!(
                "channel {channel} holds {}",
                self.values[place]
            )));
        }
        Ok(())
    }
}

/// Properties of a sample besides its voxels.
///
/// ```
/// use protomer_learn::Description;
///
/// let entry = Description {
///     name: "5pti".into(),
///     label: "P 21 21 21".into(),
///     cluster: "trypsin inhibitor".into(),
///     residues: 58.0,
///     ..Description::default()
/// };
/// assert_eq!(entry.family, "", "no other crystal of this form");
/// ```
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Description {
    /// A name, unique in the set.
    pub name: String,
    /// The class of the sample.
    pub label: String,
    /// Cluster of the sample. Samples of one cluster are related and never fall on both sides of a
    /// split.
    pub cluster: String,
    /// Family of the sample. Copies of one crystal form share a family and are weighted down
    /// together. Empty: a separate family.
    pub family: String,
    /// Number of residues.
    pub residues: f64,
    /// Radius of gyration, Å.
    pub radius_of_gyration_angstrom: f64,
    /// Extents along the principal axes, Å, largest first.
    pub extents_angstrom: [f64; 3],
    /// Net charge, e.
    pub net_charge_e: f64,
    /// Share of each of the twenty amino acids, in alphabetical order of their one-letter codes.
    pub composition: [f64; 20],
}

/// A set of samples. It decodes one sample at a time, on any thread.
///
/// ```
/// use protomer_learn::{InMemory, SampleSource};
///
/// fn voxels_of_all(set: &dyn SampleSource) -> protomer_learn::Result<usize> {
///     let mut count = 0;
///     for sample in 0..set.descriptions().len() {
///         count += set.voxels(sample)?.index.len();
///     }
///     Ok(count)
/// }
/// assert_eq!(voxels_of_all(&InMemory::default())?, 0);
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
pub trait SampleSource: Sync {
    /// Voxels along each edge of every grid.
    fn size(&self) -> usize;
    /// Names of the channels, in order.
    fn channels(&self) -> &[String];
    /// Descriptions of the samples, in order.
    fn descriptions(&self) -> &[Description];
    /// The voxels of a sample.
    ///
    /// # Errors
    /// [`LearnError::Sample`] names a sample that cannot be read; training may leave it out.
    fn voxels(&self, sample: usize) -> Result<SparseGrid>;
    /// The settings that the voxels were made with, as the program that made them wrote them down.
    /// A network can only be applied to voxels made alike.
    fn made_with(&self) -> Option<&serde_json::Value> {
        None
    }
    /// SHA-256 of the file that a sample was made from, in hexadecimal. Empty: no file, or unknown.
    fn file_sha256(&self, _sample: usize) -> &str {
        ""
    }
}

/// Samples in memory.
///
/// ```
/// use protomer_learn::{Description, InMemory, SampleSource, SparseGrid};
///
/// let set = InMemory {
///     size: 2,
///     channels: vec!["shape".into()],
///     descriptions: vec![Description { name: "one".into(), ..Description::default() }],
///     grids: vec![SparseGrid { size: 2, channels: 1, index: vec![7], values: vec![1.0] }],
/// };
/// assert_eq!(set.voxels(0)?.index, [7]);
/// assert!(set.voxels(1).is_err());
/// # Ok::<(), protomer_learn::LearnError>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct InMemory {
    /// Voxels along each edge.
    pub size: usize,
    /// Names of the channels.
    pub channels: Vec<String>,
    /// Descriptions of the samples.
    pub descriptions: Vec<Description>,
    /// Voxels of each sample.
    pub grids: Vec<SparseGrid>,
}

impl SampleSource for InMemory {
    fn size(&self) -> usize {
        self.size
    }

    fn channels(&self) -> &[String] {
        &self.channels
    }

    fn descriptions(&self) -> &[Description] {
        &self.descriptions
    }

    fn voxels(&self, sample: usize) -> Result<SparseGrid> {
        match self.grids.get(sample) {
            Some(grid) => Ok(grid.clone()),
            None => Err(missing(sample)),
        }
    }
}

/// The error for a sample that a set does not have.
pub(crate) fn missing(sample: usize) -> LearnError {
    LearnError::Sample {
        name: format!("{sample}"),
        reason: "there is no such sample".into(),
    }
}
