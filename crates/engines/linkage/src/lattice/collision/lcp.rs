//! Linear complementarity problems with a symmetric positive semidefinite matrix.
//!
//! 0 ≤ p ⟂ w = W p + q ≥ 0 are the conditions of the least ½ pᵀ W p + qᵀ p over p ≥ 0. The
//! active-set method of Lawson and Hanson finds it exactly in finitely many steps: it solves W p =
//! -q on a growing set of contacts, and takes those out whose impulse would have to pull. For q in
//! the range of W (which velocities guarantee) a contact that depends on those already in the set
//! has w = 0 once they have, and is never added.

/// A solution of the complementarity problem.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// Impulses p ≥ 0.
    pub impulses: Vec<f64>,
    /// Rates W p + q after the impulses.
    pub rates: Vec<f64>,
    /// False if the active-set method did not end and relaxation took over (no case is known).
    pub exact: bool,
}

/// Largest amount by which w may be below zero, relative to the largest q.
const TOLERANCE: f64 = 1e-13;
/// A pivot this small, relative to its diagonal, means a dependent contact.
const DEPENDENT: f64 = 1e-11;
/// An impulse this small, relative to the step that took it down, is zero but for rounding.
const VANISHED: f64 = 1e-14;
/// Relaxation ends when no impulse moves by more.
const SETTLED: f64 = 1e-15;
/// Largest number of sweeps of the relaxation.
const MOST_SWEEPS: usize = 20_000;

/// Solves 0 ≤ p ⟂ W p + q ≥ 0 for W given row by row.
///
/// ```
/// use protomer_linkage::lattice::collision::lcp;
/// // Two contacts that do not know of each other: one approaches at 3, the other opens at 1.
/// let solution = lcp::solve(&[2.0, 0.0, 0.0, 2.0], &[-3.0, 1.0]);
/// assert_eq!(solution.impulses, [1.5, 0.0]);
/// assert_eq!(solution.rates, [0.0, 1.0]);
/// ```
pub fn solve(w: &[f64], q: &[f64]) -> Solution {
    let mut search = ActiveSet::new(Problem { w, q });
    // A bound on the entries into the set; in exact arithmetic the method ends by itself.
    for _ in 0..10 * q.len() + 20 {
        let rates = search.problem.rates(&search.p);
        let Some(entering) = search.most_violated(&rates) else {
            return Solution {
                impulses: search.p,
                rates,
                exact: true,
            };
        };
        search.admit(entering);
    }
    search.problem.relax(search.p)
}

#[derive(Clone, Copy)]
struct Problem<'a> {
    w: &'a [f64],
    q: &'a [f64],
}

impl Problem<'_> {
    fn entry(&self, row: usize, column: usize) -> f64 {
        self.w[row * self.q.len() + column]
    }

    /// W p + q in one row.
    fn rate(&self, p: &[f64], row: usize) -> f64 {
        let mut sum = 0.0;
        for (column, p) in p.iter().enumerate() {
            sum += self.entry(row, column) * p;
        }
        self.q[row] + sum
    }

    fn rates(&self, p: &[f64]) -> Vec<f64> {
        (0..p.len()).map(|row| self.rate(p, row)).collect()
    }

    /// Projected Gauss-Seidel.
    fn relax(&self, mut p: Vec<f64>) -> Solution {
        for _ in 0..MOST_SWEEPS {
            let mut largest_change = 0.0_f64;
            for row in 0..p.len() {
                let diagonal = self.entry(row, row);
                if diagonal > 0.0 {
                    // One unknown at a time, never below zero.
                    let next = (p[row] - self.rate(&p, row) / diagonal).max(0.0);
                    largest_change = largest_change.max((next - p[row]).abs());
                    p[row] = next;
                }
            }
            if largest_change <= SETTLED {
                break;
            }
        }
        Solution {
            rates: self.rates(&p),
            impulses: p,
            exact: false,
        }
    }
}

/// The contacts that push, and their impulses.
struct ActiveSet<'a> {
    problem: Problem<'a>,
    tolerance: f64,
    p: Vec<f64>,
    inside: Vec<usize>,
    /// Contacts that left the set as soon as they entered it; they may try again once the set has
    /// changed.
    refused: Vec<bool>,
}

impl<'a> ActiveSet<'a> {
    fn new(problem: Problem<'a>) -> Self {
        let count = problem.q.len();
        let mut largest = 0.0_f64;
        for q in problem.q {
            largest = largest.max(q.abs());
        }
        Self {
            problem,
            tolerance: TOLERANCE * largest,
            p: vec![0.0; count],
            inside: Vec::new(),
            refused: vec![false; count],
        }
    }

    /// The contact outside the set that approaches fastest.
    fn most_violated(&self, rates: &[f64]) -> Option<usize> {
        let mut worst = None;
        let mut lowest = -self.tolerance;
        for (contact, rate) in rates.iter().enumerate() {
            // A refused contact waits until the set has changed.
            let may_enter = !self.refused[contact] && !self.inside.contains(&contact);
            if may_enter && *rate < lowest {
                (worst, lowest) = (Some(contact), *rate);
            }
        }
        worst
    }

