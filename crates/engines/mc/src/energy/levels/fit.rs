//! Equivalent charges: a few charges whose potential outside a sphere is that of many inside it.
//!
//! Positions and charges minimise the squared error of the potential at points of a sphere of
//! [`FIT_DISTANCE`] radii and, weighted up, of one far away, where only
//! monopole and dipole are left: errors of those add up over all charges of a partner. The minimum
//! is found by the Levenberg-Marquardt method.

use crate::energy::SitePotential;
use nalgebra::{DMatrix, DVector};
use protomer_kernel::Vec3;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::quadrature::points_on_sphere;

/// Distance at which equivalent charges are fitted, in radii of the node.
pub(super) const FIT_DISTANCE: f32 = 1.5;

const NEAR_POINTS: usize = 120;
const FAR_POINTS: usize = 24;
/// Radius of the far sphere, in radii of the node.
const FAR_DISTANCE: f64 = 6.0;
/// Weight of an error on the far sphere.
const FAR_WEIGHT: f64 = 100.0;
/// Largest number of steps of a fit.
const STEPS: usize = 40;
/// Equivalent charges stay within this many radii.
const LARGEST_DISTANCE: f64 = 0.95;

/// Equivalent charges of a node.
pub(super) struct Equivalent {
    pub charges: Vec<(Vec3, f64)>,
    /// Root mean square error of the potential on the near sphere, kT/e.
    pub error: f64,
}

/// The `count` charges that stand best for these, which lie within `radius` of `centre`.
pub(super) fn fit(
    charges: &[(Vec3, f64)],
    centre: &Vec3,
    radius: f64,
    count: usize,
    potential: &Yukawa,
) -> Equivalent {
    let problem = Problem::new(charges, centre, radius, potential);
    let mut present = problem.start(charges, count);
    let mut cost = problem.residual(&present).norm_squared();
    // Nearly Gauss-Newton at the start.
    let mut damping = 1e-3;
    let mut slopes = problem.slopes(&present);
    for _ in 0..STEPS {
        let Some(trial) = problem.step(&present, &slopes, damping) else {
            damping *= 10.0;
            continue;
        };
        let trial_cost = problem.residual(&trial).norm_squared();
        if trial_cost < cost {
            // Success: trust the quadratic model more. Failure below: shorter and steeper steps.
            (present, cost, damping) = (trial, trial_cost, damping * 0.2);
            slopes = problem.slopes(&present);
        } else {
            damping *= 6.0;
        }
    }
    let near = problem
        .residual(&present)
        .rows(0, NEAR_POINTS)
        .norm_squared();
    Equivalent {
        charges: present,
        error: (near / NEAR_POINTS as f64).sqrt(),
    }
}

/// Half of the first derivatives of the squared error, Jᵀr, and of its second ones, JᵀJ.
struct Slopes {
    gradient: DVector<f64>,
    normal: DMatrix<f64>,
}

/// The potential that is to be met, at points with weights.
struct Problem<'a> {
    potential: &'a Yukawa,
    centre: Vec3,
    radius: f64,
    points: Vec<(Vec3, f64)>,
    wanted: DVector<f64>,
}

impl<'a> Problem<'a> {
    fn new(charges: &[(Vec3, f64)], centre: &Vec3, radius: f64, potential: &'a Yukawa) -> Self {
        let near = sphere(NEAR_POINTS, f64::from(FIT_DISTANCE) * radius, 1.0);
        let far = sphere(FAR_POINTS, FAR_DISTANCE * radius, FAR_WEIGHT);
        // Weights multiply residuals: the far sphere counts FAR_WEIGHT² in the squared error.
        let points: Vec<(Vec3, f64)> = near.chain(far).map(|(x, w)| (centre + x, w)).collect();
        let wanted = points
            .iter()
            .map(|(x, weight)| weight * field(charges, x, potential));
        Self {
            potential,
            centre: *centre,
            radius,
            wanted: DVector::from_iterator(points.len(), wanted),
            points,
        }
    }

