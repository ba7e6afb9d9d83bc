//! MRC2014 and CCP4 volumes, mode 2 (Cheng et al., J. Struct. Biol. 192, 146 (2015)): 1024 bytes of
//! header, then 32-bit floats with x running fastest.
//!
//! Two fields of the header can hold the place of the first point: ORIGIN, in Å, which programs of
//! electron microscopy read, and NSTART, in whole spacings, which programs of crystallography read.
//! Some programs add both, so a file states one of them and leaves the other at zero.

use super::grid::Volume;
use crate::error::{IoError, Result};

const HEADER_BYTES: usize = 1024;
const LABEL_BYTES: usize = 80;
/// First word of the place of the first point, in spacings.
const NSTART: usize = 5;
/// First word of the place of the first point, in Å.
const ORIGIN: usize = 50;

/// The bytes of a volume with the place of its first point in ORIGIN; `label` (up to 80 characters of
/// ASCII) says what it holds.
///
/// ```
/// use protomer_io::volume::{Volume, mrc::write_mrc};
/// let volume = Volume {
///     shape: [2, 1, 1],
///     origin_angstrom: [0.0; 3],
///     spacing_angstrom: 0.5,
///     values: vec![1.0, 2.0],
/// };
/// let bytes = write_mrc("potential, kT/e", &volume);
/// assert_eq!(&bytes[208..212], b"MAP ");
/// assert_eq!(bytes.len(), 1024 + 8);
/// ```
pub fn write_mrc(label: &str, volume: &Volume) -> Vec<u8> {
    let mut header = header(label, volume);
    for axis in 0..3 {
        put(
            &mut header,
            ORIGIN + axis,
            real(volume.origin_angstrom[axis]),
        );
    }
    with_values(header, volume)
}

/// The bytes of a volume with the place of its first point in NSTART; `label` as for [`write_mrc`].
///
/// # Errors
/// [`IoError::Unwritable`] if the first point is not at whole multiples of the spacing.
///
/// ```
/// use protomer_io::volume::{Volume, mrc::write_ccp4};
/// let mut volume = Volume {
///     shape: [2, 1, 1],
///     origin_angstrom: [-1.5, 0.0, 2.0],
///     spacing_angstrom: 0.5,
///     values: vec![1.0, 2.0],
/// };
/// let bytes = write_ccp4("potential, kT/e", &volume)?;
/// assert_eq!(bytes[16..20], (-3_i32).to_le_bytes());
/// volume.origin_angstrom[0] = -1.6;
/// assert!(write_ccp4("potential, kT/e", &volume).is_err());
/// # Ok::<(), protomer_io::IoError>(())
/// ```
pub fn write_ccp4(label: &str, volume: &Volume) -> Result<Vec<u8>> {
    let mut header = header(label, volume);
    for axis in 0..3 {
        let start = whole_spacings(volume.origin_angstrom[axis], volume.spacing_angstrom)?;
        put(&mut header, NSTART + axis, start.to_le_bytes());
    }
    Ok(with_values(header, volume))
}

/// The number of spacings from zero to a coordinate.
fn whole_spacings(coordinate_angstrom: f64, spacing_angstrom: f64) -> Result<i32> {
    /// Largest distance from a whole number: the header states lengths in single precision.
    const ROUNDING: f64 = 1e-6;
    let exact = coordinate_angstrom / spacing_angstrom;
    let whole = exact.round();
    // Relative, as far from zero the quotient itself is rounded.
    let is_whole = (exact - whole).abs() <= ROUNDING * exact.abs().max(1.0);
    if !is_whole || whole.abs() > f64::from(i32::MAX) {
        return Err(IoError::Unwritable {
            cause: format!(
                "a CCP4 map cannot begin at {coordinate_angstrom} Å, which is no multiple of its \
                 spacing, {spacing_angstrom} Å"
            ),
            remedy: "write an MRC file, or values at multiples of the spacing".into(),
        });
    }
    Ok(whole as i32)
}

fn with_values(mut bytes: Vec<u8>, volume: &Volume) -> Vec<u8> {
    bytes.reserve(4 * volume.values.len());
    for value in &volume.values {
        bytes.extend((*value as f32).to_le_bytes());
    }
    bytes
}

