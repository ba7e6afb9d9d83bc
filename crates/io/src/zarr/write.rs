//! Samples in, one after the other.

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

/// Writes a set. The group's own metadata come last: a folder without them is no set.
pub struct SetWriter {
    store: Arc<FilesystemStore>,
    size: usize,
    channels: Vec<String>,
    implied: Vec<String>,
    offsets: Vec<i64>,
    index: Filling<u32>,
    stored: Vec<Filling<f16>>,
}

/// An array and what waits until a file of it is full.
struct Filling<T: Element + Copy> {
    array: Array<FilesystemStore>,
    name: String,
    waiting: Vec<T>,
    per_file: usize,
    files: u64,
    fill: T,
}

impl<T: Element + Copy> Filling<T> {
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
        self.array
            .store_chunk_opt(&[self.files], values, &in_order())
            .map_err(|cause| failed(&self.name, &cause.to_string()))?;
        self.files += 1;
        Ok(())
    }

    /// The last file, filled up.
    fn finish(mut self) -> Result<()> {
        if !self.waiting.is_empty() {
            let mut last = std::mem::take(&mut self.waiting);
            last.resize(self.per_file, self.fill);
            self.store(last)?;
        }
        self.array
            .store_metadata()
            .map_err(|cause| failed(&self.name, &cause.to_string()))
    }
}

/// Chunks one after the other: several threads would lay them into a file in the order in which
/// they get done.
fn in_order() -> CodecOptions {
    CodecOptions::default().with_concurrent_target(1)
}

fn failed(array: &str, cause: &str) -> IoError {
    IoError::unwritable(
        format!("array {array}: {cause}"),
        "make sure that the disk has room and may be written to",
    )
}

/// The value that a set keeps for this one: rounded to half precision, infinite beyond ± 65504.
pub fn as_stored(value: f32) -> f32 {
    f16::from_f32(value).to_f32()
}

