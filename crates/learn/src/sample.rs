//! Samples: a sparse voxel grid, and what is known of it.

use crate::{LearnError, Result};
use serde::{Deserialize, Serialize};

/// The occupied voxels of a cubic grid, with one value per channel in each.
///
/// ```
/// use protomer_learn::SparseGrid;
/// let grid = SparseGrid { size: 4, channels: 2, index: vec![5, 9], values: vec![1.0, 1.0, -0.5, 0.25] };
/// let mut dense = vec![0.0; 2 * 64];
/// grid.write_dense(&mut dense).unwrap();
/// assert_eq!((dense[5], dense[64 + 9]), (1.0, 0.25));
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SparseGrid {
    /// Voxels along each edge.
    pub size: usize,
    /// Channels.
    pub channels: usize,
    /// Occupied voxels, ascending: (z size + y) size + x.
    pub index: Vec<u32>,
    /// Values, channel by channel, each in the order of `index`.
    pub values: Vec<f32>,
}

impl SparseGrid {
    /// Writes the grid as (channel, z, y, x) over `dense`, channels x size³ numbers, which need not
    /// be zero before.
    ///
    /// # Errors
    /// [`LearnError::Sample`] if shapes disagree or an index lies outside.
    pub fn write_dense(&self, dense: &mut [f32]) -> Result<()> {
        self.check()?;
        let voxels = self.size.pow(3);
        if dense.len() != self.channels * voxels {
            return Err(damaged(format!(
                "{} numbers of room for {} x {voxels}",
                dense.len(),
                self.channels
            )));
        }
        dense.fill(0.0);
        let count = self.index.len().max(1);
        for (dense, values) in dense
            .chunks_exact_mut(voxels.max(1))
            .zip(self.values.chunks_exact(count))
        {
            for (index, value) in self.index.iter().zip(values) {
                dense[*index as usize] = *value;
            }
        }
        Ok(())
    }

    /// Whether shapes agree, indices ascend inside the grid, and every value is finite.
    ///
    /// # Errors
    /// [`LearnError::Sample`] says what is wrong.
    pub fn check(&self) -> Result<()> {
        let voxels = self.size.pow(3);
        if self.values.len() != self.channels * self.index.len() {
            return Err(damaged(format!(
                "{} values for {} voxels",
                self.values.len(),
                self.index.len()
            )));
        }
        if self.index.windows(2).any(|pair| pair[0] >= pair[1])
            || self
                .index
                .last()
                .is_some_and(|last| *last as usize >= voxels)
        {
            return Err(damaged(
                "voxel indices do not ascend inside the grid".into(),
            ));
        }
        if let Some(place) = self.values.iter().position(|value| !value.is_finite()) {
            let channel = place / self.index.len().max(1);
            return Err(damaged(format!(
                "channel {channel} holds {}",
                self.values[place]
            )));
        }
        Ok(())
    }
}

fn damaged(reason: String) -> LearnError {
    LearnError::Sample {
        name: "voxels".into(),
        reason,
    }
}

/// What is known of a sample besides its voxels.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Description {
    /// A name, unique in the set.
    pub name: String,
    /// The class it belongs to.
    pub label: String,
    /// Samples of one cluster are related and never fall on both sides of a split.
    pub cluster: String,
    /// Copies of one crystal form share a family and are weighted down together; empty: a family of
    /// its own.
    pub family: String,
    /// Residues.
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

/// Where samples come from; decoding happens one sample at a time, on any thread.
pub trait SampleSource: Sync {
    /// Voxels along each edge of every grid.
    fn size(&self) -> usize;
    /// Names of the channels, in order.
    fn channels(&self) -> &[String];
    /// What is known of each sample, in order.
    fn descriptions(&self) -> &[Description];
    /// The voxels of a sample.
    ///
    /// # Errors
    /// [`LearnError::Sample`] names a sample that cannot be read; training may leave it out.
    fn voxels(&self, sample: usize) -> Result<SparseGrid>;
    /// How the voxels were made, in the words of what made them: a network is for voxels made
    /// alike.
    fn made_with(&self) -> Option<&serde_json::Value> {
        None
    }
    /// SHA-256 of the file that a sample was made of, in hexadecimal; empty where there is no file,
    /// or nobody knows.
    fn file_sha256(&self, _sample: usize) -> &str {
        ""
    }
}

/// Samples in memory.
#[derive(Debug, Clone, Default)]
pub struct InMemory {
    /// Voxels along each edge.
    pub size: usize,
    /// Names of the channels.
    pub channels: Vec<String>,
    /// What is known of each sample.
    pub descriptions: Vec<Description>,
    /// The voxels of each.
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
        let missing = || LearnError::Sample {
            name: format!("{sample}"),
            reason: "there is no such sample".into(),
        };
        self.grids.get(sample).cloned().ok_or_else(missing)
    }
}
