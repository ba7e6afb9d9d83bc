//! Writes samples one after another.

use super::layout::{self, INDEX, Kind, LAYOUT_VERSION, NO_INDEX, OFFSETS, PROPERTIES};
use crate::{IoError, Result};
use half::f16;
use serde_json::{Map, Value, json};
use std::path::Path;
use std::sync::Arc;
use zarrs::array::{Array, CodecOptions, Element};
use zarrs::filesystem::FilesystemStore;
use zarrs::group::GroupBuilder;

/// Rows of the table of properties in one file.
const ROWS_PER_FILE: u64 = 1 << 16;

/// Writes a set. The group's own metadata come last: a folder without them is not a set.
///
/// ```
/// use protomer_io::zarr::{SetReader, SetWriter};
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("set.zarr");
/// let channels = ["shape".to_owned(), "potential".to_owned()];
/// // Two samples of three and two voxels; the shape is 1 in each and needs no array.
/// let mut writer = SetWriter::create(&path, 16, &channels, &channels[..1], 5)?;
/// writer.push(&[7, 8, 300], &[&[0.5, -1.0, 0.25]])?;
/// writer.push(&[0, 9], &[&[2.0, 4.0]])?;
/// writer.finish(&["charge_e".to_owned()], &[6.0, -2.0], serde_json::Map::new())?;
/// let set = SetReader::open(&path)?;
/// assert_eq!((set.len(), set.row(1)), (2, &[-2.0][..]));
/// assert_eq!(set.sample(1)?.values, [[1.0, 1.0], [2.0, 4.0]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct SetWriter {
    store: Arc<FilesystemStore>,
    size: usize,
    channels: Vec<String>,
    implied: Vec<String>,
    offsets: Vec<i64>,
    index: Filling<u32>,
    stored: Vec<Filling<f16>>,
}

/// An array, and the elements waiting for a full file.
struct Filling<T: Element + Copy> {
    array: Array<FilesystemStore>,
    name: String,
    waiting: Vec<T>,
    per_file: usize,
    files: u64,
    fill: T,
}

impl<T: Element + Copy> Filling<T> {
    /// A one-dimensional array with `elements` elements.
    fn new(
        store: &Arc<FilesystemStore>,
        name: &str,
        kind: Kind,
        fill: T,
        elements: u64,
    ) -> Result<Self> {
        let per_file = layout::elements_per_file(elements);
        Ok(Self {
            array: layout::array(store, name, kind, &[elements], &[per_file], Map::new())?,
            name: name.to_owned(),
            waiting: Vec::new(),
            per_file: per_file as usize,
            files: 0,
            fill,
        })
    }

    fn push(&mut self, values: impl Iterator<Item = T>) -> Result<()> {
        self.waiting.extend(values);
        while self.waiting.len() >= self.per_file {
            let rest = self.waiting.split_off(self.per_file);
            let full = std::mem::replace(&mut self.waiting, rest);
            self.store(full)?;
        }
        Ok(())
    }

    fn store(&mut self, values: Vec<T>) -> Result<()> {
        let stored = self
            .array
            .store_chunk_opt(&[self.files], values, &in_order());
        succeeded(&self.name, stored)?;
        self.files += 1;
        Ok(())
    }

    /// Stores the last file, padded.
    fn finish(mut self) -> Result<()> {
        if !self.waiting.is_empty() {
            let mut last = std::mem::take(&mut self.waiting);
            last.resize(self.per_file, self.fill);
            self.store(last)?;
        }
        succeeded(&self.name, self.array.store_metadata())
    }
}

/// Chunks are written sequentially: several threads would write them in the order in which
/// they finish.
fn in_order() -> CodecOptions {
    CodecOptions::default().with_concurrent_target(1)
}

/// Turns an error of a store into one that names the array.
fn succeeded<T, E: std::fmt::Display>(array: &str, result: std::result::Result<T, E>) -> Result<T> {
    result.map_err(|cause| {
        IoError::unwritable(
            format!("array {array}: {cause}"),
            "make sure that the disk has room and may be written to",
        )
    })
}

/// The stored form of a value: rounded to half precision, infinite beyond ± 65504.
///
/// ```
/// use protomer_io::zarr::as_stored;
/// assert_eq!(as_stored(0.25), 0.25);
/// assert!(as_stored(1e6).is_infinite());
/// ```
pub fn as_stored(value: f32) -> f32 {
    f16::from_f32(value).to_f32()
}

impl SetWriter {
    /// Starts a set in a new or empty folder, for grids of `size`³ voxels with `voxels`
    /// occupied ones in all samples together. `implied` are those of the channels that are 1 in
    /// every occupied voxel and so need no array.
    ///
    /// # Errors
    /// [`IoError::Unwritable`] for names that a channel cannot have, and if the folder cannot be
    /// written.
    pub fn create(
        path: &Path,
        size: usize,
        channels: &[String],
        implied: &[String],
        voxels: u64,
    ) -> Result<Self> {
        check_names(channels, implied)?;
        std::fs::create_dir_all(path).map_err(IoError::at(path, "make the folder"))?;
        let store = layout::store(path)?;
        let index = Filling::new(&store, INDEX, Kind::Index, NO_INDEX, voxels)?;
        let mut stored = Vec::new();
        for name in channels {
            if !implied.contains(name) {
                stored.push(Filling::new(&store, name, Kind::Channel, f16::NAN, voxels)?);
            }
        }
        Ok(Self {
            store,
            size,
            channels: channels.to_vec(),
            implied: implied.to_vec(),
            offsets: vec![0],
            index,
            stored,
        })
    }

