//! The coarse series of a cell in two lines of the processor's cache, and its head.
//!
//! Decisions read the cells of hundreds of places each, most of which come from far memory. Hence
//! 16 bits for a coefficient, in units of the cell, but the mean of the cell in single precision.
//!
//! A series has the products of T_0 to T_3, and T_4 of each coordinate alone: what is left out is of
//! the fifth order. T_3(x) T_3(y), whose coefficients are of the sixth order and above, gives its lane
//! to the three T_4.

use super::fine::Fine;
use super::lanes::BLOCK;

/// Orders along each axis in products.
pub(super) const COARSE: usize = 4;
/// The lane of T_3(x) T_3(y); x and y run within a row, z from row to row.
pub(super) const LAST: usize = BLOCK - 1;

/// The coefficients of a coarse series without the first, in units of [`Head::unit`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(128))]
pub(super) struct Packed(pub [[i16; BLOCK]; COARSE]);

/// First coefficient of a cell, and the unit of its other coefficients, kT/e.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Head {
    pub first: f32,
    pub unit: f32,
}

/// Packs a coarse series of those of its coefficients that a fine series has.
pub(super) fn pack(fine: &Fine) -> (Head, Packed) {
    let mut rows = [[0.0_f32; BLOCK]; COARSE];
    for (z, row) in rows.iter_mut().enumerate() {
        for (lane, value) in row.iter_mut().enumerate() {
            *value = orders(lane, z).map_or(0.0, |orders| fine.coefficient(orders));
        }
    }
    // The mean is much larger than the rest and would take all 16 bits; it goes into the head.
    let first = std::mem::take(&mut rows[0][0]);
    let largest = rows
        .as_flattened()
        .iter()
        // Not zero, so that an empty cell does not divide by zero.
        .fold(f32::MIN_POSITIVE, |most, value| most.max(value.abs()));
    let unit = largest / f32::from(i16::MAX);
    let packed = rows.map(|row| row.map(|value| (value / unit).round() as i16));
    (Head { first, unit }, Packed(packed))
}

/// Orders of the coefficient that a lane of a row holds.
fn orders(lane: usize, row: usize) -> Option<[usize; 3]> {
    let of_product = [lane % COARSE, lane / COARSE, row];
    match (lane, row) {
        (LAST, 0) => Some([COARSE, 0, 0]),
        (LAST, 1) => Some([0, COARSE, 0]),
        (LAST, 2) => Some([0, 0, COARSE]),
        (LAST, _) => None,
        _ => Some(of_product),
    }
}

impl Packed {
    /// Whether a series has this coefficient.
    pub fn keeps(wanted: [usize; 3]) -> bool {
        let mut places = (0..COARSE).flat_map(|row| (0..BLOCK).map(move |lane| (lane, row)));
        places.any(|(lane, row)| orders(lane, row) == Some(wanted))
    }

    /// The coefficients of T_4(x), T_4(y) and T_4(z).
    #[inline(always)]
    pub fn fourth(&self) -> [i16; 3] {
        [0, 1, 2].map(|row: usize| self.0[row][LAST])
    }
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
        let (head, packed) = pack(&fine);
        assert_eq!(head.first, fine.coefficient([0; 3]));
        for (z, row) in packed.0.iter().enumerate() {
            for (lane, value) in row.iter().enumerate().skip(usize::from(z == 0)) {
                let wanted = orders(lane, z).map_or(0.0, |orders| fine.coefficient(orders));
                let error = f32::from(*value) * head.unit - wanted;
                assert!(
                    error.abs() <= 0.5001 * head.unit,
                    "{error} of {}",
                    head.unit
                );
            }
        }
    }

    #[test]
    fn all_coefficients_up_to_the_fourth_order_but_mixed_ones_are_kept() {
        assert!(
            [[0, 0, 0], [3, 2, 3], [4, 0, 0], [0, 4, 0], [0, 0, 4]].map(Packed::keeps) == [true; 5]
        );
        assert!([[3, 3, 0], [3, 3, 3], [4, 1, 0], [0, 0, 5]].map(Packed::keeps) == [false; 4]);
    }
}
