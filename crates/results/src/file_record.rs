//! What the tables of a folder say of an input file.

use serde::{Deserialize, Serialize};

/// The row of a file in the table of its folder, and its lines in the table of warnings.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileRecord {
    /// The file.
    pub file: String,
    /// Its row.
    pub row: Vec<String>,
    /// Warnings about it.
    pub warnings: Vec<String>,
    /// Why it failed.
    pub error: Option<String>,
}
