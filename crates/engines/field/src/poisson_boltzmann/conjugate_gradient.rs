//! Conjugate gradients with a preconditioner (Hestenes and Stiefel, J. Res. Natl. Bur. Stand. 49,
//! 409 (1952)), in single precision, within refinement in double precision.
//!
//! Single precision halves what is read and written. It carries the residual along to some 10⁻⁶ of its
//! start, so after a reduction to [`BEST_REDUCTION`] it is computed again in double precision, and
//! conjugate gradients start again from there (iterative refinement; Wilkinson, *Rounding Errors in
//! Algebraic Processes*, 1963). So the solution stays exact at tolerances down to 10⁻¹².

use super::dot::{PIECE, dot, dot_of_piece};
use super::multigrid::Multigrid;
use super::operator::Operator;
use crate::{FieldError, Result};
use rayon::prelude::*;

/// Iterations after which the solver gives up.
const MOST_ITERATIONS: usize = 300;
/// The residual is computed again after it has become this part of what it was.
const BEST_REDUCTION: f64 = 1e-4;

/// Solves A x = b on the inner points, where x is zero; its values on the faces stay as they are. Returns
/// the iterations made.
///
/// # Errors
/// [`FieldError::NotConverged`] after too many iterations, and for a residual that is not finite.
pub(super) fn solve(
    a: &Operator,
    b: &[f64],
    x: &mut [f64],
    relative_tolerance: f64,
) -> Result<usize> {
    let mut solver = Solver::new(a);
    let mut norm = solver.find_first_residual(b, x);
    let start = norm;
    let goal = relative_tolerance * start;
    while norm > goal {
        // Single precision carries the residual no further than this.
        let least = BEST_REDUCTION * norm;
        norm = solver.improve(x, norm, goal.max(least));
        // A goal that is met in the last iteration is no failure.
        if solver.iterations >= MOST_ITERATIONS && norm > goal {
            return Err(FieldError::NotConverged {
                iterations: MOST_ITERATIONS,
                relative_residual: norm / start,
            });
        }
        // The goal was below what single precision can carry: the true residual decides.
        if goal < least {
            norm = solver.find_residual(b, x);
        }
    }
    // NaN is not above the goal, and infinity is not above itself.
    if !norm.is_finite() {
        return Err(FieldError::NotConverged {
            iterations: solver.iterations,
            relative_residual: norm / start,
        });
    }
    Ok(solver.iterations)
}

struct Solver<'a> {
    a: &'a Operator,
    /// Preconditioner, which also holds the residual.
    preconditioner: Multigrid<'a>,
    direction: Vec<f32>,
    /// A times the direction.
    product: Vec<f32>,
    iterations: usize,
}

impl<'a> Solver<'a> {
    fn new(a: &'a Operator) -> Self {
        Self {
            a,
            preconditioner: Multigrid::new(a),
            direction: vec![0.0; a.len()],
            product: vec![0.0; a.len()],
            iterations: 0,
        }
    }

    /// Finds the residual b - A x of an x that is zero on the inner points, and returns its norm.
    fn find_first_residual(&mut self, b: &[f64], x: &[f64]) -> f64 {
        let residual = self.preconditioner.right();
        self.a.residual_of_faces(x, b, residual);
        dot(residual, residual).sqrt()
    }

    /// Finds the residual b - A x on the inner points, and returns its norm.
    fn find_residual(&mut self, b: &[f64], x: &[f64]) -> f64 {
        let residual = self.preconditioner.right();
        // In double precision and rounded once: its relative error is that of a single number.
        self.a.residual(x, b, residual);
        dot(residual, residual).sqrt()
    }

    /// Improves x until the norm of the residual, now this, is at most `goal`, or too many iterations
    /// have been made. Returns the norm then.
    fn improve(&mut self, x: &mut [f64], norm: f64, goal: f64) -> f64 {
        // The first β is rz/∞ = 0: the direction starts as z.
        let (mut norm, mut rz) = (norm, f64::INFINITY);
        self.direction.fill(0.0);
        while norm > goal && self.iterations < MOST_ITERATIONS {
            self.iterations += 1;
            let (r, z) = self.preconditioner.apply();
            let before = rz;
            rz = dot(r, z);
            // β = (r·z)/(r·z before): Fletcher and Reeves, as A and the cycle are symmetric.
            set_direction(&mut self.direction, (rz / before) as f32, z);
            let curvature = self.a.apply(&self.direction, &mut self.product);
            // x in double precision: corrections of later rounds are small against it.
            let step = rz / curvature;
            add_scaled(x, step, &self.direction);
            // One pass: the residual and its norm.
            norm = subtract_scaled(self.preconditioner.right(), step as f32, &self.product).sqrt();
        }
        norm
    }
}

/// p = z + β p.
fn set_direction(p: &mut [f32], beta: f32, z: &[f32]) {
    let pieces = p.par_chunks_mut(PIECE).zip(z.par_chunks(PIECE));
    pieces.for_each(|(p, z)| {
        for (p, z) in p.iter_mut().zip(z) {
            *p = z + beta * *p;
        }
    });
}

