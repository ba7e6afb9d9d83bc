//! Voxel sets on disk as samples for training.

use crate::voxels::records::SampleRecord;
use crate::voxels::{open_set, set};
use anyhow::{Context, Result};
use protomer_io::zarr::SetReader;
use protomer_learn::{Description, LearnError, SampleSource, SparseGrid};
use std::path::Path;

/// A set written by `protomer voxelize`; samples are decoded on demand, on any thread.
///
/// ```no_run
/// use protomer_learn_verbs::voxels::samples::VoxelSet;
/// use std::path::Path;
/// let set = VoxelSet::open(Path::new("set.zarr"))?;
/// println!("{} samples", set.reader().len());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub struct VoxelSet {
    reader: SetReader,
    descriptions: Vec<Description>,
    files: Vec<String>,
    hashes: Vec<String>,
}

impl VoxelSet {
    /// Opens a set.
    ///
    /// # Errors
    /// Names the missing or damaged file.
    pub fn open(path: &Path) -> Result<Self> {
        let reader = open_set(path)?;
        let samples = set::samples_of(&reader).with_context(|| path.display().to_string())?;
        let files = samples
            .iter()
            .map(|sample| sample.row.file.clone())
            .collect();
        let hashes = samples
            .iter()
            .map(|sample| sample.row.sha256.clone())
            .collect();
        let describe = |sample: SampleRecord| Description {
            name: sample.row.name,
            label: sample.row.label,
            cluster: sample.row.cluster,
            family: sample.row.family,
            residues: sample.properties.residues as f64,
            radius_of_gyration_angstrom: sample.properties.radius_of_gyration_angstrom,
            extents_angstrom: sample.properties.extents_angstrom,
            net_charge_e: sample.properties.net_charge_e,
            composition: sample.properties.composition,
        };
        Ok(Self {
            descriptions: samples.into_iter().map(describe).collect(),
            reader,
            files,
            hashes,
        })
    }

    /// The file of each sample, as named in the manifest.
    pub fn files(&self) -> &[String] {
        &self.files
    }

    /// The underlying reader, with attributes and columns.
    pub fn reader(&self) -> &SetReader {
        &self.reader
    }
}

impl SampleSource for VoxelSet {
    fn size(&self) -> usize {
        self.reader.size()
    }

    fn channels(&self) -> &[String] {
        self.reader.channels()
    }

    fn descriptions(&self) -> &[Description] {
        &self.descriptions
    }

    fn made_with(&self) -> Option<&serde_json::Value> {
        self.reader.attributes().get("settings")
    }

    fn file_sha256(&self, sample: usize) -> &str {
        self.hashes.get(sample).map_or("", String::as_str)
    }

    fn voxels(&self, sample: usize) -> protomer_learn::Result<SparseGrid> {
        let stored = self
            .reader
            .sample(sample)
            .map_err(|error| LearnError::Sample {
                name: self.descriptions.get(sample).map_or_else(
                    || sample.to_string(),
                    |description| description.name.clone(),
                ),
                reason: error.to_string(),
            })?;
        let grid = SparseGrid {
            size: self.reader.size(),
            channels: stored.values.len(),
            index: stored.index,
            values: stored.values.concat(),
        };
        Ok(grid)
    }
}
