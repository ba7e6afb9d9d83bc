//! An approximate inverse of the operator, for conjugate gradients: one V-cycle.
//!
//! Every level has half the points along each axis (`transfer`). Smoothing is by Chebyshev
//! polynomials of D⁻¹ A, which need no order of points, so results do not depend on threads. The
//! cycle is symmetric, as conjugate gradients require. Single precision is enough for a
//! preconditioner.

use super::operator::{Operator, Step};
use super::transfer::{coarsen, prolong, restrict};
use std::borrow::Cow;
use std::mem::swap;

/// Degree of the smoothing polynomials.
const SMOOTHING: usize = 3;
/// Smoothing damps the part of the spectrum of D⁻¹ A above this.
const SMOOTHED_ABOVE: f32 = 0.2;
/// The whole spectrum of D⁻¹ A lies below this.
const LARGEST_EIGENVALUE: f32 = 2.0;
/// Degree of the polynomial that replaces a solution on the coarsest level, if its spectrum lies above
/// [`COARSEST_ABOVE`]; [`Coarsest`] raises it where eigenvalues are lower.
const COARSEST: usize = 24;
/// Lower end of the spectrum for which [`COARSEST`] is enough.
const COARSEST_ABOVE: f32 = 0.02;

/// A hierarchy of grids.
#[derive(Debug)]
pub(super) struct Multigrid<'a> {
    levels: Vec<Level<'a>>,
}

#[derive(Debug)]
struct Level<'a> {
    operator: Cow<'a, Operator>,
    x: Vec<f32>,
    right: Vec<f32>,
    /// The x before and then the next one, or the residual.
    other: Vec<f32>,
}

impl<'a> Multigrid<'a> {
    pub fn new(finest: &'a Operator) -> Self {
        let mut levels = vec![Level::new(Cow::Borrowed(finest))];
        while let Some(coarse) = coarsen(&levels[levels.len() - 1].operator) {
            levels.push(Level::new(Cow::Owned(coarse)));
        }
        Self { levels }
    }

    /// The residual r, zero on the faces, to be set before [`Self::apply`].
    pub fn right(&mut self) -> &mut [f32] {
        &mut self.levels[0].right
    }

    /// The residual r, and a list that is approximately A⁻¹ r.
    pub fn apply(&mut self) -> (&[f32], &[f32]) {
        self.cycle();
        let Level { right, x, .. } = &self.levels[0];
        (right, x)
    }

    fn cycle(&mut self) {
        let last = self.levels.len() - 1;
        // Down: smooth, restrict what is left. The first iterate is zero, which saves a pass.
        for depth in 0..last {
            let [fine, coarse] = self.level_and_next(depth);
            fine.smooth(SMOOTHING, SMOOTHED_ABOVE, true);
            // `other` is free between smoothings and holds the residual.
            fine.find_residual();
            let shapes = [fine.operator.shape, coarse.operator.shape];
            restrict(&fine.other, &mut coarse.right, shapes);
        }
        // The coarsest grid cannot be halved again; a longer polynomial replaces a solution.
        let Coarsest { degree, above } = Coarsest::from_shape(self.levels[last].operator.shape);
        self.levels[last].smooth(degree, above, true);
        // Up: the mirror image of the way down, so that the cycle is symmetric.
        for depth in (0..last).rev() {
            let [fine, coarse] = self.level_and_next(depth);
            let shapes = [fine.operator.shape, coarse.operator.shape];
            prolong(&coarse.x, &mut fine.x, shapes);
            fine.smooth(SMOOTHING, SMOOTHED_ABOVE, false);
        }
    }

    /// A level and the next coarser one.
    fn level_and_next(&mut self, depth: usize) -> [&mut Level<'a>; 2] {
        let (fine, coarse) = self.levels.split_at_mut(depth + 1);
        [&mut fine[depth], &mut coarse[0]]
    }
}

/// Polynomial that replaces a solution on the coarsest level.
struct Coarsest {
    degree: usize,
    above: f32,
}

impl Coarsest {
    /// The lowest eigenvalue of D⁻¹ A for a uniform medium without salt, with zeros on the faces, is
    /// 1/3 Σ (1 - cos π/n) over the axes, n cells along each. The degree grows as the root of the
    /// condition number.
    fn from_shape(shape: [usize; 3]) -> Self {
        let mut lowest = 0.0;
        for points in shape {
            // The slowest mode is half a wave over the n = points - 1 cells of an axis.
            lowest += (1.0 - (std::f32::consts::PI / (points - 1) as f32).cos()) / 3.0;
        }
        let above = lowest.min(COARSEST_ABOVE);
        let degree = (COARSEST as f32 * (COARSEST_ABOVE / above).sqrt()).ceil() as usize;
        Self { degree, above }
    }
}

impl<'a> Level<'a> {
    fn new(operator: Cow<'a, Operator>) -> Self {
        let zeros = || vec![0.0; operator.len()];
        Self {
            x: zeros(),
            right: zeros(),
            other: zeros(),
            operator,
        }
    }

    /// The residual b - A x.
    fn find_residual(&mut self) {
        let Self {
            operator, x, right, ..
        } = self;
        operator.inner_planes(&mut self.other, |plane, start| {
            operator.residual_row(x, right, plane, start);
        });
    }

