//! A convex part of a rigid body: a polytope, a disk, a ball or an ellipsoid, rounded or not.

use super::moments::{Moments, unit_rule};
use protomer_kernel::Vec3;
use protomer_kernel::shape::polytope::Polytope;
use std::f64::consts::{PI, TAU};

/// Number of directions around an ellipse, and around the third axis of an ellipsoid.
const AROUND: usize = 96;
/// Number of intervals of the third axis, with Gauss-Legendre points in each.
const ALONG: usize = 8;

/// A convex part, about its own centre. A body of one part has its centre of mass there.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Number of dimensions, 2 or 3.
    pub dimension: usize,
    /// Corners, faces and edges of the core; a disk, a ball or an ellipsoid is one corner at the
    /// centre.
    pub polytope: Polytope,
    /// The radius by which the core is rounded (Minkowski sum with a disk or a ball); that of a disk
    /// or a ball.
    pub radius: f64,
    /// The half axes of an ellipse or an ellipsoid along x, y and z.
    pub half_axes: Option<Vec3>,
    /// Vector from the centre of mass of the body to the centre of the part, in the frame of the
    /// body.
    pub centre: Vec3,
    /// The distances of the faces of the core from the centre.
    pub(crate) offsets: Vec<f64>,
    pub(crate) inradius: f64,
    pub(crate) circumradius: f64,
}

impl Part {
    /// A rounded polytope, about the origin of its corners.
    pub(crate) fn faceted(polytope: Polytope, radius: f64, centre: Vec3) -> Self {
        Self {
            dimension: polytope.dimension,
            offsets: polytope.faces.iter().map(|face| face.offset).collect(),
            inradius: polytope.inradius() + radius,
            circumradius: polytope.circumradius() + radius,
            radius,
            half_axes: None,
            centre,
            polytope,
        }
    }

    /// A disk or a ball.
    pub(crate) fn ball(dimension: usize, radius: f64) -> Self {
        Self {
            dimension,
            polytope: Polytope {
                dimension,
                corners: vec![Vec3::zeros()],
                edges: Vec::new(),
                faces: Vec::new(),
            },
            radius,
            half_axes: None,
            centre: Vec3::zeros(),
            offsets: Vec::new(),
            inradius: radius,
            circumradius: radius,
        }
    }

    /// An ellipse or an ellipsoid.
    pub(crate) fn ellipsoid(dimension: usize, half_axes: Vec3) -> Self {
        let axes = &half_axes.as_slice()[..dimension];
        let limit = |from: f64, keep: fn(f64, f64) -> f64| axes.iter().copied().fold(from, keep);
        Self {
            half_axes: Some(half_axes),
            inradius: limit(f64::INFINITY, f64::min),
            circumradius: limit(0.0, f64::max),
            ..Self::ball(dimension, 0.0)
        }
    }

    /// The part with all lengths multiplied by a factor.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        let mut part = self.clone();
        for corner in &mut part.polytope.corners {
            *corner *= factor;
        }
        for face in &mut part.polytope.faces {
            face.offset *= factor;
        }
        for offset in &mut part.offsets {
            *offset *= factor;
        }
        part.radius *= factor;
        part.half_axes = part.half_axes.map(|axes| axes * factor);
        part.centre *= factor;
        part.inradius *= factor;
        part.circumradius *= factor;
        part
    }

    /// Whether the part has no faces: a disk, a ball or an ellipsoid.
    pub fn is_round(&self) -> bool {
        self.polytope.faces.is_empty()
    }

    /// Whether the part is a disk or a ball, whose rotation no force changes.
    pub fn is_ball(&self) -> bool {
        self.is_round() && self.half_axes.is_none()
    }

    /// The radius of the largest ball about the centre that fits in.
    pub fn inradius(&self) -> f64 {
        self.inradius
    }

    /// The radius of the smallest ball about the centre that holds the part.
    pub fn circumradius(&self) -> f64 {
        self.circumradius
    }

    /// Area or volume of the part with another layer around it (Steiner). Of an ellipsoid with the
    /// support function h it is V + S t + M t² + 4π t³/3 with M = ∫ h dΩ and S by quadrature.
    ///
    /// ```
    /// use protomer_kernel::Vec3;
    /// use protomer_md::body::Kind;
    /// let ball = Kind::ball(3, 1.5)?.parts[0].volume_with_layer(0.5);
    /// let round = Kind::ellipsoid(3, Vec3::repeat(1.5))?.parts[0].volume_with_layer(0.5);
    /// assert!((ball / round - 1.0).abs() < 1e-12);
    /// # Ok::<(), protomer_md::Error>(())
    /// ```
    pub fn volume_with_layer(&self, layer: f64) -> f64 {
        let radius = self.radius + layer;
        match (self.half_axes, self.dimension) {
            _ if !self.is_round() => Moments::from_polytope(&self.polytope, radius).volume,
            (None, 2) => PI * radius * radius,
            (None, _) => 4.0 / 3.0 * PI * radius.powi(3),
            (Some(axes), 2) => {
                let turn = |k: usize| TAU * k as f64 / AROUND as f64;
                let height = |k: usize| (axes.x * turn(k).cos()).hypot(axes.y * turn(k).sin());
                let perimeter = (0..AROUND).map(height).sum::<f64>() * TAU / AROUND as f64;
                PI * axes.x * axes.y + perimeter * radius + PI * radius * radius
            }
            (Some(axes), _) => {
                let product = axes.product();
                let [curvature, surface] = over_directions(|u| {
                    let height = axes.component_mul(u).norm();
                    [height, product * u.component_div(&axes).norm()]
                });
                4.0 / 3.0 * PI * (product + radius.powi(3))
                    + radius * (surface + radius * curvature)
            }
        }
    }
}

/// Integrates over all directions.
fn over_directions(integrand: impl Fn(&Vec3) -> [f64; 2]) -> [f64; 2] {
    let mut sums = [0.0; 2];
    let rule = unit_rule();
    for part in 0..ALONG {
        for (place, weight) in &rule {
            let z = -1.0 + 2.0 * (part as f64 + place) / ALONG as f64;
            let axis_distance = (1.0 - z * z).sqrt();
            for k in 0..AROUND {
                let (sine, cosine) = (TAU * k as f64 / AROUND as f64).sin_cos();
                let values = integrand(&Vec3::new(axis_distance * cosine, axis_distance * sine, z));
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += value * weight * 2.0 / ALONG as f64 * TAU / AROUND as f64;
                }
            }
        }
    }
    sums
}
