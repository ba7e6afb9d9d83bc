//! A versioned, self-contained, checksummed file of named arrays and one JSON header: body files
//! and checkpoints.
//!
//! Layout, all numbers little-endian:
//!
//! | bytes | content |
//! |---|---|
//! | 8 | magic `\x89PRTMR\r\n`, which a transfer in text mode destroys |
//! | 4 | version of this layout |
//! | 8 | length of the whole file |
//! | 2 + n | kind, UTF-8 |
//! | 8 + n | header, JSON |
//! | 4 | number of arrays, then for each: name (2 + n), type (1), dimensions (1), shape (8 each), values |
//! | 32 | SHA-256 of everything before |

use crate::bytes::{Cursor, Ended};
use crate::{IoError, Result};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;

const MAGIC: [u8; 8] = *b"\x89PRTMR\r\n";
/// Version of the layout that this program writes, and the newest it reads.
pub const LAYOUT_VERSION: u32 = 1;
const CHECKSUM_BYTES: usize = 32;
/// JSON takes many times its length in memory, so large data belong in arrays.
const LONGEST_HEADER_BYTES: usize = 1 << 26;
const PREFIX_BYTES: usize = 8 + 4 + 8;

/// What a container file holds.
///
/// ```
/// use protomer_io::container::{Array, Container};
/// let mut container = Container::new("body", serde_json::json!({ "name": "a" }));
/// container.insert("vertices", Array::f64(vec![0.0; 6], [2, 3])?);
/// let bytes = container.to_bytes()?;
/// let back = Container::from_bytes("a.body", "body", &bytes)?;
/// assert_eq!(back, container);
/// assert_eq!(back.f64("a.body", "vertices", &[None, Some(3)])?.len(), 6);
/// # Ok::<(), protomer_io::IoError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Container {
    /// What the file is ("body", "checkpoint"), so that one is not taken for another.
    pub kind: String,
    /// Everything that is not an array.
    pub header: serde_json::Value,
    arrays: BTreeMap<String, Array>,
}

/// An array of any shape, the last index running fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    shape: Vec<usize>,
    values: Values,
}

/// The values of an array.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// 64-bit floating point.
    F64(Vec<f64>),
    /// 32-bit floating point.
    F32(Vec<f32>),
    /// 64-bit unsigned integers.
    U64(Vec<u64>),
    /// 64-bit signed integers.
    I64(Vec<i64>),
    /// 32-bit unsigned integers.
    U32(Vec<u32>),
    /// 32-bit signed integers.
    I32(Vec<i32>),
    /// Bytes.
    U8(Vec<u8>),
}

/// Applies the same expression to whichever vector the values are.
macro_rules! with_values {
    ($values:expr, $vector:ident => $expression:expr) => {
        match $values {
            Values::F64($vector) => $expression,
            Values::F32($vector) => $expression,
            Values::U64($vector) => $expression,
            Values::I64($vector) => $expression,
            Values::U32($vector) => $expression,
            Values::I32($vector) => $expression,
            Values::U8($vector) => $expression,
        }
    };
}

impl Values {
    fn len(&self) -> usize {
        with_values!(self, vector => vector.len())
    }

    fn code(&self) -> u8 {
        match self {
            Values::F64(_) => 1,
            Values::F32(_) => 2,
            Values::U64(_) => 3,
            Values::I64(_) => 4,
            Values::U32(_) => 5,
            Values::I32(_) => 6,
            Values::U8(_) => 7,
        }
    }

    fn write(&self, bytes: &mut Vec<u8>) {
        with_values!(self, vector => vector.iter().for_each(|value| bytes.extend_from_slice(&value.to_le_bytes())));
    }

