//! Evaluates the series of a field's cells: coarse and fine potentials, and derivatives.
//!
//! A series in T_0 to T_3 along x, y and z has a row of 15 products of x and y for each order of z, a
//! lane of a vector unit for each product; the last lane holds coefficients of T_4.

use super::field::{Field, Spots};
use super::lanes::{BLOCK, sum_of_lanes};
use super::packed::{COARSE, LAST, Packed};
use crate::energy::fused::add;

/// The potential at a place (kT/e) with its first and second derivatives (per Å and Å²).
#[derive(Debug, Clone, Copy)]
pub(super) struct Derivatives {
    pub value: f32,
    pub gradient: [f32; 3],
    /// By xx, yy, zz, xy, xz and yz.
    pub second: [f32; 6],
}

impl Field {
    /// Adds charge times coarse potential of each spot to the lanes of `sum`. `FUSED`: where
    /// multiply-add is one instruction.
    #[inline(always)]
    pub fn add_coarse<const FUSED: bool>(
        &self,
        spots: &Spots,
        charge: &[f32; BLOCK],
        sum: &mut [f32; BLOCK],
    ) {
        let (mut first, mut unit) = ([0.0; BLOCK], [0.0; BLOCK]);
        let mut fourth = [[0_i16; BLOCK]; 3];
        for point in 0..BLOCK {
            let cell = spots.cell[point] as usize;
            let (series, head) = (&self.coarse[cell], &self.heads[cell]);
            let Packed(rows) = series;
            let [x, y, z] = [0, 1, 2].map(|axis| spots.at[axis][point]);
            (first[point], unit[point]) = (head.first, head.unit);
            let [of_x, of_y, of_z] = series.fourth();
            (fourth[0][point], fourth[1][point], fourth[2][point]) = (of_x, of_y, of_z);
            let charge = charge[point] * head.unit;
            let (xx, yy, zz) = (x * x, y * y, z * z);
            let (z2, z3) = (2.0 * zz - 1.0, z * (4.0 * zz - 3.0));
            for lane in 0..BLOCK {
                let mut value = f32::from(rows[0][lane]);
                value = add::<FUSED>(f32::from(rows[1][lane]), z, value);
                value = add::<FUSED>(f32::from(rows[2][lane]), z2, value);
                value = add::<FUSED>(f32::from(rows[3][lane]), z3, value);
                // T_0 to T_3 are products of 1 or x with 1, 2x² - 1 or 4x² - 3.
                let of_x = add::<FUSED>(ODD_X[lane], x, EVEN_X[lane])
                    * add::<FUSED>(SLOPE_X[lane], xx, SHIFT_X[lane]);
                let of_y = add::<FUSED>(ODD_Y[lane], y, EVEN_Y[lane])
                    * add::<FUSED>(SLOPE_Y[lane], yy, SHIFT_Y[lane]);
                sum[lane] = add::<FUSED>(value, of_x * (of_y * charge), sum[lane]);
            }
        }
        let mut of_fourth = [0.0; BLOCK];
        for (fourth, at) in fourth.iter().zip(&spots.at) {
            for lane in 0..BLOCK {
                let second = add::<FUSED>(2.0 * at[lane], at[lane], -1.0);
                let t4 = add::<FUSED>(2.0 * second, second, -1.0);
                of_fourth[lane] = add::<FUSED>(f32::from(fourth[lane]), t4, of_fourth[lane]);
            }
        }
        for lane in 0..BLOCK {
            let potential = add::<FUSED>(of_fourth[lane], unit[lane], first[lane]);
            sum[lane] = add::<FUSED>(charge[lane], potential, sum[lane]);
        }
    }

