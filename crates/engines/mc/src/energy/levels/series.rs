//! Evaluates the series of a field's cells: coarse and fine potentials.
//!
//! A series in T_0 to T_3 along x, y and z has a row of 15 products of x and y for each order of z, a
//! lane of a vector unit for each product; the last lane holds coefficients of T_4.

use super::field::{Field, Spots};
use super::lanes::BLOCK;
use super::packed::{COARSE, LAST, Packed};
use protomer_kernel::fused::add;

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
        // One point at a time, its coefficients in lanes:
        // a cell is two lines of the cache, read once.
        for point in 0..BLOCK {
            let cell = spots.cell[point] as usize;
            let (series, head) = (&self.coarse[cell], &self.heads[cell]);
            let Packed(rows) = series;
            let [x, y, z] = [0, 1, 2].map(|axis| spots.coordinates[axis][point]);
            (first[point], unit[point]) = (head.first, head.unit);
            let [of_x, of_y, of_z] = series.fourth();
            (fourth[0][point], fourth[1][point], fourth[2][point]) = (of_x, of_y, of_z);
            // The unit is taken into the charge: one product per point instead of one per lane.
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
        // T_4 lane by lane over the points now: three terms per point, not worth a row each.
        let mut of_fourth = [0.0; BLOCK];
        for (fourth, coordinates) in fourth.iter().zip(&spots.coordinates) {
            for lane in 0..BLOCK {
                let second = add::<FUSED>(2.0 * coordinates[lane], coordinates[lane], -1.0);
                let t4 = add::<FUSED>(2.0 * second, second, -1.0);
                of_fourth[lane] = add::<FUSED>(f32::from(fourth[lane]), t4, of_fourth[lane]);
            }
        }
        // The mean of the cell, which is not in units.
        for lane in 0..BLOCK {
            let potential = add::<FUSED>(of_fourth[lane], unit[lane], first[lane]);
            sum[lane] = add::<FUSED>(charge[lane], potential, sum[lane]);
        }
    }

    /// Charge times fine potential of each spot, summed.
    #[inline(always)]
    pub fn fine<const FUSED: bool>(&self, spots: &Spots, charge: &[f32; BLOCK]) -> f64 {
        let mut sum = [0.0; BLOCK];
        for point in 0..BLOCK {
            let place = [0, 1, 2].map(|axis| spots.coordinates[axis][point]);
            self.fine[spots.cell[point] as usize].add::<FUSED>(place, charge[point], &mut sum);
        }
        sum.iter().map(|lane| f64::from(*lane)).sum()
    }
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
const fn along_x(values: [f32; 4]) -> [f32; BLOCK] {
    let mut lanes = [0.0; BLOCK];
    let mut lane = 0;
    while lane < BLOCK {
        lanes[lane] = values[lane % COARSE];
        lane += 1;
    }
    lanes
}

/// Lane 4 j + i has the value of j; the last one zero, since no product is there.
const fn along_y(values: [f32; 4]) -> [f32; BLOCK] {
    let mut lanes = [0.0; BLOCK];
    let mut lane = 0;
    while lane < BLOCK {
        lanes[lane] = if lane == LAST {
            0.0
        } else {
            values[lane / COARSE]
        };
        lane += 1;
    }
    lanes
}
