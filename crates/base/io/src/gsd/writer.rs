//! Appending frames to a GSD file.

use super::format::{Chunk, ENTRY_BYTES, HEADER_BYTES, Header, IndexEntry, NAME_SEGMENT_BYTES};
use crate::{IoError, Result};
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

const FIRST_INDEX_ENTRIES: u64 = 128;
const FIRST_NAME_SEGMENTS: u64 = 16;

/// Appends frames to a GSD file.
///
/// A frame's data are written first, its index entries second: a process that dies in between
/// leaves a file that ends with its last complete frame. A full index moves to the end of the
/// file at twice the size, and so does a full name list.
///
/// ```
/// use protomer_io::gsd::{Chunk, ChunkData, GsdWriter};
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("one.gsd");
/// let mut writer = GsdWriter::create(&path, "an example", "own", (1, 0))?;
/// for step in 0..3 {
///     let data = ChunkData::U64(vec![step]);
///     writer.append_frame(&[Chunk { name: "step".into(), columns: 1, data }])?;
/// }
/// assert_eq!(writer.frames(), 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct GsdWriter {
    path: PathBuf,
    file: File,
    header: Header,
    /// Bytes in the file.
    length: u64,
    entries: Vec<IndexEntry>,
    names: Vec<String>,
    name_ids: HashMap<String, u16>,
    frames: u64,
}

impl GsdWriter {
    /// Creates a file without frames, replacing an existing one.
    ///
    /// # Errors
    /// [`IoError::File`] if the system call fails.
    pub fn create(
        path: &Path,
        application: &str,
        schema: &str,
        schema_version: (u16, u16),
    ) -> Result<Self> {
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(true);
        let file = options.open(path).map_err(IoError::file(path, "create"))?;
        let names_location = HEADER_BYTES + FIRST_INDEX_ENTRIES * ENTRY_BYTES;
        let header = Header {
            index_location: HEADER_BYTES,
            index_entries: FIRST_INDEX_ENTRIES,
            names_location,
            names_segments: FIRST_NAME_SEGMENTS,
            schema_version: u32::from(schema_version.0) << 16 | u32::from(schema_version.1),
            application: application.to_owned(),
            schema: schema.to_owned(),
        };
        let mut writer = Self {
            path: path.to_owned(),
            file,
            header,
            length: names_location + FIRST_NAME_SEGMENTS * NAME_SEGMENT_BYTES,
            entries: Vec::new(),
            names: Vec::new(),
            name_ids: HashMap::new(),
            frames: 0,
        };
        let mut start = writer.header.to_bytes().to_vec();
        start.resize(writer.length as usize, 0);
        writer.write_at(0, &start)?;
        Ok(writer)
    }

    /// The frames written.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Appends a frame of these chunks.
    ///
    /// ```
    /// use protomer_io::gsd::{Chunk, ChunkData, GsdWriter};
    /// # let folder = tempfile::tempdir()?;
    /// let mut writer = GsdWriter::create(&folder.path().join("one.gsd"), "an example", "own", (1, 0))?;
    /// let step = Chunk::new("step", 1, ChunkData::U64(vec![0]));
    /// assert!(writer.append_frame(&[step.clone(), step.clone()]).is_err(), "a name is given twice");
    /// writer.append_frame(&[step])?;
    /// assert_eq!(writer.frames(), 1, "what was refused left nothing behind");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`IoError::File`] if the system call fails (disk full): the file then still ends with the
    /// frame before. [`IoError::Unwritable`] for a chunk whose values do not fill its columns, a
    /// name given twice, or an empty frame.
    pub fn append_frame(&mut self, chunks: &[Chunk]) -> Result<()> {
        // Before anything is written: a frame that is refused leaves the file as it is.
        check_chunks(chunks)?;
        // Names first: an entry must not refer to one that is not in the file.
        self.register_names(chunks)?;
        let mut data = Vec::new();
        let mut entries = Vec::with_capacity(chunks.len());
        for chunk in chunks {
            entries.push(IndexEntry {
                frame: self.frames,
                rows: chunk.data.len() as u64 / u64::from(chunk.columns),
                location: self.length + data.len() as u64,
                columns: chunk.columns,
                name: self.name_ids.get(&chunk.name).copied().unwrap_or_default(),
                code: chunk.data.code(),
            });
            data.extend_from_slice(&chunk.data.to_bytes());
        }
        // The specification wants the entries of a frame sorted by name.
        entries.sort_by_key(|entry| entry.name);
        // Data before the index: a process that dies in between leaves bytes that no entry names.
        self.write_at(self.length, &data)?;
        self.length += data.len() as u64;
        self.append_entries(&entries)?;
        self.frames += 1;
        Ok(())
    }

    /// Returns when everything written is on disk.
    ///
    /// # Errors
    /// [`IoError::File`] if the system call fails.
    pub fn sync(&mut self) -> Result<()> {
        self.file
            .sync_all()
            .map_err(IoError::file(&self.path, "write"))
    }

