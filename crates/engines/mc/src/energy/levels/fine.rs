//! The fine series of a cell: 155 of the 6³ coefficients, in six lines of the processor's cache.
//!
//! A vector holds the coefficients of sixteen products T_i(x) T_j(y) and one order in z: those with
//! i + j ≤ 4 for all six orders, the next sixteen for four. What is left out is smaller than what
//! comes after the sixth order. Low orders are in single precision, the others in 16 bits.

use super::lanes::BLOCK;
use protomer_kernel::fused::add;

/// Points of a fine series along each axis.
pub(super) const FINE: usize = 6;

/// Products with i + j ≤ 4.
const LOW: usize = 15;
/// The lane after them, which holds a unit.
const UNIT: usize = LOW;
/// Orders in z of the products after those.
const HIGH_ORDERS: usize = 4;

/// The coefficients of a cell, kT/e.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(super) struct Fine {
    /// Orders 0 and 1 in z of the low products, each with a unit in its last lane: that of order 2,
    /// and that of all others.
    pub leading: [[f32; BLOCK]; 2],
    /// Orders 2 to 5 of the low products.
    pub low: [[i16; BLOCK]; FINE - 2],
    /// Orders 0 to 3 of the high products.
    pub high: [[i16; BLOCK]; HIGH_ORDERS],
}

impl Fine {
    /// The fine series from all 6³ coefficients; x runs fastest, then y, then z.
    pub fn new(series: &[f64]) -> Self {
        // All coefficients: i + 6 (j + 6 k).
        let coefficient = |[i, j]: [usize; 2], k: usize| series[i + FINE * (j + FINE * k)] as f32;
        let low = |k: usize| {
            PRODUCTS[..LOW]
                .iter()
                .map(move |product| coefficient(*product, k))
        };
        let high = |k: usize| {
            PRODUCTS[LOW..]
                .iter()
                .map(move |product| coefficient(*product, k))
        };
        let others = (3..FINE)
            .flat_map(low)
            .chain((0..HIGH_ORDERS).flat_map(high));
        // Two units: order 2 is much larger than what follows and would spoil its 16 bits.
        let units = [unit(low(2)), unit(others)];
        Self {
            leading: [0, 1].map(|k| row(low(k).chain([units[k]]), |value| value)),
            low: [2, 3, 4, 5].map(|k| row(low(k), in_units(units[usize::from(k > 2)]))),
            high: [0, 1, 2, 3].map(|k| row(high(k), in_units(units[1]))),
        }
    }

    /// Whether a coefficient is kept.
    pub fn keeps([i, j, k]: [usize; 3]) -> bool {
        match PRODUCTS.iter().position(|product| *product == [i, j]) {
            Some(place) => place < LOW || k < HIGH_ORDERS,
            None => false,
        }
    }

    /// A coefficient; zero if it is not kept.
    pub fn coefficient(&self, [i, j, k]: [usize; 3]) -> f32 {
        let Some(place) = PRODUCTS.iter().position(|product| *product == [i, j]) else {
            return 0.0;
        };
        let unit = self.leading[usize::from(place >= LOW || k != 2)][UNIT];
        match place.checked_sub(LOW) {
            None if k < 2 => self.leading[k][place],
            None => f32::from(self.low[k - 2][place]) * unit,
            Some(lane) if k < HIGH_ORDERS => f32::from(self.high[k][lane]) * unit,
            Some(_) => 0.0,
        }
    }

