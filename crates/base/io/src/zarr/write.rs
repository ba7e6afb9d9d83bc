//! Writes samples one after another.

use super::group;
use super::layout::{
    self, INDEX, Kind, LAYOUT_VERSION, NO_INDEX, OFFSETS, PROPERTIES, in_order, succeeded,
};
use super::table::TableWriter;
use crate::{IoError, Result};
use half::f16;
use serde::Serialize;
use serde_json::Map;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zarrs::array::{Array, Element};
use zarrs::filesystem::FilesystemStore;

/// Content of a set, as far as it is known before the first sample.
///
/// ```
/// use protomer_io::zarr::{SetPlan, SetWriter};
/// # let folder = tempfile::tempdir()?;
/// let plan = SetPlan {
///     size: 16,
///     channels: vec!["shape".to_owned()],
///     implied: vec!["shape".to_owned()],
///     columns: Vec::new(),
///     samples: 1,
///     voxels: 2,
/// };
/// let writer = SetWriter::create(&folder.path().join("set.zarr"), plan)?;
/// assert!(writer.finish(&serde_json::json!({})).is_err(), "the sample it promises is missing");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SetPlan {
    /// Voxels along each edge.
    pub size: usize,
    /// Channels in order.
    pub channels: Vec<String>,
    /// Channels that are 1 in every occupied voxel and so need no array.
    pub implied: Vec<String>,
    /// Names of the columns of the table of properties.
    pub columns: Vec<String>,
    /// Number of samples.
    pub samples: u64,
    /// Occupied voxels in all samples together.
    pub voxels: u64,
}

/// Writes a set. The group's own metadata come last: a folder without them is not a set.
///
/// ```
/// use protomer_io::zarr::{SetPlan, SetReader, SetWriter};
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("set.zarr");
/// // Two samples of three and two voxels; the shape is 1 in each and needs no array.
/// let plan = SetPlan {
///     size: 16,
///     channels: vec!["shape".to_owned(), "potential".to_owned()],
///     implied: vec!["shape".to_owned()],
///     columns: vec!["charge_e".to_owned()],
///     samples: 2,
///     voxels: 5,
/// };
/// let mut writer = SetWriter::create(&path, plan)?;
/// writer.push(&[7, 8, 300], &[&[0.5, -1.0, 0.25]], &[6.0])?;
/// writer.push(&[0, 9], &[&[2.0, 4.0]], &[-2.0])?;
/// writer.finish(&serde_json::Map::new())?;
/// let set = SetReader::open(&path)?;
/// assert_eq!((set.len(), set.row(1)), (2, &[-2.0][..]));
/// assert_eq!(set.sample(1)?.values, [[1.0, 1.0], [2.0, 4.0]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct SetWriter {
    path: PathBuf,
    store: Arc<FilesystemStore>,
    plan: SetPlan,
    offsets: Vec<i64>,
    index: Filling<u32>,
    stored: Vec<Filling<f16>>,
    table: TableWriter,
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
            waiting: Vec::with_capacity(per_file as usize),
            per_file: per_file as usize,
            files: 0,
            fill,
        })
    }

    fn push(&mut self, values: impl Iterator<Item = T>) -> Result<()> {
        for value in values {
            self.waiting.push(value);
            if self.waiting.len() == self.per_file {
                self.store()?;
            }
        }
        Ok(())
    }

    /// Stores the waiting elements as a file; their memory is for those of the next.
    fn store(&mut self) -> Result<()> {
        let values = self.waiting.as_slice();
        let stored = self
            .array
            .store_chunk_opt(&[self.files], values, &in_order());
        self.files += 1;
        self.waiting.clear();
        succeeded(&self.name, stored)
    }

    /// Stores the last file, padded.
    fn finish(mut self) -> Result<()> {
        if !self.waiting.is_empty() {
            self.waiting.resize(self.per_file, self.fill);
            self.store()?;
        }
        succeeded(&self.name, self.array.store_metadata())
    }
}

/// The stored form of a value: rounded to half precision, infinite beyond ± 65504.
///
/// ```
/// use protomer_io::zarr::as_stored;
/// assert_eq!(as_stored(0.25), 0.25);
/// assert!(as_stored(1e6).is_infinite());
/// ```
pub fn as_stored(value: f32) -> f32 {
    of_stored_bits(stored_bits(value))
}

/// The 16 bits of the stored form of a value.
///
/// ```
/// use protomer_io::zarr::{of_stored_bits, stored_bits};
/// assert_eq!(of_stored_bits(stored_bits(0.25)), 0.25);
/// ```
pub fn stored_bits(value: f32) -> u16 {
    f16::from_f32(value).to_bits()
}

/// The value with this stored form.
///
/// ```
/// use protomer_io::zarr::of_stored_bits;
/// assert_eq!(of_stored_bits(0x3c00), 1.0);
/// assert_eq!(of_stored_bits(0xbc00), -1.0, "the first bit is the sign");
/// ```
pub fn of_stored_bits(bits: u16) -> f32 {
    f16::from_bits(bits).to_f32()
}