/// The header without a place: words of four bytes, numbered from one as in the description of the
/// format.
fn header(label: &str, volume: &Volume) -> Vec<u8> {
    const FLOATS: i32 = 2;
    const VERSION: i32 = 20140;
    const LITTLE_ENDIAN: [u8; 4] = [0x44, 0x44, 0, 0];
    // A word that is not set is zero: mode, start and origin included.
    let mut header = vec![0; HEADER_BYTES];
    for axis in 0..3 {
        let points = volume.shape[axis];
        // NX, NY, NZ are words 1 to 3, the sampling MX, MY, MZ words 8 to 10.
        put(&mut header, 1 + axis, whole(points));
        put(&mut header, 8 + axis, whole(points));
        let length = points as f64 * volume.spacing_angstrom;
        // CELLA: the length of all intervals of the cell, as many as points.
        put(&mut header, 11 + axis, real(length));
        // CELLB: right angles.
        put(&mut header, 14 + axis, real(90.0));
        // MAPC, MAPR, MAPS: columns along x, rows along y, sections along z.
        put(&mut header, 17 + axis, whole(axis + 1));
    }
    let statistics = Statistics::from_values(&volume.values);
    put(&mut header, 4, FLOATS.to_le_bytes());
    put(&mut header, 20, real(statistics.least));
    put(&mut header, 21, real(statistics.greatest));
    put(&mut header, 22, real(statistics.mean));
    // ISPG 1: one volume, no stack of images.
    put(&mut header, 23, whole(1));
    put(&mut header, 28, VERSION.to_le_bytes());
    put(&mut header, 53, *b"MAP ");
    put(&mut header, 54, LITTLE_ENDIAN);
    put(&mut header, 55, real(statistics.deviation));
    // NLABL: one label follows.
    put(&mut header, 56, whole(1));
    let mut text: Vec<u8> = label.bytes().filter(u8::is_ascii).collect();
    text.resize(LABEL_BYTES, b' ');
    // LABEL, words 57 onwards.
    header[224..224 + LABEL_BYTES].copy_from_slice(&text);
    header
}

fn put(header: &mut [u8], word: usize, bytes: [u8; 4]) {
    header[4 * (word - 1)..4 * word].copy_from_slice(&bytes);
}

fn whole(value: usize) -> [u8; 4] {
    (value as i32).to_le_bytes()
}

fn real(value: f64) -> [u8; 4] {
    (value as f32).to_le_bytes()
}

struct Statistics {
    least: f64,
    greatest: f64,
    mean: f64,
    /// Root mean square deviation from the mean.
    deviation: f64,
}

impl Statistics {
    fn from_values(values: &[f64]) -> Self {
        let count = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / count;
        let mut statistics = Self {
            least: f64::INFINITY,
            greatest: f64::NEG_INFINITY,
            mean,
            deviation: 0.0,
        };
        let mut squares = 0.0;
        for &value in values {
            statistics.least = statistics.least.min(value);
            statistics.greatest = statistics.greatest.max(value);
            squares += (value - mean).powi(2);
        }
        statistics.deviation = (squares / count).sqrt();
        statistics
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(first_x: f64) -> Volume {
        Volume {
            shape: [2, 1, 3],
            origin_angstrom: [first_x, 0.0, 0.3 * 7.0],
            spacing_angstrom: 0.3,
            values: vec![1.0, 2.0, -3.0, 4.0, 5.0, 6.0],
        }
    }

    fn words(bytes: &[u8]) -> Vec<[u8; 4]> {
        bytes.as_chunks().0.to_vec()
    }

    fn whole(bytes: &[u8], first: usize) -> [i32; 3] {
        [0, 1, 2].map(|axis| i32::from_le_bytes(words(bytes)[first + axis - 1]))
    }

    fn real(bytes: &[u8], first: usize) -> [f32; 3] {
        [0, 1, 2].map(|axis| f32::from_le_bytes(words(bytes)[first + axis - 1]))
    }

    #[test]
    fn a_file_states_its_first_point_once() {
        let mrc = write_mrc("potential", &volume(-15.75));
        assert_eq!(whole(&mrc, 5), [0; 3]);
        assert_eq!(real(&mrc, 50), [-15.75, 0.0, 2.1]);
        let ccp4 = write_ccp4("potential", &volume(-15.6)).unwrap();
        assert_eq!(whole(&ccp4, 5), [-52, 0, 7]);
        assert_eq!(real(&ccp4, 50), [0.0; 3]);
        for bytes in [&mrc, &ccp4] {
            // Points, intervals, and a cell of as many spacings.
            assert_eq!(whole(bytes, 1), [2, 1, 3]);
            assert_eq!(whole(bytes, 8), [2, 1, 3]);
            assert_eq!(real(bytes, 11), [0.6, 0.3, 0.9]);
            assert_eq!(real(bytes, 257), [1.0, 2.0, -3.0]);
        }
        let refused = write_ccp4("potential", &volume(-15.75)).unwrap_err();
        assert!(refused.to_string().contains("-15.75 Å"), "{refused}");
    }
}
