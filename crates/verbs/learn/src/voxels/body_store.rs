//! Bodies made in the same pass as voxels.
//!
//! Reading a structure, charging it and finding its exact surface is some 15 % of making its voxels and as
//! much of making its body. With a store for bodies it is done once. What the tables say of a body waits in
//! the work file, so a run that was interrupted and continued writes whole tables.

use anyhow::Result;
use protomer_body::Draft;
use protomer_body::surface::ExactSurface;
use protomer_results::FileRecord;
use std::path::Path;

/// Makes bodies and keeps them.
pub trait BodyStore: Sync {
    /// Vertices of the meshes per Å².
    fn density_per_angstrom2(&self) -> f64;

    /// Makes the body of a file and keeps it.
    ///
    /// # Errors
    /// If it cannot be written. An error in the file is in the record.
    fn keep(&self, file: &Path, draft: Draft, surface: ExactSurface) -> Result<FileRecord>;

    /// The record of a file without a body.
    fn failed(&self, file: &Path, error: &anyhow::Error) -> FileRecord;

    /// Writes the tables, with the records in the order of the manifest.
    ///
    /// # Errors
    /// Names the file that cannot be written; and the errors of the records.
    fn finish(&self, records: &mut dyn Iterator<Item = Result<FileRecord>>) -> Result<()>;
}
