//! Bounding discs: flat cylinders around patches of surface.
//!
//! A disc is the set {c + h n + w : |h| ≤ t, w ⊥ n, |w| ≤ r}. Its half-extent along a unit axis a
//! is t |a·n| + r √(1 - (a·n)²), so two discs whose centres lie d apart are separated along a by at
//! least
//! |d·a| minus the two half-extents.

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
        radius: -1e18,
        half_thickness: -1e18,
    };

    /// The smallest disc in the plane of a triangle: on its smallest enclosing circle.
    pub fn around_triangle(corners: &[Vec3; 3]) -> Self {
        let [a, b, c] = corners;
        let normal = (b - a)
            .cross(&(c - a))
            .try_normalize(0.0)
            .unwrap_or_else(Vec3::z);
        Self::around_points(corners, &normal, &smallest_circle_centre(corners))
    }

    /// A tight disc around the corners of some triangles: the best of four directions, the mean
    /// normal of the triangles and the principal axes of their corners.
    pub fn around_triangles(triangles: &[[Vec3; 3]]) -> Self {
        let points: Vec<Vec3> = triangles.iter().flatten().copied().collect();
        let mean_normal: Vec3 = triangles
            .iter()
            .map(|[a, b, c]| (b - a).cross(&(c - a)))
            .sum();
        let axes = covariance(&points).symmetric_eigen().eigenvectors;
        let candidates = mean_normal
            .try_normalize(0.0)
            .into_iter()
            .chain(axes.column_iter().map(|axis| axis.into()));
        candidates
            .map(|normal| Self::around_points(&points, &normal, &centre_across(&points, &normal)))
            .min_by(|left, right| left.cost().total_cmp(&right.cost()))
            .unwrap_or(Self::EMPTY)
    }

    /// The disc of a given direction and axis around points. Radius and thickness are measured from
    /// the rounded centre and normal and rounded up, so that the disc holds the points whatever the
    /// rounding.
    fn around_points(points: &[Vec3], normal: &Vec3, on_axis: &Vec3) -> Self {
        let heights = points.iter().map(|point| (point - on_axis).dot(normal));
        let (low, high) = heights.fold((f64::MAX, f64::MIN), |(low, high), h| {
            (low.min(h), high.max(h))
        });
        let centre: Vec3 = on_axis + normal * (0.5 * (low + high));
        let (centre, normal) = (centre.map(|x| x as f32), normal.map(|x| x as f32));
        let (exact_centre, exact_normal) = (centre.map(f64::from), normal.map(f64::from));
        let (mut radius, mut half_thickness) = (0.0_f64, 0.0_f64);
        for point in points {
            let offset = point - exact_centre;
            let height = offset.dot(&exact_normal);
            half_thickness = half_thickness.max(height.abs());
            radius = radius.max((offset - exact_normal * height).norm());
        }
        Self {
            centre: centre.into(),
            normal: normal.into(),
            radius: (radius as f32).next_up(),
            half_thickness: (half_thickness as f32).next_up(),
        }
    }

    /// What makes a disc bad: area times thickness, with a share for mere size.
    fn cost(&self) -> f32 {
        self.half_thickness + 0.2 * self.radius
    }
}

fn covariance(points: &[Vec3]) -> Matrix3<f64> {
    let mean = points.iter().sum::<Vec3>() / points.len().max(1) as f64;
    points
        .iter()
        .map(|point| (point - mean) * (point - mean).transpose())
        .sum()
}

/// Centre of the smallest circle around a triangle: the circumcentre if it is acute, else the
/// middle of its longest side.
fn smallest_circle_centre(corners: &[Vec3; 3]) -> Vec3 {
    let side = |i: usize| (corners[(i + 1) % 3] - corners[(i + 2) % 3]).norm_squared();
    let squared = [side(0), side(1), side(2)];
    for i in 0..3 {
        let (opposite, others) = (squared[i], squared[(i + 1) % 3] + squared[(i + 2) % 3]);
        if opposite >= others {
            return (corners[(i + 1) % 3] + corners[(i + 2) % 3]) * 0.5;
        }
    }
    // Barycentric weights of the circumcentre: a² (b² + c² - a²), and so on.
    let total: f64 = squared.iter().sum();
    let weights = squared.map(|s| s * (total - 2.0 * s));
    (0..3).map(|i| corners[i] * weights[i]).sum::<Vec3>() / weights.iter().sum::<f64>()
}

/// The centre of a nearly smallest circle around the shadow of the points along `normal`, by steps
/// of decreasing length towards the farthest point (Bădoiu and Clarkson, SODA 2003).
fn centre_across(points: &[Vec3], normal: &Vec3) -> Vec3 {
    const STEPS: usize = 48;
    let mut centre = points.iter().sum::<Vec3>() / points.len().max(1) as f64;
    for step in 1..=STEPS {
        let offset = |point: &Vec3| {
            let difference = point - centre;
            difference - normal * difference.dot(normal)
        };
        let farthest = points
            .iter()
            .map(offset)
            .max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
        centre += farthest.unwrap_or_default() / (step + 1) as f64;
    }
    centre
}
