//! Between a grid and one with half the points along each axis.
//!
//! A coarse edge is two fine ones in series, averaged with the edges next to it. Restriction is the
//! transpose of trilinear interpolation.

use super::operator::Operator;
use rayon::prelude::*;

/// Least number of points of a level along an axis.
const FEWEST_POINTS: usize = 5;

/// The operator with half the points along each axis; `None` where that leaves too few.
pub(super) fn coarsen(fine: &Operator) -> Option<Operator> {
    for points in fine.shape {
        // An odd number of points: the last one stays a
        // point of the coarse grid, and faces stay faces.
        if points.is_multiple_of(2) || points.div_ceil(2) < FEWEST_POINTS {
            return None;
        }
    }
    let [x, y, z] = [0, 1, 2].map(|axis| Rows::from_values(&fine.edges[axis], fine.shape));
    let edges = [edges_along_x(x), edges_along_y(y), edges_along_z(z)];
    let mass = coarse_mass(Rows::from_values(&fine.mass, fine.shape));
    let shape = fine.shape.map(|points| points.div_ceil(2));
    Some(Operator::new(shape, edges, mass))
}

/// Coarse edges along x: the mean over the planes and rows around.
fn edges_along_x(fine: Rows) -> Vec<f32> {
    let [_, rows, planes] = fine.shape;
    halved(fine.shape, |[j, k], coarse, _| {
        coarse.fill(0.0);
        for (k, of_plane) in around(k, planes) {
            for (j, of_row) in around(j, rows) {
                add_in_series(coarse, of_plane * of_row, fine.row(j, k));
            }
        }
    })
}

/// Coarse edges along y: the mean over the planes around and along the rows.
fn edges_along_y(fine: Rows) -> Vec<f32> {
    let [_, rows, planes] = fine.shape;
    halved(fine.shape, |[j, k], coarse, sums| {
        // Two fine edges in series make a coarse one; the rows before do not belong to it.
        let [_, (centre, _), (after, _)] = around(j, rows);
        sums.fill(0.0);
        for (k, weight) in around(k, planes) {
            add_both_in_series(sums, weight, [fine.row(centre, k), fine.row(after, k)]);
        }
        average_by_halves(sums, 1.0, coarse);
    })
}

/// Coarse edges along z: the mean over the rows around and along the rows.
fn edges_along_z(fine: Rows) -> Vec<f32> {
    let [_, rows, planes] = fine.shape;
    halved(fine.shape, |[j, k], coarse, sums| {
        let [_, (centre, _), (after, _)] = around(k, planes);
        sums.fill(0.0);
        for (j, weight) in around(j, rows) {
            add_both_in_series(sums, weight, [fine.row(j, centre), fine.row(j, after)]);
        }
        average_by_halves(sums, 1.0, coarse);
    })
}

/// k of the coarse grid: eight times the mean of the fine grid's, as boxes are eight times as large.
fn coarse_mass(fine: Rows) -> Vec<f32> {
    let [_, rows, planes] = fine.shape;
    halved(fine.shape, |[j, k], coarse, sums| {
        sums.fill(0.0);
        for (k, of_plane) in around(k, planes) {
            for (j, of_row) in around(j, rows) {
                add(sums, of_plane * of_row, fine.row(j, k));
            }
        }
        average_by_halves(sums, 8.0, coarse);
    })
}

/// Values on a grid with half the points along each axis, made row by row: `fill` gets the numbers of the
/// coarse row among rows and planes, the row, and room for a fine row.
fn halved(
    fine_shape: [usize; 3],
    fill: impl Fn([usize; 2], &mut [f32], &mut [f32]) + Sync,
) -> Vec<f32> {
    let [nx, ny, nz] = fine_shape.map(|points| points.div_ceil(2));
    let mut values = vec![0.0; nx * ny * nz];
    let planes = values.par_chunks_mut(nx * ny).enumerate();
    planes.for_each(|(k, plane)| {
        let mut sums = vec![0.0; fine_shape[0]];
        for (j, row) in plane.chunks_mut(nx).enumerate() {
            fill([j, k], row, &mut sums);
        }
    });
    values
}

/// Values on a grid, by rows along x.
#[derive(Clone, Copy)]
struct Rows<'a> {
    values: &'a [f32],
    shape: [usize; 3],
}

impl<'a> Rows<'a> {
    fn from_values(values: &'a [f32], shape: [usize; 3]) -> Self {
        Self { values, shape }
    }

    fn row(&self, j: usize, k: usize) -> &'a [f32] {
        let [nx, ny, _] = self.shape;
        &self.values[(k * ny + j) * nx..][..nx]
    }
}

/// The fine points before, at and after a coarse one, with the weights of trilinear interpolation. At an
/// end of the grid, the end stands for what would lie beyond.
fn around(coarse: usize, fine_points: usize) -> [(usize, f32); 3] {
    let centre = 2 * coarse;
    let after = (centre + 1).min(fine_points - 1);
    [
        (centre.saturating_sub(1), 0.25),
        (centre, 0.5),
        (after, 0.25),
    ]
}

/// Two edges in series over twice the length, through a face four times as large: 4 · (1/2) · harmonic
/// mean.
fn in_series(one: f32, two: f32) -> f32 {
    // Two edges without permittivity: zero instead of 0/0.
    4.0 * one * two / (one + two).max(f32::MIN_POSITIVE)
}

/// sum += weight · row.
fn add(sum: &mut [f32], weight: f32, row: &[f32]) {
    for (sum, value) in sum.iter_mut().zip(row) {
        *sum += weight * value;
    }
}

/// Adds the edges of two rows in series.
fn add_both_in_series(sum: &mut [f32], weight: f32, [one, two]: [&[f32]; 2]) {
    for (sum, (one, two)) in sum.iter_mut().zip(one.iter().zip(two)) {
        *sum += weight * in_series(*one, *two);
    }
}

