//! How far a mesh lies from the surface that it stands for.
//!
//! A mesh calibrated to an exact area and volume says nothing about its own error by them. Its
//! distance from the surface does: d, the exact signed distance, sampled at the vertices, the
//! middles of the edges and the centroids of the triangles. The mean of d² has the weights 3/20,
//! 8/20 and 9/20, by which these three means integrate a cubic over a triangle exactly (Hammer and
//! Stroud, Math. Tables Other Aids Comput. 10, 137 (1956)).

use super::implicit::ImplicitSolid;
use protomer_kernel::{TriangleMesh, Vec3};

/// Weights of the means over vertices, edge middles and centroids.
const WEIGHTS: [f64; 3] = [3.0 / 20.0, 8.0 / 20.0, 9.0 / 20.0];

/// The distance of a mesh from the surface that it stands for.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Deviation {
    /// Root of the mean squared distance over the area of the mesh, Å.
    pub rms_angstrom: f64,
    /// The largest distance found, Å.
    pub largest_angstrom: f64,
}

/// Means of squares, by weight.
#[derive(Default)]
struct Mean {
    sum: f64,
    weight: f64,
}

impl Mean {
    fn add(&mut self, square: f64, weight: f64) {
        self.sum += square * weight;
        self.weight += weight;
    }
}

impl Deviation {
    /// Samples the distance of a closed mesh from the surface of `solid`, about seven times per
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
        let mut means: [Mean; 3] = Default::default();
        let mut share = vec![0.0; mesh.vertices.len()];
        for (triangle, indices) in mesh.triangles.iter().enumerate() {
            let corners @ [a, b, c] = mesh.corners(triangle);
            let area = 0.5 * (b - a).cross(&(c - a)).norm();
            means[2].add(square_at(&((a + b + c) / 3.0)), area);
            for i in 0..3 {
                let j = (i + 1) % 3;
                share[indices[i] as usize] += area;
                // Each edge once, by one of its two triangles.
                if indices[i] < indices[j] {
                    means[1].add(square_at(&(0.5 * (corners[i] + corners[j]))), area);
                }
            }
        }
        for (vertex, share) in mesh.vertices.iter().zip(share) {
            means[0].add(square_at(vertex), share);
        }
        let mut square = 0.0;
        for (mean, weight) in means.iter().zip(WEIGHTS) {
            square += weight * mean.sum / mean.weight.max(f64::MIN_POSITIVE);
        }
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

    /// The slow twin: many points all over every triangle.
    fn sampled(mesh: &TriangleMesh, solid: &dyn ImplicitSolid) -> Deviation {
        const STEPS: usize = 8;
        let (mut mean, mut largest) = (Mean::default(), 0.0_f64);
        for triangle in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(triangle);
            let area = (b - a).cross(&(c - a)).norm();
            for i in 0..STEPS {
                for j in 0..STEPS - i {
                    let [u, v] = [i, j].map(|n| (n as f64 + 1.0 / 3.0) / STEPS as f64);
                    let point = a + (b - a) * u + (c - a) * v;
                    let distance = solid.signed_distance(&point);
                    mean.add(distance * distance, area);
                    largest = largest.max(distance.abs());
                }
            }
        }
        Deviation {
            rms_angstrom: (mean.sum / mean.weight).sqrt(),
            largest_angstrom: largest,
        }
    }

    #[test]
    fn seven_samples_per_vertex_say_what_many_say() {
        let mut cases = crate::surface::test_support::clusters(4, 20..40);
        cases.push((vec![Vec3::zeros()], vec![1.7]));
        for (centres, radii) in cases {
            let settings = MeshSettings::default();
            let surface = solvent_excluded_surface(&centres, &radii, 1.4, &settings).unwrap();
            let expected = sampled(&surface.mesh, surface.solid());
            let found = surface.deviation();
            let relative = found.rms_angstrom / expected.rms_angstrom - 1.0;
            assert!(relative.abs() < 0.05, "{found:?} {expected:?}");
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
