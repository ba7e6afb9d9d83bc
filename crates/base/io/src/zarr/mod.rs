//! Sparse voxel sets as zarr v3 groups.
//!
//! ```text
//! SET.zarr/zarr.json      attributes: the description of the set, and string properties of the samples
//!          offsets        i64, one more than samples: sample i has the elements offsets[i] .. offsets[i + 1]
//!          index          u32, voxel numbers, ascending within a sample
//!          CHANNEL        f16, the values of a channel in the order of index; one array per channel that is not implied
//!          properties     f64, samples x columns; the columns' names are its attribute "columns"
//! ```
//!
//! A channel that is 1 in every stored voxel is *implied*: it has no
//! array. The arrays over all voxels are cut into chunks of 8192 elements, compressed by zstd
//! with byte shuffle under a CRC-32C, many chunks to a file. Their fill values cannot occur in a
//! sample (NaN, the largest integer), so that a lost chunk is detected and not read as zeros.
//!
//! | module | one idea |
//! |---|---|
//! | [`layout`] | the layout shared by writer and reader: arrays, chunks, files |
//! | `metadata` | the metadata of an array, held against the layout |
//! | `stored` | an array on disk, with files and chunks verified when first read |
//! | `table` | the properties, a file at a time |
//! | `group` | the attributes, as they stream by |
//! | [`mod@write`] | writes samples one after another |
//! | [`samples`] | reads and checks one sample |
//! | [`read`] | a set with its attributes and properties in memory |

mod group;
pub mod layout;
mod metadata;
pub mod read;
pub mod samples;
mod stored;
mod table;
pub mod write;

pub use group::attributes;
pub use read::SetReader;
pub use samples::{SampleReader, StoredSample};
pub use table::Table;
pub use write::{SetPlan, SetWriter, as_stored, of_stored_bits, stored_bits};