    /// Takes a contact into the set and solves on it, taking those out that would have to pull.
    fn admit(&mut self, entering: usize) {
        self.inside.push(entering);
        // Contacts that would have to pull leave one after the other, until none has to.
        while let Some(trial) = solve_on(&self.problem, &self.inside) {
            if self.move_towards(&trial) {
                // The set has changed: what was refused may fit now.
                self.refused.fill(false);
                break;
            }
            for contact in self.blocking(&trial) {
                self.p[contact] = 0.0;
                if contact == entering {
                    self.refused[contact] = true;
                }
                self.inside.retain(|member| *member != contact);
            }
        }
        if self.inside.contains(&entering) && self.p[entering] == 0.0 {
            self.inside.retain(|member| *member != entering);
            self.refused[entering] = true;
        }
    }

    /// Moves the impulses towards a trial solution as far as none has to pull; true if they reach
    /// it.
    fn move_towards(&mut self, trial: &[f64]) -> bool {
        let mut share = 1.0_f64;
        for (contact, z) in self.inside.iter().zip(trial) {
            if *z <= 0.0 {
                let p = self.p[*contact];
                // p + s (z - p) = 0 at s = p/(p - z): the first impulse to vanish sets the share.
                share = share.min(p / (p - z));
            }
        }
        for (contact, z) in self.inside.iter().zip(trial) {
            let p = &mut self.p[*contact];
            *p += share * (z - *p);
        }
        let arrived = share >= 1.0 && trial.iter().all(|z| *z > 0.0);
        if arrived {
            // Exactly the solution, not the sum of a difference.
            for (contact, z) in self.inside.iter().zip(trial) {
                self.p[*contact] = *z;
            }
        }
        arrived
    }

    /// The contacts that set the limit of a move: those whose impulse has come down to zero, or, if
    /// rounding hides them, the one with the smallest impulse.
    fn blocking(&self, trial: &[f64]) -> Vec<usize> {
        let (mut vanished, mut smallest) = (Vec::new(), None);
        let mut least = f64::INFINITY;
        for (contact, z) in self.inside.iter().zip(trial) {
            let p = self.p[*contact];
            if *z <= 0.0 && p <= VANISHED * z.abs().max(f64::MIN_POSITIVE) {
                vanished.push(*contact);
            } else if p < least {
                (smallest, least) = (Some(*contact), p);
            }
        }
        // Rounding has left no exact zero: the smallest has to go, or the loop would not end.
        if vanished.is_empty() {
            vanished.extend(smallest);
        }
        vanished
    }
}

/// W z = -q on a set of contacts by Cholesky with one refinement; `None` if they depend on each
/// other.
fn solve_on(problem: &Problem, inside: &[usize]) -> Option<Vec<f64>> {
    let factor = Cholesky::new(problem, inside)?;
    let mut z: Vec<f64> = inside.iter().map(|contact| -problem.q[*contact]).collect();
    factor.solve(&mut z);
    let mut residual = Vec::with_capacity(inside.len());
    for row in inside {
        // One refinement: impulses of nearly dependent contacts keep their digits.
        let mut sum = 0.0;
        for (column, z) in inside.iter().zip(&z) {
            sum += problem.entry(*row, *column) * z;
        }
        residual.push(-problem.q[*row] - sum);
    }
    factor.solve(&mut residual);
    for (z, correction) in z.iter_mut().zip(residual) {
        *z += correction;
    }
    Some(z)
}

/// L with L Lᵀ = W on a set of contacts.
struct Cholesky {
    size: usize,
    factor: Vec<f64>,
}

impl Cholesky {
    fn new(problem: &Problem, inside: &[usize]) -> Option<Self> {
        let size = inside.len();
        let mut cholesky = Self {
            size,
            factor: vec![0.0; size * size],
        };
        for row in 0..size {
            for column in 0..=row {
                let entry = problem.entry(inside[row], inside[column]);
                let remainder = entry - cholesky.product_of_rows(row, column);
                cholesky.factor[row * size + column] = if row == column {
                    // Relative to its own diagonal: this contact follows from those before it.
                    if remainder.is_nan() || remainder <= DEPENDENT * entry {
                        return None;
                    }
                    remainder.sqrt()
                } else {
                    remainder / cholesky.element(column, column)
                };
            }
        }
        Some(cholesky)
    }

    fn element(&self, row: usize, column: usize) -> f64 {
        self.factor[row * self.size + column]
    }

    /// Σ L_rk L_ck over the columns k before c.
    fn product_of_rows(&self, row: usize, column: usize) -> f64 {
        (0..column)
            .map(|k| self.element(row, k) * self.element(column, k))
            .sum()
    }

    /// Replaces b by W⁻¹ b.
    fn solve(&self, b: &mut [f64]) {
        for row in 0..self.size {
            let partial_sum: f64 = (0..row).map(|k| self.element(row, k) * b[k]).sum();
            b[row] = (b[row] - partial_sum) / self.element(row, row);
        }
        for row in (0..self.size).rev() {
            let partial_sum: f64 = (row + 1..self.size)
                .map(|k| self.element(k, row) * b[k])
                .sum();
            b[row] = (b[row] - partial_sum) / self.element(row, row);
        }
    }
}
