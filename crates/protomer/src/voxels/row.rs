//! A manifest entry with the hash of its file, read from a manifest, from a set, or from the
//! list of excluded structures.

use super::manifest::Entry;
use super::records::{Exclusion, SampleRecord, SetContent};
use serde::Serialize;

/// The data used for a set's identity and for finding relatives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Row<'a> {
    /// Position in the manifest, from zero.
    pub entry: usize,
    /// Its name.
    pub name: &'a str,
    /// The file as named in the manifest.
    pub file: &'a str,
    /// Its class.
    pub label: &'a str,
    /// Its cluster.
    pub cluster: &'a str,
    /// Its family; may be empty.
    pub family: &'a str,
    /// SHA-256 of its file; empty if it could not be read.
    pub sha256: &'a str,
}

impl<'a> Row<'a> {
    /// The row of an entry.
    pub fn of_entry(entry: &'a Entry, sha256: Option<&'a str>) -> Self {
        let Entry {
            number,
            name,
            file,
            label,
            cluster,
            family,
            ..
        } = entry;
        Self {
            entry: *number,
            name,
            file,
            label,
            cluster,
            family,
            sha256: sha256.unwrap_or_default(),
        }
    }

    fn of_sample(sample: &'a SampleRecord) -> Self {
        let SampleRecord {
            entry,
            name,
            file,
            label,
            cluster,
            family,
            sha256,
            ..
        } = sample;
        Self {
            entry: *entry,
            name,
            file,
            label,
            cluster,
            family,
            sha256,
        }
    }

    fn of_exclusion(exclusion: &'a Exclusion) -> Self {
        let Exclusion {
            entry,
            name,
            file,
            label,
            cluster,
            family,
            sha256,
            ..
        } = exclusion;
        Self {
            entry: *entry,
            name,
            file,
            label,
            cluster,
            family,
            sha256,
        }
    }

    /// The rows of a set: samples, then excluded structures.
    pub fn of_content(content: &'a SetContent) -> Vec<Self> {
        let excluded = content.excluded.iter().map(Self::of_exclusion);
        content
            .samples
            .iter()
            .map(Self::of_sample)
            .chain(excluded)
            .collect()
    }
}
