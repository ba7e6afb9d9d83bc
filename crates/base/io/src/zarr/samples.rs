//! The samples of a set, without its attributes: memory for a number per sample.

use super::group::{self, Head, not_a_set};
use super::layout::{self, INDEX, Kind, OFFSETS};
use super::stored::Stored;
use super::table::Table;
use crate::{IoError, Result};
use half::f16;
use half::slice::HalfFloatSliceExt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zarrs::filesystem::FilesystemStore;

/// The samples of an open set. They may be read from several threads at once.
///
/// ```
/// use protomer_io::zarr::{SampleReader, SetPlan, SetWriter};
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("set.zarr");
/// let plan = SetPlan {
///     size: 16,
///     channels: vec!["potential".to_owned()],
///     implied: Vec::new(),
///     columns: vec!["charge_e".to_owned()],
///     samples: 1,
///     voxels: 2,
/// };
/// let mut writer = SetWriter::create(&path, plan)?;
/// writer.push(&[7, 8], &[&[0.5, -1.0]], &[6.0])?;
/// writer.finish(&serde_json::Map::new())?;
/// let samples = SampleReader::open(&path)?;
/// assert_eq!((samples.len(), samples.voxels(0)), (1, 2));
/// assert_eq!(samples.sample(0)?.values, [[0.5, -1.0]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct SampleReader {
    path: PathBuf,
    size: usize,
    channels: Vec<String>,
    offsets: Vec<i64>,
    index: Stored,
    /// Array of each channel; `None` if it is implied.
    values: Vec<Option<Stored>>,
    table: Table,
}

/// The occupied voxels of a sample and, for each channel of the set, the values there.
///
/// ```
/// use protomer_io::zarr::StoredSample;
/// // The voxel at x = 3, y = 2, z = 1 of a grid with 16 along each edge, in one channel.
/// let sample = StoredSample { index: vec![(16 + 2) * 16 + 3], values: vec![vec![0.5]] };
/// assert_eq!((sample.index[0] % 16, sample.index[0] / 16 % 16, sample.index[0] / 256), (3, 2, 1));
/// assert_eq!(sample.values[0].len(), sample.index.len());
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StoredSample {
    /// Voxel numbers, ascending: (z size + y) size + x.
    pub index: Vec<u32>,
    /// Values of each channel, in the order of `index`.
    pub values: Vec<Vec<f32>>,
}

pub(super) const MAKE_AGAIN: &str = "copy or make the set again";

