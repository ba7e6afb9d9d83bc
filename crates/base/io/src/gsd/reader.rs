//! Reading a GSD file frame by frame, without trusting any number in it.

use super::format::{
    Chunk, ChunkData, ENTRY_BYTES, HEADER_BYTES, Header, IndexEntry, NAME_SEGMENT_BYTES,
};
use crate::bytes::Cursor;
use crate::{IoError, Result};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Reads a GSD 2 file frame by frame.
///
/// ```
/// use protomer_io::gsd::{Chunk, ChunkData, GsdFile, GsdWriter};
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("one.gsd");
/// let step = Chunk { name: "step".into(), columns: 1, data: ChunkData::U64(vec![7]) };
/// GsdWriter::create(&path, "an example", "own", (1, 0))?.append_frame(&[step.clone()])?;
/// let mut file = GsdFile::open(&path)?;
/// assert_eq!(file.frames(), 1);
/// assert_eq!(file.chunk(0, "step")?, Some(step));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct GsdFile {
    path: PathBuf,
    file: File,
    header: Header,
    names: Vec<String>,
    entries: Vec<IndexEntry>,
}

const COMPLETE: &str = "give a complete GSD file of version 2";

impl GsdFile {
    /// Opens a file and reads its index. An index entry that points outside the file, as a process
    /// that died leaves it, ends the index.
    ///
    /// # Errors
    /// [`IoError::File`] if the system call fails, [`IoError::Parse`] if it is not a GSD 2 file.
    pub fn open(path: &Path) -> Result<Self> {
        let file = crate::input::open(path).map_err(IoError::file(path, "open"))?;
        let mut source = SizedFile {
            path,
            length: file.metadata().map_err(IoError::file(path, "read"))?.len(),
            file: &file,
        };
        let start = source.read(0, HEADER_BYTES)?;
        let header = match Header::read(&mut Cursor::new(&start)) {
            Ok(Ok(header)) => header,
            Ok(Err(cause)) => return Err(source.error(cause)),
            Err(_) => return Err(source.error("its header is truncated".into())),
        };
        // Saturating: whatever the header states, the read is refused beyond the file's length.
        let names_length = header.names_segments.saturating_mul(NAME_SEGMENT_BYTES);
        let names = source.read(header.names_location, names_length)?;
        let names = split_names(&names);
        let index_length = header.index_entries.saturating_mul(ENTRY_BYTES);
        let index = source.read(header.index_location, index_length)?;
        let entries = split_index(&index, names.len(), source.length);
        // Each frame has a chunk, the step at least: a larger number is damage.
        let (last, chunks) = (entries.last().map(|entry| entry.frame), entries.len());
        if let Some(last) = last.filter(|last| *last >= chunks as u64) {
            let cause =
                format!("its index is damaged: it names frame {last} and has {chunks} chunks");
            return Err(source.error(cause));
        }
        Ok(Self {
            path: path.to_owned(),
            file,
            header,
            names,
            entries,
        })
    }

