//! How far a mesh lies from the surface that it stands for.
//!
//! A mesh calibrated to an exact area and volume says nothing about its own error by them. Its
//! distance from the surface does: d, the exact signed distance, sampled at the seven points by whose
//! weights polynomials of degree five are integrated over a triangle exactly (Radon, Monatsh. Math.
//! 52, 286 (1948)). They come near its corners and the middles of its sides; the largest |d| is
//! looked for there and at the vertices.

use super::implicit::ImplicitSolid;
use protomer_kernel::{TriangleMesh, Vec3};

/// The seven points: the centroid, and two orbits of three with this barycentric coordinate twice, by
/// their weights.
const CENTROID_WEIGHT: f64 = 9.0 / 40.0;
const ORBITS: [(f64, f64); 2] = [
    // (6 ∓ √15) / 21 and (155 ∓ √15) / 1200.
    (0.101_286_507_323_456_34, 0.125_939_180_544_827_15),
    (0.470_142_064_105_115_1, 0.132_394_152_788_506_2),
];

/// The distance of a mesh from the surface that it stands for.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Deviation {
    /// Root of the mean squared distance over the area of the mesh, Å.
    pub rms_angstrom: f64,
    /// The largest distance found, Å.
    pub largest_angstrom: f64,
}

impl Deviation {
    /// Samples the distance of a closed mesh from the surface of `solid`, fifteen times per
    /// vertex of the mesh.
    ///
    /// ```
    /// use protomer_body::surface::{Arrangement, Deviation, MeshSettings, SesSolid, mesh_solid};
    /// use protomer_kernel::Vec3;
    /// let ball = SesSolid::new(&Arrangement::new(&[Vec3::zeros()], &[1.7], 1.4)?);
    /// let mesh = mesh_solid(&ball, &MeshSettings::default(), None)?;
    /// let deviation = Deviation::of(&mesh, &ball);
    /// assert!(deviation.rms_angstrom < 0.05);
    /// assert!(deviation.rms_angstrom <= deviation.largest_angstrom);
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn of(mesh: &TriangleMesh, solid: &dyn ImplicitSolid) -> Self {
        let mut largest = 0.0_f64;
        let mut square_at = |point: &Vec3| {
            let distance = solid.signed_distance(point).abs();
            largest = largest.max(distance);
            distance * distance
        };
        let (mut sum, mut weight) = (0.0, 0.0);
        for triangle in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(triangle);
            let area = 0.5 * (b - a).cross(&(c - a)).norm();
            let corners = a + b + c;
            let mut mean = CENTROID_WEIGHT * square_at(&(corners / 3.0));
            for (twice, orbit_weight) in ORBITS {
                for corner in [a, b, c] {
                    let point = corners * twice + corner * (1.0 - 3.0 * twice);
                    mean += orbit_weight * square_at(&point);
                }
            }
            sum += area * mean;
            weight += area;
        }
        for vertex in &mesh.vertices {
            square_at(vertex);
        }
        let square: f64 = sum / f64::max(weight, f64::MIN_POSITIVE);
        Self {
            rms_angstrom: square.sqrt(),
            largest_angstrom: largest,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{MeshSettings, solvent_excluded_surface};

    /// The slow twin: the centres of the 256 equal parts of every triangle.
    fn sampled(mesh: &TriangleMesh, solid: &dyn ImplicitSolid) -> Deviation {
        const STEPS: usize = 16;
        let (mut sum, mut weight, mut largest) = (0.0, 0.0, 0.0_f64);
        for triangle in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(triangle);
            let area = (b - a).cross(&(c - a)).norm();
            for i in 0..STEPS {
                for j in 0..STEPS - i {
                    // The part that stands like the triangle, and the one upside down beside it.
                    let parts = if i + j + 1 < STEPS { 2 } else { 1 };
                    for part in 1..=parts {
                        let step = |n: usize| (n as f64 + f64::from(part) / 3.0) / STEPS as f64;
                        let point = a + (b - a) * step(i) + (c - a) * step(j);
                        let distance = solid.signed_distance(&point);
                        sum += distance * distance * area;
                        weight += area;
                        largest = largest.max(distance.abs());
                    }
                }
            }
        }
        Deviation {
            rms_angstrom: (sum / weight).sqrt(),
            largest_angstrom: largest,
        }
    }

    #[test]
    fn few_samples_say_what_many_say() {
        let mut cases = crate::surface::test_support::clusters(4, 20..40);
        cases.push((vec![Vec3::zeros()], vec![1.7]));
        for (centres, radii) in cases {
            let settings = MeshSettings::default();
            let surface = solvent_excluded_surface(&centres, &radii, 1.4, &settings).unwrap();
            let expected = sampled(&surface.mesh, surface.solid());
            let found = surface.deviation();
            let relative = found.rms_angstrom / expected.rms_angstrom - 1.0;
            assert!(relative.abs() < 0.05, "{relative} {found:?} {expected:?}");
            assert!(found.largest_angstrom > 0.8 * expected.largest_angstrom);
        }
    }

    #[test]
    fn a_mesh_moved_off_its_surface_is_as_far_from_it() {
        let (centres, radii) = (vec![Vec3::zeros()], vec![5.0]);
        let settings = MeshSettings {
            density_per_angstrom2: 16.0,
            ..MeshSettings::default()
        };
        let surface = solvent_excluded_surface(&centres, &radii, 1.4, &settings).unwrap();
        let larger = surface.mesh.map_vertices(|vertex| vertex * 1.1);
        let moved = Deviation::of(&larger, surface.solid());
        assert!((moved.rms_angstrom - 0.5).abs() < 0.02, "{moved:?}");
        assert!((moved.largest_angstrom - 0.5).abs() < 0.02, "{moved:?}");
    }
}
