//! Bounding discs: flat cylinders around patches of surface.
//!
//! A disc is the set {c + h n + w : |h| ≤ t, w ⊥ n, |w| ≤ r}. Its half-extent along a unit axis a is
//! t |a·n| + r √(1 - (a·n)²), so two discs whose centres are separated by d are at least |d·a| minus
//! the two half-extents apart along a.

use crate::Vec3;
use nalgebra::Matrix3;

/// A bounding disc in the precision of the tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Disc {
    pub centre: [f32; 3],
    pub normal: [f32; 3],
    /// Radius in the plane, Å.
    pub radius: f32,
    /// Half of the thickness along the normal, Å.
    pub half_thickness: f32,
}

impl Disc {
    /// The disc of an unused lane: empty, so far from everything that every test rejects it.
    pub const EMPTY: Disc = Disc {
        centre: [0.0; 3],
        normal: [0.0; 3],
        // Finite, so that no lane computes ∞ - ∞ = NaN; large enough that every gap is positive.
        radius: -1e18,
        half_thickness: -1e18,
    };

    /// The smallest disc in the plane of a triangle: on its smallest enclosing circle.
    pub fn around_triangle(corners: &[Vec3; 3]) -> Self {
        let [a, b, c] = corners;
        let normal = (b - a)
            .cross(&(c - a))
            .try_normalize(0.0)
            // A triangle without area has no normal; any direction holds it, only less tightly.
            .unwrap_or_else(Vec3::z);
        Self::around_points(corners, &normal, &smallest_circle_centre(corners))
    }

    /// A tight disc around the corners of some triangles: the best of four directions, the mean
    /// normal of the triangles and the principal axes of their corners.
    pub fn around_triangles(triangles: &[[Vec3; 3]]) -> Self {
        let points = triangles.as_flattened();
        // The sum of cross products weights each normal by the area of its triangle.
        let mut mean_normal = Vec3::zeros();
        for [a, b, c] in triangles {
            mean_normal += (b - a).cross(&(c - a));
        }
        let mut directions: Vec<Vec3> = mean_normal.try_normalize(0.0).into_iter().collect();
        let axes = covariance(points).symmetric_eigen().eigenvectors;
        for axis in axes.column_iter() {
            directions.push(axis.into());
        }
        let mut best = Self::EMPTY;
        let mut least_cost = f32::INFINITY;
        for normal in directions {
            let disc = Self::around_points(points, &normal, &centre_across(points, &normal));
            if disc.cost() < least_cost {
                least_cost = disc.cost();
                best = disc;
            }
        }
        best
    }

    /// The disc of a given direction and axis around points. Radius and thickness are measured from
    /// the rounded centre and normal and rounded up, so that the disc holds the points whatever the
    /// rounding.
    fn around_points(points: &[Vec3], normal: &Vec3, on_axis: &Vec3) -> Self {
        let (mut low, mut high) = (f64::MAX, f64::MIN);
        // The first pass finds the middle of the heights,
        // the second measures from the rounded centre.
        for point in points {
            let height = (point - on_axis).dot(normal);
            low = low.min(height);
            high = high.max(height);
        }
        let centre = (on_axis + normal * (0.5 * (low + high))).cast::<f32>();
        let normal = normal.cast::<f32>();
        let (rounded_centre, rounded_normal) = (centre.cast::<f64>(), normal.cast::<f64>());
        let (mut radius, mut half_thickness) = (0.0_f64, 0.0_f64);
        for point in points {
            let offset = point - rounded_centre;
            let height = offset.dot(&rounded_normal);
            half_thickness = half_thickness.max(height.abs());
            radius = radius.max((offset - rounded_normal * height).norm());
        }
        Self {
            centre: centre.into(),
            normal: normal.into(),
            // The cast rounds to nearest, perhaps down; one
            // step up makes the disc hold its points again.
            radius: (radius as f32).next_up(),
            half_thickness: (half_thickness as f32).next_up(),
        }
    }

    /// The badness of a disc: its thickness, and a share of its radius.
    fn cost(&self) -> f32 {
        // Thin first: 0.2 keeps a disc from growing very wide for a little less thickness.
        self.half_thickness + 0.2 * self.radius
    }
}

/// The sum Σ (p - mean)(p - mean)ᵀ over points.
pub(super) fn covariance(points: &[Vec3]) -> Matrix3<f64> {
    let mean = points.iter().sum::<Vec3>() / points.len().max(1) as f64;
    let mut sum = Matrix3::zeros();
    for point in points {
        sum += (point - mean) * (point - mean).transpose();
    }
    sum
}

/// Centre of the smallest circle around a triangle: the circumcentre if it is acute, else the
/// middle of its longest side.
fn smallest_circle_centre([a, b, c]: &[Vec3; 3]) -> Vec3 {
    // Squared lengths of the sides opposite to each corner.
    let aa = (b - c).norm_squared();
    let bb = (c - a).norm_squared();
    let cc = (a - b).norm_squared();
    if aa >= bb + cc {
        return (b + c) * 0.5;
    }
    if bb >= cc + aa {
        return (c + a) * 0.5;
    }
    if cc >= aa + bb {
        return (a + b) * 0.5;
    }
    // Barycentric weights of the circumcentre: a² (b² + c² - a²), and so on.
    let total = aa + bb + cc;
    let [u, v, w] = [aa, bb, cc].map(|side| side * (total - 2.0 * side));
    (a * u + b * v + c * w) / (u + v + w)
}

/// The centre of a nearly smallest circle around the shadow of the points along `normal`, by steps
/// of decreasing length towards the farthest point (Bădoiu and Clarkson, SODA 2003).
fn centre_across(points: &[Vec3], normal: &Vec3) -> Vec3 {
    const STEPS: usize = 48;
    let mut centre = points.iter().sum::<Vec3>() / points.len().max(1) as f64;
    for step in 1..=STEPS {
        let mut farthest = Vec3::zeros();
        for point in points {
            let difference = point - centre;
            let projection = difference - normal * difference.dot(normal);
            if projection.norm_squared() >= farthest.norm_squared() {
                farthest = projection;
            }
        }
        // Any centre is safe: the radius is measured from it afterwards.
        centre += farthest / (step + 1) as f64;
    }
    centre
}
