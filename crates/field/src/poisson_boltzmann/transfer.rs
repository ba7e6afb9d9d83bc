//! Between a grid and one with half the points along each axis.
//!
//! A coarse edge is two fine ones in series, averaged with the edges beside it. Restriction is the
//! transpose of trilinear interpolation.

use super::operator::Operator;
use rayon::prelude::*;
use std::borrow::Cow;

/// No level has fewer points along an axis.
const FEWEST_POINTS: usize = 5;

/// The operator with half the points along each axis; `None` where that leaves too few.
pub(super) fn coarsen(fine: &Operator) -> Option<Operator> {
    for points in fine.shape {
        if points.is_multiple_of(2) || points.div_ceil(2) < FEWEST_POINTS {
            return None;
        }
    }
    let shape = fine.shape.map(|points| points.div_ceil(2));
    let edges = [0, 1, 2].map(|axis| coarse_edges(fine, axis));
    Some(Operator::new(shape, edges, coarse_mass(fine)))
}

/// The edges of the coarse grid along an axis.
fn coarse_edges(fine: &Operator, axis: usize) -> Vec<f32> {
    // Two in series over twice the length, through a face four times as large:
    // 4 · (1/2) · harmonic mean.
    let in_series =
        |_, here: f32, after: f32| 4.0 * here * after / (here + after).max(f32::MIN_POSITIVE);
    Halved::of(&fine.edges[axis], fine.shape)
        .along(axis, in_series)
        .along((axis + 1) % 3, average)
        .along((axis + 2) % 3, average)
        .values
        .into_owned()
}

/// k of the coarse grid: eight times the average of the fine grid's, as boxes are eight times as
/// large.
fn coarse_mass(fine: &Operator) -> Vec<f32> {
    Halved::of(&fine.mass, fine.shape)
        .along(2, average)
        .along(1, average)
        .along(0, |before, here, after| 8.0 * average(before, here, after))
        .values
        .into_owned()
}

/// The mean of a point and its two neighbours, weighted as trilinear interpolation weighs them.
fn average(before: f32, here: f32, after: f32) -> f32 {
    0.25 * before + 0.5 * here + 0.25 * after
}

/// Values on a grid that has half the points along some axes.
struct Halved<'a> {
    values: Cow<'a, [f32]>,
    shape: [usize; 3],
}

impl<'a> Halved<'a> {
    fn of(values: &'a [f32], shape: [usize; 3]) -> Self {
        let values = Cow::Borrowed(values);
        Self { values, shape }
    }

    /// The values with half the points along one more axis: every second one combined with its
    /// neighbours before and after, which at an end are the point itself.
    fn along(&self, axis: usize, combine: impl Fn(f32, f32, f32) -> f32 + Sync) -> Halved<'static> {
        let mut shape = self.shape;
        let last = shape[axis] - 1;
        shape[axis] = shape[axis].div_ceil(2);
        let around = |coarse: usize| {
            let here = 2 * coarse;
            [here.saturating_sub(1), here, (here + 1).min(last)]
        };
        let halve_row = |j: usize, k: usize, target: &mut [f32]| {
            let row = self.row(j, k);
            for (i, value) in target.iter_mut().enumerate() {
                let [before, here, after] = around(i).map(|i| row[i]);
                *value = combine(before, here, after);
            }
        };
        let combine_rows = |[before, here, after]: [&[f32]; 3], target: &mut [f32]| {
            let columns = before.iter().zip(here).zip(after);
            for (value, ((before, here), after)) in target.iter_mut().zip(columns) {
                *value = combine(*before, *here, *after);
            }
        };
        let mut values = vec![0.0_f32; shape.iter().product()];
        let planes = values.par_chunks_mut(shape[0] * shape[1]).enumerate();
        planes.for_each(|(k, plane)| {
            for (j, target) in plane.chunks_mut(shape[0]).enumerate() {
                match axis {
                    0 => halve_row(j, k, target),
                    1 => combine_rows(around(j).map(|j| self.row(j, k)), target),
                    _ => combine_rows(around(k).map(|k| self.row(j, k)), target),
                }
            }
        });
        let values = Cow::Owned(values);
        Halved { values, shape }
    }

    /// A row along x.
    fn row(&self, j: usize, k: usize) -> &[f32] {
        let [nx, ny, _] = self.shape;
        &self.values[(k * ny + j) * nx..][..nx]
    }
}

