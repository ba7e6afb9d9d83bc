//! What becomes a set: samples and exclusions.
//!
//! What describes the samples is never all in memory. It is read from the manifest and the work
//! file, row by row, and goes into `zarr.json` as it is read. A structure took 4 kB of memory; now
//! a hash and two offsets of it take 160 bytes.

use super::records::Exclusion;
use super::row::Row;
use super::structure::Properties;
use anyhow::Result;
use protomer_field::voxels::Voxels;
use std::collections::BTreeMap;

/// The content of a set. Samples are requested one at a time and more than once, so that nobody has
/// to hold them all.
pub trait Content {
    /// Number of samples.
    fn len(&self) -> usize;

    /// Whether there are no samples.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Occupied voxels of all samples.
    fn voxels(&self) -> u64;

    /// The manifest entry of a sample.
    ///
    /// # Errors
    /// If there is no such sample.
    fn row(&self, sample: usize) -> Result<Row>;

    /// The properties and voxels of a sample, with one list of values per channel.
    ///
    /// # Errors
    /// Names the file that cannot be read.
    fn sample(&self, sample: usize) -> Result<(Properties, Voxels)>;

    /// Excluded structures, in order.
    fn excluded(&self) -> &[Exclusion];

    /// The warnings of the samples that have any, by name.
    fn warnings(&self) -> &BTreeMap<String, Vec<String>>;
}
