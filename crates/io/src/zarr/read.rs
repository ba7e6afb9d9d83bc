//! One sample out, checked.

use super::layout::{self, INDEX, LAYOUT_VERSION, OFFSETS, PROPERTIES};
use crate::{IoError, Result};
use half::f16;
use half::slice::HalfFloatSliceExt;
use serde_json::{Map, Value};
use std::borrow::Cow;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use zarrs::array::codec::Crc32cCodec;
use zarrs::array::codec::api::BytesToBytesCodecTraits;
use zarrs::array::{
    Array, ArrayShardedExt, ArrayShardedReadableExt, ArrayShardedReadableExtCache, ArraySubset,
    BytesRepresentation, CodecOptions, ElementOwned,
};
use zarrs::filesystem::FilesystemStore;
use zarrs::group::Group;

/// An open set. Samples may be read from several threads at once.
pub struct SetReader {
    path: PathBuf,
    size: usize,
    channels: Vec<String>,
    attributes: Map<String, Value>,
    names: Vec<String>,
    offsets: Vec<u64>,
    columns: Vec<String>,
    rows: Vec<f64>,
    index: Stored,
    /// For each channel its array; `None` if it is implied.
    values: Vec<Option<Stored>>,
}

/// The occupied voxels of a sample and, for each channel of the set, the values there.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StoredSample {
    /// Voxel numbers, ascending: (z size + y) size + x.
    pub index: Vec<u32>,
    /// One list per channel, in the order of `index`.
    pub values: Vec<Vec<f32>>,
}

/// An array over all voxels.
struct Stored {
    name: String,
    array: Array<FilesystemStore>,
    cache: ArrayShardedReadableExtCache,
    per_file: u64,
    per_chunk: u64,
    /// Which chunks have been held against their checksums already.
    verified: Vec<AtomicBool>,
}

/// Chunks remembered as verified: 16 million, a thousand times the largest set.
const MOST_CHUNKS: u64 = 1 << 24;
const MAKE_AGAIN: &str = "copy or make the set again";

