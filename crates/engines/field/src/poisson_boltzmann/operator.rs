//! (A φ)_i = Σ_edges c (φ_i - φ_j) + k_i φ_i on the inner points of a grid.
//!
//! c is the permittivity of an edge and k is permittivity · κ² · h²: each balance of fluxes is
//! divided by the spacing. Points on the faces of the grid are given, not unknown: A ignores their rows,
//! and their values are zero in what it is applied to. A is symmetric and positive definite.

use super::dot::dot_of_piece;
use protomer_kernel::vectorised;
use rayon::prelude::*;
use std::sync::Arc;

/// A in single precision.
#[derive(Debug, Clone)]
pub struct Operator {
    pub shape: [usize; 3],
    /// Coefficients of the edges to the next point along each axis, shared by the operators of several salts.
    pub edges: Arc<[Vec<f32>; 3]>,
    /// k.
    pub mass: Vec<f32>,
    /// D, the sum of the edges of a point and k, and its inverse; zero on the faces.
    diagonal: Vec<f32>,
    inverse_diagonal: Vec<f32>,
}

impl Operator {
    pub fn new(shape: [usize; 3], edges: impl Into<Arc<[Vec<f32>; 3]>>, mass: Vec<f32>) -> Self {
        let mut operator = Self {
            shape,
            edges: edges.into(),
            mass,
            diagonal: Vec::new(),
            inverse_diagonal: Vec::new(),
        };
        let mut diagonal = vec![0.0; operator.len()];
        operator.inner_planes(&mut diagonal, |plane, start| operator.sum_row(plane, start));
        let mut inverse = vec![0.0; operator.len()];
        operator.inner_planes(&mut inverse, |plane, start| {
            // 1/0 on the faces between rows is wiped by `inner_planes`.
            for (inverse, value) in plane.iter_mut().zip(&diagonal[start..]) {
                *inverse = value.recip();
            }
        });
        (operator.diagonal, operator.inverse_diagonal) = (diagonal, inverse);
        operator
    }

    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    pub fn strides(&self) -> [usize; 3] {
        [1, self.shape[0], self.shape[0] * self.shape[1]]
    }

    /// Calls `work` for every plane across z but the faces, with the values from its first inner point to
    /// its last and the index of the first, and returns its results. One long row makes better use of
    /// vectors than many short ones; what `work` leaves on the faces between rows becomes zero.
    pub fn inner_planes<T: Copy + Default + Send, R: Send>(
        &self,
        values: &mut [T],
        work: impl Fn(&mut [T], usize) -> R + Sync,
    ) -> Vec<R> {
        let [nx, ny, nz] = self.shape;
        // From the first inner point of the plane to the last, across row ends.
        let inner = nx + 1..nx * (ny - 1) - 1;
        let planes = values.par_chunks_mut(nx * ny).enumerate();
        let inner_planes = planes.skip(1).take(nz - 2);
        let on_plane = |(k, plane): (usize, &mut [T])| {
            let outcome = work(&mut plane[inner.clone()], k * nx * ny + inner.start);
            // The ends of rows are faces of the grid, which the long row has overwritten.
            for row in plane[nx..nx * (ny - 1)].chunks_exact_mut(nx) {
                (row[0], row[nx - 1]) = (T::default(), T::default());
            }
            outcome
        };
        inner_planes.map(on_plane).collect()
    }

    /// Sets the values on the faces to zero.
    #[cfg(test)]
    pub fn clear_faces<T: Copy + Default>(&self, values: &mut [T]) {
        let [nx, ny, nz] = self.shape;
        for (k, plane) in values.chunks_mut(nx * ny).enumerate() {
            for (j, row) in plane.chunks_mut(nx).enumerate() {
                if k == 0 || k + 1 == nz || j == 0 || j + 1 == ny {
                    row.fill(T::default());
                } else {
                    row[0] = T::default();
                    row[nx - 1] = T::default();
                }
            }
        }
    }

    /// out = A x on inner points; returns x · A x.
    pub fn apply(&self, x: &[f32], out: &mut [f32]) -> f64 {
        let products = self.inner_planes(out, |plane, start| {
            self.apply_row(x, plane, start);
            dot_of_piece(&x[start..start + plane.len()], plane)
        });
        products.iter().sum()
    }