    /// Name and version (major, minor) of the schema.
    ///
    /// ```
    /// use protomer_io::gsd::{FrameWriter, GsdFile};
    /// # let folder = tempfile::tempdir()?;
    /// let path = folder.path().join("trajectory.gsd");
    /// FrameWriter::open(&path, Vec::new(), 0)?.sync()?;
    /// let file = GsdFile::open(&path)?;
    /// assert_eq!((file.schema(), file.frames()), (("hoomd", (1, 4)), 0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn schema(&self) -> (&str, (u16, u16)) {
        let version = self.header.schema_version;
        (
            &self.header.schema,
            ((version >> 16) as u16, version as u16),
        )
    }

    /// The program that wrote the file.
    ///
    /// ```
    /// use protomer_io::gsd::{GsdFile, GsdWriter};
    /// # let folder = tempfile::tempdir()?;
    /// let path = folder.path().join("one.gsd");
    /// GsdWriter::create(&path, "an example", "own", (1, 0))?.sync()?;
    /// assert_eq!(GsdFile::open(&path)?.application(), "an example");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn application(&self) -> &str {
        &self.header.application
    }

    /// The number of frames.
    pub fn frames(&self) -> u64 {
        // A frame is complete when an entry names it; frames without chunks do not exist.
        self.entries.last().map_or(0, |entry| entry.frame + 1)
    }

    /// One chunk of a frame; `None` if the frame does not have it (in the HOOMD schema it is then
    /// as in frame 0).
    ///
    /// ```
    /// use protomer_io::gsd::{Chunk, ChunkData, GsdFile, GsdWriter};
    /// # let folder = tempfile::tempdir()?;
    /// let path = folder.path().join("one.gsd");
    /// let step = Chunk::new("step", 1, ChunkData::U64(vec![40]));
    /// GsdWriter::create(&path, "an example", "own", (1, 0))?.append_frame(&[step.clone()])?;
    /// let mut file = GsdFile::open(&path)?;
    /// assert_eq!((file.chunk(0, "step")?, file.chunk(0, "energy")?), (Some(step), None));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`IoError::File`] if the system call fails, [`IoError::Parse`] for a type of values that
    /// this program never writes.
    pub fn chunk(&mut self, frame: u64, name: &str) -> Result<Option<Chunk>> {
        let Some(id) = self.names.iter().position(|candidate| candidate == name) else {
            return Ok(None);
        };
        for entry in self.frame_entries(frame) {
            if usize::from(entry.name) == id {
                return self.read_entry(*entry).map(Some);
            }
        }
        Ok(None)
    }

    /// All chunks of a frame, in the order in which they were written.
    ///
    /// ```
    /// use protomer_io::gsd::{Chunk, ChunkData, GsdFile, GsdWriter};
    /// # let folder = tempfile::tempdir()?;
    /// let path = folder.path().join("one.gsd");
    /// let chunks = ["step", "energy"].map(|name| Chunk::new(name, 1, ChunkData::F64(vec![1.5])));
    /// GsdWriter::create(&path, "an example", "own", (1, 0))?.append_frame(&chunks)?;
    /// assert_eq!(GsdFile::open(&path)?.frame(0)?, chunks);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`GsdFile::chunk`].
    pub fn frame(&mut self, frame: u64) -> Result<Vec<Chunk>> {
        let mut entries = self.frame_entries(frame).to_vec();
        // The index is sorted by name within a frame; locations keep the order of writing.
        entries.sort_by_key(|entry| entry.location);
        let mut chunks = Vec::with_capacity(entries.len());
        for entry in entries {
            chunks.push(self.read_entry(entry)?);
        }
        Ok(chunks)
    }

    fn frame_entries(&self, frame: u64) -> &[IndexEntry] {
        // Entries ascend by frame, which `split_index` made sure of.
        let start = self.entries.partition_point(|entry| entry.frame < frame);
        let end = self.entries.partition_point(|entry| entry.frame <= frame);
        &self.entries[start..end]
    }

    fn read_entry(&self, entry: IndexEntry) -> Result<Chunk> {
        // Asked again: a file that is still being written has grown since it was opened.
        let metadata = self.file.metadata();
        let mut source = SizedFile {
            path: &self.path,
            length: metadata.map_err(IoError::file(&self.path, "read"))?.len(),
            file: &self.file,
        };
        let name = self.names.get(usize::from(entry.name));
        let name = name.cloned().unwrap_or_default();
        let bytes = source.read(entry.location, entry.length().unwrap_or(u64::MAX))?;
        match ChunkData::from_bytes(entry.code, &bytes) {
            Some(data) => Ok(Chunk {
                name,
                columns: entry.columns,
                data,
            }),
            None => {
                let file = self.path.display().to_string();
                let cause = format!("chunk {name:?} has values of type {}", entry.code);
                let remedy = "open it with the Python package gsd";
                Err(IoError::parse(&file, 0, cause, remedy))
            }
        }
    }
}

/// The names of a list of zero-terminated strings, up to the first empty one.
fn split_names(list: &[u8]) -> Vec<String> {
    let mut names = Vec::new();
    for name in list.split(|byte| *byte == 0) {
        if name.is_empty() {
            break;
        }
        names.push(String::from_utf8_lossy(name).into_owned());
    }
    names
}

/// The entries of an index, up to the first that is empty, out of order, without a name or outside
/// the file.
fn split_index(index: &[u8], names: usize, file_length: u64) -> Vec<IndexEntry> {
    let mut entries: Vec<IndexEntry> = Vec::new();
    let mut cursor = Cursor::new(index);
    let mut last_frame = 0;
    while let Ok(entry) = IndexEntry::read(&mut cursor) {
        let is_named = usize::from(entry.name) < names;
        let is_ordered = last_frame <= entry.frame;
        // Location 0 is the header, so it marks the end of the list.
        if entry.location == 0 || !is_named || !is_ordered || !entry.lies_within(file_length) {
            break;
        }
        last_frame = entry.frame;
        entries.push(entry);
    }
    entries
}

/// A file and its length, which no read may exceed.
struct SizedFile<'a> {
    path: &'a Path,
    file: &'a File,
    length: u64,
}

impl SizedFile<'_> {
    /// Bytes of the file; memory is never taken for more than the file has.
    fn read(&mut self, location: u64, count: u64) -> Result<Vec<u8>> {
        let end = location.checked_add(count);
        if end.is_none_or(|end| end > self.length) {
            let cause = format!("it is truncated: {count} bytes at {location} are missing");
            return Err(self.error(cause));
        }
        // Only now: the file has these bytes, so a wrong count cannot take all memory.
        let mut bytes = vec![0; count as usize];
        let mut read = || {
            self.file.seek(SeekFrom::Start(location))?;
            self.file.read_exact(&mut bytes)
        };
        read().map_err(IoError::file(self.path, "read"))?;
        Ok(bytes)
    }

    fn error(&self, cause: String) -> IoError {
        IoError::parse(&self.path.display().to_string(), 0, cause, COMPLETE)
    }
}
