//! The coarse series of a cell in two lines of the processor's cache.
//!
//! Decisions read the cells of hundreds of places each, most of which come from far memory. Hence
//! 16 bits for a coefficient, in units of the cell, but the mean of the cell in single precision.

use super::fine::Fine;

/// Points of a coarse series along each axis.
pub(super) const COARSE: usize = 4;
/// x and y run within a row, z from row to row.
const ROW: usize = COARSE * COARSE;

/// The coefficients of a coarse series without the first, in units of [`Head::unit`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(128))]
pub(super) struct Packed(pub [[i16; ROW]; COARSE]);

/// What the coefficients of a cell are multiples of, and the first of them, kT/e.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Head {
    pub first: f32,
    pub unit: f32,
}

/// Those of the first 4³ coefficients that a fine series has.
pub(super) fn pack(fine: &Fine) -> (Head, Packed) {
    let mut rows = [[0.0_f32; ROW]; COARSE];
    for (z, row) in rows.iter_mut().enumerate() {
        for (place, value) in row.iter_mut().enumerate() {
            *value = fine.coefficient([place % COARSE, place / COARSE, z]);
        }
    }
    let first = std::mem::take(&mut rows[0][0]);
    let largest = rows
        .as_flattened()
        .iter()
        .fold(f32::MIN_POSITIVE, |most, value| most.max(value.abs()));
    let unit = largest / f32::from(i16::MAX);
    let packed = rows.map(|row| row.map(|value| (value / unit).round() as i16));
    (Head { first, unit }, Packed(packed))
}

#[cfg(test)]
mod tests {
    use super::super::fine::FINE;
    use super::*;

    #[test]
    fn coefficients_are_kept_to_half_a_unit() {
        let series: Vec<f64> = (0..FINE.pow(3))
            .map(|place| 3.0 * (place as f64).sin() / (1.0 + place as f64))
            .collect();
        let fine = Fine::new(&series);
        let (head, Packed(rows)) = pack(&fine);
        assert_eq!(head.first, fine.coefficient([0; 3]));
        for (z, row) in rows.iter().enumerate() {
            for (place, value) in row.iter().enumerate().skip(usize::from(z == 0)) {
                let wanted = fine.coefficient([place % COARSE, place / COARSE, z]);
                let error = f32::from(*value) * head.unit - wanted;
                assert!(
                    error.abs() <= 0.5001 * head.unit,
                    "{error} of {}",
                    head.unit
                );
            }
        }
    }
}