    /// Reads `count` values; memory is taken only for bytes that are there.
    fn read(
        code: u8,
        count: usize,
        cursor: &mut Cursor,
    ) -> std::result::Result<Option<Self>, Ended> {
        macro_rules! read {
            ($variant:ident, $number:ty) => {{
                const SIZE: usize = size_of::<$number>();
                let ended = Ended {
                    at: cursor.position(),
                };
                let bytes = cursor.take(count.checked_mul(SIZE).ok_or(ended)?)?;
                let number = |chunk: &[u8]| {
                    let mut array = [0; SIZE];
                    array.copy_from_slice(chunk);
                    <$number>::from_le_bytes(array)
                };
                Values::$variant(bytes.chunks_exact(SIZE).map(number).collect())
            }};
        }
        Ok(Some(match code {
            1 => read!(F64, f64),
            2 => read!(F32, f32),
            3 => read!(U64, u64),
            4 => read!(I64, i64),
            5 => read!(U32, u32),
            6 => read!(I32, i32),
            7 => read!(U8, u8),
            _ => return Ok(None),
        }))
    }
}

macro_rules! array_constructors {
    ($($name:ident $variant:ident $number:ty),*) => {
        impl Array {
            $(
                /// An array of this shape.
                ///
                /// # Errors
                /// [`IoError::Unwritable`] unless the shape has as many elements as there are
                /// values.
                pub fn $name(values: Vec<$number>, shape: impl Into<Vec<usize>>) -> Result<Self> {
                    Self::new(Values::$variant(values), shape.into())
                }
            )*
        }

        impl Container {
            $(
                /// The values of the array of this name and shape; `None` in the shape stands for
                /// any length.
                ///
                /// # Errors
                /// [`IoError::Parse`] if there is no such array, or if it has another type or
                /// shape.
                pub fn $name(&self, file: &str, name: &str, shape: &[Option<usize>]) -> Result<&[$number]> {
                    match self.array(file, name, shape)? {
                        Values::$variant(values) => Ok(values),
                        _ => Err(corrupt(file, format!("array {name:?} has not the type {}", stringify!($number)))),
                    }
                }
            )*
        }
    };
}

array_constructors!(f64 F64 f64, f32 F32 f32, u64 U64 u64, i64 I64 i64, u32 U32 u32, i32 I32 i32, u8 U8 u8);

impl Array {
    /// An array of this shape.
    ///
    /// # Errors
    /// [`IoError::Unwritable`] unless the shape has as many elements as there are values.
    pub fn new(values: Values, shape: Vec<usize>) -> Result<Self> {
        if element_count(shape.iter().copied()) != Some(values.len())
            || shape.len() > usize::from(u8::MAX)
        {
            let cause = format!("{} values do not fill the shape {shape:?}", values.len());
            return Err(IoError::unwritable(
                cause,
                "give a shape whose product is the number of values",
            ));
        }
        Ok(Self { shape, values })
    }

    /// Lengths along each dimension.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// The values, the last index running fastest.
    pub fn values(&self) -> &Values {
        &self.values
    }
}

impl Container {
    /// A container without arrays.
    pub fn new(kind: impl Into<String>, header: serde_json::Value) -> Self {
        Self {
            kind: kind.into(),
            header,
            arrays: BTreeMap::new(),
        }
    }

    /// Adds an array, replacing one of the same name.
    pub fn insert(&mut self, name: impl Into<String>, array: Array) {
        self.arrays.insert(name.into(), array);
    }

    /// The array of this name.
    pub fn get(&self, name: &str) -> Option<&Array> {
        self.arrays.get(name)
    }

    /// The arrays in the order of their names.
    pub fn arrays(&self) -> impl Iterator<Item = (&str, &Array)> {
        self.arrays
            .iter()
            .map(|(name, array)| (name.as_str(), array))
    }

    fn array(&self, file: &str, name: &str, shape: &[Option<usize>]) -> Result<&Values> {
        let array = self
            .arrays
            .get(name)
            .ok_or_else(|| corrupt(file, format!("array {name:?} is missing")))?;
        let fits = |(length, expected): (&usize, &Option<usize>)| {
            expected.is_none_or(|expected| expected == *length)
        };
        if array.shape.len() != shape.len() || !array.shape.iter().zip(shape).all(fits) {
            return Err(corrupt(
                file,
                format!("array {name:?} has the unexpected shape {:?}", array.shape),
            ));
        }
        Ok(&array.values)
    }

