//! A manifest entry with the hash of its file, taken from a manifest or read from a set.

use super::manifest::Entry;
use protomer_io::digest::Digest;
use serde::{Deserialize, Serialize};

/// The data used for a set's identity and for finding relatives.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Row {
    /// Position in the manifest, from zero.
    pub entry: usize,
    /// Name of the structure.
    pub name: String,
    /// The file as named in the manifest.
    pub file: String,
    /// Class of the structure.
    pub label: String,
    /// Cluster of the structure.
    pub cluster: String,
    /// Family of the structure; may be empty.
    pub family: String,
    /// SHA-256 of the file; empty if it could not be read.
    pub sha256: String,
}

impl Row {
    /// Names of [`Self::words`].
    pub const WORDS: [&'static str; 6] = ["name", "label", "cluster", "family", "file", "sha256"];

    /// The row of an entry.
    pub fn new(entry: Entry, sha256: Option<Digest>) -> Self {
        Self {
            entry: entry.number,
            name: entry.name,
            file: entry.file,
            label: entry.label,
            cluster: entry.cluster,
            family: entry.family,
            sha256: sha256.map_or_else(String::new, |digest| digest.to_string()),
        }
    }

    /// Everything but the position.
    pub fn words(&self) -> [&str; 6] {
        [
            &self.name,
            &self.label,
            &self.cluster,
            &self.family,
            &self.file,
            &self.sha256,
        ]
    }
}
