//! Reads and checks one sample.

use super::layout::{self, INDEX, LAYOUT_VERSION, OFFSETS, PROPERTIES};
use super::stored::Stored;
use crate::{IoError, Result};
use half::f16;
use half::slice::HalfFloatSliceExt;
use serde_json::{Map, Value};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zarrs::filesystem::FilesystemStore;
use zarrs::group::Group;

/// An open set. Samples may be read from several threads at once. [`super::SetWriter`] has an
/// example.
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

const MAKE_AGAIN: &str = "copy or make the set again";

impl SetReader {
    /// Opens a set and reads everything but the voxels.
    ///
    /// # Errors
    /// [`IoError::Parse`] names the file that is missing, damaged or of a newer layout.
    pub fn open(path: &Path) -> Result<Self> {
        let (store, attributes) = open_group(path)?;
        let head = Head {
            path,
            attributes: &attributes,
        };
        head.check_version()?;
        let size = head.size()?;
        let channels = head.list("channels")?;
        let implied = head.list("implied_channels")?;
        let index = Stored::open(path, &store, INDEX)?;
        let offsets = read_offsets(path, &store, index.length())?;
        let mut values = Vec::with_capacity(channels.len());
        for name in &channels {
            values.push(if implied.contains(name) {
                None
            } else {
                Some(head.channel(&store, name, index.length())?)
            });
        }
        let properties = Stored::open(path, &store, PROPERTIES)?;
        let (columns, rows) = table(path, &properties, offsets.len() - 1)?;
        let samples = attributes.get("samples");
        let names = words(samples.and_then(|samples| samples.get("name"))).unwrap_or_default();
        Ok(Self {
            path: path.to_owned(),
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

    /// Attributes of the group.
    pub fn attributes(&self) -> &Map<String, Value> {
        &self.attributes
    }

    /// Names of the numeric columns.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The numeric properties of a sample, in the order of the columns; empty if there is
    /// no such sample.
    pub fn row(&self, sample: usize) -> &[f64] {
        let width = self.columns.len();
        self.rows
            .get(sample * width..(sample + 1) * width)
            .unwrap_or_default()
    }

    /// The string properties of the samples, by the name of the list.
    pub fn words(&self, list: &str) -> Option<Vec<String>> {
        words(self.attributes.get("samples")?.get(list))
    }

    /// Occupied voxels of a sample; zero if there is no such sample.
    pub fn voxels(&self, sample: usize) -> usize {
        match self.range(sample) {
            Some(range) => (range.end - range.start) as usize,
            None => 0,
        }
    }

    fn range(&self, sample: usize) -> Option<Range<u64>> {
        Some(*self.offsets.get(sample)?..*self.offsets.get(sample + 1)?)
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
        let from = self.offsets.partition_point(|offset| *offset <= begin);
        let from = from.saturating_sub(1);
        let to = self.offsets.partition_point(|offset| *offset < end);
        let to = to.saturating_sub(1).min(self.len()).max(from + 1);
        let cause = format!(
            "{cause}, met at sample {}; it holds {} samples, {} to {}",
            self.name(sample),
            to - from,
            self.name(from),
            self.name(to - 1)
        );
        IoError::parse(&stored.file(&self.path, file), 0, cause, MAKE_AGAIN)
    }

    /// The name of a sample for messages: its number if the set names none.
    fn name(&self, sample: usize) -> String {
        match self.names.get(sample) {
            Some(name) => name.clone(),
            None => sample.to_string(),
        }
    }
}

/// The values of a channel in single precision; all must be present and finite.
fn read_channel(stored: &Stored, range: Range<u64>) -> std::result::Result<Vec<f32>, String> {
    let halves: Vec<f16> = stored.read(range)?;
    let singles = halves.to_f32_vec();
    if singles.iter().all(|value| value.is_finite()) {
        Ok(singles)
    } else {
        Err("values are missing or not finite".into())
    }
}

/// The group's folder as a store, and its attributes.
fn open_group(path: &Path) -> Result<(Arc<FilesystemStore>, Map<String, Value>)> {
    if !path.join("zarr.json").is_file() {
        let cause = "there is no zarr group here, or an unfinished one";
        return Err(not_a_set(path, cause));
    }
    let store = layout::store(path)?;
    match Group::open(store.clone(), "/") {
        Ok(group) => Ok((store, group.attributes().clone())),
        Err(cause) => Err(not_a_set(path, &cause.to_string())),
    }
}

fn not_a_set(path: &Path, cause: &str) -> IoError {
    let file = path.join("zarr.json").display().to_string();
    let remedy = "give a set that protomer voxelize has written";
    IoError::parse(&file, 0, cause, remedy)
}

/// The attributes of a group that describe the set.
struct Head<'a> {
    path: &'a Path,
    attributes: &'a Map<String, Value>,
}

impl Head<'_> {
    fn number(&self, key: &str) -> Option<u64> {
        self.attributes.get(key)?.as_u64()
    }

    fn check_version(&self) -> Result<()> {
        match self.number("layout_version") {
            None => Err(not_a_set(self.path, "it is not a voxel set")),
            Some(version) if version > LAYOUT_VERSION => {
                let cause =
                    format!("layout {version} is newer than this program's, {LAYOUT_VERSION}");
                Err(not_a_set(self.path, &cause))
            }
            Some(_) => Ok(()),
        }
    }

    fn size(&self) -> Result<usize> {
        match self.number("size") {
            Some(size @ 1..=1024) => Ok(size as usize),
            _ => Err(not_a_set(
                self.path,
                "attribute 'size' is missing or absurd",
            )),
        }
    }

    fn list(&self, key: &str) -> Result<Vec<String>> {
        match words(self.attributes.get(key)) {
            Some(list) => Ok(list),
            None => Err(not_a_set(self.path, &format!("there is no list '{key}'"))),
        }
    }

    /// The array of a channel, with a value for each voxel of the set.
    fn channel(&self, store: &Arc<FilesystemStore>, name: &str, voxels: u64) -> Result<Stored> {
        let stored = Stored::open(self.path, store, name)?;
        if stored.length() == voxels {
            return Ok(stored);
        }
        let values = stored.length();
        let cause = format!("array {name} has {values} values, index {voxels}");
        Err(not_a_set(self.path, &cause))
    }
}

/// Where each sample begins, and where the last one ends.
fn read_offsets(path: &Path, store: &Arc<FilesystemStore>, voxels: u64) -> Result<Vec<u64>> {
    let stored = Stored::open(path, store, OFFSETS)?;
    let bad = |cause: &str| Err(IoError::parse(&stored.file(path, 0), 0, cause, MAKE_AGAIN));
    let offsets: Vec<i64> = match stored.read(0..stored.length()) {
        Ok(offsets) => offsets,
        Err(cause) => return bad(&cause),
    };
    let is_whole = offsets.first() == Some(&0)
        && offsets.last().copied() == i64::try_from(voxels).ok()
        && offsets.is_sorted();
    if !is_whole {
        return bad("the offsets do not ascend from zero to the number of voxels");
    }
    Ok(offsets.into_iter().map(|offset| offset as u64).collect())
}

/// Columns and rows of the table of properties.
fn table(path: &Path, stored: &Stored, samples: usize) -> Result<(Vec<String>, Vec<f64>)> {
    let file = path.join(PROPERTIES).display().to_string();
    let bad = |cause: &str| Err(IoError::parse(&file, 0, cause, MAKE_AGAIN));
    let Some(columns) = words(stored.attributes().get("columns")) else {
        return bad("there is no list 'columns'");
    };
    let rows = match stored.read_table() {
        Ok(rows) => rows,
        Err(cause) => return bad(&cause),
    };
    if rows.len() != samples * columns.len() {
        let (numbers, width) = (rows.len(), columns.len());
        return bad(&format!(
            "{numbers} numbers for {samples} samples of {width} columns"
        ));
    }
    Ok((columns, rows))
}

/// A list of words.
fn words(value: Option<&Value>) -> Option<Vec<String>> {
    let mut words = Vec::new();
    for word in value?.as_array()? {
        words.push(word.as_str()?.to_owned());
    }
    Some(words)
}