    /// The coarse potential at the spot of a lane with its derivatives; `None` in no cell.
    #[inline(always)]
    pub fn derivatives<const FUSED: bool>(
        &self,
        spots: &Spots,
        lane: usize,
    ) -> Option<Derivatives> {
        let (cell, edge) = (spots.cell[lane] as usize, spots.edge[lane]);
        let [x, y, z] = [0, 1, 2].map(|axis| spots.at[axis][lane]);
        let (series, head) = (self.coarse.get(cell)?, self.heads.get(cell)?);
        let Packed(rows) = series;
        let of_z = chebyshev_derivatives(z).map(|order| order.map(|value| value * head.unit));
        let mut along_z = [[0.0; BLOCK]; 3];
        for (row, z) in rows.iter().zip(0..) {
            for (sum, of_z) in along_z.iter_mut().zip(&of_z) {
                for lane in 0..BLOCK {
                    sum[lane] = add::<FUSED>(f32::from(row[lane]), of_z[z], sum[lane]);
                }
            }
        }
        let mut products = [[0.0; BLOCK]; 10];
        let [z0, z1, z2] = along_z;
        for lane in 0..BLOCK {
            let [x0, x1, x2] = LANES_X.at::<FUSED>(lane, x);
            let [y0, y1, y2] = LANES_Y.at::<FUSED>(lane, y);
            let (xy, xz, yz) = (x0 * y0, x0 * z0[lane], y0 * z0[lane]);
            products[0][lane] = xy * z0[lane];
            products[1][lane] = x1 * yz;
            products[2][lane] = y1 * xz;
            products[3][lane] = xy * z1[lane];
            products[4][lane] = x2 * yz;
            products[5][lane] = y2 * xz;
            products[6][lane] = xy * z2[lane];
            products[7][lane] = x1 * y1 * z0[lane];
            products[8][lane] = x1 * y0 * z1[lane];
            products[9][lane] = x0 * y1 * z1[lane];
        }
        let [mut value, gx, gy, gz, mut second @ ..] = sums_of_lanes(&products);
        let mut gradient = [gx, gy, gz];
        for (axis, (coefficient, t)) in series.fourth().into_iter().zip([x, y, z]).enumerate() {
            let (coefficient, square) = (f32::from(coefficient) * head.unit, t * t);
            value += coefficient * (8.0 * square * (square - 1.0) + 1.0);
            gradient[axis] += coefficient * t * (32.0 * square - 16.0);
            second[axis] += coefficient * (96.0 * square - 16.0);
        }
        let scale = 2.0 / edge;
        Some(Derivatives {
            value: head.first + value,
            gradient: gradient.map(|g| g * scale),
            second: second.map(|h| h * (scale * scale)),
        })
    }

    /// Charge times fine potential of each spot, summed.
    #[inline(always)]
    pub fn fine<const FUSED: bool>(&self, spots: &Spots, charge: &[f32; BLOCK]) -> f64 {
        let mut sum = [0.0; BLOCK];
        for point in 0..BLOCK {
            let at = [0, 1, 2].map(|axis| spots.at[axis][point]);
            self.fine[spots.cell[point] as usize].add::<FUSED>(at, charge[point], &mut sum);
        }
        sum.iter().map(|lane| f64::from(*lane)).sum()
    }
}

/// T_0 to T_3 at t, their first and their second derivatives.
#[inline(always)]
fn chebyshev_derivatives(t: f32) -> [[f32; COARSE]; 3] {
    [
        [1.0, t, 2.0 * t * t - 1.0, t * (4.0 * t * t - 3.0)],
        [0.0, 1.0, 4.0 * t, 12.0 * t * t - 3.0],
        [0.0, 0.0, 4.0, 24.0 * t],
    ]
}

/// In each lane a function of one coordinate as (a t² + b t + c) (d t + e), with its derivatives.
struct Lanes {
    value: [[f32; BLOCK]; 4],
    first: [[f32; BLOCK]; 3],
    second: [[f32; BLOCK]; 2],
}

static LANES_X: Lanes = Lanes {
    value: [ODD_X, EVEN_X, SLOPE_X, SHIFT_X],
    first: [
        along_x([0.0, 0.0, 0.0, 12.0]),
        along_x([0.0, 0.0, 4.0, 0.0]),
        along_x([0.0, 1.0, 0.0, -3.0]),
    ],
    second: [
        along_x([0.0, 0.0, 0.0, 24.0]),
        along_x([0.0, 0.0, 4.0, 0.0]),
    ],
};
static LANES_Y: Lanes = Lanes {
    value: [ODD_Y, EVEN_Y, SLOPE_Y, SHIFT_Y],
    first: [
        along_y([0.0, 0.0, 0.0, 12.0]),
        along_y([0.0, 0.0, 4.0, 0.0]),
        along_y([0.0, 1.0, 0.0, -3.0]),
    ],
    second: [
        along_y([0.0, 0.0, 0.0, 24.0]),
        along_y([0.0, 0.0, 4.0, 0.0]),
    ],
};