impl SetWriter {
    /// Starts a set in a new or empty folder.
    ///
    /// # Errors
    /// [`IoError::Unwritable`] for names that a channel cannot have, and if the folder cannot be
    /// written.
    pub fn create(path: &Path, plan: SetPlan) -> Result<Self> {
        check_names(&plan.channels, &plan.implied)?;
        std::fs::create_dir_all(path).map_err(IoError::file(path, "make the folder"))?;
        let store = layout::store(path)?;
        let voxels = plan.voxels;
        let index = Filling::new(&store, INDEX, Kind::Index, NO_INDEX, voxels)?;
        let mut stored = Vec::new();
        // An implied channel is 1 at every occupied voxel and has no array.
        for name in &plan.channels {
            if !plan.implied.contains(name) {
                stored.push(Filling::new(&store, name, Kind::Channel, f16::NAN, voxels)?);
            }
        }
        let mut offsets = Vec::with_capacity(1 + plan.samples as usize);
        offsets.push(0);
        Ok(Self {
            path: path.to_owned(),
            table: TableWriter::new(&store, &plan.columns, plan.samples)?,
            store,
            plan,
            offsets,
            index,
            stored,
        })
    }

    /// Adds a sample: its occupied voxels, ascending, for each channel that is not implied the
    /// values there, and its row of the table. Values are kept in half precision: three digits, up
    /// to ± 65504.
    ///
    /// # Errors
    /// [`IoError::Unwritable`] for indices that do not ascend inside the grid, lengths that
    /// disagree, values that half precision cannot hold, and a file that cannot be written.
    pub fn push(&mut self, index: &[u32], values: &[&[f32]], row: &[f64]) -> Result<()> {
        // All checks before the first array grows: arrays and table must stay in step.
        if !layout::ascends_within(index, self.plan.size) {
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
            // Half precision ends at 65504; infinity would be read as damage.
            if let Some(value) = values.iter().find(|value| !as_stored(**value).is_finite()) {
                let name = &channel.name;
                let cause = format!("channel {name} holds {value}, more than half precision can");
                return Err(self.bad_sample(&cause));
            }
        }
        self.table.push(row)?;
        for (channel, values) in self.stored.iter_mut().zip(values) {
            channel.push(values.iter().copied().map(f16::from_f32))?;
        }
        self.index.push(index.iter().copied())?;
        // The end of this sample is the start of the next, so n samples have n + 1 offsets.
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

    /// Completes the set with further attributes, which are serialised straight into their file.
    /// Among them should be `samples`, words for each sample: an object of lists, of which `name` is
    /// used in messages.
    ///
    /// # Errors
    /// [`IoError::Unwritable`] if fewer samples or voxels were pushed than promised, and
    /// [`IoError::File`] if the attributes cannot be serialised or written.
    pub fn finish(self, attributes: &impl Serialize) -> Result<()> {
        self.check_finish()?;
        self.index.finish()?;
        for channel in self.stored {
            channel.finish()?;
        }
        // Only now is their number known for certain; they are small beside the voxels.
        let count = self.offsets.len() as u64;
        let mut offsets = Filling::new(&self.store, OFFSETS, Kind::Offsets, -1_i64, count)?;
        offsets.push(self.offsets.into_iter())?;
        offsets.finish()?;
        self.table.finish()?;
        let all = Attributes {
            layout_version: LAYOUT_VERSION,
            size: self.plan.size,
            channels: &self.plan.channels,
            implied_channels: &self.plan.implied,
            further: attributes,
        };
        // Last: a folder without it is an unfinished set, which every reader refuses.
        group::write(&self.path, &all)
    }

    fn check_finish(&self) -> Result<()> {
        let pushed = [self.table.rows(), self.voxels() as u64];
        let promised = [self.plan.samples, self.plan.voxels];
        for (items, (pushed, promised)) in ["samples", "voxels"]
            .iter()
            .zip(pushed.iter().zip(promised))
        {
            if *pushed != promised {
                let cause = format!("{pushed} {items} were pushed, {promised} were promised");
                return Err(IoError::unwritable(cause, "count them before"));
            }
        }
        Ok(())
    }
}

/// The attributes of the group.
#[derive(Serialize)]
struct Attributes<'a, A> {
    layout_version: u64,
    size: usize,
    channels: &'a [String],
    implied_channels: &'a [String],
    #[serde(flatten)]
    further: &'a A,
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

/// Whether a channel can have this name: it names an array and, in an ablation, folders.
pub(super) fn is_identifier(name: &str) -> bool {
    let is_allowed = |c: char| c.is_ascii_alphanumeric() || c == '_';
    !name.is_empty() && name.chars().all(is_allowed)
}
