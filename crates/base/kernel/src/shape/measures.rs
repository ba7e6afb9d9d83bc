//! What is known exactly of a convex shape with rounded edges.
//!
//! The Minkowski sum of a convex body with a ball of radius r has (Steiner)
//!
//! V = V₀ + S₀ r + M₀ r² + 4π r³/3,   S = S₀ + 2 M₀ r + 4π r²,   M = M₀ + 4π r,
//!
//! with the integrated mean curvature M₀ = ½ Σ over edges of length times exterior angle for a
//! polyhedron. Its second virial coefficient is B2 = V + S M / 4π (Isihara, J. Chem. Phys. 18, 1446
//! (1950)). In a plane A = A₀ + P₀ r + π r², P = P₀ + 2π r, and B2 = A + P²/4π.

use super::Shape;
use super::hull::Hull;
use crate::error::require;
use crate::{KernelError, Result, TriangleMesh, Vec3};
use std::collections::HashMap;
use std::f64::consts::PI;

/// Measures of a convex shape with rounded edges. In a plane, the volume is the area, the surface
/// the perimeter, and the integrated curvature 2π.
///
/// ```
/// use protomer_kernel::shape::{builders::by_name, measures::Measures};
/// let square = Measures::from_shape(&by_name("polygon:4")?, 0.0)?;
/// // A + P²/4π
/// assert!((square.b2 - (1.0 + 16.0 / (4.0 * std::f64::consts::PI))).abs() < 1e-12);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measures {
    /// Volume.
    pub volume: f64,
    /// Surface.
    pub surface: f64,
    /// Integral of the mean curvature over the surface.
    pub integrated_mean_curvature: f64,
    /// Second virial coefficient of hard bodies of this shape.
    pub b2: f64,
}

impl Measures {
    /// Measures of the Minkowski sum of a shape with a ball (a disk in a plane) of this radius.
    ///
    /// ```
    /// use protomer_kernel::shape::{builders::by_name, measures::Measures};
    /// let cube = by_name("cube")?;
    /// assert!((Measures::from_shape(&cube, 0.0)?.surface - 6.0).abs() < 1e-12);
    /// // Six faces, a quarter of a cylinder at each of twelve edges, a ball at the corners.
    /// let pi = std::f64::consts::PI;
    /// let rounded = 6.0 + 12.0 * pi / 2.0 * 0.1 + 4.0 * pi * 0.01;
    /// assert!((Measures::from_shape(&cube, 0.1)?.surface - rounded).abs() < 1e-12);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// [`KernelError::OutOfRange`] for a negative radius; [`KernelError::BadShape`] for a shape
    /// without volume.
    pub fn from_shape(shape: &Shape, rounding_radius: f64) -> Result<Self> {
        check_rounding(rounding_radius)?;
        let measures = match shape {
            Shape::Flat(corners) => of_polygon(corners, rounding_radius),
            Shape::Solid(hull) => of_hull(hull, rounding_radius),
        };
        if measures.volume <= 0.0 {
            return Err(KernelError::BadShape(
                "its points lie in a plane, on a line or in one place, so it has no volume; add \
                 points or a rounding radius"
                    .into(),
            ));
        }
        measures.if_finite()
    }

    /// The mixed second virial coefficient B12 of two hard convex bodies, half of their mean excluded volume
    /// (Isihara and Hayashida, J. Phys. Soc. Jpn. 6, 40 (1951)): with bodies in space
    /// 2 B12 = V₁ + V₂ + (S₁ M₂ + S₂ M₁)/4π, in a plane A₁ + A₂ + P₁ P₂/2π.
    ///
    /// ```
    /// use protomer_kernel::shape::ellipsoid::measures_of_ellipsoid;
    /// let [small, large] = [0.5, 1.5].map(|radius| measures_of_ellipsoid(&[radius; 3], 0.0));
    /// let b12 = small?.mixed_b2(&large?, 3);
    /// assert!((b12 - 2.0 * std::f64::consts::PI / 3.0 * 8.0).abs() < 1e-9);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn mixed_b2(&self, other: &Self, dimension: usize) -> f64 {
        let volumes = self.volume + other.volume;
        let mixed = match dimension {
            2 => self.surface * other.surface / (2.0 * PI),
            _ => {
                (self.surface * other.integrated_mean_curvature
                    + other.surface * self.integrated_mean_curvature)
                    / (4.0 * PI)
            }
        };
        0.5 * (volumes + mixed)
    }

    /// Returns the measures, or an error if the shape is so large that they overflow.
    pub(super) fn if_finite(self) -> Result<Self> {
        if self.b2.is_finite() && self.surface.is_finite() {
            return Ok(self);
        }
        Err(KernelError::BadShape(
            "it is so large that its measures overflow; choose a larger unit of length".into(),
        ))
    }
}

