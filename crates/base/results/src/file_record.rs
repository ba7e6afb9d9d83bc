//! What the tables of a folder say of an input file.

use serde::{Deserialize, Serialize};

/// The row of a file in the table of its folder, and its lines in the table of warnings.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileRecord {
    /// The file.
    pub file: String,
    /// Row of the file.
    pub row: Vec<String>,
    /// Warnings about the file.
    pub warnings: Vec<String>,
    /// Reason why the file failed.
    pub error: Option<String>,
}