/// coarse = Pᵀ fine, with P trilinear interpolation; shapes of the fine and the coarse grid.
pub(super) fn restrict(fine: &[f32], coarse: &mut [f32], [fine_shape, shape]: [[usize; 3]; 2]) {
    let row =
        |j: usize, k: usize| &fine[(k * fine_shape[1] + j) * fine_shape[0]..][..fine_shape[0]];
    let planes = coarse.par_chunks_mut(shape[0] * shape[1]).enumerate();
    planes.for_each(|(k, values)| {
        values.fill(0.0);
        if k == 0 || k + 1 == shape[2] {
            return;
        }
        let mut across = vec![0.0; fine_shape[0]];
        for j in 1..shape[1] - 1 {
            let around = [2 * k - 1, 2 * k, 2 * k + 1]
                .map(|k| [2 * j - 1, 2 * j, 2 * j + 1].map(|j| row(j, k)));
            sum_across(&around, &mut across);
            let target = &mut values[j * shape[0]..][..shape[0]];
            let inner = shape[0] - 1;
            for (i, value) in target.iter_mut().enumerate().take(inner).skip(1) {
                *value = 0.5 * (across[2 * i - 1] + across[2 * i + 1]) + across[2 * i];
            }
        }
    });
}

/// The sum over three planes of three rows, those before and after with half the weight.
fn sum_across(planes: &[[&[f32]; 3]; 3], sum: &mut [f32]) {
    let n = sum.len();
    let [below, here, above] = planes.map(|rows| rows.map(|row| &row[..n]));
    let along = |rows: &[&[f32]; 3], i: usize| 0.5 * (rows[0][i] + rows[2][i]) + rows[1][i];
    for (i, sum) in sum.iter_mut().enumerate() {
        *sum = 0.5 * (along(&below, i) + along(&above, i)) + along(&here, i);
    }
}

/// fine += P coarse, with P trilinear interpolation; shapes of the fine and the coarse grid.
pub(super) fn prolong(coarse: &[f32], fine: &mut [f32], [fine_shape, shape]: [[usize; 3]; 2]) {
    let row = |k: usize, j: usize| &coarse[(k * shape[1] + j) * shape[0]..][..shape[0]];
    let planes = fine
        .par_chunks_mut(fine_shape[0] * fine_shape[1])
        .enumerate();
    let inner_planes = planes.skip(1).take(fine_shape[2] - 2);
    inner_planes.for_each(|(k, values)| {
        let (k0, k1) = ends(k);
        for j in 1..fine_shape[1] - 1 {
            let (j0, j1) = ends(j);
            let rows = [row(k0, j0), row(k0, j1), row(k1, j0), row(k1, j1)];
            let target = &mut values[j * fine_shape[0]..][..fine_shape[0]];
            add_along_row(&rows, target);
        }
    });
}

/// The coarse points on either side of a fine one, the same twice where they coincide.
fn ends(index: usize) -> (usize, usize) {
    (index / 2, index.div_ceil(2))
}