    /// The bytes of the file. The same content gives the same bytes.
    ///
    /// # Errors
    /// [`IoError::Unwritable`] for names longer than 65 535 bytes.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        bytes.extend_from_slice(&MAGIC);
        bytes.extend_from_slice(&LAYOUT_VERSION.to_le_bytes());
        bytes.extend_from_slice(&[0; 8]); // the length, filled in below
        write_name(&mut bytes, &self.kind)?;
        let header = serde_json::to_vec(&self.header).map_err(|error| {
            IoError::unwritable(format!("the header is no JSON ({error})"), "use text keys")
        })?;
        if header.len() > LONGEST_HEADER_BYTES {
            let cause = format!("the header has {} bytes", header.len());
            return Err(IoError::unwritable(cause, "put large data into arrays"));
        }
        bytes.extend_from_slice(&(header.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&header);
        bytes.extend_from_slice(&(self.arrays.len() as u32).to_le_bytes());
        for (name, array) in &self.arrays {
            write_name(&mut bytes, name)?;
            bytes.extend_from_slice(&[array.values.code(), array.shape.len() as u8]);
            array
                .shape
                .iter()
                .for_each(|length| bytes.extend_from_slice(&(*length as u64).to_le_bytes()));
            array.values.write(&mut bytes);
        }
        let length = (bytes.len() + CHECKSUM_BYTES) as u64;
        bytes[12..20].copy_from_slice(&length.to_le_bytes());
        let checksum = Sha256::digest(&bytes);
        bytes.extend_from_slice(&checksum);
        Ok(bytes)
    }

    /// Reads a container of this kind. `file` is its name for error messages.
    ///
    /// # Errors
    /// [`IoError::Parse`] says whether the file is no protomer file, newer than this program, cut,
    /// damaged, or of another kind. Memory is only ever taken for bytes that are there.
    pub fn from_bytes(file: &str, kind: &str, bytes: &[u8]) -> Result<Self> {
        let content = check_envelope(file, bytes)?;
        let mut cursor = Cursor::new(content);
        let container = read_content(file, &mut cursor).map_err(|unreadable| match unreadable {
            Unreadable::Ended(ended) => corrupt(
                file,
                format!("a value is missing at byte {}", ended.at + PREFIX_BYTES),
            ),
            Unreadable::Error(error) => error,
        })?;
        if cursor.remaining() > 0 {
            return Err(corrupt(
                file,
                format!("{} bytes are left over", cursor.remaining()),
            ));
        }
        if container.kind != kind {
            let cause = format!(
                "it is a {} file where a {kind} file was expected",
                container.kind
            );
            return Err(IoError::parse(
                file,
                0,
                cause,
                format!("give a {kind} file"),
            ));
        }
        Ok(container)
    }
}

/// Checks magic, version, length and checksum; returns what lies between the length and the
/// checksum.
fn check_envelope<'a>(file: &str, bytes: &'a [u8]) -> Result<&'a [u8]> {
    let mut cursor = Cursor::new(bytes);
    if bytes.is_empty() || cursor.take(MAGIC.len()).ok() != Some(MAGIC.as_slice()) {
        let cause = "it is not a protomer file";
        return Err(IoError::parse(
            file,
            0,
            cause,
            "give a file that protomer wrote, copied in binary mode",
        ));
    }
    let cut = |_| truncated(file, bytes.len(), None);
    let version = cursor.u32().map_err(cut)?;
    if version > LAYOUT_VERSION {
        let cause = format!(
            "its version {version} is newer than this program, which reads up to {LAYOUT_VERSION}"
        );
        return Err(IoError::parse(
            file,
            0,
            cause,
            "use a newer protomer, or make the file again with this one",
        ));
    }
    let length = cursor.u64().map_err(cut)?;
    if length > bytes.len() as u64 {
        return Err(truncated(file, bytes.len(), Some(length)));
    }
    let signed = bytes
        .len()
        .checked_sub(CHECKSUM_BYTES)
        .filter(|signed| *signed >= PREFIX_BYTES);
    let signed = signed.ok_or_else(|| truncated(file, bytes.len(), None))?;
    if length < bytes.len() as u64
        || Sha256::digest(&bytes[..signed]).as_slice() != &bytes[signed..]
    {
        return Err(IoError::parse(
            file,
            0,
            "its checksum differs: the file is damaged",
            "make it again",
        ));
    }
    Ok(&bytes[PREFIX_BYTES..signed])
}

