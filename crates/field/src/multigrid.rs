//! An approximate inverse of the operator, for conjugate gradients: one V-cycle.
//!
//! Every level has half the points along each axis. Smoothing is by Chebyshev polynomials of D⁻¹ A
//! (no order of points, so results do not depend on threads); coarse edges are two fine ones in
//! series, averaged over the four-by-four neighbourhood across; restriction is the transpose of
//! trilinear interpolation. The cycle is symmetric, as conjugate gradients need. Single precision
//! is enough for a preconditioner.

use super::operator::Operator;
use rayon::prelude::*;

/// Degree of the smoothing polynomials.
const SMOOTHING: usize = 3;
/// Of the spectrum of D⁻¹ A, which lies below 2, the part above this is damped by smoothing.
const SMOOTHED_ABOVE: f32 = 0.35;
const LARGEST_EIGENVALUE: f32 = 2.0;
/// Degree of the polynomial that stands for a solution on the coarsest level.
const COARSEST: usize = 24;
const COARSEST_ABOVE: f32 = 0.02;
/// No level has fewer points along an axis.
const FEWEST_POINTS: usize = 5;

/// A hierarchy of grids.
#[derive(Debug)]
pub struct Multigrid {
    levels: Vec<Level>,
}

#[derive(Debug)]
struct Level {
    operator: Operator,
    x: Vec<f32>,
    right: Vec<f32>,
    residual: Vec<f32>,
    direction: Vec<f32>,
}

impl Multigrid {
    pub fn new(finest: &Operator) -> Self {
        let mut levels = vec![Level::new(finest.clone())];
        while let Some(coarse) = coarsen(&levels[levels.len() - 1].operator) {
            levels.push(Level::new(coarse));
        }
        Self { levels }
    }

    /// out ≈ A⁻¹ r.
    pub fn apply(&mut self, r: &[f64], out: &mut [f64]) {
        self.levels[0]
            .right
            .par_iter_mut()
            .zip(r)
            .for_each(|(right, r)| *right = *r as f32);
        self.cycle();
        out.par_iter_mut()
            .zip(&self.levels[0].x)
            .for_each(|(out, x)| *out = f64::from(*x));
    }

    fn cycle(&mut self) {
        let last = self.levels.len() - 1;
        for depth in 0..last {
            let (fine, coarse) = self.levels.split_at_mut(depth + 1);
            let (fine, coarse) = (&mut fine[depth], &mut coarse[0]);
            fine.x.fill(0.0);
            fine.smooth(SMOOTHING, SMOOTHED_ABOVE, true);
            fine.find_residual();
            restrict(
                &fine.residual,
                fine.operator.shape,
                &mut coarse.right,
                coarse.operator.shape,
            );
        }
        let coarsest = &mut self.levels[last];
        coarsest.x.fill(0.0);
        coarsest.smooth(COARSEST, COARSEST_ABOVE, true);
        for depth in (0..last).rev() {
            let (fine, coarse) = self.levels.split_at_mut(depth + 1);
            let (fine, coarse) = (&mut fine[depth], &coarse[0]);
            prolong(
                &coarse.x,
                coarse.operator.shape,
                &mut fine.x,
                fine.operator.shape,
            );
            fine.smooth(SMOOTHING, SMOOTHED_ABOVE, false);
        }
    }
}

impl Level {
    fn new(operator: Operator) -> Self {
        let zeros = || vec![0.0; operator.len()];
        Self {
            x: zeros(),
            right: zeros(),
            residual: zeros(),
            direction: zeros(),
            operator,
        }
    }

    fn find_residual(&mut self) {
        let Self {
            operator,
            x,
            right,
            residual,
            ..
        } = self;
        operator.inner_rows(residual, |row, start| {
            operator.apply_row(x, row, start);
            for (value, b) in row.iter_mut().zip(&right[start..]) {
                *value = b - *value;
            }
        });
    }