/// Adds the interpolant of four coarse rows, a fine row between them, to its inner points.
#[inline(always)]
fn add_along_row(rows: &[&[f32]; 4], target: &mut [f32]) {
    let mean = |i: usize| 0.25 * (rows[0][i] + rows[1][i] + rows[2][i] + rows[3][i]);
    let last = target.len() - 1;
    for (i, value) in target.iter_mut().enumerate().take(last).skip(1) {
        let (i0, i1) = ends(i);
        *value += 0.5 * (mean(i0) + mean(i1));
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use protomer_kernel::random::CounterRng;

    const FINE: [usize; 3] = [17, 9, 13];
    const COARSE: [usize; 3] = [9, 5, 7];

    fn random(count: usize, rng: &mut CounterRng) -> Vec<f32> {
        (0..count)
            .map(|_| rng.uniform_in(1.0, 80.0) as f32)
            .collect()
    }

    /// Calls `visit` with each point of the coarse grid and its index.
    fn for_each_coarse(mut visit: impl FnMut([usize; 3], usize)) {
        for index in 0..COARSE.iter().product() {
            let [nx, ny, _] = COARSE;
            visit([index % nx, index / nx % ny, index / nx / ny], index);
        }
    }

    /// The fine points around a coarse one, those at most one away along each axis, held on the grid,
    /// and the product of `weights` along the axes.
    fn around(at: [usize; 3], weights: [[f32; 3]; 3]) -> Vec<([usize; 3], f32)> {
        let mut found = Vec::new();
        for n in 0..27 {
            let step = [n % 3, n / 3 % 3, n / 9];
            let place = [0, 1, 2].map(|axis| {
                (2 * at[axis] + step[axis])
                    .saturating_sub(1)
                    .min(FINE[axis] - 1)
            });
            let weight = weights[0][step[0]] * weights[1][step[1]] * weights[2][step[2]];
            found.push((place, weight));
        }
        found
    }

    fn fine_index([i, j, k]: [usize; 3]) -> usize {
        (k * FINE[1] + j) * FINE[0] + i
    }

    fn assert_close(found: f32, expected: f32) {
        assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
    }

    /// The slow twin: sums over all neighbours at once.
    #[test]
    fn coarse_coefficients_are_averages_over_all_neighbours() {
        let mut rng = CounterRng::new(11, 0, 0);
        let count = FINE.iter().product();
        let edges = [0; 3].map(|_| random(count, &mut rng));
        let operator = Operator::new(FINE, edges, random(count, &mut rng));
        let coarse = coarsen(&operator).unwrap();
        assert_eq!(coarse.shape, COARSE);
        let mean = [0.25, 0.5, 0.25];
        for_each_coarse(|at, index| {
            let mut mass = 0.0;
            for (place, weight) in around(at, [mean; 3]) {
                mass += 8.0 * weight * operator.mass[fine_index(place)];
            }
            assert_close(coarse.mass[index], mass);
            for axis in 0..3 {
                let mut weights = [mean; 3];
                weights[axis] = [0.0, 1.0, 0.0];
                let mut permittivity = 0.0;
                for (place, weight) in around(at, weights) {
                    let mut next = place;
                    next[axis] = (place[axis] + 1).min(FINE[axis] - 1);
                    let [first, second] =
                        [place, next].map(|place| operator.edges[axis][fine_index(place)]);
                    permittivity += weight * 4.0 * first * second / (first + second);
                }
                assert_close(coarse.edges[axis][index], permittivity);
            }
        });
    }

    /// The slow twin: sums over all neighbours at once.
    #[test]
    fn restriction_sums_over_all_neighbours() {
        let fine = random(FINE.iter().product(), &mut CounterRng::new(12, 0, 0));
        let mut coarse = vec![0.0; COARSE.iter().product()];
        restrict(&fine, &mut coarse, [FINE, COARSE]);
        for_each_coarse(|at, index| {
            let is_inner = (0..3).all(|axis| at[axis] > 0 && at[axis] + 1 < COARSE[axis]);
            if !is_inner {
                assert_eq!(coarse[index], 0.0);
                return;
            }
            let mut sum = 0.0;
            for (place, weight) in around(at, [[0.5, 1.0, 0.5]; 3]) {
                sum += weight * fine[fine_index(place)];
            }
            assert_close(coarse[index], sum);
        });
    }
}
