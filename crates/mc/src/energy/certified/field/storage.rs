//! The field as bytes, little-endian:
//!
//! | bytes | |
//! |---|---|
//! | 8 | edge of a cube, f64 |
//! | 24 | lower corner, f64 |
//! | 24 | cubes along each axis, u64 |
//! | 8 | polynomials P, u64 |
//! | 4 each | the polynomial at each place of the grid, u32 |
//! | 224 P | coefficients without their padding, f32 |
//! | 4 P | error bounds, f32 |

use super::{
    COEFFICIENTS, Coefficients, DEGREE, DIVIDE_ABOVE, DIVIDED, NO_CUBE, SAFETY, SAMPLES,
    SmoothField,
};
use std::io::{Error, ErrorKind, Read, Result, Write};

/// Room reserved before anything is read, entries: a length that is wrong cannot ask for more
/// memory than the file is long.
const RESERVED: usize = 1 << 16;

impl SmoothField {
    /// The constants that shape a field.
    pub(in super::super) const PARAMETERS: [f64; 4] =
        [DEGREE as f64, SAMPLES as f64, SAFETY, DIVIDE_ABOVE];

    /// Writes the field.
    pub(in super::super) fn write_to(&self, writer: &mut impl Write) -> Result<()> {
        for number in std::iter::once(self.edge).chain(self.corner) {
            writer.write_all(&number.to_le_bytes())?;
        }
        for count in self.counts.into_iter().chain([self.coefficients.len()]) {
            writer.write_all(&(count as u64).to_le_bytes())?;
        }
        for cube in &self.cubes {
            writer.write_all(&cube.to_le_bytes())?;
        }
        let coefficients = self
            .coefficients
            .iter()
            .flat_map(|cube| cube.0.iter().take(COEFFICIENTS));
        for number in coefficients.chain(&self.errors) {
            writer.write_all(&number.to_le_bytes())?;
        }
        Ok(())
    }

    /// Reads a field. Whatever the bytes say, using the result does not panic.
    pub(in super::super) fn read_from(reader: &mut impl Read) -> Result<Self> {
        let edge = f64::from_le_bytes(array(reader)?);
        let mut corner = [0.0; 3];
        for number in &mut corner {
            *number = f64::from_le_bytes(array(reader)?);
        }
        let mut counts = [0; 3];
        for count in &mut counts {
            *count = length(reader)?;
        }
        let polynomials = length(reader)?;
        let [x, y, z] = counts;
        let places = x
            .checked_mul(y)
            .and_then(|xy| xy.checked_mul(z))
            .ok_or_else(|| bad("the grid is too large"))?;
        let mut cubes = Vec::with_capacity(places.min(RESERVED));
        for _ in 0..places {
            let cube = u32::from_le_bytes(array(reader)?);
            let last = if cube & DIVIDED != 0 {
                (cube & !DIVIDED) as usize + 7
            } else {
                cube as usize
            };
            if cube != NO_CUBE && last >= polynomials {
                return Err(bad("a cube has no polynomial"));
            }
            cubes.push(cube);
        }
        let mut coefficients = Vec::with_capacity(polynomials.min(RESERVED));
        for _ in 0..polynomials {
            let bytes: [u8; 4 * COEFFICIENTS] = array(reader)?;
            let mut cube = Coefficients([0.0; super::PADDED]);
            for (number, bytes) in cube.0.iter_mut().zip(bytes.as_chunks::<4>().0) {
                *number = f32::from_le_bytes(*bytes);
            }
            coefficients.push(cube);
        }
        let mut errors = Vec::with_capacity(polynomials.min(RESERVED));
        for _ in 0..polynomials {
            errors.push(f32::from_le_bytes(array(reader)?));
        }
        Ok(Self {
            edge,
            corner,
            counts,
            cubes,
            coefficients,
            errors,
        })
    }
}

fn array<const N: usize>(reader: &mut impl Read) -> Result<[u8; N]> {
    let mut bytes = [0; N];
    reader.read_exact(&mut bytes)?;
    Ok(bytes)
}

fn length(reader: &mut impl Read) -> Result<usize> {
    usize::try_from(u64::from_le_bytes(array(reader)?)).map_err(|_| bad("a length is too large"))
}

fn bad(what: &str) -> Error {
    Error::new(ErrorKind::InvalidData, what)
}
