//! MRC2014 volumes, mode 2 (Cheng et al., J. Struct. Biol. 192, 146 (2015)): 1024 bytes of header,
//! then 32-bit floats with x running fastest.

use super::Volume;

const HEADER_BYTES: usize = 1024;

/// The bytes of a volume; `label` (up to 80 characters of ASCII) says what it holds.
///
/// ```
/// use protomer_io::volume::{Volume, mrc::write_mrc};
/// let volume = Volume { shape: [2, 1, 1], origin_angstrom: [0.0; 3], spacing_angstrom: 0.5, values: vec![1.0, 2.0] };
/// let bytes = write_mrc("potential, kT/e", &volume);
/// assert_eq!(&bytes[208..212], b"MAP ");
/// assert_eq!(bytes.len(), 1024 + 8);
/// ```
pub fn write_mrc(label: &str, volume: &Volume) -> Vec<u8> {
    let mut header = [0_u8; HEADER_BYTES];
    let mut put =
        |word: usize, bytes: [u8; 4]| header[4 * (word - 1)..4 * word].copy_from_slice(&bytes);
    let whole = |x: usize| (x as i32).to_le_bytes();
    let real = |x: f64| (x as f32).to_le_bytes();
    let count = volume.values.len().max(1) as f64;
    let mean = volume.values.iter().sum::<f64>() / count;
    let square = volume
        .values
        .iter()
        .map(|x| (x - mean).powi(2))
        .sum::<f64>()
        / count;
    for axis in 0..3 {
        put(1 + axis, whole(volume.shape[axis]));
        put(8 + axis, whole(volume.shape[axis]));
        put(
            11 + axis,
            real(volume.shape[axis] as f64 * volume.spacing_angstrom),
        );
        put(14 + axis, real(90.0));
        put(17 + axis, whole(axis + 1));
        put(50 + axis, real(volume.origin_angstrom[axis]));
    }
    put(4, whole(2));
    put(
        20,
        real(volume.values.iter().copied().fold(f64::INFINITY, f64::min)),
    );
    put(
        21,
        real(
            volume
                .values
                .iter()
                .copied()
                .fold(f64::NEG_INFINITY, f64::max),
        ),
    );
    put(22, real(mean));
    put(23, whole(1));
    put(28, whole(20140));
    put(53, *b"MAP ");
    put(54, [0x44, 0x44, 0, 0]);
    put(55, real(square.sqrt()));
    put(56, whole(1));
    for (target, byte) in header[224..304].iter_mut().zip(
        label
            .bytes()
            .filter(u8::is_ascii)
            .chain(std::iter::repeat(b' ')),
    ) {
        *target = byte;
    }
    let mut bytes = header.to_vec();
    bytes.reserve(4 * volume.values.len());
    for value in &volume.values {
        bytes.extend((*value as f32).to_le_bytes());
    }
    bytes
}
