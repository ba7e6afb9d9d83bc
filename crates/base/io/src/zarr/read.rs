//! A set with its attributes and properties in memory.

use super::group::{attributes, words};
use super::samples::{SampleReader, StoredSample};
use crate::Result;
use serde_json::{Map, Value};
use std::path::Path;

/// An open set. Samples may be read from several threads at once. [`super::SetWriter`] has an
/// example.
pub struct SetReader {
    samples: SampleReader,
    attributes: Map<String, Value>,
    rows: Vec<f64>,
}

impl SetReader {
    /// Opens a set and reads everything but the voxels.
    ///
    /// # Errors
    /// [`crate::IoError::Parse`] names the file that is missing, damaged or of a newer layout.
    pub fn open(path: &Path) -> Result<Self> {
        let samples = SampleReader::open(path)?;
        let mut rows = Vec::with_capacity(samples.len() * samples.table().columns().len());
        for part in samples.table().parts() {
            rows.extend(part?);
        }
        Ok(Self {
            samples,
            attributes: attributes(path)?,
            rows,
        })
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// Voxels along each edge.
    pub fn size(&self) -> usize {
        self.samples.size()
    }

    /// Channels in order.
    pub fn channels(&self) -> &[String] {
        self.samples.channels()
    }

    /// Attributes of the group.
    pub fn attributes(&self) -> &Map<String, Value> {
        &self.attributes
    }

    /// Names of the numeric columns.
    pub fn columns(&self) -> &[String] {
        self.samples.table().columns()
    }

    /// The numeric properties of a sample, in the order of the columns; empty if there is
    /// no such sample.
    pub fn row(&self, sample: usize) -> &[f64] {
        let width = self.columns().len();
        self.rows
            .get(sample * width..(sample + 1) * width)
            .unwrap_or_default()
    }

    /// The string properties of the samples, by the name of the list.
    pub fn words(&self, list: &str) -> Option<Vec<String>> {
        words(self.attributes.get("samples")?.get(list)?)
    }

    /// Occupied voxels of a sample; zero if there is no such sample.
    pub fn voxels(&self, sample: usize) -> usize {
        self.samples.voxels(sample)
    }

    /// Reads a sample.
    ///
    /// # Errors
    /// As [`SampleReader::sample`].
    pub fn sample(&self, sample: usize) -> Result<StoredSample> {
        self.samples.sample(sample)
    }
}
