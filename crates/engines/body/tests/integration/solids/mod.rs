//! Analytic solids for the tests.

pub mod random;
pub mod ses;

use protomer_body::surface::{ImplicitSolid, Target};
use protomer_kernel::{TriangleMesh, Vec3};
use std::f64::consts::PI;

/// The union of balls.
pub struct Balls(pub Vec<(Vec3, f64)>);

impl Balls {
    pub fn new(balls: &[(f64, f64, f64, f64)]) -> Self {
        Self(
            balls
                .iter()
                .map(|&(x, y, z, r)| (Vec3::new(x, y, z), r))
                .collect(),
        )
    }
}

impl ImplicitSolid for Balls {
    fn signed_distance(&self, point: &Vec3) -> f64 {
        self.0
            .iter()
            .map(|(c, r)| (point - c).norm() - r)
            .fold(f64::INFINITY, f64::min)
    }
    fn project(&self, point: &Vec3) -> (Vec3, Vec3) {
        let nearest = |p: &Vec3| {
            *self
                .0
                .iter()
                .min_by(|a, b| ((p - a.0).norm() - a.1).total_cmp(&((p - b.0).norm() - b.1)))
                .unwrap()
        };
        let (mut foot, mut normal) = (*point, Vec3::x());
        for _ in 0..8 {
            let (c, r) = nearest(&foot);
            normal = (foot - c).try_normalize(1e-12).unwrap_or(Vec3::x());
            foot = c + normal * r;
        }
        (foot, normal)
    }
    fn bounds(&self) -> (Vec3, Vec3) {
        let low = self
            .0
            .iter()
            .fold(Vec3::repeat(f64::INFINITY), |low, (c, r)| {
                low.inf(&c.add_scalar(-r))
            });
        let high = self
            .0
            .iter()
            .fold(Vec3::repeat(f64::NEG_INFINITY), |high, (c, r)| {
                high.sup(&c.add_scalar(*r))
            });
        (low, high)
    }
    fn cover(&self) -> Vec<(Vec3, f64)> {
        self.0.clone()
    }
}

/// A torus about the z axis; a spindle torus's outer surface if `minor > major`.
pub struct Torus {
    pub major: f64,
    pub minor: f64,
}

impl Torus {
    pub fn exact(&self) -> Target {
        let area_angstrom2 = 4.0 * PI * PI * self.major * self.minor;
        Target {
            area_angstrom2,
            volume_angstrom3: area_angstrom2 * self.minor / 2.0,
        }
    }
    fn ring(&self, p: &Vec3) -> Vec3 {
        Vec3::new(p.x, p.y, 0.0)
            .try_normalize(1e-12)
            .unwrap_or(Vec3::x())
            * self.major
    }
}

impl ImplicitSolid for Torus {
    fn signed_distance(&self, p: &Vec3) -> f64 {
        (p - self.ring(p)).norm() - self.minor
    }
    fn project(&self, p: &Vec3) -> (Vec3, Vec3) {
        let ring = self.ring(p);
        let normal = (p - ring).try_normalize(1e-12).unwrap_or(Vec3::z());
        (ring + normal * self.minor, normal)
    }
    fn bounds(&self) -> (Vec3, Vec3) {
        let r = self.major + self.minor;
        (Vec3::new(-r, -r, -self.minor), Vec3::new(r, r, self.minor))
    }
    fn cover(&self) -> Vec<(Vec3, f64)> {
        let steps = 24;
        (0..steps)
            .map(|i| {
                let angle = 2.0 * PI * i as f64 / steps as f64;
                (
                    Vec3::new(angle.cos(), angle.sin(), 0.0) * self.major,
                    self.minor + self.major * PI / steps as f64,
                )
            })
            .collect()
    }
}

/// A ball with a concentric ball taken out.
pub struct Shell {
    pub outer: f64,
    pub inner: f64,
}

impl ImplicitSolid for Shell {
    fn signed_distance(&self, p: &Vec3) -> f64 {
        (p.norm() - self.outer).max(self.inner - p.norm())
    }
    fn project(&self, p: &Vec3) -> (Vec3, Vec3) {
        let direction = p.try_normalize(1e-12).unwrap_or(Vec3::x());
        if p.norm() > 0.5 * (self.outer + self.inner) {
            (direction * self.outer, direction)
        } else {
            (direction * self.inner, -direction)
        }
    }
    fn bounds(&self) -> (Vec3, Vec3) {
        (Vec3::repeat(-self.outer), Vec3::repeat(self.outer))
    }
    fn cover(&self) -> Vec<(Vec3, f64)> {
        vec![(Vec3::zeros(), self.outer)]
    }
}

/// Smallest area, Å², and smallest shape factor (1 for equilateral) of the triangles of a mesh.
pub fn worst(mesh: &TriangleMesh) -> (f64, f64) {
    (0..mesh.triangles.len()).map(|t| mesh.corners(t)).fold(
        (f64::INFINITY, f64::INFINITY),
        |worst, [a, b, c]| {
            let area = 0.5 * (b - a).cross(&(c - a)).norm();
            let sides = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
            (
                worst.0.min(area),
                worst.1.min(4.0 * 3f64.sqrt() * area / sides),
            )
        },
    )
}