    /// Charges spread out among those there are, each with the sum of those nearest to it.
    fn start(&self, charges: &[(Vec3, f64)], count: usize) -> Vec<(Vec3, f64)> {
        let mut chosen: Vec<(Vec3, f64)> = vec![(charges[0].0, 0.0)];
        let gap = |x: &Vec3, chosen: &[(Vec3, f64)]| {
            chosen
                .iter()
                .map(|(y, _)| (x - y).norm_squared())
                .fold(f64::INFINITY, f64::min)
        };
        // Farthest-point sampling: no two start in one
        // place, where the fit could not separate them.
        while chosen.len() < count.min(charges.len()) {
            let farthest = charges
                .iter()
                .max_by(|a, b| gap(&a.0, &chosen).total_cmp(&gap(&b.0, &chosen)));
            chosen.push((farthest.map_or(self.centre, |(x, _)| *x), 0.0));
        }
        // Every charge goes to its nearest representative, so the monopole is right at the start.
        for (x, q) in charges {
            let near = |a: &&mut (Vec3, f64), b: &&mut (Vec3, f64)| {
                (a.0 - x)
                    .norm_squared()
                    .total_cmp(&(b.0 - x).norm_squared())
            };
            if let Some(nearest) = chosen.iter_mut().min_by(near) {
                nearest.1 += q;
            }
        }
        chosen
    }

    fn residual(&self, charges: &[(Vec3, f64)]) -> DVector<f64> {
        let values = self
            .points
            .iter()
            .map(|(x, weight)| weight * field(charges, x, self.potential));
        DVector::from_iterator(self.points.len(), values) - &self.wanted
    }

    fn slopes(&self, charges: &[(Vec3, f64)]) -> Slopes {
        let mut jacobian = DMatrix::zeros(self.points.len(), 4 * charges.len());
        for (row, (x, weight)) in self.points.iter().enumerate() {
            for (k, (y, charge)) in charges.iter().enumerate() {
                let apart = y - x;
                let [value, slope] = self.potential.taylor::<2>(apart.norm_squared());
                // Columns 4k: by the charge; 4k + 1 to 4k + 3: by its place, through t = r².
                jacobian[(row, 4 * k)] = weight * value;
                for axis in 0..3 {
                    // dt/dy = 2 (y - x).
                    let change = weight * charge * 2.0 * slope * apart[axis];
                    jacobian[(row, 4 * k + 1 + axis)] = change;
                }
            }
        }
        Slopes {
            gradient: jacobian.tr_mul(&self.residual(charges)),
            normal: jacobian.tr_mul(&jacobian),
        }
    }

    /// A Levenberg-Marquardt step; `None` where the normal equations have no solution.
    fn step(
        &self,
        charges: &[(Vec3, f64)],
        slopes: &Slopes,
        damping: f64,
    ) -> Option<Vec<(Vec3, f64)>> {
        let mut normal = slopes.normal.clone();
        let scale = normal.diagonal().max();
        for k in 0..normal.nrows() {
            // Marquardt's scaling, and a floor for columns of charges that are zero.
            normal[(k, k)] += damping * normal[(k, k)] + 1e-12 * scale;
        }
        let change = normal.cholesky()?.solve(&slopes.gradient);
        let shifted_charges = charges.iter().enumerate().map(|(k, (y, charge))| {
            let shift = Vec3::new(change[4 * k + 1], change[4 * k + 2], change[4 * k + 3]);
            // Minus: `gradient` is Jᵀr, and the step is -(JᵀJ)⁻¹ Jᵀr.
            (self.inside(y - shift), charge - change[4 * k])
        });
        Some(shifted_charges.collect())
    }

    fn inside(&self, x: Vec3) -> Vec3 {
        // On or outside the sphere, a charge would come close to the points of the fit.
        let from_centre = x - self.centre;
        let farthest = LARGEST_DISTANCE * self.radius;
        match from_centre.norm() > farthest {
            true => self.centre + from_centre.normalize() * farthest,
            false => x,
        }
    }
}

fn field(charges: &[(Vec3, f64)], x: &Vec3, potential: &Yukawa) -> f64 {
    let contribution = |(y, q): &(Vec3, f64)| q * potential.at_square((x - y).norm_squared());
    charges.iter().map(contribution).sum()
}

/// Points spread evenly over a sphere about the origin, with a weight.
fn sphere(count: usize, radius: f64, weight: f64) -> impl Iterator<Item = (Vec3, f64)> {
    points_on_sphere(count).map(move |point| (point * radius, weight))
}
