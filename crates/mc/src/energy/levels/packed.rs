//! The coarse series of a cell in two lines of the processor's cache.
//!
//! Decisions read the cells of hundreds of places each, most of which come from far memory. Hence
//! 16 bits for a coefficient, in units of the cell. T_3(x) T_3(y) is left out, whose coefficients are
//! of the sixth order and above: the mean of the cell and the unit, in single precision, are in its
//! lane.

use super::fine::Fine;
use super::lanes::BLOCK;

/// Points of a coarse series along each axis.
pub(super) const COARSE: usize = 4;
/// The lane of T_3(x) T_3(y); x and y run within a row, z from row to row.
pub(super) const HEAD: usize = BLOCK - 1;

/// The coefficients of a coarse series without the first, in units, and in the last lane the two
/// halves of what [`first`](Self::first) and [`unit`](Self::unit) return.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(128))]
pub(super) struct Packed(pub [[i16; BLOCK]; COARSE]);

impl Packed {
    /// From those of the coefficients that a fine series has.
    pub fn new(fine: &Fine) -> Self {
        let mut rows = [[0.0_f32; BLOCK]; COARSE];
        for (z, row) in rows.iter_mut().enumerate() {
            for (place, value) in row.iter_mut().enumerate().take(HEAD) {
                *value = fine.coefficient([place % COARSE, place / COARSE, z]);
            }
        }
        let first = std::mem::take(&mut rows[0][0]);
        let largest = rows
            .as_flattened()
            .iter()
            .fold(f32::MIN_POSITIVE, |most, value| most.max(value.abs()));
        let unit = largest / f32::from(i16::MAX);
        let mut packed = rows.map(|row| row.map(|value| (value / unit).round() as i16));
        [packed[0][HEAD], packed[1][HEAD]] = halves(first);
        [packed[2][HEAD], packed[3][HEAD]] = halves(unit);
        Self(packed)
    }

    /// Whether the series has a coefficient.
    pub fn keeps(orders: [usize; 3]) -> bool {
        let [i, j, k] = orders;
        i.max(j).max(k) < COARSE && i + COARSE * j != HEAD
    }

    /// The first coefficient, kT/e.
    #[inline(always)]
    pub fn first(&self) -> f32 {
        whole([self.0[0][HEAD], self.0[1][HEAD]])
    }

    /// What the others are multiples of, kT/e.
    #[inline(always)]
    pub fn unit(&self) -> f32 {
        whole([self.0[2][HEAD], self.0[3][HEAD]])
    }
}

fn halves(number: f32) -> [i16; 2] {
    let bits = number.to_bits();
    [bits as i16, (bits >> 16) as i16]
}

#[inline(always)]
fn whole([low, high]: [i16; 2]) -> f32 {
    f32::from_bits(u32::from(low as u16) | u32::from(high as u16) << 16)
}

#[cfg(test)]
mod tests {
    use super::super::fine::FINE;
    use super::*;

    #[test]
    fn coefficients_are_kept_to_half_a_unit() {
        let series: Vec<f64> = (0..FINE.pow(3))
            .map(|place| -3.0 * (place as f64 + 2.0).sin() / (1.0 + place as f64))
            .collect();
        let fine = Fine::new(&series);
        let packed = Packed::new(&fine);
        assert_eq!(packed.first(), fine.coefficient([0; 3]));
        let mut largest = 0.0_f32;
        for (z, row) in packed.0.iter().enumerate() {
            for (place, value) in row.iter().enumerate().skip(usize::from(z == 0)) {
                let orders = [place % COARSE, place / COARSE, z];
                let wanted = fine.coefficient(orders);
                let error = f32::from(*value) * packed.unit() - wanted;
                if Packed::keeps(orders) {
                    largest = largest.max(wanted.abs());
                    assert!(
                        error.abs() <= 0.5001 * packed.unit(),
                        "{error} of {}",
                        packed.unit()
                    );
                }
            }
        }
        assert_eq!(packed.unit(), largest / f32::from(i16::MAX));
        assert!(!Packed::keeps([3, 3, 0]) && !Packed::keeps([4, 0, 0]));
    }
}