/// Adds each second edge of a row in series with the next, the last with itself.
fn add_in_series(sum: &mut [f32], weight: f32, row: &[f32]) {
    let (pairs, last) = row.as_chunks::<2>();
    let pairs = pairs
        .iter()
        .copied()
        .chain(last.iter().map(|last| [*last; 2]));
    for (sum, [one, two]) in sum.iter_mut().zip(pairs) {
        *sum += weight * in_series(one, two);
    }
}

/// Each second point of a row averaged with its neighbours, times a factor.
fn average_by_halves(row: &[f32], factor: f32, coarse: &mut [f32]) {
    for (i, value) in coarse.iter_mut().enumerate() {
        let [before, centre, after] = around(i, row.len()).map(|(i, weight)| weight * row[i]);
        *value = factor * (before + centre + after);
    }
}

/// coarse = Pᵀ fine, with P trilinear interpolation; shapes of the fine and the coarse grid.
pub(super) fn restrict(fine: &[f32], coarse: &mut [f32], [fine_shape, shape]: [[usize; 3]; 2]) {
    let fine = Rows::from_values(fine, fine_shape);
    let planes = coarse.par_chunks_mut(shape[0] * shape[1]).enumerate();
    planes.for_each(|(k, values)| {
        values.fill(0.0);
        // Faces carry no residual.
        if k == 0 || k + 1 == shape[2] {
            return;
        }
        let mut sums = vec![0.0; fine_shape[0]];
        for j in 1..shape[1] - 1 {
            let around = [2 * k - 1, 2 * k, 2 * k + 1]
                .map(|k| [2 * j - 1, 2 * j, 2 * j + 1].map(|j| fine.row(j, k)));
            sum_across(&around, &mut sums);
            let target = &mut values[j * shape[0]..][..shape[0]];
            let inner = shape[0] - 1;
            for (i, value) in target.iter_mut().enumerate().take(inner).skip(1) {
                // Pᵀ: the weights ½, 1, ½ along each axis, the product over axes.
                *value = 0.5 * (sums[2 * i - 1] + sums[2 * i + 1]) + sums[2 * i];
            }
        }
    });
}

/// The sum over three planes of three rows, those before and after with half the weight.
fn sum_across(planes: &[[&[f32]; 3]; 3], sum: &mut [f32]) {
    let n = sum.len();
    let [below, middle, above] = planes.map(|rows| rows.map(|row| &row[..n]));
    let weighted_sum = |rows: &[&[f32]; 3], i: usize| 0.5 * (rows[0][i] + rows[2][i]) + rows[1][i];
    for (i, sum) in sum.iter_mut().enumerate() {
        *sum = 0.5 * (weighted_sum(&below, i) + weighted_sum(&above, i)) + weighted_sum(&middle, i);
    }
}

/// fine += P coarse, with P trilinear interpolation, for values that are zero on the faces of the coarse
/// grid; shapes of the fine and the coarse grid.
pub(super) fn prolong(coarse: &[f32], fine: &mut [f32], [fine_shape, shape]: [[usize; 3]; 2]) {
    let coarse = Rows::from_values(coarse, shape);
    let planes = fine
        .par_chunks_mut(fine_shape[0] * fine_shape[1])
        .enumerate();
    // Faces are given and take no correction.
    let inner_planes = planes.skip(1).take(fine_shape[2] - 2);
    inner_planes.for_each(|(k, values)| {
        let (k0, k1) = ends(k);
        let mut sums = vec![0.0; shape[0]];
        // A quarter of each of four rows; two of them, or all, may be the same row.
        for j in 1..fine_shape[1] - 1 {
            let (j0, j1) = ends(j);
            sums.fill(0.0);
            for (j, k) in [(j0, k0), (j1, k0), (j0, k1), (j1, k1)] {
                add(&mut sums, 0.25, coarse.row(j, k));
            }
            add_between(&sums, &mut values[j * fine_shape[0]..][..fine_shape[0]]);
        }
    });
}

/// The coarse points on either side of a fine one, the same twice where they coincide.
fn ends(index: usize) -> (usize, usize) {
    (index / 2, index.div_ceil(2))
}

/// Adds to a fine row, from its second point on, in turn the mean of two neighbours of a coarse row and the
/// second of them.
fn add_between(row: &[f32], fine: &mut [f32]) {
    // From the second point: fine points 1, 2 are between 0 and 1, and on 1, and so on.
    let pairs = fine[1..].as_chunks_mut::<2>().0;
    for ([between, point], (before, after)) in pairs.iter_mut().zip(row.iter().zip(&row[1..])) {
        *between += 0.5 * (before + after);
        *point += after;
    }
}

#[cfg(test)]
mod tests {
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
        for_each_coarse(|node, index| {
            let mut mass = 0.0;
            for (place, weight) in around(node, [mean; 3]) {
                mass += 8.0 * weight * operator.mass[fine_index(place)];
            }
            assert_close(coarse.mass[index], mass);
            for axis in 0..3 {
                let mut weights = [mean; 3];
                weights[axis] = [0.0, 1.0, 0.0];
                let mut permittivity = 0.0;
                for (place, weight) in around(node, weights) {
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
        for_each_coarse(|node, index| {
            let is_inner = (0..3).all(|axis| node[axis] > 0 && node[axis] + 1 < COARSE[axis]);
            if !is_inner {
                assert_eq!(coarse[index], 0.0);
                return;
            }
            let mut sum = 0.0;
            for (place, weight) in around(node, [[0.5, 1.0, 0.5]; 3]) {
                sum += weight * fine[fine_index(place)];
            }
            assert_close(coarse[index], sum);
        });
    }
}
