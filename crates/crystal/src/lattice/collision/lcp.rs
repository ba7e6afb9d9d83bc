//! Linear complementarity problems with a symmetric positive semidefinite matrix.
//!
//! 0 ≤ p ⟂ w = W p + q ≥ 0 are the conditions of the least ½ pᵀ W p + qᵀ p over p ≥ 0. The
//! active-set method of Lawson and Hanson finds it exactly in finitely many steps: it solves W p =
//! -q on a growing set of contacts, and takes those out whose impulse would have to pull. For q in
//! the range of W (which velocities guarantee) a contact that depends on those already in the set
//! has w = 0 once they have, and is never asked for.

/// A solution.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// p ≥ 0.
    pub impulses: Vec<f64>,
    /// W p + q.
    pub left: Vec<f64>,
    /// False if the active-set method did not end, and relaxation had to (no case is known).
    pub exact: bool,
}

/// What w may be below zero, relative to the largest q.
const TOLERANCE: f64 = 1e-13;
/// A pivot this small, relative to its diagonal, means a dependent contact.
const DEPENDENT: f64 = 1e-11;
const MOST_SWEEPS: usize = 20_000;

/// Solves 0 ≤ p ⟂ W p + q ≥ 0 for W given row by row.
pub fn solve(w: &[f64], q: &[f64]) -> Solution {
    let count = q.len();
    let tolerance = TOLERANCE * q.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let left = |p: &[f64]| -> Vec<f64> {
        q.iter()
            .zip(w.chunks_exact(count))
            .map(|(q, row)| q + row.iter().zip(p).map(|(w, p)| w * p).sum::<f64>())
            .collect()
    };
    let mut p = vec![0.0; count];
    let mut inside: Vec<usize> = Vec::new();
    let mut refused = vec![false; count];
    if count == 0 {
        return Solution {
            impulses: p,
            left: Vec::new(),
            exact: true,
        };
    }
    for _ in 0..10 * count + 20 {
        let rates = left(&p);
        let open =
            (0..count).filter(|j| !inside.contains(j) && !refused[*j] && rates[*j] < -tolerance);
        let Some(entering) = open.min_by(|a, b| rates[*a].total_cmp(&rates[*b])) else {
            return Solution {
                impulses: p,
                left: rates,
                exact: true,
            };
        };
        inside.push(entering);
        while let Some(trial) = solve_inside(w, q, &inside) {
            let limit = inside
                .iter()
                .zip(&trial)
                .filter(|(_, z)| **z <= 0.0)
                .map(|(j, z)| p[*j] / (p[*j] - z));
            let share = limit.fold(1.0_f64, f64::min);
            for (j, z) in inside.iter().zip(&trial) {
                p[*j] += share * (z - p[*j]);
            }
            if share >= 1.0 && trial.iter().all(|z| *z > 0.0) {
                for (j, z) in inside.iter().zip(&trial) {
                    p[*j] = *z;
                }
                refused.fill(false);
                break;
            }
            // The contact that set the limit goes to zero exactly; rounding must not keep it.
            let stopped: Vec<usize> = inside
                .iter()
                .zip(&trial)
                .filter(|(j, z)| **z <= 0.0 && p[**j] <= 1e-14 * z.abs().max(f64::MIN_POSITIVE))
                .map(|(j, _)| *j)
                .collect();
            let smallest = inside
                .iter()
                .copied()
                .filter(|j| !stopped.contains(j))
                .min_by(|a, b| p[*a].total_cmp(&p[*b]));
            let out = if stopped.is_empty() {
                smallest.into_iter().collect()
            } else {
                stopped
            };
            for j in &out {
                p[*j] = 0.0;
                if *j == entering {
                    refused[*j] = true;
                }
            }
            inside.retain(|j| !out.contains(j));
        }
        if inside.contains(&entering) && p[entering] == 0.0 {
            inside.retain(|j| *j != entering);
            refused[entering] = true;
        }
    }
    relax(w, q, p)
}

/// W z = -q on a set of contacts by Cholesky with one refinement; `None` if they depend on each
/// other.
fn solve_inside(w: &[f64], q: &[f64], inside: &[usize]) -> Option<Vec<f64>> {
    let (count, size) = (q.len(), inside.len());
    let at = |row: usize, column: usize| w[inside[row] * count + inside[column]];
    let mut factor = vec![0.0; size * size];
    for row in 0..size {
        for column in 0..=row {
            let known: f64 = (0..column)
                .map(|k| factor[row * size + k] * factor[column * size + k])
                .sum();
            let rest = at(row, column) - known;
            if row == column {
                if rest.is_nan() || rest <= DEPENDENT * at(row, row) {
                    return None;
                }
                factor[row * size + row] = rest.sqrt();
            } else {
                factor[row * size + column] = rest / factor[column * size + column];
            }
        }
    }
    let back_substitute = |mut b: Vec<f64>| {
        for row in 0..size {
            let known: f64 = (0..row).map(|k| factor[row * size + k] * b[k]).sum();
            b[row] = (b[row] - known) / factor[row * size + row];
        }
        for row in (0..size).rev() {
            let known: f64 = (row + 1..size).map(|k| factor[k * size + row] * b[k]).sum();
            b[row] = (b[row] - known) / factor[row * size + row];
        }
        b
    };
    let mut z = back_substitute(inside.iter().map(|j| -q[*j]).collect());
    let residual = (0..size)
        .map(|row| -q[inside[row]] - (0..size).map(|k| at(row, k) * z[k]).sum::<f64>())
        .collect();
    for (z, correction) in z.iter_mut().zip(back_substitute(residual)) {
        *z += correction;
    }
    Some(z)
}

/// Projected Gauss-Seidel.
fn relax(w: &[f64], q: &[f64], mut p: Vec<f64>) -> Solution {
    let count = q.len();
    let rate =
        |p: &[f64], row: usize| q[row] + (0..count).map(|k| w[row * count + k] * p[k]).sum::<f64>();
    for _ in 0..MOST_SWEEPS {
        let mut moved = 0.0_f64;
        for row in 0..count {
            let diagonal = w[row * count + row];
            if diagonal > 0.0 {
                let next = (p[row] - rate(&p, row) / diagonal).max(0.0);
                moved = moved.max((next - p[row]).abs());
                p[row] = next;
            }
        }
        if moved <= 1e-15 {
            break;
        }
    }
    let left = (0..count).map(|row| rate(&p, row)).collect();
    Solution {
        impulses: p,
        left,
        exact: false,
    }
}
