//! Sparse voxel sets as zarr v3 groups.
//!
//! ```text
//! SET.zarr/zarr.json      attributes: what the set is, and the words known of each sample
//!          offsets        i64, one more than samples: sample i has the elements offsets[i] .. offsets[i + 1]
//!          index          u32, voxel numbers, ascending within a sample
//!          CHANNEL        f16, the values of a channel in the order of index; one array per channel that is not implied
//!          properties     f64, samples x columns; the columns' names are its attribute "columns"
//! ```
//!
//! A channel that is 1 wherever it is not 0, and nowhere 0 in what is stored, is *implied*: it has
//! no array. The arrays over all voxels are cut into chunks of 8192 elements, compressed by zstd
//! with byte shuffle under a CRC-32C, many chunks to a file. Their fill values are what no sample
//! can hold (NaN, the largest integer), so that a lost chunk is noticed and not taken for zeros.
//!
//! | module | one idea |
//! |---|---|
//! | [`layout`] | arrays, chunks, files: what writer and reader must agree on |
//! | `stored` | an array on the disk, its chunks checked when they are first read |
//! | [`mod@write`] | samples in, one after the other |
//! | [`read`] | one sample out, checked |

pub mod layout;
pub mod read;
mod stored;
pub mod write;

pub use read::{SetReader, StoredSample};
pub use write::{SetWriter, as_stored};