impl SetReader {
    /// Opens a set and reads everything but the voxels.
    ///
    /// # Errors
    /// [`IoError::Parse`] names the file that is missing, damaged or of a newer layout.
    pub fn open(path: &Path) -> Result<Self> {
        let file = path.join("zarr.json").display().to_string();
        let bad = |cause: String| {
            IoError::parse(
                &file,
                0,
                cause,
                "give a set that protomer voxelize has written",
            )
        };
        if !path.join("zarr.json").is_file() {
            return Err(bad(
                "there is no zarr group here, or an unfinished one".into()
            ));
        }
        let store = layout::store(path)?;
        let group = Group::open(store.clone(), "/").map_err(|cause| bad(cause.to_string()))?;
        let attributes = group.attributes().clone();
        let number = |key: &str| attributes.get(key).and_then(Value::as_u64);
        let version = number("layout_version").ok_or_else(|| bad("it is no voxel set".into()))?;
        if version > LAYOUT_VERSION {
            return Err(bad(format!(
                "layout {version} is newer than this program's, {LAYOUT_VERSION}"
            )));
        }
        let size = number("size").filter(|size| (1..=1024).contains(size));
        let size =
            size.ok_or_else(|| bad("attribute 'size' is missing or absurd".into()))? as usize;
        let channels =
            words(attributes.get("channels")).ok_or_else(|| bad("no list 'channels'".into()))?;
        let implied = words(attributes.get("implied_channels"))
            .ok_or_else(|| bad("no 'implied_channels'".into()))?;
        let open = |name: &str| Stored::open(path, &store, name);
        let offsets = open(OFFSETS)?;
        let offsets_file = offsets.file(path, 0);
        let bad_offsets = |cause: &str| IoError::parse(&offsets_file, 0, cause, MAKE_AGAIN);
        let all: Vec<i64> = offsets
            .read(0..offsets.length())
            .map_err(|cause| bad_offsets(&cause))?;
        let index = open(INDEX)?;
        let ends = (all.first().copied(), all.last().copied());
        if ends != (Some(0), i64::try_from(index.length()).ok())
            || all.windows(2).any(|pair| pair[0] > pair[1])
        {
            return Err(bad_offsets(
                "the offsets do not ascend from zero to the number of voxels",
            ));
        }
        let offsets: Vec<u64> = all.iter().map(|offset| *offset as u64).collect();
        let samples = offsets.len() - 1;
        let values = channels
            .iter()
            .map(|name| (!implied.contains(name)).then(|| open(name)).transpose());
        let values = values.collect::<Result<Vec<Option<Stored>>>>()?;
        if let Some(short) = values
            .iter()
            .flatten()
            .find(|stored| stored.length() != index.length())
        {
            let cause = format!(
                "array {} has {} values, index {}",
                short.name,
                short.length(),
                index.length()
            );
            return Err(bad(cause));
        }
        let (columns, rows) = table(path, &open(PROPERTIES)?, samples)?;
        let names = words(
            attributes
                .get("samples")
                .and_then(|samples| samples.get("name")),
        )
        .unwrap_or_default();
        let path = path.to_owned();
        Ok(Self {
            path,
            size,
            channels,
            attributes,
            names,
            offsets,
            columns,
            rows,
            index,
            values,
        })
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Voxels along each edge.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Channels in order.
    pub fn channels(&self) -> &[String] {
        &self.channels
    }

    /// Attributes of the group.
    pub fn attributes(&self) -> &Map<String, Value> {
        &self.attributes
    }

    /// Names of the columns of numbers.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The numbers known of a sample, in the order of the columns; empty if there is no such
    /// sample.
    pub fn row(&self, sample: usize) -> &[f64] {
        let width = self.columns.len();
        self.rows
            .get(sample * width..(sample + 1) * width)
            .unwrap_or_default()
    }

    /// The words known of each sample, by the name of the list.
    pub fn words(&self, list: &str) -> Option<Vec<String>> {
        words(self.attributes.get("samples")?.get(list))
    }

    /// Occupied voxels of a sample; zero if there is no such sample.
    pub fn voxels(&self, sample: usize) -> usize {
        self.range(sample)
            .map_or(0, |range| (range.end - range.start) as usize)
    }

    fn range(&self, sample: usize) -> Option<Range<u64>> {
        Some(*self.offsets.get(sample)?..*self.offsets.get(sample + 1)?)
    }

    /// Reads a sample.
    ///
    /// # Errors
    /// [`IoError::Parse`] for a sample that is not there; for a damaged or missing file it names
    /// the file and all samples that lie in it.
    pub fn sample(&self, sample: usize) -> Result<StoredSample> {
        let range = self.range(sample).ok_or_else(|| {
            let cause = format!("there is no sample {sample}; the set has {}", self.len());
            IoError::parse(
                &self.path.display().to_string(),
                0,
                cause,
                "count from zero",
            )
        })?;
        let damaged = |stored: &Stored, cause: &str| self.damaged(stored, &range, sample, cause);
        let index: Vec<u32> = self
            .index
            .read(range.clone())
            .map_err(|cause| damaged(&self.index, &cause))?;
        let beyond = index
            .last()
            .is_some_and(|last| *last as usize >= self.size.pow(3));
        if beyond || index.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Err(damaged(
                &self.index,
                "voxel numbers do not ascend inside the grid",
            ));
        }
        let mut values = Vec::with_capacity(self.values.len());
        for stored in &self.values {
            values.push(match stored {
                None => vec![1.0; index.len()],
                Some(stored) => {
                    let halves: Vec<f16> = stored
                        .read(range.clone())
                        .map_err(|cause| damaged(stored, &cause))?;
                    let singles = halves.to_f32_vec();
                    if singles.iter().any(|value| !value.is_finite()) {
                        return Err(damaged(stored, "values are missing or not finite"));
                    }
                    singles
                }
            });
        }
        Ok(StoredSample { index, values })
    }

    /// The error for a file that a sample could not be read from.
    fn damaged(&self, stored: &Stored, range: &Range<u64>, sample: usize, cause: &str) -> IoError {
        let first = range.start / stored.per_file;
        let last = range.end.saturating_sub(1).max(range.start) / stored.per_file;
        // Of the files that a sample lies in, the one that cannot be read, if one alone cannot.
        let is_bad = |file: &u64| !stored.reads(*file);
        let file = (first..=last).find(is_bad).unwrap_or(first);
        let (begin, end) = (file * stored.per_file, (file + 1) * stored.per_file);
        let from = self
            .offsets
            .partition_point(|offset| *offset <= begin)
            .saturating_sub(1);
        let to = self
            .offsets
            .partition_point(|offset| *offset < end)
            .saturating_sub(1)
            .min(self.len())
            .max(from + 1);
        let name = |sample: usize| {
            self.names
                .get(sample)
                .cloned()
                .unwrap_or_else(|| sample.to_string())
        };
        let cause = format!(
            "{cause}, met at sample {}; it holds {} samples, {} to {}",
            name(sample),
            to - from,
            name(from),
            name(to - 1)
        );
        IoError::parse(&stored.file(&self.path, file), 0, cause, MAKE_AGAIN)
    }
}