    /// Chebyshev iteration on D⁻¹ A x = D⁻¹ b for eigenvalues from `above` to 2 (Saad, *Iterative
    /// Methods for Sparse Linear Systems*, algorithm 12.1).
    fn smooth(&mut self, degree: usize, above: f32, from_zero: bool) {
        let (theta, delta) = (
            0.5 * (LARGEST_EIGENVALUE + above),
            0.5 * (LARGEST_EIGENVALUE - above),
        );
        let sigma = theta / delta;
        let mut rho = 1.0 / sigma;
        for step in 0..degree {
            if step == 0 && from_zero {
                self.residual.copy_from_slice(&self.right);
            } else {
                self.find_residual();
            }
            let next = 1.0 / (2.0 * sigma - rho);
            let (keep, take) = if step == 0 {
                (0.0, 1.0 / theta)
            } else {
                (next * rho, 2.0 * next / delta)
            };
            if step > 0 {
                rho = next;
            }
            let Self {
                operator,
                x,
                residual,
                direction,
                ..
            } = self;
            operator.inner_rows(direction, |row, start| {
                let (residual, diagonal) = (&residual[start..], &operator.diagonal[start..]);
                for ((value, r), d) in row.iter_mut().zip(residual).zip(diagonal) {
                    *value = keep * *value + take * r / d;
                }
            });
            operator.inner_rows(x, |row, start| {
                for (value, d) in row.iter_mut().zip(&direction[start..]) {
                    *value += d;
                }
            });
        }
    }
}

/// The operator with half the points along each axis; `None` where that leaves too few.
fn coarsen(fine: &Operator) -> Option<Operator> {
    let halves = |points: usize| {
        (points % 2 == 1 && points.div_ceil(2) >= FEWEST_POINTS).then(|| points.div_ceil(2))
    };
    let shape = [
        halves(fine.shape[0])?,
        halves(fine.shape[1])?,
        halves(fine.shape[2])?,
    ];
    let strides = fine.strides();
    let count: usize = shape.iter().product();
    let clamp = |index: isize, axis: usize| index.clamp(0, fine.shape[axis] as isize - 1) as usize;
    let at = |i: isize, j: isize, k: isize| {
        clamp(i, 0) + clamp(j, 1) * strides[1] + clamp(k, 2) * strides[2]
    };
    let weights = [(-1, 0.25_f32), (0, 0.5), (1, 0.25)];
    let plane = shape[0] * shape[1];
    let edges = std::array::from_fn(|axis| {
        let mut edge = vec![0.0_f32; count];
        edge.par_chunks_mut(plane)
            .enumerate()
            .for_each(|(k, values)| {
                for (n, value) in values.iter_mut().enumerate() {
                    let place = [
                        2 * (n % shape[0]) as isize,
                        2 * (n / shape[0]) as isize,
                        2 * k as isize,
                    ];
                    let along = place[axis] + 1 < fine.shape[axis] as isize;
                    let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
                    for (da, wa) in weights {
                        for (db, wb) in weights {
                            let mut p = place;
                            p[second] += da;
                            p[third] += db;
                            let first = fine.edges[axis][at(p[0], p[1], p[2])];
                            p[axis] += 1;
                            let next = if along {
                                fine.edges[axis][at(p[0], p[1], p[2])]
                            } else {
                                first
                            };
                            // Two in series over twice the length; the coarse face is four times as
                            // large: 4 · (1/2) · harmonic mean.
                            *value += wa * wb * 2.0 * 2.0 * first * next
                                / (first + next).max(f32::MIN_POSITIVE);
                        }
                    }
                }
            });
        edge
    });
    let mut mass = vec![0.0_f32; count];
    mass.par_chunks_mut(plane)
        .enumerate()
        .for_each(|(k, values)| {
            for (n, value) in values.iter_mut().enumerate() {
                let place = [
                    2 * (n % shape[0]) as isize,
                    2 * (n / shape[0]) as isize,
                    2 * k as isize,
                ];
                for (di, wi) in weights {
                    for (dj, wj) in weights {
                        for (dk, wk) in weights {
                            *value += 8.0
                                * wi
                                * wj
                                * wk
                                * fine.mass[at(place[0] + di, place[1] + dj, place[2] + dk)];
                        }
                    }
                }
            }
        });
    Some(Operator::new(shape, edges, mass))
}

/// coarse = Pᵀ fine, P trilinear interpolation.
fn restrict(fine: &[f32], fine_shape: [usize; 3], coarse: &mut [f32], shape: [usize; 3]) {
    let plane = shape[0] * shape[1];
    let weights = [(-1_isize, 0.5_f32), (0, 1.0), (1, 0.5)];
    coarse
        .par_chunks_mut(plane)
        .enumerate()
        .for_each(|(k, values)| {
            values.fill(0.0);
            if k == 0 || k + 1 == shape[2] {
                return;
            }
            for j in 1..shape[1] - 1 {
                for i in 1..shape[0] - 1 {
                    let mut sum = 0.0;
                    for (dk, wk) in weights {
                        for (dj, wj) in weights {
                            let row = ((2 * k as isize + dk) as usize * fine_shape[1]
                                + (2 * j as isize + dj) as usize)
                                * fine_shape[0]
                                + 2 * i;
                            sum += wk * wj * (0.5 * (fine[row - 1] + fine[row + 1]) + fine[row]);
                        }
                    }
                    values[j * shape[0] + i] = sum;
                }
            }
        });
}

