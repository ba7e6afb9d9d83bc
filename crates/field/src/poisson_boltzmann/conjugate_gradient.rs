//! Conjugate gradients with a preconditioner (Hestenes and Stiefel, J. Res. Natl. Bur. Stand. 49,
//! 409 (1952)).

use super::multigrid::Multigrid;
use super::operator::Operator;
use crate::{FieldError, Result};
use rayon::prelude::*;

/// Iterations after which the solver gives up.
const MOST_ITERATIONS: usize = 300;
/// Sums are taken in pieces of this length, so that they do not depend on threads.
const PIECE: usize = 1 << 14;
/// Partial sums within a piece.
const LANES: usize = 8;

/// Solves A x = b on the inner points, from the x given, whose values on the faces stay as they are.
/// Returns the iterations made.
pub(super) fn solve(
    a: &Operator,
    b: Vec<f64>,
    x: &mut [f64],
    relative_tolerance: f64,
) -> Result<usize> {
    let mut preconditioner = Multigrid::new(a);
    let mut p = vec![0.0; b.len()];
    let mut ap = vec![0.0; b.len()];
    let mut r = residual(a, b, x, &mut ap);
    let start = dot(&r, &r);
    if start == 0.0 {
        return Ok(0);
    }
    let mut rz = 0.0;
    for iteration in 0..MOST_ITERATIONS {
        let rr = dot(&r, &r);
        if rr <= relative_tolerance * relative_tolerance * start {
            return Ok(iteration);
        }
        let z = preconditioner.apply(&r);
        let before = rz;
        rz = dot(&r, z);
        let beta = if iteration == 0 { 0.0 } else { rz / before };
        // p = z + β p.
        p.par_iter_mut()
            .zip(z)
            .for_each(|(p, z)| *p = f64::from(*z) + beta * *p);
        a.apply(&p, &mut ap);
        let step = rz / dot(&p, &ap);
        add_scaled(x, step, &p);
        add_scaled(&mut r, -step, &ap);
    }
    Err(FieldError::NotConverged {
        iterations: MOST_ITERATIONS,
        relative_residual: (dot(&r, &r) / start).sqrt(),
    })
}

/// b - A x on the inner points, zero on the faces; `ax` is overwritten.
fn residual(a: &Operator, mut b: Vec<f64>, x: &[f64], ax: &mut [f64]) -> Vec<f64> {
    a.apply(x, ax);
    add_scaled(&mut b, -1.0, ax);
    a.clear_faces(&mut b);
    b
}

/// x += factor · y.
fn add_scaled(x: &mut [f64], factor: f64, y: &[f64]) {
    x.par_iter_mut().zip(y).for_each(|(x, y)| *x += factor * y);
}

/// a · b.
fn dot<T: Copy + Into<f64> + Sync>(a: &[f64], b: &[T]) -> f64 {
    let pieces = a.par_chunks(PIECE).zip(b.par_chunks(PIECE));
    let sums: Vec<f64> = pieces.map(|(a, b)| dot_of_piece(a, b)).collect();
    sums.iter().sum()
}

fn dot_of_piece<T: Copy + Into<f64>>(a: &[f64], b: &[T]) -> f64 {
    let (a_chunks, a_rest) = a.as_chunks::<LANES>();
    let (b_chunks, b_rest) = b.as_chunks::<LANES>();
    let mut lanes = [0.0; LANES];
    for (a, b) in a_chunks.iter().zip(b_chunks) {
        for lane in 0..LANES {
            lanes[lane] += a[lane] * b[lane].into();
        }
    }
    let mut rest = 0.0;
    for (a, b) in a_rest.iter().zip(b_rest) {
        rest += a * (*b).into();
    }
    lanes.iter().sum::<f64>() + rest
}
