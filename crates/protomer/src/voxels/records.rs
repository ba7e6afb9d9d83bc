//! The content of a set without its voxels: samples, and structures that were excluded.

use super::manifest::Entry;
use super::structure::{Properties, Reason, Sample};
use anyhow::{Context, Result};
use protomer_io::zarr::SetReader;
use serde::{Deserialize, Serialize};

/// A structure that was excluded from the set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Exclusion {
    /// Position in the manifest, from zero.
    pub entry: usize,
    /// Its name.
    pub name: String,
    /// The file as named in the manifest.
    pub file: String,
    /// Its class.
    pub label: String,
    /// Its cluster.
    pub cluster: String,
    /// Its family.
    pub family: String,
    /// SHA-256 of the file; empty if it could not be read.
    pub sha256: String,
    /// Why.
    pub reason: Reason,
    /// A description in words.
    pub detail: String,
}

impl Exclusion {
    /// The exclusion of an entry.
    pub fn new(entry: &Entry, sha256: Option<&str>, reason: Reason, detail: String) -> Self {
        let Entry {
            number,
            name,
            file,
            label,
            cluster,
            family,
            ..
        } = entry.clone();
        let sha256 = sha256.unwrap_or_default().to_owned();
        Self {
            entry: number,
            name,
            file,
            label,
            cluster,
            family,
            sha256,
            reason,
            detail,
        }
    }
}

/// A sample without its voxels.
#[derive(Debug, Clone, PartialEq)]
pub struct SampleRecord {
    /// Position in the manifest, from zero.
    pub entry: usize,
    /// Its name.
    pub name: String,
    /// The file as named in the manifest.
    pub file: String,
    /// Its class.
    pub label: String,
    /// Its cluster.
    pub cluster: String,
    /// Its family.
    pub family: String,
    /// SHA-256 of the file.
    pub sha256: String,
    /// The key of its voxels in the work file.
    pub key: String,
    /// Occupied voxels.
    pub voxels: usize,
    /// Its properties.
    pub properties: Properties,
    /// Warnings about its file.
    pub warnings: Vec<String>,
}

impl SampleRecord {
    /// The record of an entry's sample.
    pub fn new(entry: &Entry, sha256: Option<&str>, key: &str, sample: &Sample) -> Self {
        let Entry {
            number,
            name,
            file,
            label,
            cluster,
            family,
            ..
        } = entry.clone();
        Self {
            entry: number,
            name,
            file,
            label,
            cluster,
            family,
            sha256: sha256.unwrap_or_default().to_owned(),
            key: key.to_owned(),
            voxels: sample.voxels.index.len(),
            properties: sample.properties.clone(),
            warnings: sample.warnings.clone(),
        }
    }
}

/// The structures left out of a set.
///
/// # Errors
/// If the attribute is damaged.
pub fn exclusions(reader: &SetReader) -> Result<Vec<Exclusion>> {
    let Some(value) = reader.attributes().get("excluded") else {
        return Ok(Vec::new());
    };
    serde_json::from_value(value.clone())
        .context("the attribute 'excluded' is damaged; make the set again")
}

/// The content of a set, except for the voxels.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SetContent {
    /// Samples in order.
    pub samples: Vec<SampleRecord>,
    /// Excluded structures, in order.
    pub excluded: Vec<Exclusion>,
}

impl SetContent {
    /// Occupied voxels of all samples.
    pub fn voxels(&self) -> u64 {
        self.samples.iter().map(|sample| sample.voxels as u64).sum()
    }
}