/// fine += P coarse.
fn prolong(coarse: &[f32], shape: [usize; 3], fine: &mut [f32], fine_shape: [usize; 3]) {
    let plane = fine_shape[0] * fine_shape[1];
    fine.par_chunks_mut(plane)
        .enumerate()
        .for_each(|(k, values)| {
            if k == 0 || k + 1 == fine_shape[2] {
                return;
            }
            let span = |index: usize| (index / 2, index.div_ceil(2));
            let (k0, k1) = span(k);
            for j in 1..fine_shape[1] - 1 {
                let (j0, j1) = span(j);
                let row = |k: usize, j: usize| {
                    &coarse[(k * shape[1] + j) * shape[0]..(k * shape[1] + j + 1) * shape[0]]
                };
                let rows = [row(k0, j0), row(k0, j1), row(k1, j0), row(k1, j1)];
                let mean = |i: usize| 0.25 * (rows[0][i] + rows[1][i] + rows[2][i] + rows[3][i]);
                let target = &mut values[j * fine_shape[0]..(j + 1) * fine_shape[0]];
                for (i, value) in target
                    .iter_mut()
                    .enumerate()
                    .skip(1)
                    .take(fine_shape[0] - 2)
                {
                    let (i0, i1) = span(i);
                    *value += 0.5 * (mean(i0) + mean(i1));
                }
            }
        });
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    fn operator(shape: [usize; 3], seed: u64) -> Operator {
        let mut rng = CounterRng::new(seed, 0, 0);
        let count = shape.iter().product();
        let edges = std::array::from_fn(|_| {
            (0..count)
                .map(|_| {
                    if rng.uniform_in(0.0, 1.0) < 0.5 {
                        2.0
                    } else {
                        80.0
                    }
                })
                .collect()
        });
        let mass = (0..count)
            .map(|_| rng.uniform_in(0.0, 1.0) as f32)
            .collect();
        Operator::new(shape, edges, mass)
    }

    fn inner(shape: [usize; 3], rng: &mut CounterRng) -> Vec<f64> {
        let on_face = |index: usize, points: usize| index == 0 || index + 1 == points;
        (0..shape.iter().product())
            .map(|n| {
                let (i, j, k) = (
                    n % shape[0],
                    n / shape[0] % shape[1],
                    n / shape[0] / shape[1],
                );
                let face = on_face(i, shape[0]) || on_face(j, shape[1]) || on_face(k, shape[2]);
                if face { 0.0 } else { rng.uniform_in(-1.0, 1.0) }
            })
            .collect()
    }

    #[test]
    fn operator_and_cycle_are_symmetric_and_positive() {
        let shape = [17, 9, 33];
        let a = operator(shape, 1);
        let mut cycle = Multigrid::new(&a);
        let mut rng = CounterRng::new(2, 0, 0);
        let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(a, b)| a * b).sum::<f64>();
        for _ in 0..5 {
            let (x, y) = (inner(shape, &mut rng), inner(shape, &mut rng));
            let (mut ax, mut ay) = (vec![0.0; x.len()], vec![0.0; x.len()]);
            a.apply(&x, &mut ax);
            a.apply(&y, &mut ay);
            assert!(
                (dot(&ax, &y) - dot(&x, &ay)).abs()
                    < 1e-9 * dot(&ax, &ax).sqrt() * dot(&y, &y).sqrt()
            );
            assert!(dot(&ax, &x) > 0.0);
            let (mut mx, mut my) = (vec![0.0; x.len()], vec![0.0; x.len()]);
            cycle.apply(&x, &mut mx);
            cycle.apply(&y, &mut my);
            assert!(
                (dot(&mx, &y) - dot(&x, &my)).abs()
                    < 1e-4 * dot(&mx, &mx).sqrt() * dot(&y, &y).sqrt()
            );
            assert!(dot(&mx, &x) > 0.0);
        }
    }
}