    /// Adds a sample: its occupied voxels, ascending, and for each channel that is not implied the
    /// values there. Values are kept in half precision: three digits, up to ± 65504.
    ///
    /// # Errors
    /// [`IoError::Unwritable`] for indices that do not ascend inside the grid, lengths that
    /// disagree, values that half precision cannot hold, and a file that cannot be written.
    pub fn push(&mut self, index: &[u32], values: &[&[f32]]) -> Result<()> {
        if !layout::ascends_within(index, self.size) {
            let cause = "voxel numbers do not ascend inside the grid";
            return Err(self.bad_sample(cause));
        }
        let is_complete = values.iter().all(|values| values.len() == index.len());
        if values.len() != self.stored.len() || !is_complete {
            let lengths: Vec<usize> = values.iter().map(|values| values.len()).collect();
            let (voxels, channels) = (index.len(), self.stored.len());
            let cause = format!("{lengths:?} values for {voxels} voxels, {channels} channels");
            return Err(self.bad_sample(&cause));
        }
        for (channel, values) in self.stored.iter().zip(values) {
            if let Some(value) = values.iter().find(|value| !as_stored(**value).is_finite()) {
                let name = &channel.name;
                let cause = format!("channel {name} holds {value}, more than half precision can");
                return Err(self.bad_sample(&cause));
            }
        }
        for (channel, values) in self.stored.iter_mut().zip(values) {
            channel.push(values.iter().copied().map(f16::from_f32))?;
        }
        self.index.push(index.iter().copied())?;
        self.offsets.push(self.voxels() + index.len() as i64);
        Ok(())
    }

    /// Voxels of the samples so far.
    fn voxels(&self) -> i64 {
        self.offsets.last().copied().unwrap_or(0)
    }

    /// The error for the sample that comes next.
    fn bad_sample(&self, cause: &str) -> IoError {
        let sample = self.offsets.len() - 1;
        let remedy = "give a sample of the form that the layout describes";
        IoError::unwritable(format!("sample {sample}: {cause}"), remedy)
    }

    /// Completes the set with a table of numbers for each sample (rows in the order of the samples)
    /// and further attributes. Among them should be `samples`, words for each sample: an object of
    /// lists, of which `name` is used in messages.
    ///
    /// # Errors
    /// [`IoError::Unwritable`] if the table does not have the right shape or fewer voxels were
    /// pushed than promised.
    pub fn finish(
        self,
        columns: &[String],
        rows: &[f64],
        attributes: Map<String, Value>,
    ) -> Result<()> {
        let samples = self.offsets.len() - 1;
        self.check_finish(samples * columns.len(), rows.len())?;
        self.index.finish()?;
        for channel in self.stored {
            channel.finish()?;
        }
        let count = self.offsets.len() as u64;
        let mut offsets = Filling::new(&self.store, OFFSETS, Kind::Offsets, -1_i64, count)?;
        offsets.push(self.offsets.iter().copied())?;
        offsets.finish()?;
        write_table(&self.store, columns, rows, samples as u64)?;
        let mut all = Map::from_iter([
            ("layout_version".to_owned(), json!(LAYOUT_VERSION)),
            ("size".to_owned(), json!(self.size)),
            ("channels".to_owned(), json!(self.channels)),
            ("implied_channels".to_owned(), json!(self.implied)),
        ]);
        all.extend(attributes);
        let mut builder = GroupBuilder::new();
        let group = builder.attributes(all).build(self.store.clone(), "/");
        succeeded("group", succeeded("group", group)?.store_metadata())
    }

    fn check_finish(&self, expected: usize, numbers: usize) -> Result<()> {
        if numbers != expected {
            let cause = format!("{numbers} numbers for a table of {expected}");
            return Err(IoError::unwritable(cause, "give one row per sample"));
        }
        let promised = self.index.array.shape().first().copied().unwrap_or(0);
        let pushed = self.voxels();
        if promised != pushed as u64 {
            let cause = format!("{pushed} voxels were pushed, {promised} were promised");
            return Err(IoError::unwritable(cause, "count them before"));
        }
        Ok(())
    }
}

fn check_names(channels: &[String], implied: &[String]) -> Result<()> {
    const TAKEN: [&str; 3] = [INDEX, OFFSETS, PROPERTIES];
    for name in channels {
        if !is_identifier(name) || TAKEN.contains(&name.as_str()) {
            let cause = format!("a channel cannot be called '{name}'");
            let remedy = "use letters, digits and _, and none of the arrays' names";
            return Err(IoError::unwritable(cause, remedy));
        }
    }
    for name in implied {
        if !channels.contains(name) {
            let cause = format!("'{name}' is implied but not a channel");
            return Err(IoError::unwritable(cause, "name it among the channels"));
        }
    }
    Ok(())
}

fn is_identifier(name: &str) -> bool {
    let is_allowed = |c: char| c.is_ascii_alphanumeric() || c == '_';
    !name.is_empty() && name.chars().all(is_allowed)
}

fn write_table(
    store: &Arc<FilesystemStore>,
    columns: &[String],
    rows: &[f64],
    samples: u64,
) -> Result<()> {
    let width = columns.len().max(1);
    let per_file = samples.clamp(1, ROWS_PER_FILE);
    let array = layout::array(
        store,
        PROPERTIES,
        Kind::Properties,
        &[samples, width as u64],
        &[per_file, width as u64],
        Map::from_iter([("columns".to_owned(), json!(columns))]),
    )?;
    for (file, part) in rows.chunks(per_file as usize * width).enumerate() {
        let mut part = part.to_vec();
        part.resize(per_file as usize * width, f64::NAN);
        let stored = array.store_chunk_opt(&[file as u64, 0], part, &in_order());
        succeeded(PROPERTIES, stored)?;
    }
    succeeded(PROPERTIES, array.store_metadata())
}