/// Refuses a radius that is negative or no number.
pub(super) fn check_rounding(radius: f64) -> Result<()> {
    require(
        "the rounding radius",
        radius,
        "zero or positive",
        radius >= 0.0,
    )
}

fn of_polygon(corners: &[[f64; 2]], r: f64) -> Measures {
    let (mut area, mut perimeter) = (0.0, 0.0);
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        area += 0.5 * (a[0] * b[1] - a[1] * b[0]);
        perimeter += (b[0] - a[0]).hypot(b[1] - a[1]);
    }
    rounded_in_plane(area, perimeter, r)
}

/// Measures of a convex area with a rounding.
pub(super) fn rounded_in_plane(area: f64, perimeter: f64, r: f64) -> Measures {
    let volume = area + perimeter * r + PI * r * r;
    let surface = perimeter + 2.0 * PI * r;
    Measures {
        volume,
        surface,
        integrated_mean_curvature: 2.0 * PI,
        b2: volume + surface * surface / (4.0 * PI),
    }
}

pub(super) fn of_hull(hull: &Hull, r: f64) -> Measures {
    let (volume, surface, curvature) = match hull {
        Hull::Point(_) => (0.0, 0.0, 0.0),
        Hull::Segment([a, b]) => (0.0, 0.0, PI * (b - a).norm()),
        Hull::Polygon(corners) => of_thin_polygon(corners),
        Hull::Polyhedron(mesh) => (
            mesh.volume_angstrom3(),
            mesh.area_angstrom2(),
            mean_curvature(mesh),
        ),
    };
    rounded_in_space(volume, surface, curvature, r)
}

/// Measures of a convex body with a rounding.
pub(super) fn rounded_in_space(volume: f64, surface: f64, curvature: f64, r: f64) -> Measures {
    let ball = 4.0 * PI;
    let rounded_volume = volume + surface * r + curvature * r * r + ball / 3.0 * r.powi(3);
    let rounded_surface = surface + 2.0 * curvature * r + ball * r * r;
    let rounded_curvature = curvature + ball * r;
    Measures {
        volume: rounded_volume,
        surface: rounded_surface,
        integrated_mean_curvature: rounded_curvature,
        b2: rounded_volume + rounded_surface * rounded_curvature / ball,
    }
}

/// Volume, surface and integrated mean curvature of a thin polygon, which has two sides, and at
/// every edge an exterior angle of π.
fn of_thin_polygon(corners: &[Vec3]) -> (f64, f64, f64) {
    let (mut area, mut perimeter) = (Vec3::zeros(), 0.0);
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        area += 0.5 * (a - corners[0]).cross(&(b - corners[0]));
        perimeter += (b - a).norm();
    }
    (0.0, 2.0 * area.norm(), 0.5 * PI * perimeter)
}

