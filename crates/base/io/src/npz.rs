//! NumPy archives: named arrays in a ZIP file, as `numpy.load` reads them.
//!
//! The layout of an array is that of NumPy's format version 1.0 (NEP 1): a header that is a Python
//! dictionary, then the values in C order, little-endian.

use crate::{IoError, Result};
use std::io::{Cursor, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// The values of an array, the last axis running fastest.
///
/// ```
/// use protomer_io::npz::{NamedArray, NpyValues, write_npz};
/// let size = |values| write_npz(&[NamedArray { name: "x", shape: &[2], values }]).map(|file| file.len());
/// let (single, double) = (size(NpyValues::F32(&[1.0, 2.0]))?, size(NpyValues::F64(&[1.0, 2.0]))?);
/// assert_eq!(double - single, 8, "four bytes more for each value");
/// # Ok::<(), protomer_io::IoError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NpyValues<'a> {
    /// Single precision.
    F32(&'a [f32]),
    /// Double precision.
    F64(&'a [f64]),
}

impl NpyValues<'_> {
    fn len(&self) -> usize {
        match self {
            NpyValues::F32(values) => values.len(),
            NpyValues::F64(values) => values.len(),
        }
    }

    fn kind(&self) -> &'static str {
        match self {
            NpyValues::F32(_) => "<f4",
            NpyValues::F64(_) => "<f8",
        }
    }

    fn write(&self, bytes: &mut Vec<u8>) {
        match self {
            NpyValues::F32(values) => {
                for value in *values {
                    bytes.extend_from_slice(&value.to_le_bytes());
                }
            }
            NpyValues::F64(values) => {
                for value in *values {
                    bytes.extend_from_slice(&value.to_le_bytes());
                }
            }
        }
    }
}

/// One array of an archive.
///
/// ```
/// use protomer_io::npz::{NamedArray, NpyValues, write_npz};
/// let values = NpyValues::F64(&[1.0, 2.0, 3.0]);
/// let row = NamedArray { name: "charges", shape: &[3], values };
/// assert!(write_npz(&[row]).is_ok());
/// assert!(write_npz(&[NamedArray { shape: &[2, 2], ..row }]).is_err(), "four places, three values");
/// assert!(write_npz(&[row, row]).is_err(), "two arrays have one name");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NamedArray<'a> {
    /// The key under which `numpy.load` finds it.
    pub name: &'a str,
    /// Lengths of the axes; empty for a single number.
    pub shape: &'a [usize],
    /// The values in C order.
    pub values: NpyValues<'a>,
}

/// The bytes of an uncompressed archive of arrays, the same bytes for the same arrays.
///
/// # Errors
/// [`IoError::Unwritable`] if a shape does not fit its values, or two arrays have one name.
///
/// ```
/// use protomer_io::npz::{NamedArray, NpyValues, write_npz};
/// let values = NpyValues::F64(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
/// let bytes = write_npz(&[NamedArray { name: "potential", shape: &[1, 2, 3], values }])?;
/// assert_eq!(&bytes[..2], b"PK");
/// # Ok::<(), protomer_io::IoError>(())
/// ```
pub fn write_npz(arrays: &[NamedArray]) -> Result<Vec<u8>> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for array in arrays {
        let expected: usize = array.shape.iter().product();
        if expected != array.values.len() {
            let count = array.values.len();
            let cause = format!("{count} values for the shape {:?}", array.shape);
            return Err(refused(array.name, &cause));
        }
        if let Err(error) = add(&mut archive, array) {
            return Err(refused(array.name, &error.to_string()));
        }
    }
    match archive.finish() {
        Ok(bytes) => Ok(bytes.into_inner()),
        Err(error) => Err(refused("archive", &error.to_string())),
    }
}

fn add(archive: &mut ZipWriter<Cursor<Vec<u8>>>, array: &NamedArray) -> zip::result::ZipResult<()> {
    // File times keep their minimum value, so that equal arrays give equal bytes.
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    archive.start_file(format!("{}.npy", array.name), options)?;
    archive.write_all(&npy(array))?;
    Ok(())
}

fn refused(name: &str, cause: &str) -> IoError {
    IoError::unwritable(
        format!("array {name}: {cause}"),
        "give every array a unique name and as many values as its shape requires",
    )
}

/// An array with its header, which is padded so that the values begin at a multiple of 64 bytes.
fn npy(array: &NamedArray) -> Vec<u8> {
    const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";
    let lengths: Vec<String> = array.shape.iter().map(usize::to_string).collect();
    let shape = match lengths.as_slice() {
        // A tuple of one element needs its comma in Python.
        [length] => format!("({length},)"),
        lengths => format!("({})", lengths.join(", ")),
    };
    let kind = array.values.kind();
    let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    // Magic and version, then two bytes for the length of the header.
    let before = MAGIC.len() + 2;
    // The line end counts; NumPy wants the values at a multiple of 64 to map them.
    let padded = (before + header.len() + 1).next_multiple_of(64) - before;
    let mut bytes = MAGIC.to_vec();
    bytes.extend((padded as u16).to_le_bytes());
    bytes.extend(format!("{header:<width$}\n", width = padded - 1).into_bytes());
    array.values.write(&mut bytes);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    fn array<'a>(name: &'a str, shape: &'a [usize], values: &'a [f64]) -> NamedArray<'a> {
        NamedArray {
            name,
            shape,
            values: NpyValues::F64(values),
        }
    }

    #[test]
    fn headers_are_those_of_numpy() {
        // As numpy 2.3 prints them.
        for (shape, text) in [(&[][..], "()"), (&[3], "(3,)"), (&[1, 3], "(1, 3)")] {
            let values = vec![0.5; shape.iter().product()];
            let bytes = npy(&array("a", shape, &values));
            let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
            let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
            let expected = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {text}, }}");
            assert_eq!(header.trim_end(), expected);
            assert!(header.ends_with('\n') && (10 + length) % 64 == 0);
            assert_eq!(bytes.len(), 10 + length + 8 * values.len());
        }
    }

    #[test]
    fn arrays_come_back_from_the_archive() {
        let bytes =
            write_npz(&[array("one", &[2], &[1.5, -2.0]), array("two", &[], &[7.0])]).unwrap();
        assert_eq!(
            bytes,
            write_npz(&[array("one", &[2], &[1.5, -2.0]), array("two", &[], &[7.0])]).unwrap()
        );
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
        let mut content = Vec::new();
        archive
            .by_name("one.npy")
            .unwrap()
            .read_to_end(&mut content)
            .unwrap();
        assert_eq!(content, npy(&array("one", &[2], &[1.5, -2.0])));
        assert_eq!(
            &content[content.len() - 16..content.len() - 8],
            &1.5_f64.to_le_bytes()
        );
        assert_eq!(archive.len(), 2);
    }

    #[test]
    fn wrong_shapes_and_equal_names_are_refused() {
        assert!(
            write_npz(&[array("a", &[3], &[1.0])])
                .unwrap_err()
                .to_string()
                .contains("1 values for the shape [3]")
        );
        assert!(write_npz(&[array("a", &[1], &[1.0]), array("a", &[1], &[1.0])]).is_err());
    }
}
