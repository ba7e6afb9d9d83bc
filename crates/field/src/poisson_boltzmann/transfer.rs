//! Between a grid and one with half the points along each axis.
//!
//! A coarse edge is two fine ones in series, averaged over the four-by-four neighbourhood across.
//! Restriction is the transpose of trilinear interpolation.

use super::operator::Operator;
use crate::grid::set_points;
use rayon::prelude::*;

/// No level has fewer points along an axis.
const FEWEST_POINTS: usize = 5;
/// Weights of a coarse point's neighbours among the fine points along an axis; their sum is one.
const AVERAGE: [(isize, f32); 3] = [(-1, 0.25), (0, 0.5), (1, 0.25)];

/// The operator with half the points along each axis; `None` where that leaves too few.
pub(super) fn coarsen(fine: &Operator) -> Option<Operator> {
    for points in fine.shape {
        if points.is_multiple_of(2) || points.div_ceil(2) < FEWEST_POINTS {
            return None;
        }
    }
    let shape = fine.shape.map(|points| points.div_ceil(2));
    let edges = [0, 1, 2].map(|axis| coarse_edges(fine, shape, axis));
    Some(Operator::new(shape, edges, coarse_mass(fine, shape)))
}

/// The fine point of a coarse one.
fn fine_place(coarse: [usize; 3]) -> [isize; 3] {
    coarse.map(|index| 2 * index as isize)
}

/// The index of the fine point nearest to a place that may lie just outside the grid.
fn nearest_index(fine: &Operator, place: [isize; 3]) -> usize {
    let strides = fine.strides();
    let mut index = 0;
    for axis in 0..3 {
        let last = fine.shape[axis] as isize - 1;
        index += place[axis].clamp(0, last) as usize * strides[axis];
    }
    index
}

/// The edges of the coarse grid along an axis.
fn coarse_edges(fine: &Operator, shape: [usize; 3], axis: usize) -> Vec<f32> {
    let edges = &fine.edges[axis];
    let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut coarse = vec![0.0_f32; shape.iter().product()];
    set_points(shape, &mut coarse, |at, value| {
        let place = fine_place(at);
        let has_next = place[axis] + 1 < fine.shape[axis] as isize;
        for (da, wa) in AVERAGE {
            for (db, wb) in AVERAGE {
                let mut p = place;
                p[second] += da;
                p[third] += db;
                let first = edges[nearest_index(fine, p)];
                p[axis] += 1;
                let next = if has_next {
                    edges[nearest_index(fine, p)]
                } else {
                    first
                };
                // Two in series over twice the length, through a face four times as large:
                // 4 · (1/2) · harmonic mean.
                *value +=
                    wa * wb * 2.0 * 2.0 * first * next / (first + next).max(f32::MIN_POSITIVE);
            }
        }
    });
    coarse
}

/// k of the coarse grid: eight times the average of the fine grid's, as boxes are eight times as
/// large.
fn coarse_mass(fine: &Operator, shape: [usize; 3]) -> Vec<f32> {
    let mut coarse = vec![0.0_f32; shape.iter().product()];
    set_points(shape, &mut coarse, |at, value| {
        let [i, j, k] = fine_place(at);
        for (di, wi) in AVERAGE {
            for (dj, wj) in AVERAGE {
                for (dk, wk) in AVERAGE {
                    let index = nearest_index(fine, [i + di, j + dj, k + dk]);
                    *value += 8.0 * wi * wj * wk * fine.mass[index];
                }
            }
        }
    });
    coarse
}

/// coarse = Pᵀ fine, with P trilinear interpolation; shapes of the fine and the coarse grid.
pub(super) fn restrict(fine: &[f32], coarse: &mut [f32], [fine_shape, shape]: [[usize; 3]; 2]) {
    let weights = [(-1_isize, 0.5_f32), (0, 1.0), (1, 0.5)];
    let sum_around = |i: usize, j: usize, k: usize| {
        let mut sum = 0.0;
        for (dk, wk) in weights {
            for (dj, wj) in weights {
                let plane = (2 * k as isize + dk) as usize * fine_shape[1];
                let row = (plane + (2 * j as isize + dj) as usize) * fine_shape[0] + 2 * i;
                sum += wk * wj * (0.5 * (fine[row - 1] + fine[row + 1]) + fine[row]);
            }
        }
        sum
    };
    let planes = coarse.par_chunks_mut(shape[0] * shape[1]).enumerate();
    planes.for_each(|(k, values)| {
        values.fill(0.0);
        if k == 0 || k + 1 == shape[2] {
            return;
        }
        for j in 1..shape[1] - 1 {
            for i in 1..shape[0] - 1 {
                values[j * shape[0] + i] = sum_around(i, j, k);
            }
        }
    });
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