    /// b - A x on inner points, in double precision but for the result.
    pub fn residual(&self, x: &[f64], b: &[f64], out: &mut [f32]) {
        self.inner_planes(out, |plane, start| {
            self.exact_residual_row(x, b, plane, start)
        });
    }

    /// b - A x on inner points, for an x that is zero but on the faces of the grid.
    pub fn residual_of_faces(&self, x: &[f64], b: &[f64], out: &mut [f32]) {
        let [nx, ny, nz] = self.shape;
        let plane_length = nx * ny;
        self.inner_planes(out, |plane, start| {
            // Inner points next to a face see its values;
            // all others see zeros, so b is their residual.
            let k = start / plane_length;
            if k == 1 || k + 2 == nz {
                self.exact_residual_row(x, b, plane, start);
                return;
            }
            for (out, b) in plane.iter_mut().zip(&b[start..]) {
                *out = *b as f32;
            }
            let last_row = (ny - 3) * nx;
            // First and last inner rows, then the ends of the rows between.
            self.exact_residual_row(x, b, &mut plane[..nx - 2], start);
            self.exact_residual_row(x, b, &mut plane[last_row..], start + last_row);
            for row in (0..=last_row).step_by(nx) {
                for index in [row, row + nx - 3] {
                    self.exact_residual_row(x, b, &mut plane[index..=index], start + index);
                }
            }
        });
    }

    vectorised!(
        /// D at successive points.
        fn sum_row[sum_row_avx512, sum_row_avx2, sum_row_any](self: &Self, out: &mut [f32], start: usize)
    );
    vectorised!(
        /// A x at successive points.
        fn apply_row[apply_row_avx512, apply_row_avx2, apply_row_any](self: &Self, x: &[f32], out: &mut [f32], start: usize)
    );
    vectorised!(
        /// The residual b - A x at successive points.
        pub fn residual_row[residual_row_avx512, residual_row_avx2, residual_row_any](self: &Self, x: &[f32], b: &[f32], out: &mut [f32], start: usize)
    );
    vectorised!(
        /// The residual b - A x at successive points, in double precision.
        fn exact_residual_row[exact_residual_avx512, exact_residual_avx2, exact_residual_any](self: &Self, x: &[f64], b: &[f64], out: &mut [f32], start: usize)
    );
    vectorised!(
        /// A step at successive points: x + keep · (x - last) + take · D⁻¹ (b - A x) in place of the
        /// last x.
        pub fn step_row[step_row_avx512, step_row_avx2, step_row_any](self: &Self, x: &[f32], b: &[f32], step: Step, last: &mut [f32], start: usize)
    );

    #[inline(always)]
    fn sum_row_any(&self, out: &mut [f32], start: usize) {
        let n = out.len();
        let [east, west, north, south, up, down] = self.edges_around(start, n);
        let mass = &self.mass[start..start + n];
        for (i, out) in out.iter_mut().enumerate() {
            *out = east[i] + west[i] + north[i] + south[i] + up[i] + down[i] + mass[i];
        }
    }

    /// Edges of successive points to the east, west, north, south, up and down.
    #[inline(always)]
    fn edges_around(&self, start: usize, n: usize) -> [&[f32]; 6] {
        let [_, y, z] = self.strides();
        let [ex, ey, ez] = &*self.edges;
        // West, south and down of a point are east, north and up of its neighbour before.
        [
            &ex[start..start + n],
            &ex[start - 1..start - 1 + n],
            &ey[start..start + n],
            &ey[start - y..start - y + n],
            &ez[start..start + n],
            &ez[start - z..start - z + n],
        ]
    }

    #[inline(always)]
    fn apply_row_any(&self, x: &[f32], out: &mut [f32], start: usize) {
        let n = out.len();
        let row = Row::new(self, x, start, n);
        let diagonal = &self.diagonal[start..start + n];
        for (i, out) in out.iter_mut().enumerate() {
            // Multiplied out: D x - Σ c x_j, one product less per point than differences.
            *out = diagonal[i] * row.centre[i] - row.sum_around(i);
        }
    }

