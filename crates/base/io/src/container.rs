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
/// Length of the checksum at the end.
const CHECKSUM_BYTES: usize = 32;
/// JSON takes many times its length in memory, so large data belong in arrays.
const LONGEST_HEADER_BYTES: usize = 1 << 26;
/// Length of what comes before the header.
const PREFIX_BYTES: usize = 8 + 4 + 8;

/// The content of a container file.
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
    /// The kind of file ("body", "checkpoint"), to prevent confusion.
    pub kind: String,
    /// Everything except the arrays.
    pub header: serde_json::Value,
    arrays: BTreeMap<String, Array>,
}

/// An array of any shape, the last index running fastest.
///
/// ```
/// use protomer_io::container::Array;
/// let array = Array::u32(vec![1, 2, 3, 4, 5, 6], [2, 3])?;
/// assert_eq!(array.shape(), [2, 3]);
/// assert!(Array::u32(vec![1], [2, 3]).is_err());
/// # Ok::<(), protomer_io::IoError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    shape: Vec<usize>,
    values: Values,
}

/// The values of an array.
///
/// ```
/// use protomer_io::container::{Array, Values};
/// let array = Array::new(Values::U8(vec![1, 2, 3]), vec![3])?;
/// assert_eq!(array, Array::u8(vec![1, 2, 3], [3])?);
/// # Ok::<(), protomer_io::IoError>(())
/// ```
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

/// Applies the same expression to the vector, whatever its type.
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
        with_values!(self, vector => {
            for value in vector {
                bytes.extend_from_slice(&value.to_le_bytes());
            }
        });
    }

    /// Reads `count` values; memory is allocated only for bytes that exist.
    fn read(
        code: u8,
        count: usize,
        cursor: &mut Cursor,
    ) -> std::result::Result<Option<Self>, Ended> {
        Ok(Some(match code {
            1 => Values::F64(numbers(count, cursor, f64::from_le_bytes)?),
            2 => Values::F32(numbers(count, cursor, f32::from_le_bytes)?),
            3 => Values::U64(numbers(count, cursor, u64::from_le_bytes)?),
            4 => Values::I64(numbers(count, cursor, i64::from_le_bytes)?),
            5 => Values::U32(numbers(count, cursor, u32::from_le_bytes)?),
            6 => Values::I32(numbers(count, cursor, i32::from_le_bytes)?),
            7 => Values::U8(numbers(count, cursor, u8::from_le_bytes)?),
            _ => return Ok(None),
        }))
    }
}

