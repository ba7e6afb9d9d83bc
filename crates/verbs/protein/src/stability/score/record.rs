//! Results for one complex, as stored.

use super::Measure;
use anyhow::Result;
use protomer_io::atomic::write_atomically;
use protomer_results::keys;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;

/// File of a record.
const FILE: &str = "row.json";

/// Results for one complex.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ScoreRecord {
    /// Version of the program that made the record; another one scores again.
    pub version: String,
    /// SHA-256 of the files when they were read; empty for one that could not be read.
    pub sha256: Vec<String>,
    /// Chains that were stated for the two bodies.
    pub bodies: Vec<Vec<String>>,
    /// The groups of columns that are done.
    pub measured: Vec<Measured>,
    /// Warnings about the complex.
    pub warnings: Vec<String>,
    /// Reason why the complex could not be scored.
    pub error: Option<String>,
    /// Groups that were requested and missing when that happened.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tried: Vec<Measure>,
}

/// The columns of a group.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Measured {
    pub measure: Measure,
    /// Headings and values; null for a value that does not exist.
    pub values: Vec<(String, Value)>,
}

impl ScoreRecord {
    /// The record in a directory; `None` if there is none.
    ///
    /// # Errors
    /// If the file is damaged.
    pub fn read(directory: &Path) -> Result<Option<Self>> {
        Ok(keys::read_json_if_present(&directory.join(FILE))?)
    }

    /// Writes the record.
    ///
    /// # Errors
    /// Names the file that cannot be written.
    pub fn write(&self, directory: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(self)?;
        Ok(write_atomically(&directory.join(FILE), |file| {
            file.write_all(text.as_bytes())
        })?)
    }

    /// Whether a group is done.
    pub fn has(&self, measure: Measure) -> bool {
        self.measured.iter().any(|group| group.measure == measure)
    }

    /// Adds the columns of a group.
    pub fn add(&mut self, measure: Measure, values: Vec<(String, Value)>) {
        self.measured.push(Measured { measure, values });
    }

    /// Adds warnings, each once.
    pub fn warn(&mut self, warnings: impl IntoIterator<Item = String>) {
        for warning in warnings {
            let text = warning
                .strip_prefix("warning: ")
                .map_or_else(|| warning.clone(), str::to_owned);
            if !self.warnings.contains(&text) {
                self.warnings.push(text);
            }
        }
    }

    /// The value under a heading.
    pub fn value(&self, heading: &str) -> Option<&Value> {
        let mut values = self.measured.iter().flat_map(|group| &group.values);
        values
            .find(|(name, _)| name == heading)
            .map(|(_, value)| value)
    }
}

/// A column with a number; null for one that is not finite.
pub(super) fn number(heading: impl Into<String>, value: f64) -> (String, Value) {
    (heading.into(), Value::from(value))
}

/// A column with a whole number.
pub(super) fn count(heading: impl Into<String>, value: usize) -> (String, Value) {
    (heading.into(), Value::from(value))
}
