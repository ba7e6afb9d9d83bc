//! Coexistence: common tangents of free energies per volume.
//!
//! Phases coexist where a line touches the free energy per volume, as a function of a density or packing
//! fraction x, at two points and is nowhere above it: the slope is the chemical potential, and minus
//! the intercept the pressure. With several branches (fluid, crystals), the line is below all of
//! them.
//!
//! All branches are sampled; the lower convex hull of the samples has a long edge exactly where
//! there is a tangent, or a metastable branch in between. Newton's method then finds the touching points. If
//! the hull has no long edge, no phases coexist.

use protomer_kernel::jet::Jet;

/// Newton's method ends when a step is shorter than this part of the density.
const CONVERGED: f64 = 1e-14;
/// Largest number of steps of Newton's method.
const MOST_STEPS: usize = 100;
/// Touching points nearer than this part of their density are one.
const ONE_POINT: f64 = 1e-6;

/// A branch of a free energy.
pub struct Branch<'a> {
    /// Name of the branch.
    pub name: &'a str,
    /// Free energy per volume, with derivatives.
    pub free_energy: &'a dyn Fn(Jet) -> Jet,
    /// Densities at which the branch is sampled, ascending.
    pub samples: Vec<f64>,
}

/// Two phases that coexist.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coexistence {
    /// Indices of the branches of the phases.
    pub branches: [usize; 2],
    /// Densities, ascending.
    pub densities: [f64; 2],
    /// The common slope.
    pub chemical_potential: f64,
    /// Minus the common intercept.
    pub pressure: f64,
}

/// Every coexistence, by density; empty if there is none.
///
/// ```
/// use protomer_kernel::jet::Jet;
/// use protomer_hpmc::tangent::{Branch, coexistences, even_samples};
/// let double_well = |x: Jet| (x * x - 1.0) * (x * x - 1.0) + x * 0.3;
/// let samples = even_samples(-2.0, 2.0, 500);
/// let branch = Branch { name: "one", free_energy: &double_well, samples };
/// let found = coexistences(&[branch]);
/// assert!((found[0].densities[0] + 1.0).abs() < 1e-12);
/// assert!((found[0].chemical_potential - 0.3).abs() < 1e-12);
/// ```
pub fn coexistences(branches: &[Branch<'_>]) -> Vec<Coexistence> {
    let mut points = Vec::new();
    for (
        branch,
        Branch {
            free_energy,
            samples,
            ..
        },
    ) in branches.iter().enumerate()
    {
        for (number, x) in samples.iter().enumerate() {
            let value = free_energy(Jet::variable(*x, 0)).value;
            if value.is_finite() {
                points.push(Point {
                    branch,
                    number,
                    x: *x,
                    value,
                });
            }
        }
    }
    // Ties in density by value: the lower branch is the one that can be touched.
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.value.total_cmp(&b.value)));
    let hull = lower_hull(&points);
    let mut coexistences: Vec<Coexistence> = Vec::new();
    for pair in hull.windows(2) {
        let [low, high] = [pair[0], pair[1]];
        // A long edge skips samples of its branch or leads to another one.
        let is_tangent = low.branch != high.branch || high.number > low.number + 1;
        if is_tangent && let Some(tangent) = touch(branches, [low, high]) {
            let is_known = coexistences.iter().any(|other| other.is_same(&tangent));
            if !is_known {
                coexistences.push(tangent);
            }
        }
    }
    coexistences
}

/// Samples at equal distances.
///
/// ```
/// use protomer_hpmc::tangent::even_samples;
/// assert_eq!(even_samples(1.0, 2.0, 4), [1.0, 1.25, 1.5, 1.75, 2.0]);
/// ```
pub fn even_samples(low: f64, high: f64, intervals: usize) -> Vec<f64> {
    let step = (high - low) / intervals as f64;
    (0..=intervals)
        .map(|number| low + step * number as f64)
        .collect()
}

impl Coexistence {
    fn is_same(&self, other: &Self) -> bool {
        let is_near = |n: usize| {
            let (a, b) = (self.densities[n], other.densities[n]);
            (a - b).abs() <= ONE_POINT * a.abs().max(b.abs())
        };
        self.branches == other.branches && is_near(0) && is_near(1)
    }
}

#[derive(Debug, Clone, Copy)]
struct Point {
    branch: usize,
    number: usize,
    x: f64,
    value: f64,
}

/// The points of the lower convex hull, by density.
fn lower_hull(points: &[Point]) -> Vec<Point> {
    let mut hull: Vec<Point> = Vec::new();
    for point in points {
        // The last point leaves if it is on or above the line past it.
        while let [.., before, last] = hull.as_slice() {
            let slope = (point.value - before.value) / (point.x - before.x);
            let is_above = last.value >= before.value + slope * (last.x - before.x);
            if !is_above {
                break;
            }
            hull.pop();
        }
        // Of two points at one density the lower one comes first.
        if hull.last().is_none_or(|last| last.x < point.x) {
            hull.push(*point);
        }
    }
    hull
}

/// Newton's method for equal slopes and equal intercepts.
fn touch(branches: &[Branch<'_>], ends: [Point; 2]) -> Option<Coexistence> {
    let mut x = ends.map(|end| end.x);
    let jets = |x: &[f64; 2]| {
        let jet = |n: usize| (branches[ends[n].branch].free_energy)(Jet::variable(x[n], 0));
        [jet(0), jet(1)]
    };
    // One sample to either side: Newton's method may not jump to another tangent.
    let room = ends.map(|end| {
        let samples = &branches[end.branch].samples;
        let before = samples[end.number.saturating_sub(1)];
        let after = samples[(end.number + 1).min(samples.len() - 1)];
        [before, after]
    });
    for _ in 0..MOST_STEPS {
        let [a, b] = jets(&x);
        let slope = b.first() - a.first();
        let intercept = (b.value - x[1] * b.first()) - (a.value - x[0] * a.first());
        // The slopes change by b'' dx1 - a'' dx0, the intercepts by x0 a'' dx0 - x1 b'' dx1.
        let width = x[1] - x[0];
        // Solution of the two linear equations by elimination.
        let steps = [
            (intercept + x[1] * slope) / (width * a.second()),
            (intercept + x[0] * slope) / (width * b.second()),
        ];
        let mut is_still = true;
        for n in 0..2 {
            let old = x[n];
            x[n] = (old + steps[n]).clamp(room[n][0], room[n][1]);
            is_still &= (x[n] - old).abs() <= CONVERGED * old.abs();
        }
        if is_still {
            break;
        }
    }
    let [a, b] = jets(&x);
    let is_one_point = x[1] - x[0] <= ONE_POINT * x[1].abs().max(x[0].abs());
    // A tangent touches where the branches are convex, and not at the end of a branch.
    let touches = a.second() > 0.0
        && b.second() > 0.0
        && (0..2).all(|n| x[n] > room[n][0] && x[n] < room[n][1]);
    if is_one_point || !touches {
        return None;
    }
    Some(Coexistence {
        branches: ends.map(|end| end.branch),
        densities: x,
        chemical_potential: 0.5 * (a.first() + b.first()),
        pressure: 0.5 * (x[0] * a.first() - a.value + x[1] * b.first() - b.value),
    })
}
