//! An array on disk, with chunks verified when first read.

use crate::{IoError, Result};
use serde_json::{Map, Value};
use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use zarrs::array::codec::Crc32cCodec;
use zarrs::array::codec::api::BytesToBytesCodecTraits;
use zarrs::array::{
    Array, ArrayBytes, ArrayShardedExt, ArrayShardedReadableExt, ArrayShardedReadableExtCache,
    ArraySubset, BytesRepresentation, CodecOptions, ElementOwned,
};
use zarrs::filesystem::FilesystemStore;

/// Maximum number of chunks remembered as verified: 16 million, a thousand times the largest set.
const MOST_CHUNKS: u64 = 1 << 24;

/// An array of the layout.
pub(super) struct Stored {
    name: String,
    array: Array<FilesystemStore>,
    cache: ArrayShardedReadableExtCache,
    per_file: u64,
    per_chunk: u64,
    /// The chunks that have already been verified.
    verified: Vec<AtomicBool>,
}

impl Stored {
    pub(super) fn open(path: &Path, store: &Arc<FilesystemStore>, name: &str) -> Result<Self> {
        let damaged = |cause: String| {
            let file = path.join(name).join("zarr.json").display().to_string();
            Err(IoError::parse(
                &file,
                0,
                cause,
                "copy or make the set again",
            ))
        };
        let array = match Array::open(store.clone(), &format!("/{name}")) {
            Ok(array) => array,
            Err(cause) => return damaged(cause.to_string()),
        };
        let chunk_shape = match array.chunk_shape(&vec![0; array.shape().len()]) {
            Ok(shape) => shape,
            Err(cause) => return damaged(cause.to_string()),
        };
        let per_file = chunk_shape.first().map_or(1, |length| length.get());
        let subchunk_shape = array.subchunk_shape().unwrap_or(chunk_shape);
        let per_chunk = subchunk_shape
            .first()
            .map_or(per_file, |length| length.get());
        let length = array.shape().first().copied().unwrap_or(0);
        // A damaged length must not allocate memory: stored elements take at least a bit each.
        let chunks = length.div_ceil(per_chunk).min(MOST_CHUNKS);
        let mut verified = Vec::new();
        verified.resize_with(chunks as usize, AtomicBool::default);
        let cache = ArrayShardedReadableExtCache::new(&array);
        Ok(Self {
            name: name.to_owned(),
            array,
            cache,
            per_file,
            per_chunk,
            verified,
        })
    }

    /// Elements along each dimension.
    pub(super) fn shape(&self) -> &[u64] {
        self.array.shape()
    }

    /// Elements along the first dimension.
    pub(super) fn length(&self) -> u64 {
        self.array.shape().first().copied().unwrap_or(0)
    }

    /// Elements in one file.
    pub(super) fn per_file(&self) -> u64 {
        self.per_file
    }

    pub(super) fn attributes(&self) -> &Map<String, Value> {
        self.array.attributes()
    }

    /// The path of a file of the array.
    pub(super) fn file(&self, path: &Path, file: u64) -> String {
        let folder = path.join(&self.name).join("c");
        folder.join(file.to_string()).display().to_string()
    }

    /// Elements of an array of one dimension.
    pub(super) fn read<T: ElementOwned>(
        &self,
        range: Range<u64>,
    ) -> std::result::Result<Vec<T>, String> {
        if range.is_empty() {
            return Ok(Vec::new());
        }
        self.verify(&range)?;
        let subset = ArraySubset::new_with_ranges(&[range]);
        // One sample is little work; parallelism is left to the caller.
        let options = CodecOptions::default().with_concurrent_target(1);
        self.array
            .retrieve_array_subset_sharded_opt::<Vec<T>>(&self.cache, &subset, &options)
            .map_err(|cause| cause.to_string())
    }

    /// Rows of an array of numbers with `width` columns.
    pub(super) fn read_rows(
        &self,
        rows: Range<u64>,
        width: u64,
    ) -> std::result::Result<Vec<f64>, String> {
        self.array
            .retrieve_array_subset(&ArraySubset::new_with_ranges(&[rows, 0..width]))
            .map_err(|cause| cause.to_string())
    }

    /// Verifies the checksums of the chunks of a range, once: reading a part of a chunk does not.
    fn verify(&self, range: &Range<u64>) -> std::result::Result<(), String> {
        if !self.array.is_sharded() {
            return Ok(());
        }
        for chunk in range.start / self.per_chunk..=(range.end - 1) / self.per_chunk {
            let verified = self.verified.get(chunk as usize);
            if verified.is_some_and(|verified| verified.load(Ordering::Relaxed)) {
                continue;
            }
            self.verify_chunk(chunk)?;
            if let Some(verified) = verified {
                verified.store(true, Ordering::Relaxed);
            }
        }
        Ok(())
    }

    fn verify_chunk(&self, chunk: u64) -> std::result::Result<(), String> {
        let encoded = self.array.retrieve_encoded_subchunk(&self.cache, &[chunk]);
        let bytes = match encoded {
            Ok(Some(bytes)) => bytes,
            Ok(None) => return Err("a part is missing".into()),
            Err(cause) => return Err(cause.to_string()),
        };
        // The checksum is the outermost codec; the inner ones are left to the array.
        let size = BytesRepresentation::BoundedSize(bytes.len() as u64);
        let options = CodecOptions::default();
        match Crc32cCodec::new().decode(Cow::Owned(bytes), &size, &options) {
            Ok(_) => Ok(()),
            Err(cause) => Err(cause.to_string()),
        }
    }

    /// Whether a file can be read completely.
    pub(super) fn reads(&self, file: u64) -> bool {
        self.array.retrieve_chunk::<ArrayBytes>(&[file]).is_ok()
    }
}
