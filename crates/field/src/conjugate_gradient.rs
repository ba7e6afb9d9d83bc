//! Conjugate gradients with a preconditioner (Hestenes and Stiefel, J. Res. Natl. Bur. Stand. 49,
//! 409 (1952)).

use crate::multigrid::Multigrid;
use crate::operator::Operator;
use crate::{FieldError, Result};
use rayon::prelude::*;

/// Iterations after which a solution is given up.
const MOST_ITERATIONS: usize = 300;
/// Sums are taken in pieces of this length, so that they do not depend on threads.
const PIECE: usize = 1 << 14;

/// Solves A x = b on the inner points, from the x given. Returns the iterations made.
pub fn solve(a: &Operator, b: &[f64], x: &mut [f64], relative_tolerance: f64) -> Result<usize> {
    let mut preconditioner = Multigrid::new(a);
    let zeros = || vec![0.0; b.len()];
    let (mut r, mut z, mut p, mut ap) = (zeros(), zeros(), zeros(), zeros());
    a.apply(x, &mut ap);
    a.inner_rows(&mut r, |row, start| {
        for (offset, r) in row.iter_mut().enumerate() {
            *r = b[start + offset] - ap[start + offset];
        }
    });
    let start = dot(b, b).max(dot(&r, &r));
    if start == 0.0 {
        return Ok(0);
    }
    let mut rz = 0.0;
    for iteration in 0..MOST_ITERATIONS {
        let rr = dot(&r, &r);
        if rr <= relative_tolerance * relative_tolerance * start {
            return Ok(iteration);
        }
        preconditioner.apply(&r, &mut z);
        let before = rz;
        rz = dot(&r, &z);
        let beta = if iteration == 0 { 0.0 } else { rz / before };
        p.par_iter_mut()
            .zip(&z)
            .for_each(|(p, z)| *p = z + beta * *p);
        a.apply(&p, &mut ap);
        let step = rz / dot(&p, &ap);
        x.par_iter_mut().zip(&p).for_each(|(x, p)| *x += step * p);
        r.par_iter_mut()
            .zip(&ap)
            .for_each(|(r, ap)| *r -= step * ap);
    }
    Err(FieldError::NotConverged {
        iterations: MOST_ITERATIONS,
        relative_residual: (dot(&r, &r) / start).sqrt(),
    })
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let pieces: Vec<f64> = a
        .par_chunks(PIECE)
        .zip(b.par_chunks(PIECE))
        .map(|(a, b)| {
            let mut lanes = [0.0; 8];
            for (a, b) in a.chunks_exact(8).zip(b.chunks_exact(8)) {
                for lane in 0..8 {
                    lanes[lane] += a[lane] * b[lane];
                }
            }
            let rest = a.len() / 8 * 8;
            lanes.iter().sum::<f64>()
                + a[rest..]
                    .iter()
                    .zip(&b[rest..])
                    .map(|(a, b)| a * b)
                    .sum::<f64>()
        })
        .collect();
    pieces.iter().sum()
}
