//! The GSD file layer: frames of named, typed arrays ("chunks").
//!
//! A file is a header of 256 bytes, an index block of 32-byte entries, a name list of
//! zero-terminated strings, and data. The first index entry with location 0 ends the index. Within
//! the index, entries are ordered by frame, then by name.

use crate::bytes::{Cursor, Ended};

const MAGIC: u64 = 0x65DF_65DF_65DF_65DF;
const FILE_VERSION: u32 = 2 << 16;
pub(super) const HEADER_BYTES: u64 = 256;
pub(super) const ENTRY_BYTES: u64 = 32;
/// The name list is allocated in segments of this length.
pub(super) const NAME_SEGMENT_BYTES: u64 = 64;

/// One named array of a frame, `rows` x `columns`, the column running fastest.
///
/// ```
/// use protomer_io::gsd::{Chunk, ChunkData};
/// let data = ChunkData::F32(vec![0.0, 0.0, 1.5]);
/// let chunk = Chunk { name: "particles/position".into(), columns: 3, data };
/// assert_eq!(chunk.data.len() / chunk.columns as usize, 1);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Chunk {
    /// Name, such as `particles/position`.
    pub name: String,
    /// Number of columns.
    pub columns: u32,
    /// The values; their number is a multiple of `columns`.
    pub data: ChunkData,
}

/// The values of a chunk.
///
/// ```
/// use protomer_io::gsd::{Chunk, ChunkData};
/// let positions = Chunk::new("particles/position", 3, ChunkData::F32(vec![0.0; 6]));
/// assert_eq!(positions.data.len(), 6);
/// assert!(ChunkData::U32(Vec::new()).is_empty());
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum ChunkData {
    /// 8-bit unsigned integers.
    U8(Vec<u8>),
    /// 32-bit unsigned integers.
    U32(Vec<u32>),
    /// 64-bit unsigned integers.
    U64(Vec<u64>),
    /// 8-bit signed integers: the schema's text.
    I8(Vec<i8>),
    /// 32-bit floating point.
    F32(Vec<f32>),
    /// 64-bit floating point.
    F64(Vec<f64>),
}

impl ChunkData {
    pub(super) fn code(&self) -> u8 {
        match self {
            ChunkData::U8(_) => 1,
            ChunkData::U32(_) => 3,
            ChunkData::U64(_) => 4,
            ChunkData::I8(_) => 5,
            ChunkData::F32(_) => 9,
            ChunkData::F64(_) => 10,
        }
    }

    /// The number of values.
    ///
    /// ```
    /// use protomer_io::gsd::ChunkData;
    /// assert_eq!(ChunkData::F64(vec![1.0, 2.0]).len(), 2, "values, not bytes");
    /// ```
    pub fn len(&self) -> usize {
        match self {
            ChunkData::U8(values) => values.len(),
            ChunkData::U32(values) => values.len(),
            ChunkData::U64(values) => values.len(),
            ChunkData::I8(values) => values.len(),
            ChunkData::F32(values) => values.len(),
            ChunkData::F64(values) => values.len(),
        }
    }

    /// Whether there are no values.
    ///
    /// ```
    /// use protomer_io::gsd::ChunkData;
    /// assert!(ChunkData::U8(Vec::new()).is_empty() && !ChunkData::U8(vec![0]).is_empty());
    /// ```
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(super) fn to_bytes(&self) -> Vec<u8> {
        match self {
            ChunkData::U8(values) => values.clone(),
            ChunkData::U32(values) => bytes_of(values, u32::to_le_bytes),
            ChunkData::U64(values) => bytes_of(values, u64::to_le_bytes),
            ChunkData::I8(values) => bytes_of(values, i8::to_le_bytes),
            ChunkData::F32(values) => bytes_of(values, f32::to_le_bytes),
            ChunkData::F64(values) => bytes_of(values, f64::to_le_bytes),
        }
    }

    pub(super) fn from_bytes(code: u8, bytes: &[u8]) -> Option<Self> {
        Some(match code {
            1 => ChunkData::U8(bytes.to_vec()),
            3 => ChunkData::U32(numbers(bytes, u32::from_le_bytes)),
            4 => ChunkData::U64(numbers(bytes, u64::from_le_bytes)),
            5 => ChunkData::I8(numbers(bytes, i8::from_le_bytes)),
            9 => ChunkData::F32(numbers(bytes, f32::from_le_bytes)),
            10 => ChunkData::F64(numbers(bytes, f64::from_le_bytes)),
            _ => return None,
        })
    }
}

fn bytes_of<const N: usize, T: Copy>(values: &[T], bytes: fn(T) -> [u8; N]) -> Vec<u8> {
    values.iter().copied().flat_map(bytes).collect()
}

fn numbers<const N: usize, T>(bytes: &[u8], number: fn([u8; N]) -> T) -> Vec<T> {
    let (chunks, _) = bytes.as_chunks::<N>();
    chunks.iter().copied().map(number).collect()
}