/// The next `count` numbers of `SIZE` bytes each.
fn numbers<const SIZE: usize, T>(
    count: usize,
    cursor: &mut Cursor,
    number: fn([u8; SIZE]) -> T,
) -> std::result::Result<Vec<T>, Ended> {
    let ended = Ended {
        byte: cursor.position(),
    };
    // Checked before anything is allocated: a length from the file may be near 2⁶⁴.
    let bytes = cursor.take(count.checked_mul(SIZE).ok_or(ended)?)?;
    let (chunks, _) = bytes.as_chunks::<SIZE>();
    Ok(chunks.iter().copied().map(number).collect())
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
                /// The values of the array of this name and shape; `None` in the shape matches
                /// any length.
                ///
                /// # Errors
                /// [`IoError::Parse`] if there is no such array, or if it has another type or
                /// shape.
                pub fn $name(&self, file: &str, name: &str, shape: &[Option<usize>]) -> Result<&[$number]> {
                    match self.array(file, name, shape)? {
                        Values::$variant(values) => Ok(values),
                        _ => {
                            let cause = format!("array {name:?} does not have the type {}", stringify!($number));
                            Err(corrupt(file, cause))
                        }
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
    /// ```
    /// use protomer_io::container::{Array, Values};
    /// let values = Values::I32(vec![1, 2, 3, 4]);
    /// assert!(Array::new(values.clone(), vec![2, 2]).is_ok());
    /// assert!(Array::new(values, vec![2, 3]).is_err(), "it has six places");
    /// ```
    ///
    /// # Errors
    /// [`IoError::Unwritable`] unless the shape has as many elements as there are values.
    pub fn new(values: Values, shape: Vec<usize>) -> Result<Self> {
        // The number of dimensions is written as one byte.
        let is_filled = element_count(&shape) == Some(values.len());
        if !is_filled || shape.len() > usize::from(u8::MAX) {
            let cause = format!("{} values do not fill the shape {shape:?}", values.len());
            let remedy = "give a shape whose product is the number of values";
            return Err(IoError::unwritable(cause, remedy));
        }
        Ok(Self { shape, values })
    }

    /// Lengths along each dimension.
    ///
    /// ```
    /// use protomer_io::container::Array;
    /// let corners = Array::f64(vec![0.0; 12], [4, 3])?;
    /// assert_eq!(corners.shape(), [4, 3]);
    /// # Ok::<(), protomer_io::IoError>(())
    /// ```
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// The values, the last index running fastest.
    ///
    /// ```
    /// use protomer_io::container::{Array, Values};
    /// let numbers = Array::u32(vec![1, 2, 3, 4], [2, 2])?;
    /// assert_eq!(numbers.values(), &Values::U32(vec![1, 2, 3, 4]));
    /// # Ok::<(), protomer_io::IoError>(())
    /// ```
    pub fn values(&self) -> &Values {
        &self.values
    }
}

impl Container {
    /// A container without arrays.
    ///
    /// ```
    /// use protomer_io::container::Container;
    /// let container = Container::new("body", serde_json::json!({ "name": "lysozyme" }));
    /// assert_eq!((container.kind.as_str(), container.arrays().count()), ("body", 0));
    /// assert_eq!(container.header["name"], "lysozyme");
    /// ```
    pub fn new(kind: impl Into<String>, header: serde_json::Value) -> Self {
        Self {
            kind: kind.into(),
            header,
            arrays: BTreeMap::new(),
        }
    }

    /// Adds an array, replacing one of the same name.
    ///
    /// ```
    /// use protomer_io::container::{Array, Container};
    /// let mut container = Container::new("body", serde_json::json!({}));
    /// container.insert("charges", Array::f64(vec![1.0], [1])?);
    /// container.insert("charges", Array::f64(vec![1.0, -1.0], [2])?);
    /// assert_eq!(container.get("charges").map(Array::shape), Some(&[2][..]));
    /// assert_eq!(container.get("vertices"), None);
    /// # Ok::<(), protomer_io::IoError>(())
    /// ```
    pub fn insert(&mut self, name: impl Into<String>, array: Array) {
        self.arrays.insert(name.into(), array);
    }

    /// The array of this name.
    ///
    /// ```
    /// use protomer_io::container::{Array, Container};
    /// let mut container = Container::new("body", serde_json::json!({}));
    /// let charges = Array::f64(vec![1.0, -1.0], [2])?;
    /// container.insert("charges", charges.clone());
    /// assert_eq!(container.get("charges"), Some(&charges));
    /// # Ok::<(), protomer_io::IoError>(())
    /// ```
    pub fn get(&self, name: &str) -> Option<&Array> {
        self.arrays.get(name)
    }

    /// The arrays in the order of their names.
    ///
    /// ```
    /// use protomer_io::container::{Array, Container};
    /// let mut container = Container::new("body", serde_json::json!({}));
    /// container.insert("vertices", Array::f64(vec![0.0; 3], [1, 3])?);
    /// container.insert("charges", Array::f64(vec![1.0], [1])?);
    /// let names: Vec<&str> = container.arrays().map(|(name, _)| name).collect();
    /// assert_eq!(names, ["charges", "vertices"]);
    /// # Ok::<(), protomer_io::IoError>(())
    /// ```
    pub fn arrays(&self) -> impl Iterator<Item = (&str, &Array)> {
        self.arrays
            .iter()
            .map(|(name, array)| (name.as_str(), array))
    }

    fn array(&self, file: &str, name: &str, shape: &[Option<usize>]) -> Result<&Values> {
        let Some(array) = self.arrays.get(name) else {
            return Err(corrupt(file, format!("array {name:?} is missing")));
        };
        let mut fits = array.shape.len() == shape.len();
        for (length, expected) in array.shape.iter().zip(shape) {
            fits &= expected.is_none_or(|expected| expected == *length);
        }
        if fits {
            return Ok(&array.values);
        }
        let cause = format!("array {name:?} has the unexpected shape {:?}", array.shape);
        Err(corrupt(file, cause))
    }

    /// The bytes of the file. The same content gives the same bytes.
    ///
    /// ```
    /// use protomer_io::container::{Array, Container};
    /// let (mut one, mut other) = (Container::new("a", 1.into()), Container::new("a", 1.into()));
    /// one.insert("x", Array::f64(vec![1.0], [1])?);
    /// one.insert("y", Array::f64(vec![2.0], [1])?);
    /// other.insert("y", Array::f64(vec![2.0], [1])?);
    /// other.insert("x", Array::f64(vec![1.0], [1])?);
    /// assert_eq!(one.to_bytes()?, other.to_bytes()?, "the order of insertion leaves no trace");
    /// # Ok::<(), protomer_io::IoError>(())
    /// ```
    ///
    /// # Errors
    /// [`IoError::Unwritable`] for names longer than 65 535 bytes.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        bytes.extend_from_slice(&MAGIC);
        bytes.extend_from_slice(&LAYOUT_VERSION.to_le_bytes());
        bytes.extend_from_slice(&[0; 8]); // the length, filled in below
        write_name(&mut bytes, &self.kind)?;
        let header = self.header_bytes()?;
        bytes.extend_from_slice(&(header.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&header);
        bytes.extend_from_slice(&(self.arrays.len() as u32).to_le_bytes());
        // A map in the order of its keys: equal content gives equal bytes.
        for (name, array) in &self.arrays {
            write_name(&mut bytes, name)?;
            bytes.extend_from_slice(&[array.values.code(), array.shape.len() as u8]);
            for length in &array.shape {
                bytes.extend_from_slice(&(*length as u64).to_le_bytes());
            }
            array.values.write(&mut bytes);
        }
        // The checksum counts as part of the file, and the length is covered by it.
        let length = (bytes.len() + CHECKSUM_BYTES) as u64;
        bytes[12..20].copy_from_slice(&length.to_le_bytes());
        let checksum = Sha256::digest(&bytes);
        bytes.extend_from_slice(&checksum);
        Ok(bytes)
    }

    fn header_bytes(&self) -> Result<Vec<u8>> {
        let header = match serde_json::to_vec(&self.header) {
            Ok(header) => header,
            Err(error) => {
                let cause = format!("the header cannot be written as JSON ({error})");
                return Err(IoError::unwritable(cause, "use text keys"));
            }
        };
        if header.len() > LONGEST_HEADER_BYTES {
            let cause = format!("the header has {} bytes", header.len());
            return Err(IoError::unwritable(cause, "put large data into arrays"));
        }
        Ok(header)
    }

    /// Reads a container of this kind. `file` is its name for error messages.
    ///
    /// ```
    /// use protomer_io::container::Container;
    /// let mut bytes = Container::new("body", serde_json::json!({})).to_bytes()?;
    /// assert!(Container::from_bytes("a.body", "checkpoint", &bytes).is_err(), "another kind");
    /// bytes[30] ^= 1;
    /// let error = Container::from_bytes("a.body", "body", &bytes).map_err(|error| error.to_string());
    /// assert!(error.is_err_and(|message| message.contains("its checksum differs")));
    /// # Ok::<(), protomer_io::IoError>(())
    /// ```
    ///
    /// # Errors
    /// [`IoError::Parse`] says whether the file is not a protomer file, newer than this program,
    /// cut, damaged, or of another kind. Memory is only allocated for bytes that exist.
    pub fn from_bytes(file: &str, kind: &str, bytes: &[u8]) -> Result<Self> {
        let content = check_envelope(file, bytes)?;
        let mut cursor = Cursor::new(content);
        let container = match read_content(file, &mut cursor) {
            Ok(container) => container,
            Err(Unreadable::Error(error)) => return Err(error),
            Err(Unreadable::Ended(ended)) => {
                // The cursor began after the prefix; a message counts from the start of the file.
                let byte = ended.byte + PREFIX_BYTES;
                return Err(corrupt(file, format!("a value is missing at byte {byte}")));
            }
        };
        if cursor.remaining() > 0 {
            let cause = format!("{} bytes are left over", cursor.remaining());
            return Err(corrupt(file, cause));
        }
        if container.kind != kind {
            let actual_kind = container.kind;
            let cause = format!("it is a {actual_kind} file where a {kind} file was expected");
            let remedy = format!("give a {kind} file");
            return Err(IoError::parse(file, 0, cause, remedy));
        }
        Ok(container)
    }
}

/// Checks magic, version, length and checksum; returns what lies between the length and the
/// checksum.
fn check_envelope<'a>(file: &str, bytes: &'a [u8]) -> Result<&'a [u8]> {
    let mut cursor = Cursor::new(bytes);
    // Another kind of file is told apart from a damaged one.
    if cursor.take(MAGIC.len()) != Ok(MAGIC.as_slice()) {
        let remedy = "give a file that protomer wrote, copied in binary mode";
        return Err(IoError::parse(file, 0, "it is not a protomer file", remedy));
    }
    let (Ok(version), Ok(length)) = (cursor.u32(), cursor.u64()) else {
        return Err(truncated(file, bytes.len(), None));
    };
    // Before length and checksum: a newer layout may have them elsewhere.
    if version > LAYOUT_VERSION {
        let cause = format!(
            "its version {version} is newer than this program, which reads versions up to {LAYOUT_VERSION}"
        );
        let remedy = "use a newer protomer, or make the file again with this one";
        return Err(IoError::parse(file, 0, cause, remedy));
    }
    // Shorter than stated: the transfer broke off, which is worth its own message.
    if length > bytes.len() as u64 {
        return Err(truncated(file, bytes.len(), Some(length)));
    }
    let signed = match bytes.len().checked_sub(CHECKSUM_BYTES) {
        Some(signed) if signed >= PREFIX_BYTES => signed,
        _ => return Err(truncated(file, bytes.len(), None)),
    };
    // The checksum covers everything before it, magic and length included.
    let checksum = Sha256::digest(&bytes[..signed]);
    if length < bytes.len() as u64 || checksum.as_slice() != &bytes[signed..] {
        let cause = "its checksum differs: the file is damaged";
        return Err(IoError::parse(file, 0, cause, "make it again"));
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
    // On 32 bits the length may not fit; the largest one then ends the data.
    let length = usize::try_from(cursor.u64()?).unwrap_or(usize::MAX);
    // Only if the bytes are there: else the file is truncated, which is said below.
    if length > LONGEST_HEADER_BYTES && length <= cursor.remaining() {
        return Err(corrupt(file, format!("its header has {length} bytes")).into());
    }
    let header = match serde_json::from_slice(cursor.take(length)?) {
        Ok(header) => header,
        Err(error) => {
            let cause = format!("its header is not JSON ({error})");
            return Err(corrupt(file, cause).into());
        }
    };
    let mut container = Container::new(kind, header);
    // The count only controls the loop: every array takes bytes, so a wrong one ends the data.
    for _ in 0..cursor.u32()? {
        let (name, array) = read_array(file, cursor)?;
        container.insert(name, array);
    }
    Ok(container)
}

fn read_array(file: &str, cursor: &mut Cursor) -> std::result::Result<(String, Array), Unreadable> {
    let name = read_name(file, cursor)?;
    let (code, dimensions) = (cursor.u8()?, cursor.u8()?);
    let mut shape = Vec::with_capacity(dimensions.into());
    for _ in 0..dimensions {
        shape.push(usize::try_from(cursor.u64()?).unwrap_or(usize::MAX));
    }
    let Some(count) = element_count(&shape) else {
        let cause = format!("array {name:?} has the impossible shape {shape:?}");
        return Err(corrupt(file, cause).into());
    };
    match Values::read(code, count, cursor)? {
        Some(values) => Ok((name, Array { shape, values })),
        None => {
            let cause = format!("array {name:?} has the unknown type {code}");
            Err(corrupt(file, cause).into())
        }
    }
}

/// The product of the lengths; `None` if it overflows.
fn element_count(shape: &[usize]) -> Option<usize> {
    let mut count = 1_usize;
    for length in shape {
        count = count.checked_mul(*length)?;
    }
    Some(count)
}

fn write_name(bytes: &mut Vec<u8>, name: &str) -> Result<()> {
    let Ok(length) = u16::try_from(name.len()) else {
        let cause = format!("a name is {} bytes long", name.len());
        return Err(IoError::unwritable(cause, "use a shorter name"));
    };
    bytes.extend_from_slice(&length.to_le_bytes());
    bytes.extend_from_slice(name.as_bytes());
    Ok(())
}

fn read_name(file: &str, cursor: &mut Cursor) -> std::result::Result<String, Unreadable> {
    let length = cursor.u16()?;
    match std::str::from_utf8(cursor.take(length.into())?) {
        Ok(name) => Ok(name.to_owned()),
        Err(_) => Err(corrupt(file, "a name is not UTF-8".to_owned()).into()),
    }
}

fn truncated(file: &str, present: usize, expected: Option<u64>) -> IoError {
    let cause = match expected {
        Some(expected) => format!("it is truncated at byte {present} of {expected}"),
        None => format!("it is truncated at byte {present}"),
    };
    IoError::parse(file, 0, cause, "copy or make it again")
}

fn corrupt(file: &str, cause: String) -> IoError {
    let remedy = "the file was not written by this version of protomer: make it again";
    IoError::parse(file, 0, cause, remedy)
}