    /// Chebyshev iteration on D⁻¹ A x = D⁻¹ b for eigenvalues from `above` to 2 (Saad, *Iterative
    /// Methods for Sparse Linear Systems*, algorithm 12.1), with the last x instead of its direction:
    /// one list less to read and write.
    fn smooth(&mut self, degree: usize, above: f32, from_zero: bool) {
        // Centre and half-width of the interval in which the polynomial is small.
        let theta = 0.5 * (LARGEST_EIGENVALUE + above);
        let delta = 0.5 * (LARGEST_EIGENVALUE - above);
        let sigma = theta / delta;
        let mut rho = 1.0 / sigma;
        if from_zero {
            // From x = 0, D⁻¹ b / θ needs no product with A.
            self.start(1.0 / theta);
        } else {
            let take = 1.0 / theta;
            self.advance(Step { keep: 0.0, take });
        }
        for _ in 1..degree {
            // The three-term recurrence of Chebyshev polynomials.
            let next = 1.0 / (2.0 * sigma - rho);
            self.advance(Step {
                keep: next * rho,
                take: 2.0 * next / delta,
            });
            rho = next;
        }
    }

    /// The step from zero, which stays as the last x.
    fn start(&mut self, take: f32) {
        let Self {
            operator,
            x,
            right,
            other,
        } = self;
        // The "last" x of the next step is zero, as from it the step was made.
        other.fill(0.0);
        operator.inner_planes(x, |plane, start| {
            operator.scale_row(right, take, plane, start);
        });
    }

    /// Makes one step, in one pass over the grid.
    fn advance(&mut self, step: Step) {
        let Self {
            operator,
            x,
            right,
            other,
        } = self;
        operator.inner_planes(other, |plane, start| {
            operator.step_row(x, right, step, plane, start);
        });
        // `other` held the last x and received the new one in the same pass.
        swap(x, other);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    fn operator(shape: [usize; 3], seed: u64) -> Operator {
        let mut rng = CounterRng::new(seed, 0, 0);
        let count = shape.iter().product();
        let mut permittivity = |_| if rng.uniform() < 0.5 { 2.0 } else { 80.0 };
        let edges = [0; 3].map(|_| (0..count).map(&mut permittivity).collect());
        let mass = (0..count).map(|_| rng.uniform() as f32).collect();
        Operator::new(shape, edges, mass)
    }

    fn inner(shape: [usize; 3], rng: &mut CounterRng) -> Vec<f32> {
        let mut values = vec![0.0; shape.iter().product()];
        for k in 1..shape[2] - 1 {
            for j in 1..shape[1] - 1 {
                for i in 1..shape[0] - 1 {
                    values[(k * shape[1] + j) * shape[0] + i] = rng.uniform_in(-1.0, 1.0) as f32;
                }
            }
        }
        values
    }

    fn dot(x: &[f32], y: &[f32]) -> f64 {
        let terms = x.iter().zip(y);
        terms.map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
    }

    fn solved(cycle: &mut Multigrid, right: &[f32]) -> Vec<f32> {
        cycle.right().copy_from_slice(right);
        cycle.apply().1.to_vec()
    }

    /// A grid with an even number of points has one level. The slowest part of the solution is the
    /// product of sines over the axes.
    #[test]
    fn the_coarsest_level_is_solved_however_many_points_it_has() {
        for points in [12_usize, 32, 60] {
            let shape = [points; 3];
            let count = points.pow(3);
            let a = Operator::new(shape, [0; 3].map(|_| vec![80.0; count]), vec![0.0; count]);
            let mut cycle = Multigrid::new(&a);
            assert_eq!(cycle.levels.len(), 1);
            let sine = |i: usize| (std::f64::consts::PI * i as f64 / (points - 1) as f64).sin();
            let mut right = Vec::with_capacity(count);
            for index in 0..count {
                let [i, j, k] = [1, points, points * points].map(|stride| index / stride % points);
                right.push((sine(i) * sine(j) * sine(k)) as f32);
            }
            a.clear_faces(&mut right);
            let solved = solved(&mut cycle, &right);
            let mut left = vec![0.0; count];
            a.apply(&solved, &mut left);
            for (left, right) in left.iter_mut().zip(&right) {
                *left -= right;
            }
            let part = (dot(&left, &left) / dot(&right, &right)).sqrt();
            assert!(part < 0.05, "{points}: {part}");
        }
    }

    #[test]
    fn operator_and_cycle_are_symmetric_and_positive() {
        let shape = [17, 9, 33];
        let a = operator(shape, 1);
        let mut cycle = Multigrid::new(&a);
        let mut rng = CounterRng::new(2, 0, 0);
        let norm = |x: &[f32]| dot(x, x).sqrt();
        for _ in 0..5 {
            let (x, y) = (inner(shape, &mut rng), inner(shape, &mut rng));
            let (mut ax, mut ay) = (vec![0.0; x.len()], vec![0.0; x.len()]);
            let curvature = a.apply(&x, &mut ax);
            a.apply(&y, &mut ay);
            assert!((dot(&ax, &y) - dot(&x, &ay)).abs() < 1e-6 * norm(&ax) * norm(&y));
            assert!((curvature / dot(&ax, &x) - 1.0).abs() < 1e-6);
            assert!(curvature > 0.0);
            let [mx, my] = [&x, &y].map(|x| solved(&mut cycle, x));
            assert!((dot(&mx, &y) - dot(&x, &my)).abs() < 1e-4 * norm(&mx) * norm(&y));
            assert!(dot(&mx, &x) > 0.0);
        }
    }
}