impl SetWriter {
    /// Begins a set in a folder that is new or empty, for grids of `size`³ voxels with `voxels`
    /// occupied ones in all samples together. `implied` are those of the channels that are 1 in
    /// every occupied voxel and so need no array.
    ///
    /// # Errors
    /// [`IoError::Unwritable`] for names that are no channel names, and if the folder cannot be
    /// written.
    pub fn create(
        path: &Path,
        size: usize,
        channels: &[String],
        implied: &[String],
        voxels: u64,
    ) -> Result<Self> {
        let is_name = |name: &String| {
            !name.is_empty() && name.bytes().all(|c| c.is_ascii_alphanumeric() || c == b'_')
        };
        let taken = [INDEX, OFFSETS, PROPERTIES];
        if let Some(name) = channels
            .iter()
            .find(|name| !is_name(name) || taken.contains(&name.as_str()))
        {
            let cause = format!("'{name}' is no name for a channel");
            return Err(IoError::unwritable(
                cause,
                "use letters, digits and _, and none of the arrays' names",
            ));
        }
        if let Some(name) = implied.iter().find(|name| !channels.contains(name)) {
            return Err(IoError::unwritable(
                format!("'{name}' is implied but no channel"),
                "name it among the channels",
            ));
        }
        std::fs::create_dir_all(path).map_err(IoError::at(path, "make the folder"))?;
        let store = layout::store(path)?;
        let per_file = layout::elements_per_file(voxels);
        let array = |name: &str, kind| {
            layout::array(&store, name, kind, &[voxels], &[per_file], Map::new())
        };
        let per_file = per_file as usize;
        let index = Filling {
            array: array(INDEX, Kind::Index)?,
            name: INDEX.into(),
            waiting: Vec::new(),
            per_file,
            files: 0,
            fill: NO_INDEX,
        };
        let stored = channels
            .iter()
            .filter(|name| !implied.contains(name))
            .map(|name| {
                let array = array(name, Kind::Channel)?;
                Ok(Filling {
                    array,
                    name: name.clone(),
                    waiting: Vec::new(),
                    per_file,
                    files: 0,
                    fill: f16::NAN,
                })
            });
        let stored = stored.collect::<Result<Vec<_>>>()?;
        let (channels, implied) = (channels.to_vec(), implied.to_vec());
        Ok(Self {
            store,
            size,
            channels,
            implied,
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
    /// disagree, values that half precision cannot hold, and a disk that takes no more.
    pub fn push(&mut self, index: &[u32], values: &[&[f32]]) -> Result<()> {
        let sample = self.offsets.len() - 1;
        let bad = |cause: String| {
            IoError::unwritable(
                format!("sample {sample}: {cause}"),
                "give what the layout says",
            )
        };
        let voxels = self.size.pow(3);
        if index.windows(2).any(|pair| pair[0] >= pair[1])
            || index.last().is_some_and(|last| *last as usize >= voxels)
        {
            return Err(bad("voxel numbers do not ascend inside the grid".into()));
        }
        if values.len() != self.stored.len()
            || values.iter().any(|values| values.len() != index.len())
        {
            let lengths: Vec<usize> = values.iter().map(|values| values.len()).collect();
            let cause = format!(
                "{lengths:?} values for {} voxels, {} channels",
                index.len(),
                self.stored.len()
            );
            return Err(bad(cause));
        }
        for (channel, values) in self.stored.iter_mut().zip(values) {
            if let Some(value) = values.iter().find(|value| !as_stored(**value).is_finite()) {
                return Err(bad(format!(
                    "channel {} holds {value}, more than half precision can",
                    channel.name
                )));
            }
            channel.push(values.iter().map(|value| f16::from_f32(*value)))?;
        }
        self.index.push(index.iter().copied())?;
        let end = self.offsets.last().copied().unwrap_or(0) + index.len() as i64;
        self.offsets.push(end);
        Ok(())
    }

    /// Ends the set with a table of numbers known of each sample (rows in the order of the samples)
    /// and further attributes; among them should be `samples`, words known of each sample: an
    /// object of lists, of which `name` serves messages.
    ///
    /// # Errors
    /// [`IoError::Unwritable`] if the table has not the right shape or fewer voxels came than were
    /// promised.
    pub fn finish(
        self,
        columns: &[String],
        rows: &[f64],
        attributes: Map<String, Value>,
    ) -> Result<()> {
        let samples = self.offsets.len() - 1;
        if rows.len() != samples * columns.len() {
            let cause = format!(
                "{} numbers for {samples} samples of {} columns",
                rows.len(),
                columns.len()
            );
            return Err(IoError::unwritable(cause, "give one row per sample"));
        }
        let promised = self.index.array.shape().first().copied().unwrap_or(0);
        let came = self.offsets.last().copied().unwrap_or(0);
        if promised != came as u64 {
            let cause = format!("{came} voxels came, {promised} were promised");
            return Err(IoError::unwritable(cause, "count them before"));
        }
        self.index.finish()?;
        for channel in self.stored {
            channel.finish()?;
        }
        let count = self.offsets.len() as u64;
        let per_file = layout::elements_per_file(count);
        let mut offsets = Filling {
            array: layout::array(
                &self.store,
                OFFSETS,
                Kind::Offsets,
                &[count],
                &[per_file],
                Map::new(),
            )?,
            name: OFFSETS.into(),
            waiting: Vec::new(),
            per_file: per_file as usize,
            files: 0,
            fill: -1_i64,
        };
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
        let group = GroupBuilder::new()
            .attributes(all)
            .build(self.store.clone(), "/");
        let group = group.map_err(|cause| failed("group", &cause.to_string()))?;
        group
            .store_metadata()
            .map_err(|cause| failed("group", &cause.to_string()))
    }
}

fn write_table(
    store: &Arc<FilesystemStore>,
    columns: &[String],
    rows: &[f64],
    samples: u64,
) -> Result<()> {
    let width = columns.len().max(1);
    let per_file = samples.clamp(1, ROWS_PER_FILE);
    let attributes = Map::from_iter([("columns".to_owned(), json!(columns))]);
    let shape = [samples, width as u64];
    let array = layout::array(
        store,
        PROPERTIES,
        Kind::Properties,
        &shape,
        &[per_file, width as u64],
        attributes,
    )?;
    for (file, part) in rows.chunks(per_file as usize * width).enumerate() {
        let mut part = part.to_vec();
        part.resize(per_file as usize * width, f64::NAN);
        array
            .store_chunk_opt(&[file as u64, 0], part, &in_order())
            .map_err(|cause| failed(PROPERTIES, &cause.to_string()))?;
    }
    array
        .store_metadata()
        .map_err(|cause| failed(PROPERTIES, &cause.to_string()))
}
