//! MRC2014 volumes, mode 2 (Cheng et al., J. Struct. Biol. 192, 146 (2015)): 1024 bytes of header,
//! then 32-bit floats with x running fastest.

use super::grid::Volume;

const HEADER_BYTES: usize = 1024;
const LABEL_BYTES: usize = 80;

/// The bytes of a volume; `label` (up to 80 characters of ASCII) says what it holds.
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
    let mut bytes = header(label, volume);
    bytes.reserve(4 * volume.values.len());
    for value in &volume.values {
        bytes.extend((*value as f32).to_le_bytes());
    }
    bytes
}

/// The header: words of four bytes, numbered from one as the format's description does.
fn header(label: &str, volume: &Volume) -> Vec<u8> {
    const FLOATS: i32 = 2;
    const VERSION: i32 = 20140;
    const LITTLE_ENDIAN: [u8; 4] = [0x44, 0x44, 0, 0];
    let mut header = vec![0; HEADER_BYTES];
    for axis in 0..3 {
        let points = volume.shape[axis];
        put(&mut header, 1 + axis, whole(points));
        put(&mut header, 8 + axis, whole(points));
        let length = points as f64 * volume.spacing_angstrom;
        put(&mut header, 11 + axis, real(length));
        put(&mut header, 14 + axis, real(90.0));
        put(&mut header, 17 + axis, whole(axis + 1));
        put(&mut header, 50 + axis, real(volume.origin_angstrom[axis]));
    }
    let statistics = Statistics::of(&volume.values);
    put(&mut header, 4, FLOATS.to_le_bytes());
    put(&mut header, 20, real(statistics.least));
    put(&mut header, 21, real(statistics.greatest));
    put(&mut header, 22, real(statistics.mean));
    put(&mut header, 23, whole(1));
    put(&mut header, 28, VERSION.to_le_bytes());
    put(&mut header, 53, *b"MAP ");
    put(&mut header, 54, LITTLE_ENDIAN);
    put(&mut header, 55, real(statistics.deviation));
    put(&mut header, 56, whole(1));
    let mut text: Vec<u8> = label.bytes().filter(u8::is_ascii).collect();
    text.resize(LABEL_BYTES, b' ');
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
    fn of(values: &[f64]) -> Self {
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