impl SampleReader {
    /// Opens the arrays of a set.
    ///
    /// # Errors
    /// [`IoError::Parse`] names the file that is missing, damaged or of a newer layout.
    pub fn open(path: &Path) -> Result<Self> {
        let head = Head::read(path)?;
        let store = layout::store(path)?;
        let size = head.size(path)?;
        let channels = head.channels(path)?;
        let implied = head.implied(path)?;
        let index = Stored::open(path, &store, INDEX, Kind::Index)?;
        // Offsets are held in memory, eight bytes a sample: any sample is then found at once.
        let offsets = read_offsets(path, &store, index.length())?;
        let mut values = Vec::with_capacity(channels.len());
        for name in &channels {
            values.push(if implied.contains(name) {
                None
            } else {
                Some(open_channel(path, &store, name, index.length())?)
            });
        }
        let table = Table::open(path, &store, offsets.len() - 1)?;
        Ok(Self {
            path: path.to_owned(),
            size,
            channels,
            offsets,
            index,
            values,
            table,
        })
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Whether there are no samples.
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

    /// The table of the samples' properties.
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// Occupied voxels of a sample; zero if there is no such sample.
    pub fn voxels(&self, sample: usize) -> usize {
        match self.range(sample) {
            Some(range) => (range.end - range.start) as usize,
            None => 0,
        }
    }

    fn range(&self, sample: usize) -> Option<Range<u64>> {
        let (begin, end) = (self.offsets.get(sample)?, self.offsets.get(sample + 1)?);
        Some(*begin as u64..*end as u64)
    }

    /// Reads a sample.
    ///
    /// # Errors
    /// [`IoError::Parse`] for a sample that does not exist; for a damaged or missing file,
    /// names the file and all samples in it.
    pub fn sample(&self, sample: usize) -> Result<StoredSample> {
        let Some(range) = self.range(sample) else {
            let set = self.path.display().to_string();
            let cause = format!("there is no sample {sample}; the set has {}", self.len());
            return Err(IoError::parse(&set, 0, cause, "count from zero"));
        };
        let index = match self.read_index(range.clone()) {
            Ok(index) => index,
            Err(cause) => return Err(self.damaged(&self.index, &range, sample, &cause)),
        };
        let mut values = Vec::with_capacity(self.values.len());
        for stored in &self.values {
            let Some(stored) = stored else {
                // An implied channel is 1 wherever the sample has a voxel.
                values.push(vec![1.0; index.len()]);
                continue;
            };
            match read_channel(stored, range.clone()) {
                Ok(channel) => values.push(channel),
                Err(cause) => return Err(self.damaged(stored, &range, sample, &cause)),
            }
        }
        Ok(StoredSample { index, values })
    }

    fn read_index(&self, range: Range<u64>) -> std::result::Result<Vec<u32>, String> {
        let index: Vec<u32> = self.index.read(range)?;
        if layout::ascends_within(&index, self.size) {
            Ok(index)
        } else {
            Err("voxel numbers do not ascend inside the grid".into())
        }
    }

    /// The error if a sample cannot be read from a file.
    fn damaged(&self, stored: &Stored, range: &Range<u64>, sample: usize, cause: &str) -> IoError {
        let per_file = stored.per_file();
        let first = range.start / per_file;
        let last = range.end.saturating_sub(1).max(range.start) / per_file;
        // The unreadable file among those of the sample, if there is exactly one.
        let file = (first..=last)
            .find(|file| !stored.reads(*file))
            .unwrap_or(first);
        let (begin, end) = (file * per_file, (file + 1) * per_file);
        let offsets = &self.offsets;
        // All samples with voxels in the file are lost with it, not only this one.
        let from = offsets.partition_point(|offset| *offset as u64 <= begin);
        let from = from.saturating_sub(1);
        let to = offsets.partition_point(|offset| (*offset as u64) < end);
        let to = to.saturating_sub(1).min(self.len()).max(from + 1);
        let names = group::names(&self.path);
        // A number if the set names none.
        let name = |sample: usize| match names.get(sample) {
            Some(name) => name.clone(),
            None => sample.to_string(),
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

/// The array of a channel, with a value for each voxel of the set.
fn open_channel(
    path: &Path,
    store: &Arc<FilesystemStore>,
    name: &str,
    voxels: u64,
) -> Result<Stored> {
    let stored = Stored::open(path, store, name, Kind::Channel)?;
    if stored.length() == voxels {
        return Ok(stored);
    }
    let values = stored.length();
    let cause = format!("array {name} has {values} values, index {voxels}");
    Err(not_a_set(path, &cause))
}

/// The values of a channel in single precision; all must be present and finite.
fn read_channel(stored: &Stored, range: Range<u64>) -> std::result::Result<Vec<f32>, String> {
    // Half precision on disk, single in memory.
    let halves: Vec<f16> = stored.read(range)?;
    let singles = halves.to_f32_vec();
    // The fill value is NaN: a chunk that was never written cannot pass as data.
    if singles.iter().all(|value| value.is_finite()) {
        Ok(singles)
    } else {
        Err("values are missing or not finite".into())
    }
}

/// Reads the index of the first element of each sample and the end of the last sample; none is
/// negative.
fn read_offsets(path: &Path, store: &Arc<FilesystemStore>, voxels: u64) -> Result<Vec<i64>> {
    let stored = Stored::open(path, store, OFFSETS, Kind::Offsets)?;
    let bad = |cause: &str| Err(IoError::parse(&stored.file(path, 0), 0, cause, MAKE_AGAIN));
    let offsets: Vec<i64> = match stored.read(0..stored.length()) {
        Ok(offsets) => offsets,
        Err(cause) => return bad(&cause),
    };
    // Ascending from 0 to the end: then every range lies within the arrays.
    let is_whole = offsets.first() == Some(&0)
        && offsets.last().copied() == i64::try_from(voxels).ok()
        && offsets.is_sorted();
    if !is_whole {
        return bad("the offsets do not ascend from zero to the number of voxels");
    }
    Ok(offsets)
}