impl Stored {
    fn open(path: &Path, store: &std::sync::Arc<FilesystemStore>, name: &str) -> Result<Self> {
        let file = path.join(name).join("zarr.json").display().to_string();
        let bad = |cause: String| IoError::parse(&file, 0, cause, MAKE_AGAIN);
        let array = Array::open(store.clone(), &format!("/{name}"))
            .map_err(|cause| bad(cause.to_string()))?;
        let per_file = array
            .chunk_shape(&vec![0; array.shape().len()])
            .map_err(|cause| bad(cause.to_string()))?;
        let per_file = per_file.first().map_or(1, |length| length.get());
        let per_chunk = array
            .subchunk_shape()
            .and_then(|shape| Some(shape.first()?.get()))
            .unwrap_or(per_file);
        let length = array.shape().first().copied().unwrap_or(0);
        // A damaged length must not take memory: elements that are there take at least a bit each.
        let chunks = length.div_ceil(per_chunk).min(MOST_CHUNKS);
        let verified = (0..chunks).map(|_| AtomicBool::new(false)).collect();
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

    fn length(&self) -> u64 {
        self.array.shape().first().copied().unwrap_or(0)
    }

    fn file(&self, path: &Path, file: u64) -> String {
        path.join(&self.name)
            .join("c")
            .join(file.to_string())
            .display()
            .to_string()
    }

    /// Elements of an array of one dimension.
    fn read<T: ElementOwned>(&self, range: Range<u64>) -> std::result::Result<Vec<T>, String> {
        if range.is_empty() {
            return Ok(Vec::new());
        }
        self.verify(&range)?;
        let subset = ArraySubset::new_with_ranges(&[range]);
        // One sample is little work: threads belong to whoever asks for many.
        let options = CodecOptions::default().with_concurrent_target(1);
        self.array
            .retrieve_array_subset_sharded_opt::<Vec<T>>(&self.cache, &subset, &options)
            .map_err(|cause| cause.to_string())
    }

    /// Holds the chunks of a range against their checksums, once: reading a part of a chunk does
    /// not.
    fn verify(&self, range: &Range<u64>) -> std::result::Result<(), String> {
        if !self.array.is_sharded() {
            return Ok(());
        }
        for chunk in range.start / self.per_chunk..=(range.end - 1) / self.per_chunk {
            let verified = usize::try_from(chunk)
                .ok()
                .and_then(|chunk| self.verified.get(chunk));
            if verified.is_some_and(|verified| verified.load(Ordering::Relaxed)) {
                continue;
            }
            let bytes = self
                .array
                .retrieve_encoded_subchunk(&self.cache, &[chunk])
                .map_err(|cause| cause.to_string())?;
            let bytes = bytes.ok_or("a part is missing")?;
            // The checksum stands last: what is under it is left to the array's own codecs.
            let size = BytesRepresentation::BoundedSize(bytes.len() as u64);
            let checked =
                Crc32cCodec::new().decode(Cow::Owned(bytes), &size, &CodecOptions::default());
            checked.map_err(|cause| cause.to_string())?;
            if let Some(verified) = verified {
                verified.store(true, Ordering::Relaxed);
            }
        }
        Ok(())
    }

    /// Whether a file can be read from end to end.
    fn reads(&self, file: u64) -> bool {
        self.array
            .retrieve_chunk::<zarrs::array::ArrayBytes>(&[file])
            .is_ok()
    }
}

fn table(path: &Path, stored: &Stored, samples: usize) -> Result<(Vec<String>, Vec<f64>)> {
    let file = path.join(PROPERTIES).display().to_string();
    let bad = |cause: String| IoError::parse(&file, 0, cause, MAKE_AGAIN);
    let columns = words(stored.array.attributes().get("columns"))
        .ok_or_else(|| bad("no list 'columns'".into()))?;
    let rows: Vec<f64> = stored
        .array
        .retrieve_array_subset(&stored.array.subset_all())
        .map_err(|cause| bad(cause.to_string()))?;
    if rows.len() != samples * columns.len() {
        return Err(bad(format!(
            "{} numbers for {samples} samples of {} columns",
            rows.len(),
            columns.len()
        )));
    }
    Ok((columns, rows))
}

/// A list of words.
fn words(value: Option<&Value>) -> Option<Vec<String>> {
    value?
        .as_array()?
        .iter()
        .map(|word| word.as_str().map(str::to_owned))
        .collect()
}