enum Unreadable {
    Ended(Ended),
    Error(IoError),
}

impl From<Ended> for Unreadable {
    fn from(ended: Ended) -> Self {
        Unreadable::Ended(ended)
    }
}

impl From<IoError> for Unreadable {
    fn from(error: IoError) -> Self {
        Unreadable::Error(error)
    }
}

fn read_content(file: &str, cursor: &mut Cursor) -> std::result::Result<Container, Unreadable> {
    let kind = read_name(file, cursor)?;
    let length = usize::try_from(cursor.u64()?).unwrap_or(usize::MAX);
    if length > LONGEST_HEADER_BYTES && length <= cursor.remaining() {
        return Err(corrupt(file, format!("its header has {length} bytes")).into());
    }
    let header = serde_json::from_slice(cursor.take(length)?)
        .map_err(|error| corrupt(file, format!("its header is no JSON ({error})")))?;
    let mut container = Container::new(kind, header);
    for _ in 0..cursor.u32()? {
        let name = read_name(file, cursor)?;
        let (code, dimensions) = (cursor.u8()?, cursor.u8()?);
        let mut shape = Vec::with_capacity(dimensions.into());
        for _ in 0..dimensions {
            shape.push(usize::try_from(cursor.u64()?).unwrap_or(usize::MAX));
        }
        let bad_shape = || {
            corrupt(
                file,
                format!("array {name:?} has the impossible shape {shape:?}"),
            )
        };
        let count = element_count(shape.iter().copied()).ok_or_else(bad_shape)?;
        let values = Values::read(code, count, cursor)?
            .ok_or_else(|| corrupt(file, format!("array {name:?} has the unknown type {code}")))?;
        container.insert(name, Array { shape, values });
    }
    Ok(container)
}

fn element_count(shape: impl Iterator<Item = usize>) -> Option<usize> {
    shape.into_iter().try_fold(1usize, usize::checked_mul)
}

fn write_name(bytes: &mut Vec<u8>, name: &str) -> Result<()> {
    let length = u16::try_from(name.len()).map_err(|_| {
        IoError::unwritable(
            format!("a name is {} bytes long", name.len()),
            "use a shorter name",
        )
    })?;
    bytes.extend_from_slice(&length.to_le_bytes());
    bytes.extend_from_slice(name.as_bytes());
    Ok(())
}

fn read_name(file: &str, cursor: &mut Cursor) -> std::result::Result<String, Unreadable> {
    let length = cursor.u16()?;
    let name = cursor.take(length.into())?;
    let name =
        std::str::from_utf8(name).map_err(|_| corrupt(file, "a name is no UTF-8".to_owned()))?;
    Ok(name.to_owned())
}

fn truncated(file: &str, present: usize, expected: Option<u64>) -> IoError {
    let of = expected.map_or_else(String::new, |expected| format!(" of {expected}"));
    IoError::parse(
        file,
        0,
        format!("it is truncated at byte {present}{of}"),
        "copy or make it again",
    )
}

fn corrupt(file: &str, cause: String) -> IoError {
    IoError::parse(
        file,
        0,
        cause,
        "the file was not written by this version of protomer: make it again",
    )
}
