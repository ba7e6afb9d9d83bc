//! (A φ)_i = Σ_edges c (φ_i - φ_j) + k_i φ_i on the inner points of a grid.
//!
//! c is the permittivity of an edge and k is permittivity · κ² · h²: each balance of fluxes is
//! divided by the spacing. Points on the faces of the grid are given, not unknown: A ignores their rows, and their
//! values are zero in what it is applied to. A is symmetric and positive definite.

use protomer_kernel::vectorised;
use rayon::prelude::*;
use std::ops::{Mul, Sub};

/// A in single precision.
#[derive(Debug, Clone)]
pub struct Operator {
    pub shape: [usize; 3],
    /// Coefficients of the edges to the next point along each axis.
    pub edges: [Vec<f32>; 3],
    /// k.
    pub mass: Vec<f32>,
    /// The sum of the edges of a point and k; one on the faces.
    pub diagonal: Vec<f32>,
}

/// The precision in which an operator is applied.
pub trait Number: Copy + Send + Sync + From<f32> + Mul<Output = Self> + Sub<Output = Self> {}

impl Number for f32 {}
impl Number for f64 {}

impl Operator {
    pub fn new(shape: [usize; 3], edges: [Vec<f32>; 3], mass: Vec<f32>) -> Self {
        let mut operator = Self {
            shape,
            edges,
            mass,
            diagonal: Vec::new(),
        };
        operator.diagonal = operator.sum_rows();
        operator
    }

    fn sum_rows(&self) -> Vec<f32> {
        let mut diagonal = vec![1.0; self.len()];
        self.inner_rows(&mut diagonal, |row, start| {
            let [_, y, z] = self.strides();
            for (offset, value) in row.iter_mut().enumerate() {
                let i = start + offset;
                let [ex, ey, ez] = &self.edges;
                *value = ex[i] + ex[i - 1] + ey[i] + ey[i - y] + ez[i] + ez[i - z] + self.mass[i];
            }
        });
        diagonal
    }

    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    pub fn strides(&self) -> [usize; 3] {
        [1, self.shape[0], self.shape[0] * self.shape[1]]
    }

    /// Calls `work` for the inner points of every row along x, with the index of the first.
    pub fn inner_rows<T: Send>(&self, values: &mut [T], work: impl Fn(&mut [T], usize) + Sync) {
        let [nx, ny, nz] = self.shape;
        let planes = values.par_chunks_mut(nx * ny).enumerate();
        let inner_planes = planes.skip(1).take(nz - 2);
        inner_planes.for_each(|(k, plane)| {
            for j in 1..ny - 1 {
                let row = &mut plane[j * nx + 1..(j + 1) * nx - 1];
                work(row, (k * ny + j) * nx + 1);
            }
        });
    }

    /// As [`inner_rows`](Self::inner_rows), for the same rows of two lists.
    pub fn inner_rows_of_two<T: Send, U: Send>(
        &self,
        one: &mut [T],
        two: &mut [U],
        work: impl Fn(&mut [T], &mut [U], usize) + Sync,
    ) {
        let [nx, ny, nz] = self.shape;
        let planes = one.par_chunks_mut(nx * ny).zip(two.par_chunks_mut(nx * ny));
        let inner_planes = planes.enumerate().skip(1).take(nz - 2);
        inner_planes.for_each(|(k, (one, two))| {
            for j in 1..ny - 1 {
                let row = j * nx + 1..(j + 1) * nx - 1;
                work(&mut one[row.clone()], &mut two[row], (k * ny + j) * nx + 1);
            }
        });
    }

    /// Zero on the faces.
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

    /// out = A x on inner points.
    pub fn apply(&self, x: &[f64], out: &mut [f64]) {
        self.inner_rows(out, |row, start| self.apply_row(x, row, start));
    }

    vectorised!(
        /// One row of A x.
        pub fn apply_row, apply_row_any, apply_row_avx512, apply_row_avx2,
        (x: &[f64], out: &mut [f64], start: usize) -> ()
    );
    vectorised!(
        /// One row of the residual b - A x.
        pub fn residual_row, residual_row_any, residual_row_avx512, residual_row_avx2,
        (x: &[f32], b: &[f32], out: &mut [f32], start: usize) -> ()
    );
    vectorised!(
        /// One row of a step d = keep · d + take · D⁻¹ (b - A x) and next = x + d.
        pub fn step_row, step_row_any, step_row_avx512, step_row_avx2,
        (x: &[f32], b: &[f32], step: Step, d: &mut [f32], next: &mut [f32], start: usize) -> ()
    );

    #[inline(always)]
    fn apply_row_any(&self, x: &[f64], out: &mut [f64], start: usize) {
        let row = Row::new(self, x, start, out.len());
        for (i, out) in out.iter_mut().enumerate() {
            *out = row.product(i);
        }
    }

    #[inline(always)]
    fn residual_row_any(&self, x: &[f32], b: &[f32], out: &mut [f32], start: usize) {
        let row = Row::new(self, x, start, out.len());
        let b = &b[start..start + out.len()];
        for (i, out) in out.iter_mut().enumerate() {
            *out = b[i] - row.product(i);
        }
    }

    #[inline(always)]
    fn step_row_any(
        &self,
        x: &[f32],
        b: &[f32],
        step: Step,
        d: &mut [f32],
        next: &mut [f32],
        start: usize,
    ) {
        let n = d.len();
        let row = Row::new(self, x, start, n);
        let (b, next) = (&b[start..start + n], &mut next[..n]);
        for i in 0..n {
            let residual = b[i] - row.product(i);
            d[i] = step.keep * d[i] + step.take * residual / row.diagonal[i];
            next[i] = row.here[i] + d[i];
        }
    }
}

/// Factors of a step of an iteration.
#[derive(Debug, Clone, Copy)]
pub struct Step {
    pub keep: f32,
    pub take: f32,
}

/// Coefficients and values around a row of points. Equal lengths let the compiler drop the bounds
/// checks and use vectors.
struct Row<'a, T> {
    diagonal: &'a [f32],
    /// Edges to the east, west, north, south, up and down.
    edges: [&'a [f32]; 6],
    here: &'a [T],
    /// Values in these directions.
    neighbours: [&'a [T]; 6],
}

impl<'a, T: Number> Row<'a, T> {
    #[inline(always)]
    fn new(operator: &'a Operator, x: &'a [T], start: usize, n: usize) -> Self {
        let [_, y, z] = operator.strides();
        let [ex, ey, ez] = &operator.edges;
        let part = |edges: &'a [f32], first: usize| &edges[first..first + n];
        let values = |first: usize| &x[first..first + n];
        Self {
            diagonal: part(&operator.diagonal, start),
            edges: [
                part(ex, start),
                part(ex, start - 1),
                part(ey, start),
                part(ey, start - y),
                part(ez, start),
                part(ez, start - z),
            ],
            here: values(start),
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

    /// (A x) at a point of the row.
    #[inline(always)]
    fn product(&self, i: usize) -> T {
        let [east, west, north, south, up, down] = self.edges;
        let [xe, xw, xn, xs, xu, xd] = self.neighbours;
        T::from(self.diagonal[i]) * self.here[i]
            - T::from(east[i]) * xe[i]
            - T::from(west[i]) * xw[i]
            - T::from(north[i]) * xn[i]
            - T::from(south[i]) * xs[i]
            - T::from(up[i]) * xu[i]
            - T::from(down[i]) * xd[i]
    }
}
