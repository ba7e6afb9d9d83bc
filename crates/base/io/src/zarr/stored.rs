//! An array on disk, with files and chunks verified when first read.

use super::layout::{self, Kind};
use super::metadata::{Metadata, require_sizes};
use crate::{IoError, Result};
use serde_json::{Map, Value};
use std::borrow::Cow;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};
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
    folder: PathBuf,
    array: Array<FilesystemStore>,
    cache: ArrayShardedReadableExtCache,
    per_file: u64,
    per_chunk: u64,
    /// The files whose list of chunks has already been verified.
    verified_files: Vec<AtomicBool>,
    /// The chunks that have already been verified.
    verified: Vec<AtomicBool>,
}

impl Stored {
    /// Opens an array whose metadata are those of the layout. The array is made from its kind, its shape
    /// and the shape of its files; no other metadata of the file are interpreted.
    pub(super) fn open(
        path: &Path,
        store: &Arc<FilesystemStore>,
        name: &str,
        kind: Kind,
    ) -> Result<Self> {
        let folder = path.join(name);
        let damaged = |cause: String| {
            let file = folder.join("zarr.json").display().to_string();
            Err(IoError::parse(
                &file,
                0,
                cause,
                "copy or make the set again",
            ))
        };
        // Sizes are checked before an array is made of them, and the metadata compared with
        // those of the array made: nothing of the file is interpreted by another program.
        let opened = Metadata::read(&folder.join("zarr.json")).and_then(|metadata| {
            let [shape, per_file] = [metadata.shape()?, metadata.per_file()?];
            require_sizes(kind, &shape, &per_file)?;
            let attributes = metadata.attributes();
            let made = layout::array(store, name, kind, &shape, &per_file, attributes);
            let array = made.map_err(|error| error.to_string())?;
            metadata.require_equal(&array)?;
            Ok((array, per_file))
        });
        let (array, per_file) = match opened {
            Ok((array, per_file)) => (array, per_file.first().copied().unwrap_or(1)),
            Err(cause) => return damaged(cause),
        };
        let per_chunk = match array.subchunk_shape() {
            Some(shape) => shape.first().map_or(per_file, |length| length.get()),
            None => per_file,
        };
        let length = array.shape().first().copied().unwrap_or(0);
        let untested = |count: u64| {
            let mut verified = Vec::new();
            verified.resize_with(count.min(MOST_CHUNKS) as usize, AtomicBool::default);
            verified
        };
        let cache = ArrayShardedReadableExtCache::new(&array);
        Ok(Self {
            name: name.to_owned(),
            folder,
            array,
            cache,
            per_file,
            per_chunk,
            verified_files: untested(length.div_ceil(per_file)),
            verified: untested(length.div_ceil(per_chunk)),
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
            // An empty sample touches no chunk.
            return Ok(Vec::new());
        }
        self.verify(&range)?;
        // The cache keeps the lists of chunks of files, not the chunks.
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

    /// Verifies the files and the checksums of the chunks of a range, once: reading a part of a chunk
    /// does not.
    fn verify(&self, range: &Range<u64>) -> std::result::Result<(), String> {
        // A table is small and is read as a whole: its checksum is verified with it.
        if !self.array.is_sharded() {
            return Ok(());
        }
        // `range` is not empty.
        let last = range.end - 1;
        for file in range.start / self.per_file..=last / self.per_file {
            once(self.verified_files.get(file as usize), || {
                self.verify_file(file)
            })?;
        }
        for chunk in range.start / self.per_chunk..=last / self.per_chunk {
            once(self.verified.get(chunk as usize), || {
                self.verify_chunk(chunk)
            })?;
        }
        Ok(())
    }

    /// Verifies that the chunks of a file lie in the file: zarrs takes memory for any length that the
    /// list at its end states.
    fn verify_file(&self, file: u64) -> std::result::Result<(), String> {
        let chunks = self.per_file / self.per_chunk;
        // The last file has fewer chunks than it has places for.
        let elements = self.length() - file * self.per_file;
        let used = elements.div_ceil(self.per_chunk).min(chunks);
        let path = self.folder.join("c").join(file.to_string());
        let list = chunk_list(&path, chunks).map_err(|cause| cause.to_string())?;
        for entry in list.entries.iter().take(used as usize) {
            match entry {
                [u64::MAX, u64::MAX] => return Err("a part is missing".into()),
                // Chunks lie before the list; one that ends behind its start overlaps it.
                [offset, size]
                    if offset
                        .checked_add(*size)
                        .is_some_and(|end| end <= list.start) => {}
                _ => return Err("a part is stated to lie outside the file".into()),
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
        // The decoded size is not known and not needed: an upper bound will do.
        let size = BytesRepresentation::BoundedSize(bytes.len() as u64);
        let options = CodecOptions::default();
        match Crc32cCodec::new().decode(Cow::Owned(bytes), &size, &options) {
            Ok(_) => Ok(()),
            Err(cause) => Err(cause.to_string()),
        }
    }

    /// Whether a file can be read completely.
    pub(super) fn reads(&self, file: u64) -> bool {
        let is_sound = !self.array.is_sharded() || self.verify_file(file).is_ok();
        is_sound && self.array.retrieve_chunk::<ArrayBytes>(&[file]).is_ok()
    }
}

/// Does the work unless it has been done before.
fn once(
    done: Option<&AtomicBool>,
    work: impl FnOnce() -> std::result::Result<(), String>,
) -> std::result::Result<(), String> {
    // Relaxed: at worst two threads verify the same chunk.
    if done.is_some_and(|done| done.load(Ordering::Relaxed)) {
        return Ok(());
    }
    work()?;
    // Only after success: a damaged chunk must be reported every time.
    if let Some(done) = done {
        done.store(true, Ordering::Relaxed);
    }
    Ok(())
}

/// Positions of the chunks in a file.
struct ChunkList {
    /// First byte of the list itself.
    start: u64,
    /// First byte and length of each chunk; the largest numbers if it was never written.
    entries: Vec<[u64; 2]>,
}

/// The list at the end of a file: two numbers of 8 bytes for each chunk and a checksum of 4 bytes.
fn chunk_list(path: &Path, chunks: u64) -> std::io::Result<ChunkList> {
    let mut file = crate::input::open(path)?;
    let length = 16 * chunks + 4;
    let start = file.metadata()?.len().checked_sub(length);
    let start = start.ok_or(std::io::ErrorKind::UnexpectedEof)?;
    file.seek(SeekFrom::Start(start))?;
    // Without the checksum of the list; zarrs verifies that itself.
    let mut bytes = vec![0; 16 * chunks as usize];
    file.read_exact(&mut bytes)?;
    let (numbers, _) = bytes.as_chunks::<8>();
    let (entries, _) = numbers.as_chunks::<2>();
    let number = |bytes: &[u8; 8]| u64::from_le_bytes(*bytes);
    Ok(ChunkList {
        start,
        entries: entries
            .iter()
            .map(|entry| entry.each_ref().map(number))
            .collect(),
    })
}