/// x += factor · y.
fn add_scaled(x: &mut [f64], factor: f64, y: &[f32]) {
    let pieces = x.par_chunks_mut(PIECE).zip(y.par_chunks(PIECE));
    pieces.for_each(|(x, y)| {
        for (x, y) in x.iter_mut().zip(y) {
            *x += factor * f64::from(*y);
        }
    });
}

/// x -= factor · y; returns x · x.
fn subtract_scaled(x: &mut [f32], factor: f32, y: &[f32]) -> f64 {
    let pieces = x.par_chunks_mut(PIECE).zip(y.par_chunks(PIECE));
    let squares = pieces.map(|(x, y)| {
        for (x, y) in x.iter_mut().zip(y) {
            *x -= factor * y;
        }
        dot_of_piece(x, x)
    });
    squares.collect::<Vec<f64>>().iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    /// The slow twin of the residual: each row of A by itself, in double precision.
    fn residual_norm(a: &Operator, b: &[f64], x: &[f64]) -> f64 {
        let [nx, ny, nz] = a.shape;
        let strides = [1, nx, nx * ny];
        let mut square = 0.0;
        for k in 1..nz - 1 {
            for j in 1..ny - 1 {
                for i in 1..nx - 1 {
                    let index = (k * ny + j) * nx + i;
                    let mut residual = b[index] - f64::from(a.mass[index]) * x[index];
                    for (edges, stride) in a.edges.iter().zip(strides) {
                        residual -= f64::from(edges[index]) * (x[index] - x[index + stride]);
                        residual -=
                            f64::from(edges[index - stride]) * (x[index] - x[index - stride]);
                    }
                    square += residual * residual;
                }
            }
        }
        square.sqrt()
    }

    #[test]
    fn the_residual_reaches_the_tolerance_in_double_precision() {
        let shape = [33, 17, 25];
        let count = shape.iter().product();
        let mut rng = CounterRng::new(5, 0, 0);
        let mut permittivity = |_| if rng.uniform() < 0.5 { 2.0 } else { 80.0 };
        let edges = [0; 3].map(|_| (0..count).map(&mut permittivity).collect());
        let mass = (0..count).map(|_| rng.uniform() as f32).collect();
        let a = Operator::new(shape, edges, mass);
        let b: Vec<f64> = (0..count).map(|_| rng.uniform_in(-1.0, 1.0)).collect();
        // Values on the faces are given.
        let mut given: Vec<f64> = (0..count).map(|_| rng.uniform_in(-1.0, 1.0)).collect();
        let [nx, ny, nz] = shape;
        for (index, value) in given.iter_mut().enumerate() {
            let [i, j, k] = [index % nx, index / nx % ny, index / nx / ny];
            let inner = |i: usize, n: usize| i > 0 && i + 1 < n;
            if inner(i, nx) && inner(j, ny) && inner(k, nz) {
                *value = 0.0;
            }
        }
        // The twin of the first residual.
        let (mut first, mut all) = (vec![0.0; count], vec![0.0; count]);
        a.residual_of_faces(&given, &b, &mut first);
        a.residual(&given, &b, &mut all);
        assert_eq!(first, all);
        for tolerance in [1e-2, 1e-4, 1e-6, 1e-12] {
            let mut x = given.clone();
            let start = residual_norm(&a, &b, &x);
            solve(&a, &b, &mut x, tolerance).unwrap();
            let part = residual_norm(&a, &b, &x) / start;
            assert!(part < 1.001 * tolerance, "{tolerance}: {part}");
            assert_eq!(x[..shape[0]], given[..shape[0]]);
        }
        let mut zero = vec![0.0; count];
        assert_eq!(solve(&a, &vec![0.0; count], &mut zero, 1e-6).unwrap(), 0);
    }

    #[test]
    fn too_small_a_tolerance_is_an_error() {
        let (shape, count) = ([9; 3], 729);
        let a = Operator::new(shape, [0; 3].map(|_| vec![80.0; count]), vec![0.0; count]);
        let mut rng = CounterRng::new(6, 0, 0);
        let b: Vec<f64> = (0..count).map(|_| rng.uniform_in(-1.0, 1.0)).collect();
        let error = solve(&a, &b, &mut vec![0.0; count], 1e-25).unwrap_err();
        assert!(matches!(error, FieldError::NotConverged { .. }), "{error}");
    }

    /// The second number is infinite in single precision.
    #[test]
    fn sources_that_are_not_finite_are_an_error() {
        let (shape, count) = ([9; 3], 729);
        let a = Operator::new(shape, [0; 3].map(|_| vec![80.0; count]), vec![0.0; count]);
        for wrong in [f64::NAN, 1e300] {
            let mut b = vec![0.0; count];
            b[count / 2] = wrong;
            let error = solve(&a, &b, &mut vec![0.0; count], 1e-6).unwrap_err();
            assert!(matches!(error, FieldError::NotConverged { .. }), "{error}");
        }
    }
}