    /// Adds `charge` times the potential at a place of the cell to the sum of the lanes. `FUSED`:
    /// where multiply-add is one instruction.
    #[inline(always)]
    pub fn add<const FUSED: bool>(&self, [x, y, z]: [f32; 3], charge: f32, sum: &mut [f32; BLOCK]) {
        let [unit_2, unit] = [self.leading[0][UNIT], self.leading[1][UNIT]];
        let (xx, yy, zz) = (x * x, y * y, z * z);
        // T_2 to T_5 of z; the units of the rows are multiplied in once here.
        let (z2, z3) = (2.0 * zz - 1.0, z * (4.0 * zz - 3.0));
        let z4 = 2.0 * z * z3 - z2;
        let z5 = 2.0 * z * z4 - z3;
        let (low_z, high_z) = (
            [z2 * unit_2, z3 * unit, z4 * unit, z5 * unit],
            [unit, z * unit, z2 * unit, z3 * unit],
        );
        // All of z first: the sum over orders has one chain for low products and one for high ones.
        for lane in 0..BLOCK {
            let mut low = add::<FUSED>(self.leading[1][lane], z, self.leading[0][lane]);
            low = add::<FUSED>(f32::from(self.low[0][lane]), low_z[0], low);
            low = add::<FUSED>(f32::from(self.low[1][lane]), low_z[1], low);
            low = add::<FUSED>(f32::from(self.low[2][lane]), low_z[2], low);
            low = add::<FUSED>(f32::from(self.low[3][lane]), low_z[3], low);
            let mut high = f32::from(self.high[0][lane]) * high_z[0];
            high = add::<FUSED>(f32::from(self.high[1][lane]), high_z[1], high);
            high = add::<FUSED>(f32::from(self.high[2][lane]), high_z[2], high);
            high = add::<FUSED>(f32::from(self.high[3][lane]), high_z[3], high);
            let low_product =
                LOW_X.evaluate::<FUSED>(lane, x, xx) * LOW_Y.evaluate::<FUSED>(lane, y, yy);
            let high_product =
                HIGH_X.evaluate::<FUSED>(lane, x, xx) * HIGH_Y.evaluate::<FUSED>(lane, y, yy);
            // T_i(x) T_j(y) last, one product per lane.
            let potential = add::<FUSED>(high, high_product, low * low_product);
            sum[lane] = add::<FUSED>(potential, charge, sum[lane]);
        }
    }
}

fn unit(values: impl Iterator<Item = f32>) -> f32 {
    // Never zero, so the division of empty rows is defined.
    let largest = values.fold(f32::MIN_POSITIVE, |most, value| most.max(value.abs()));
    largest / f32::from(i16::MAX)
}

fn in_units(unit: f32) -> impl Fn(f32) -> i16 {
    move |value| (value / unit).round() as i16
}

fn row<T: Copy + Default>(
    values: impl Iterator<Item = f32>,
    stored: impl Fn(f32) -> T,
) -> [T; BLOCK] {
    let mut row = [T::default(); BLOCK];
    for (place, value) in row.iter_mut().zip(values) {
        *place = stored(value);
    }
    row
}

/// The orders in x and y of the products, lowest total first.
const PRODUCTS: [[usize; 2]; LOW + BLOCK] = products();

const fn products() -> [[usize; 2]; LOW + BLOCK] {
    let (mut products, mut count, mut total) = ([[0; 2]; LOW + BLOCK], 0, 0);
    // Of a total of eight, 4 + 4 comes first.
    while total < 2 * FINE {
        let mut step = 0;
        while step < FINE {
            let j = (total / 2 + step) % FINE;
            if j <= total && total - j < FINE && count < products.len() {
                products[count] = [total - j, j];
                count += 1;
            }
            step += 1;
        }
        total += 1;
    }
    products
}

/// T_n of one coordinate in each lane, as (odd t + even) (a t⁴ + b t² + c).
struct Functions {
    odd: [f32; BLOCK],
    even: [f32; BLOCK],
    fourth: [f32; BLOCK],
    square: [f32; BLOCK],
    constant: [f32; BLOCK],
}

/// Odd, even, a, b and c of T_0 to T_5.
const FACTORS: [[f32; 5]; FINE] = [
    [0.0, 1.0, 0.0, 0.0, 1.0],
    [1.0, 0.0, 0.0, 0.0, 1.0],
    [0.0, 1.0, 0.0, 2.0, -1.0],
    [1.0, 0.0, 0.0, 4.0, -3.0],
    [0.0, 1.0, 8.0, -8.0, 1.0],
    [1.0, 0.0, 16.0, -20.0, 5.0],
];