impl Lanes {
    /// The function of a lane at t, with its first and second derivatives.
    #[inline(always)]
    fn at<const FUSED: bool>(&self, lane: usize, t: f32) -> [f32; 3] {
        let [odd, even, slope, shift] = &self.value;
        let [square, linear, constant] = &self.first;
        let [second, at_zero] = &self.second;
        [
            add::<FUSED>(odd[lane], t, even[lane]) * add::<FUSED>(slope[lane], t * t, shift[lane]),
            add::<FUSED>(
                add::<FUSED>(square[lane], t, linear[lane]),
                t,
                constant[lane],
            ),
            add::<FUSED>(second[lane], t, at_zero[lane]),
        ]
    }
}

/// The sums. By itself, since compilers make much worse code of it within a longer function.
#[inline(never)]
fn sums_of_lanes(lanes: &[[f32; BLOCK]; 10]) -> [f32; 10] {
    lanes.each_ref().map(sum_of_lanes)
}

const ODD: [f32; 4] = [0.0, 1.0, 0.0, 1.0];
const EVEN: [f32; 4] = [1.0, 0.0, 1.0, 0.0];
const SLOPE: [f32; 4] = [0.0, 0.0, 2.0, 4.0];
const SHIFT: [f32; 4] = [1.0, 1.0, -1.0, -3.0];
const ODD_X: [f32; BLOCK] = along_x(ODD);
const EVEN_X: [f32; BLOCK] = along_x(EVEN);
const SLOPE_X: [f32; BLOCK] = along_x(SLOPE);
const SHIFT_X: [f32; BLOCK] = along_x(SHIFT);
const ODD_Y: [f32; BLOCK] = along_y(ODD);
const EVEN_Y: [f32; BLOCK] = along_y(EVEN);
const SLOPE_Y: [f32; BLOCK] = along_y(SLOPE);
const SHIFT_Y: [f32; BLOCK] = along_y(SHIFT);

/// Lane 4 j + i has the value of i.
const fn along_x(of: [f32; 4]) -> [f32; BLOCK] {
    let mut lanes = [0.0; BLOCK];
    let mut lane = 0;
    while lane < BLOCK {
        lanes[lane] = of[lane % COARSE];
        lane += 1;
    }
    lanes
}

/// Lane 4 j + i has the value of j; the last one zero, since no product is there.
const fn along_y(of: [f32; 4]) -> [f32; BLOCK] {
    let mut lanes = [0.0; BLOCK];
    let mut lane = 0;
    while lane < BLOCK {
        lanes[lane] = if lane == LAST { 0.0 } else { of[lane / COARSE] };
        lane += 1;
    }
    lanes
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::field::tests::{field, places};
    use super::BLOCK;

    #[test]
    fn derivatives_are_those_of_differences() {
        let field = field();
        let step = 0.01;
        let mut compared = 0;
        for place in places(400) {
            let at = |shift: [f32; 3]| {
                let moved = [0, 1, 2].map(|axis| place[axis] + step * shift[axis]);
                let spots = field.locate(&moved.map(|x| [x; BLOCK])).unwrap();
                (
                    spots.cell[7],
                    field.derivatives::<false>(&spots, 7).unwrap(),
                )
            };
            let (cell, here) = at([0.0; 3]);
            for axis in 0..3 {
                let mut shift = [0.0; 3];
                shift[axis] = 1.0;
                let (above_cell, above) = at(shift);
                let (below_cell, below) = at(shift.map(|x| -x));
                // Derivatives jump from cell to cell.
                if above_cell != cell || below_cell != cell {
                    continue;
                }
                compared += 1;
                let slope = (above.value - below.value) / (2.0 * step);
                let size = here.gradient.map(f32::abs).iter().sum::<f32>() + 1e-3;
                assert!((slope - here.gradient[axis]).abs() < 0.01 * size + 1e-3);
                let curvature = (above.gradient[axis] - below.gradient[axis]) / (2.0 * step);
                let size = here.second.map(f32::abs).iter().sum::<f32>();
                assert!((curvature - here.second[axis]).abs() < 0.01 * size + 1e-4);
                let mixed = |a: usize, b: usize| [[0, 3, 4], [3, 1, 5], [4, 5, 2]][a][b];
                let other = (axis + 1) % 3;
                let curvature = (above.gradient[other] - below.gradient[other]) / (2.0 * step);
                assert!((curvature - here.second[mixed(axis, other)]).abs() < 0.01 * size + 1e-4);
            }
        }
        assert!(compared > 600, "{compared}");
    }
}
