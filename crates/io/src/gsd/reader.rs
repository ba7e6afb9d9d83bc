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
#[derive(Debug)]
pub struct GsdFile {
    path: PathBuf,
    file: File,
    header: Header,
    names: Vec<String>,
    entries: Vec<IndexEntry>,
}

impl GsdFile {
    /// Opens a file and reads its index. Index entries from the first that points outside the file
    /// on, as a process that died leaves them, are taken for the end.
    ///
    /// # Errors
    /// [`IoError::File`] if the system refuses, [`IoError::Parse`] if it is no GSD 2 file.
    pub fn open(path: &Path) -> Result<Self> {
        let mut file = File::open(path).map_err(IoError::at(path, "open"))?;
        let length = file.metadata().map_err(IoError::at(path, "read"))?.len();
        let bad = |cause: String| {
            IoError::parse(
                &path.display().to_string(),
                0,
                cause,
                "give a complete GSD file of version 2",
            )
        };
        let start = read_at(&mut file, path, length, 0, HEADER_BYTES)?;
        let header = Header::read(&mut Cursor::new(&start))
            .map_err(|_| bad("its header is cut".into()))?
            .map_err(bad)?;
        let names_length = header.names_segments.saturating_mul(NAME_SEGMENT_BYTES);
        let names = read_at(&mut file, path, length, header.names_location, names_length)?;
        let names: Vec<String> = names
            .split(|byte| *byte == 0)
            .take_while(|name| !name.is_empty())
            .map(|name| String::from_utf8_lossy(name).into_owned())
            .collect();
        let index_length = header.index_entries.saturating_mul(ENTRY_BYTES);
        let index = read_at(&mut file, path, length, header.index_location, index_length)?;
        let mut entries: Vec<IndexEntry> = Vec::new();
        let mut cursor = Cursor::new(&index);
        while let Ok(entry) = IndexEntry::read(&mut cursor) {
            let end = entry
                .length()
                .and_then(|bytes| bytes.checked_add(entry.location));
            let ordered = entries.last().is_none_or(|last| last.frame <= entry.frame);
            let named = usize::from(entry.name) < names.len();
            if entry.location == 0 || end.is_none_or(|end| end > length) || !ordered || !named {
                break;
            }
            entries.push(entry);
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
    pub fn schema(&self) -> (&str, (u16, u16)) {
        let version = self.header.schema_version;
        (
            &self.header.schema,
            ((version >> 16) as u16, version as u16),
        )
    }

    /// The program that wrote the file.
    pub fn application(&self) -> &str {
        &self.header.application
    }

    /// The number of frames.
    pub fn frames(&self) -> u64 {
        self.entries.last().map_or(0, |entry| entry.frame + 1)
    }

    /// One chunk of a frame; `None` if the frame does not have it (in the HOOMD schema it is then
    /// as in frame 0).
    ///
    /// # Errors
    /// [`IoError::File`] if the system refuses, [`IoError::Parse`] for a type of values that this
    /// program never writes.
    pub fn chunk(&mut self, frame: u64, name: &str) -> Result<Option<Chunk>> {
        let wanted = |entry: &&IndexEntry| {
            self.names
                .get(usize::from(entry.name))
                .is_some_and(|known| known == name)
        };
        match self.frame_entries(frame).iter().find(wanted).copied() {
            Some(entry) => self.read_entry(entry).map(Some),
            None => Ok(None),
        }
    }

    /// All chunks of a frame, in the order in which they were written.
    ///
    /// # Errors
    /// As [`GsdFile::chunk`].
    pub fn frame(&mut self, frame: u64) -> Result<Vec<Chunk>> {
        let mut entries = self.frame_entries(frame).to_vec();
        entries.sort_by_key(|entry| entry.location);
        entries
            .into_iter()
            .map(|entry| self.read_entry(entry))
            .collect()
    }

    fn frame_entries(&self, frame: u64) -> &[IndexEntry] {
        let start = self.entries.partition_point(|entry| entry.frame < frame);
        let end = self.entries.partition_point(|entry| entry.frame <= frame);
        &self.entries[start..end]
    }

    fn read_entry(&mut self, entry: IndexEntry) -> Result<Chunk> {
        let name = self
            .names
            .get(usize::from(entry.name))
            .cloned()
            .unwrap_or_default();
        let length = self
            .file
            .metadata()
            .map_err(IoError::at(&self.path, "read"))?
            .len();
        let bytes = entry.length().unwrap_or(u64::MAX);
        let bytes = read_at(&mut self.file, &self.path, length, entry.location, bytes)?;
        let data = ChunkData::from_bytes(entry.code, &bytes).ok_or_else(|| {
            let cause = format!("chunk {name:?} has values of type {}", entry.code);
            IoError::parse(
                &self.path.display().to_string(),
                0,
                cause,
                "open it with the Python package gsd",
            )
        })?;
        Ok(Chunk {
            name,
            columns: entry.columns,
            data,
        })
    }
}

/// Bytes of a file, refusing to take memory for more than the file has.
fn read_at(
    file: &mut File,
    path: &Path,
    file_length: u64,
    location: u64,
    count: u64,
) -> Result<Vec<u8>> {
    if location
        .checked_add(count)
        .is_none_or(|end| end > file_length)
    {
        let cause = format!("it is cut: {count} bytes at {location} are missing");
        return Err(IoError::parse(
            &path.display().to_string(),
            0,
            cause,
            "give a complete GSD file of version 2",
        ));
    }
    let mut bytes = vec![0; count as usize];
    file.seek(SeekFrom::Start(location))
        .and_then(|_| file.read_exact(&mut bytes))
        .map_err(IoError::at(path, "read"))?;
    Ok(bytes)
}
