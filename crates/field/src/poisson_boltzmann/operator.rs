//! (A φ)_i = Σ_edges c (φ_i - φ_j) + k_i φ_i on the inner points of a grid.
//!
//! c is the permittivity of an edge and k is permittivity · κ² · h²: each balance of fluxes is
//! divided by the spacing. Points on the faces of the grid are given, not unknown: A ignores their rows, and their
//! values are zero in what it is applied to. A is symmetric and positive definite.

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

    /// out = A x on inner points.
    pub fn apply<T: Number>(&self, x: &[T], out: &mut [T]) {
        self.inner_rows(out, |row, start| self.apply_row(x, row, start));
    }

    /// One row of A x.
    #[inline(always)]
    pub fn apply_row<T: Number>(&self, x: &[T], out: &mut [T], start: usize) {
        let (n, [_, y, z]) = (out.len(), self.strides());
        let [ex, ey, ez] = &self.edges;
        // Equal lengths let the compiler drop the bounds checks and use vectors.
        let diagonal = &self.diagonal[start..start + n];
        let (east, west) = (&ex[start..start + n], &ex[start - 1..start - 1 + n]);
        let (north, south) = (&ey[start..start + n], &ey[start - y..start - y + n]);
        let (up, down) = (&ez[start..start + n], &ez[start - z..start - z + n]);
        let here = &x[start..start + n];
        let (xe, xw) = (&x[start + 1..start + 1 + n], &x[start - 1..start - 1 + n]);
        let (xn, xs) = (&x[start + y..start + y + n], &x[start - y..start - y + n]);
        let (xu, xd) = (&x[start + z..start + z + n], &x[start - z..start - z + n]);
        for i in 0..n {
            out[i] = T::from(diagonal[i]) * here[i]
                - T::from(east[i]) * xe[i]
                - T::from(west[i]) * xw[i]
                - T::from(north[i]) * xn[i]
                - T::from(south[i]) * xs[i]
                - T::from(up[i]) * xu[i]
                - T::from(down[i]) * xd[i];
        }
    }
}