    #[inline(always)]
    fn exact_residual_any(&self, x: &[f64], b: &[f64], out: &mut [f32], start: usize) {
        let n = out.len();
        let row = Row::new(self, x, start, n);
        let (mass, b) = (&self.mass[start..start + n], &b[start..start + n]);
        for (i, out) in out.iter_mut().enumerate() {
            // Differences first: in double precision they keep what single sums would cancel away.
            *out = (b[i] - row.flux(i) - f64::from(mass[i]) * row.centre[i]) as f32;
        }
    }

    #[inline(always)]
    fn residual_row_any(&self, x: &[f32], b: &[f32], out: &mut [f32], start: usize) {
        let n = out.len();
        let row = Row::new(self, x, start, n);
        let (diagonal, b) = (&self.diagonal[start..start + n], &b[start..start + n]);
        for (i, out) in out.iter_mut().enumerate() {
            *out = b[i] + row.sum_around(i) - diagonal[i] * row.centre[i];
        }
    }

    #[inline(always)]
    fn step_row_any(&self, x: &[f32], b: &[f32], step: Step, last: &mut [f32], start: usize) {
        let n = last.len();
        let row = Row::new(self, x, start, n);
        let b = &b[start..start + n];
        let inverse = &self.inverse_diagonal[start..start + n];
        for (i, last) in last.iter_mut().enumerate() {
            let value = row.centre[i];
            // D⁻¹ (b - A x) = D⁻¹ (b + Σ c x_j) - x.
            let residual = inverse[i] * (b[i] + row.sum_around(i)) - value;
            *last = value + step.keep * (value - *last) + step.take * residual;
        }
    }

    /// D⁻¹ b at successive points, times a factor.
    pub fn scale_row(&self, b: &[f32], factor: f32, out: &mut [f32], start: usize) {
        // On faces the inverse is zero, so nothing is left there.
        let terms = b[start..].iter().zip(&self.inverse_diagonal[start..]);
        for (out, (b, inverse)) in out.iter_mut().zip(terms) {
            *out = factor * b * inverse;
        }
    }
}

/// Factors of a step of an iteration.
#[derive(Debug, Clone, Copy)]
pub struct Step {
    pub keep: f32,
    pub take: f32,
}

/// Coefficients and values around successive points. Equal lengths let the compiler drop the bounds
/// checks and use vectors.
struct Row<'a, T> {
    /// Edges to the east, west, north, south, up and down.
    edges: [&'a [f32]; 6],
    centre: &'a [T],
    /// Values in these directions.
    neighbours: [&'a [T]; 6],
}

impl<'a, T> Row<'a, T> {
    #[inline(always)]
    fn new(operator: &'a Operator, x: &'a [T], start: usize, n: usize) -> Self {
        let [_, y, z] = operator.strides();
        let values = |first: usize| &x[first..first + n];
        Self {
            edges: operator.edges_around(start, n),
            centre: values(start),
            neighbours: [
                values(start + 1),
                values(start - 1),
                values(start + y),
                values(start - y),
                values(start + z),
                values(start - z),
            ],
        }
    }
}

impl Row<'_, f32> {
    /// Σ c φ_j.
    #[inline(always)]
    fn sum_around(&self, i: usize) -> f32 {
        let [east, west, north, south, up, down] = self.edges;
        let [xe, xw, xn, xs, xu, xd] = self.neighbours;
        east[i] * xe[i]
            + west[i] * xw[i]
            + north[i] * xn[i]
            + south[i] * xs[i]
            + up[i] * xu[i]
            + down[i] * xd[i]
    }
}

impl Row<'_, f64> {
    /// Σ c (φ_i - φ_j).
    #[inline(always)]
    fn flux(&self, i: usize) -> f64 {
        let value = self.centre[i];
        let [east, west, north, south, up, down] = self.edges.map(|edges| f64::from(edges[i]));
        let [xe, xw, xn, xs, xu, xd] = self.neighbours.map(|values| value - values[i]);
        east * xe + west * xw + north * xn + south * xs + up * xu + down * xd
    }
}