const LOW_X: Functions = Functions::from_axis(0, LOW, 0);
const LOW_Y: Functions = Functions::from_axis(0, LOW, 1);
const HIGH_X: Functions = Functions::from_axis(LOW, BLOCK, 0);
const HIGH_Y: Functions = Functions::from_axis(LOW, BLOCK, 1);

impl Functions {
    /// Functions of `count` products from `first` on; the other lanes are zero.
    const fn from_axis(first: usize, count: usize, axis: usize) -> Self {
        let mut functions = Self {
            odd: [0.0; BLOCK],
            even: [0.0; BLOCK],
            fourth: [0.0; BLOCK],
            square: [0.0; BLOCK],
            constant: [0.0; BLOCK],
        };
        let mut lane = 0;
        while lane < count {
            let [odd, even, fourth, square, constant] = FACTORS[PRODUCTS[first + lane][axis]];
            functions.odd[lane] = odd;
            functions.even[lane] = even;
            functions.fourth[lane] = fourth;
            functions.square[lane] = square;
            functions.constant[lane] = constant;
            lane += 1;
        }
        functions
    }

    #[inline(always)]
    fn evaluate<const FUSED: bool>(&self, lane: usize, t: f32, square: f32) -> f32 {
        let odd_or_even = add::<FUSED>(self.odd[lane], t, self.even[lane]);
        let series = add::<FUSED>(self.fourth[lane], square, self.square[lane]);
        odd_or_even * add::<FUSED>(series, square, self.constant[lane])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn orders() -> impl Iterator<Item = [usize; 3]> {
        (0..FINE.pow(3)).map(|place| [place % FINE, place / FINE % FINE, place / (FINE * FINE)])
    }

    /// Coefficients that fall with their order, as those of smooth functions do.
    fn series() -> Vec<f64> {
        let coefficient = |[i, j, k]: [usize; 3]| {
            ((i + 7 * j + 31 * k) as f64).sin() * 0.2_f64.powi((i + j + k) as i32)
        };
        orders().map(coefficient).collect()
    }

    #[test]
    fn kept_coefficients_are_the_series_to_half_a_unit() {
        let series = series();
        let fine = Fine::new(&series);
        let units = fine.leading.map(|row| f64::from(row[UNIT]));
        assert!(units[0] < 2e-6 && units[1] < 5e-7, "{units:?}");
        let mut kept = 0;
        for (orders, expected) in orders().zip(series) {
            let unit = units[usize::from(orders[2] != 2)].max(1e-8);
            if Fine::keeps(orders) {
                let error = f64::from(fine.coefficient(orders)) - expected;
                assert!(error.abs() <= 0.501 * unit, "{orders:?} {error}");
                kept += 1;
            } else {
                assert_eq!(fine.coefficient(orders), 0.0);
                assert!(orders.into_iter().sum::<usize>() >= 8, "{orders:?}");
            }
        }
        assert_eq!(kept, LOW * FINE + BLOCK * HIGH_ORDERS);
    }

    #[test]
    fn the_sum_of_the_lanes_is_the_chebyshev_series() {
        let fine = Fine::new(&series());
        let chebyshev = |n: usize, t: f32| (n as f64 * f64::from(t).acos()).cos();
        for place in [[0.3, -0.8, 0.1], [-1.0, 1.0, 0.9], [0.0, 0.5, -0.6]] {
            let term = |orders: [usize; 3]| {
                let polynomials = |axis: usize| chebyshev(orders[axis], place[axis]);
                f64::from(fine.coefficient(orders))
                    * polynomials(0)
                    * polynomials(1)
                    * polynomials(2)
            };
            let expected = 0.7 * orders().map(term).sum::<f64>();
            let mut sum = [0.0; BLOCK];
            fine.add::<false>(place, 0.7, &mut sum);
            let found: f64 = sum.iter().map(|lane| f64::from(*lane)).sum();
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
    }
}
