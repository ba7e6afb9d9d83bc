//! Bodies made on the way, of the same sites and surfaces as voxels.
//!
//! Reading a structure, charging it and finding its surface exactly is a seventh of making its voxels and
//! a sixth of making its body: whoever wants both does it once. The store makes the body and keeps it;
//! what it tells of it waits in the work file, so that the tables of a run that was continued are whole.

use anyhow::Result;
use protomer_body::Draft;
use protomer_body::surface::ExactSurface;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Makes bodies and keeps them.
pub trait BodyStore: Sync {
    /// Vertices of the meshes per Å².
    fn density_per_angstrom2(&self) -> f64;

    /// Makes the body of a file and keeps it.
    fn keep(&self, file: &Path, draft: Draft, surface: ExactSurface) -> BodyRecord;

    /// The record of a file without a body.
    fn failed(&self, file: &Path, error: &anyhow::Error) -> BodyRecord;

    /// Whether the tables have been written: those of these structures, or those of their parts.
    fn is_finished(&self) -> bool;

    /// Writes the tables, with the records in the order of the manifest.
    ///
    /// # Errors
    /// Names the file that cannot be written; and the errors of the records.
    fn finish(&self, records: &mut dyn Iterator<Item = Result<BodyRecord>>) -> Result<()>;
}

/// What is told of a body.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyRecord {
    /// Its file.
    pub file: String,
    /// Its row in the table of bodies.
    pub row: Vec<String>,
    /// Warnings about it.
    pub warnings: Vec<String>,
    /// Why it could not be made.
    pub error: Option<String>,
}