    /// Renames the file, replacing an existing file of this name.
    pub(super) fn rename(&mut self, path: &Path) -> Result<()> {
        std::fs::rename(&self.path, path).map_err(IoError::file(path, "write"))?;
        self.path = path.to_owned();
        Ok(())
    }

    fn append_entries(&mut self, entries: &[IndexEntry]) -> Result<()> {
        let total = (self.entries.len() + entries.len()) as u64;
        // One entry stays zero, to terminate the list.
        if total >= self.header.index_entries {
            // Twice the room: the index is moved log₂ n times, so appending stays linear.
            self.move_index((total + 1).next_power_of_two() * 2)?;
        }
        let end = self.header.index_location + self.entries.len() as u64 * ENTRY_BYTES;
        self.write_at(end, &bytes_of(entries))?;
        self.entries.extend_from_slice(entries);
        Ok(())
    }

    fn move_index(&mut self, capacity: u64) -> Result<()> {
        let mut block = bytes_of(&self.entries);
        // Zeros mark the end of the list.
        block.resize((capacity * ENTRY_BYTES) as usize, 0);
        // The new block is there before the header points to it; the old one stays as waste.
        self.write_at(self.length, &block)?;
        self.header.index_location = self.length;
        self.header.index_entries = capacity;
        self.length += block.len() as u64;
        self.write_header()
    }

    /// Adds new names to the name list; if that fails, they remain unknown.
    fn register_names(&mut self, chunks: &[Chunk]) -> Result<()> {
        let count = self.names.len();
        let result = self.write_new_names(chunks);
        if result.is_err() {
            // Only in memory: a list on disk that is longer does no harm.
            self.names.truncate(count);
            self.name_ids.retain(|_, id| usize::from(*id) < count);
        }
        result
    }

    fn write_new_names(&mut self, chunks: &[Chunk]) -> Result<()> {
        let count = self.names.len();
        for chunk in chunks {
            if !self.name_ids.contains_key(&chunk.name) {
                let Ok(id) = u16::try_from(self.names.len()) else {
                    let cause = "there are more than 65 536 chunk names";
                    return Err(IoError::unwritable(cause, "use fewer"));
                };
                self.name_ids.insert(chunk.name.clone(), id);
                self.names.push(chunk.name.clone());
            }
        }
        if self.names.len() == count {
            return Ok(());
        }
        let mut list = Vec::new();
        for name in &self.names {
            list.extend_from_slice(name.as_bytes());
            list.push(0);
        }
        // One more byte: an empty name ends the list.
        let needed = (list.len() as u64 + 1).div_ceil(NAME_SEGMENT_BYTES);
        if needed <= self.header.names_segments {
            return self.write_at(self.header.names_location, &list);
        }
        self.move_names(needed.next_power_of_two(), list)
    }

    fn move_names(&mut self, segments: u64, mut list: Vec<u8>) -> Result<()> {
        self.header.names_segments = segments;
        list.resize((segments * NAME_SEGMENT_BYTES) as usize, 0);
        self.write_at(self.length, &list)?;
        self.header.names_location = self.length;
        self.length += list.len() as u64;
        self.write_header()
    }

    fn write_header(&mut self) -> Result<()> {
        let bytes = self.header.to_bytes();
        self.write_at(0, &bytes)
    }

    fn write_at(&mut self, location: u64, bytes: &[u8]) -> Result<()> {
        self.file
            .seek(SeekFrom::Start(location))
            .and_then(|_| self.file.write_all(bytes))
            .map_err(IoError::file(&self.path, "write"))
    }
}

fn bytes_of(entries: &[IndexEntry]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(entries.len() * ENTRY_BYTES as usize);
    for entry in entries {
        bytes.extend_from_slice(&entry.to_bytes());
    }
    bytes
}

fn check_chunks(chunks: &[Chunk]) -> Result<()> {
    if chunks.is_empty() {
        let remedy = "give it at least its step";
        return Err(IoError::unwritable("a frame has no chunks", remedy));
    }
    for (index, chunk) in chunks.iter().enumerate() {
        let (name, values) = (&chunk.name, chunk.data.len());
        let is_repeated = chunks[..index].iter().any(|other| other.name == *name);
        let (cause, remedy) =
            if chunk.columns == 0 || !values.is_multiple_of(chunk.columns as usize) {
                let columns = chunk.columns;
                let cause = format!("chunk {name:?} has {values} values in {columns} columns");
                (cause, "give whole rows")
            } else if name.is_empty() || name.contains('\0') {
                (format!("a chunk has the name {name:?}"), "give it a name")
            } else if is_repeated {
                (format!("chunk {name:?} is given twice"), "give it once")
            } else {
                continue;
            };
        return Err(IoError::unwritable(cause, remedy));
    }
    Ok(())
}