/// Integrated mean curvature of a mesh. Edges between triangles of one face have no exterior angle.
fn mean_curvature(mesh: &TriangleMesh) -> f64 {
    // Each directed edge has one triangle; its reverse belongs to the neighbour.
    let mut normals = HashMap::new();
    for (number, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(number);
        let normal = (b - a).cross(&(c - a)).normalize();
        let [i, j, k] = *triangle;
        for edge in [(i, j), (j, k), (k, i)] {
            normals.insert(edge, normal);
        }
    }
    let mut sum = 0.0;
    for (number, triangle) in mesh.triangles.iter().enumerate() {
        let corners = mesh.corners(number);
        for side in 0..3 {
            let (from, to) = (triangle[side], triangle[(side + 1) % 3]);
            let first = normals.get(&(from, to));
            // Each edge once.
            let Some((first, second)) = first.zip(normals.get(&(to, from))).filter(|_| from < to)
            else {
                continue;
            };
            let length = (corners[(side + 1) % 3] - corners[side]).norm();
            // The exterior angle by atan2 keeps its digits where the normals are nearly parallel.
            sum += 0.5 * length * first.cross(second).norm().atan2(first.dot(second));
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::builders::by_name;
    use super::*;

    fn assert_near(found: f64, expected: f64) {
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
    }

    #[test]
    fn solids_have_their_closed_forms() {
        let (root_2, root_3) = (2.0_f64.sqrt(), 3.0_f64.sqrt());
        // Exterior angles: π - acos(1/3) for the tetrahedron, acos(1/3) for the octahedron.
        let third = (1.0_f64 / 3.0).acos();
        for (name, volume, surface, curvature) in [
            ("tetrahedron", root_2 / 12.0, root_3, 3.0 * (PI - third)),
            ("cube", 1.0, 6.0, 3.0 * PI),
            ("octahedron", root_2 / 3.0, 2.0 * root_3, 6.0 * third),
            ("cuboid:1,2,3", 6.0, 22.0, 6.0 * PI),
        ] {
            let measures = Measures::from_shape(&by_name(name).unwrap(), 0.0).unwrap();
            assert_near(measures.volume, volume);
            assert_near(measures.surface, surface);
            assert_near(measures.integrated_mean_curvature, curvature);
            assert_near(measures.b2, volume + surface * curvature / (4.0 * PI));
        }
    }

    #[test]
    fn balls_disks_and_rods_are_rounded_points_and_segments() {
        let ball = Shape::solid(&[Vec3::zeros()]).unwrap();
        let ball = Measures::from_shape(&ball, 0.5).unwrap();
        assert_near(ball.volume, PI / 6.0);
        assert_near(ball.b2, 4.0 * PI / 6.0);
        let disk = Measures::from_shape(&Shape::flat(&[[1.0, 1.0]]).unwrap(), 0.5).unwrap();
        assert_near(disk.volume, PI / 4.0);
        assert_near(disk.b2, 2.0 * PI / 4.0);
        let rod = Shape::solid(&[Vec3::zeros(), 3.0 * Vec3::x()]).unwrap();
        let rod = Measures::from_shape(&rod, 0.5).unwrap();
        assert_near(rod.volume, PI * 0.25 * 3.0 + PI / 6.0);
        assert_near(rod.surface, PI * 3.0 + PI);
        let stadium = Shape::flat(&[[0.0, 0.0], [3.0, 0.0]]).unwrap();
        let stadium = Measures::from_shape(&stadium, 0.5).unwrap();
        assert_near(stadium.volume, 3.0 + PI / 4.0);
        assert_near(stadium.surface, 6.0 + PI);
    }

    #[test]
    fn a_thin_plate_is_the_limit_of_a_cuboid() {
        let plate = |height: f64| {
            let corner = |n: u32| {
                let bit = |place: u32| f64::from(n >> place & 1);
                Vec3::new(2.0 * bit(0), bit(1), height * bit(2))
            };
            let points: Vec<Vec3> = (0..8).map(corner).collect();
            Measures::from_shape(&Shape::solid(&points).unwrap(), 0.3).unwrap()
        };
        let (flat, thin) = (plate(0.0), plate(1e-7));
        assert!((flat.volume / thin.volume - 1.0).abs() < 1e-6);
        assert!((flat.b2 / thin.b2 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn without_volume_and_with_negative_rounding_it_is_refused() {
        let flat = Shape::flat(&[[0.0, 0.0], [1.0, 0.0]]).unwrap();
        let no_volume = Measures::from_shape(&flat, 0.0).unwrap_err().to_string();
        assert!(no_volume.contains("no volume"), "{no_volume}");
        assert!(Measures::from_shape(&flat, -1.0).is_err());
        assert!(Measures::from_shape(&flat, f64::NAN).is_err());
    }
}