/// Bytes of one value of a type of the specification; `None` for an unknown type.
fn size_of_type(code: u8) -> Option<u64> {
    match code {
        1 | 5 | 11 => Some(1),
        2 | 6 => Some(2),
        3 | 7 | 9 => Some(4),
        4 | 8 | 10 => Some(8),
        _ => None,
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct IndexEntry {
    pub frame: u64,
    pub rows: u64,
    pub location: u64,
    pub columns: u32,
    pub name: u16,
    pub code: u8,
}

impl IndexEntry {
    pub(super) fn to_bytes(self) -> [u8; ENTRY_BYTES as usize] {
        let mut bytes = [0; ENTRY_BYTES as usize];
        // Offsets of gsd_index_entry: frame 0, rows 8,
        // location 16, columns 24, name 28, type 30, flags 31.
        bytes[0..8].copy_from_slice(&self.frame.to_le_bytes());
        bytes[8..16].copy_from_slice(&self.rows.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.location.to_le_bytes());
        bytes[24..28].copy_from_slice(&self.columns.to_le_bytes());
        bytes[28..30].copy_from_slice(&self.name.to_le_bytes());
        bytes[30] = self.code;
        bytes
    }

    pub(super) fn read(cursor: &mut Cursor) -> std::result::Result<Self, Ended> {
        let entry = Self {
            frame: cursor.u64()?,
            rows: cursor.u64()?,
            location: cursor.u64()?,
            columns: cursor.u32()?,
            name: cursor.u16()?,
            code: cursor.u8()?,
        };
        cursor.u8()?; // flags, reserved
        Ok(entry)
    }

    /// Whether the data lie within a file of this length.
    pub(super) fn lies_within(&self, file_length: u64) -> bool {
        // `None` of a multiplication that overflows counts as outside.
        let end = self
            .length()
            .and_then(|length| length.checked_add(self.location));
        end.is_some_and(|end| end <= file_length)
    }

    /// Length of the data in bytes; `None` if it is impossible.
    pub(super) fn length(&self) -> Option<u64> {
        self.rows
            .checked_mul(self.columns.into())?
            .checked_mul(size_of_type(self.code)?)
    }
}

#[derive(Debug)]
pub(super) struct Header {
    pub index_location: u64,
    pub index_entries: u64,
    pub names_location: u64,
    pub names_segments: u64,
    pub schema_version: u32,
    pub application: String,
    pub schema: String,
}

impl Header {
    pub(super) fn to_bytes(&self) -> [u8; HEADER_BYTES as usize] {
        let mut bytes = [0; HEADER_BYTES as usize];
        // gsd_header: five numbers of 8 bytes from byte 0, two of 4 bytes at 40
        // and 44, then two texts of 64 bytes at 48 and 112; the rest is reserved.
        let numbers = [
            MAGIC,
            self.index_location,
            self.index_entries,
            self.names_location,
            self.names_segments,
        ]
        .into_iter();
        for (slot, number) in bytes.chunks_exact_mut(8).zip(numbers) {
            slot.copy_from_slice(&number.to_le_bytes());
        }
        bytes[40..44].copy_from_slice(&self.schema_version.to_le_bytes());
        bytes[44..48].copy_from_slice(&FILE_VERSION.to_le_bytes());
        // Names are cut to leave a terminating zero in their 64 bytes.
        for (start, text) in [(48, &self.application), (112, &self.schema)] {
            let text = &text.as_bytes()[..text.len().min(63)];
            bytes[start..start + text.len()].copy_from_slice(text);
        }
        bytes
    }

    /// Reads a header; `Ok(Err(cause))` for a file that is not GSD 2.
    pub(super) fn read(
        cursor: &mut Cursor,
    ) -> std::result::Result<std::result::Result<Self, String>, Ended> {
        if cursor.u64()? != MAGIC {
            return Ok(Err("it is not a GSD file".into()));
        }
        let index_location = cursor.u64()?;
        let index_entries = cursor.u64()?;
        let names_location = cursor.u64()?;
        let names_segments = cursor.u64()?;
        let schema_version = cursor.u32()?;
        let version = cursor.u32()?;
        let (major, minor) = (version >> 16, version & 0xFFFF);
        if major != FILE_VERSION >> 16 {
            let cause = format!("it is a GSD file of version {major}.{minor}, not 2");
            return Ok(Err(cause));
        }
        let application = zero_terminated(cursor.take(64)?);
        let schema = zero_terminated(cursor.take(64)?);
        Ok(Ok(Self {
            index_location,
            index_entries,
            names_location,
            names_segments,
            schema_version,
            application,
            schema,
        }))
    }
}

/// The text before the first zero.
fn zero_terminated(bytes: &[u8]) -> String {
    let text = bytes.split(|byte| *byte == 0).next().unwrap_or_default();
    String::from_utf8_lossy(text).into_owned()
}
