//! How far a mesh lies from the surface that it stands for.
//!
//! A mesh calibrated to an exact area and volume says nothing about its own error by them. Its
//! distance from the surface does: d, the exact signed distance. The mean of d² over a triangle comes
//! from seven points, exact for polynomials of degree five (Radon, Monatsh. Math. 52, 286 (1948)).
//!
//! That is done on every triangle of a small mesh. For a large one there is a guide, an approximate
//! mean of d² for every triangle, either from the centroid and the corners or, at no cost, from what
//! the calibration of the mesh knows. The triangles with the largest values get the full rule, and of
//! the others a sample, every k-th triangle; the ratio of the rule and the guide over the sample
//! corrects the guide's sum over the rest (double sampling with a ratio estimate: Cochran, Sampling
//! Techniques, chapter 12 (1977)). The largest |d| is sought at the points of the rule and at the
//! corners of triangles with large values.

use super::implicit::ImplicitSolid;
use protomer_kernel::{TriangleMesh, Vec3};

/// The weight of the centroid.
const CENTROID_WEIGHT: f64 = 9.0 / 40.0;
/// Two orbits of three points: the barycentric coordinate that such a point has twice, and its
/// weight.
const ORBITS: [(f64, f64); 2] = [
    // (6 ∓ √15) / 21 and (155 ∓ √15) / 1200.
    (0.101_286_507_323_456_34, 0.125_939_180_544_827_15),
    (0.470_142_064_105_115_1, 0.132_394_152_788_506_2),
];
/// A simple rule, exact for degree two: weights of the centroid and of each corner.
const SIMPLE_WEIGHTS: (f64, f64) = (3.0 / 4.0, 1.0 / 12.0);
/// Least number of triangles in the sample, if there are that many.
const FEWEST_SAMPLED: usize = 2500;
/// Share of the largest root mean square above which a triangle gets the full rule.
const LARGE: f64 = 0.5;

/// The distance of a mesh from the surface that it stands for.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Deviation {
    /// Root of the mean squared distance over the area of the mesh, Å. Of meshes with more than
    /// 5000 triangles it is an estimate, good to about one percent.
    pub rms_angstrom: f64,
    /// The largest distance found, Å.
    pub largest_angstrom: f64,
}

impl Deviation {
    /// Samples the distance of a closed mesh from the surface of `solid`, three times per vertex of
    /// the mesh and seven times per triangle of the sample.
    ///
    /// ```
    /// use protomer_body::surface::{Arrangement, Deviation, MeshSettings, SesSolid, mesh_solid};
    /// use protomer_kernel::Vec3;
    /// let ball = SesSolid::new(&Arrangement::new(&[Vec3::zeros()], &[1.7], 1.4)?);
    /// let mesh = mesh_solid(&ball, &MeshSettings::default(), None)?;
    /// let deviation = Deviation::measure(&mesh, &ball);
    /// assert!(deviation.rms_angstrom < 0.05);
    /// assert!(deviation.rms_angstrom <= deviation.largest_angstrom);
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn measure(mesh: &TriangleMesh, solid: &dyn ImplicitSolid) -> Self {
        Self::guided(mesh, solid, &simple_guide(mesh, solid))
    }

    /// Variant of [`Self::measure`] with a guide that is known: an estimate of the mean squared distance
    /// on every triangle, Å².
    pub(crate) fn guided(mesh: &TriangleMesh, solid: &dyn ImplicitSolid, guide: &[f64]) -> Self {
        // At least so many in the sample, whatever the size of the mesh.
        let every = (mesh.triangles.len() / FEWEST_SAMPLED).max(1);
        sampled(mesh, solid, guide, every)
    }
}

/// The mean square on every triangle by the simple rule.
fn simple_guide(mesh: &TriangleMesh, solid: &dyn ImplicitSolid) -> Vec<f64> {
    let at_vertices = squares_at(&mesh.vertices, solid);
    let centroids = (0..mesh.triangles.len()).map(|triangle| centroid(&mesh.corners(triangle)));
    let at_centroids = squares_at(&centroids.collect::<Vec<Vec3>>(), solid);
    let (of_centroid, of_corner) = SIMPLE_WEIGHTS;
    let mut guide = Vec::with_capacity(mesh.triangles.len());
    for (vertices, at_centroid) in mesh.triangles.iter().zip(at_centroids) {
        let at_corners = vertices.map(|vertex| at_vertices[vertex as usize]);
        guide.push(of_centroid * at_centroid + of_corner * at_corners.iter().sum::<f64>());
    }
    guide
}

/// The deviation with every so many triangles in the sample.
fn sampled(
    mesh: &TriangleMesh,
    solid: &dyn ImplicitSolid,
    guide: &[f64],
    every: usize,
) -> Deviation {
    // The guide is a mean square: half the largest root is a quarter of it.
    let large = LARGE * LARGE * guide.iter().copied().fold(0.0, f64::max);
    let is_in_full = |triangle: usize| guide[triangle] > large || triangle.is_multiple_of(every);
    let in_full: Vec<usize> = (0..mesh.triangles.len())
        .filter(|t| is_in_full(*t))
        .collect();
    // In the order of the triangles.
    let mut of_rule = means_and_largest(mesh, solid, &in_full).into_iter();
    let (mut area, mut largest) = (0.0, 0.0_f64);
    // A small mesh is looked at everywhere.
    let mut looked_at = vec![every == 1; mesh.vertices.len()];
    // Sums over the triangles with large values, over the rest and over the sample of the rest.
    let (mut of_large, mut guide_of_rest) = (0.0, 0.0);
    let (mut of_sample, mut guide_of_sample) = (0.0, 0.0);
    for (triangle, guide) in (0..mesh.triangles.len()).zip(guide) {
        let size = area_of(&mesh.corners(triangle));
        area += size;
        let is_large = *guide > large;
        if !is_large {
            guide_of_rest += size * guide;
        }
        if is_in_full(triangle)
            && let Some((mean, largest_here)) = of_rule.next()
        {
            largest = largest.max(largest_here);
            if is_large {
                of_large += size * mean;
                // Corners lie farthest from a surface that the triangle straddles.
                for vertex in mesh.triangles[triangle] {
                    looked_at[vertex as usize] = true;
                }
            } else {
                of_sample += size * mean;
                guide_of_sample += size * guide;
            }
        }
    }
    let vertices = mesh.vertices.iter().zip(looked_at);
    let vertices = vertices.filter(|(_, is_looked_at)| *is_looked_at);
    let vertices: Vec<Vec3> = vertices.map(|(vertex, _)| *vertex).collect();
    for square in squares_at(&vertices, solid) {
        largest = largest.max(square);
    }
    // The guide may be off by a factor; over the sample it is known which.
    let ratio = if guide_of_sample > 0.0 {
        of_sample / guide_of_sample
    } else {
        1.0
    };
    let sum = of_large + ratio * guide_of_rest;
    Deviation {
        rms_angstrom: (sum / f64::max(area, f64::MIN_POSITIVE)).sqrt(),
        largest_angstrom: largest.sqrt(),
    }
}

/// The squared distances of places, Å².
fn squares_at(places: &[Vec3], solid: &dyn ImplicitSolid) -> Vec<f64> {
    let mut values = Vec::new();
    solid.signed_distances(places, &mut values);
    for value in &mut values {
        *value *= *value;
    }
    values
}

/// The mean of the squared distance over each of some triangles from seven points, and the largest at
/// them, Å².
fn means_and_largest(
    mesh: &TriangleMesh,
    solid: &dyn ImplicitSolid,
    triangles: &[usize],
) -> Vec<(f64, f64)> {
    let mut places = Vec::with_capacity(7 * triangles.len());
    for triangle in triangles {
        places.extend(seven_points(&mesh.corners(*triangle)));
    }
    let squares = squares_at(&places, solid);
    let (of_triangles, _) = squares.as_chunks::<7>();
    let each = of_triangles.iter().map(|squares| {
        let [centre, near @ .., a, b, c] = squares;
        let mut mean = CENTROID_WEIGHT * centre;
        for (orbit, (_, weight)) in [near, &[*a, *b, *c]].into_iter().zip(ORBITS) {
            mean += weight * orbit.iter().sum::<f64>();
        }
        (mean, squares.iter().copied().fold(0.0, f64::max))
    });
    each.collect()
}

/// The points of the rule: the centroid and the two orbits.
fn seven_points(corners: &[Vec3; 3]) -> [Vec3; 7] {
    let sum: Vec3 = corners.iter().sum();
    let point = |twice: f64, corner: &Vec3| sum * twice + corner * (1.0 - 3.0 * twice);
    let [a, b, c] = corners;
    let [(near, _), (far, _)] = ORBITS;
    [
        centroid(corners),
        point(near, a),
        point(near, b),
        point(near, c),
        point(far, a),
        point(far, b),
        point(far, c),
    ]
}

fn centroid([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (a + b + c) / 3.0
}

fn area_of([a, b, c]: &[Vec3; 3]) -> f64 {
    0.5 * (b - a).cross(&(c - a)).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chemistry::{SiteSettings, build_sites};
    use crate::structure::{SelectionSettings, Structure};
    use crate::surface::{MeshSettings, Surface, solvent_excluded_surface};
    use crate::{SurfaceSettings, surface_of_sites};
    use std::fs::File;
    use std::io::Read;
    use std::path::{Path, PathBuf};

    /// The slow twin: the centres of the 256 equal parts of every triangle.
    fn of_many_points(mesh: &TriangleMesh, solid: &dyn ImplicitSolid) -> Deviation {
        const STEPS: usize = 16;
        let (mut sum, mut weight, mut largest) = (0.0, 0.0, 0.0_f64);
        for triangle in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(triangle);
            let area = (b - a).cross(&(c - a)).norm();
            for i in 0..STEPS {
                for j in 0..STEPS - i {
                    // The part that stands like the triangle, and the one upside down next to it.
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
            let expected = of_many_points(&surface.mesh, surface.solid());
            let found = surface.deviation();
            let relative = found.rms_angstrom / expected.rms_angstrom - 1.0;
            assert!(relative.abs() < 0.05, "{relative} {found:?} {expected:?}");
            assert!(found.largest_angstrom > 0.8 * expected.largest_angstrom);
        }
    }

    /// The slow twin: all seven points of every triangle.
    #[test]
    fn a_sample_of_the_triangles_says_what_all_of_them_say() {
        for (centres, radii) in crate::surface::test_support::clusters(3, 150..200) {
            let settings = MeshSettings::default();
            let surface = solvent_excluded_surface(&centres, &radii, 1.4, &settings).unwrap();
            let (mesh, solid) = (&surface.mesh, surface.solid());
            let simple = simple_guide(mesh, solid);
            let all = sampled(mesh, solid, &simple, 1);
            for guide in [&simple, surface.expected_squares()] {
                for every in [2, 5, 11] {
                    let some = sampled(mesh, solid, guide, every);
                    let relative = some.rms_angstrom / all.rms_angstrom - 1.0;
                    assert!(relative.abs() < 0.05, "{every}: {relative}");
                    let largest = some.largest_angstrom / all.largest_angstrom;
                    assert!(largest > 0.9 && largest <= 1.0, "{every}: {largest}");
                }
            }
        }
    }

    /// The surface of a structure file as `ingest` makes it; `None` for a file that is no protein.
    fn surface_of_protein(file: &Path) -> Option<Surface> {
        let (name, mut bytes) = (file.display().to_string(), Vec::new());
        let mut text = flate2::read::MultiGzDecoder::new(File::open(file).unwrap());
        text.read_to_end(&mut bytes).ok()?;
        let structure = Structure::read(&name, &bytes).ok()?;
        let selection = structure.select(&SelectionSettings::default()).ok()?;
        let sites = build_sites(&selection, &SiteSettings::default()).ok()?;
        surface_of_sites(&sites.sites, &SurfaceSettings::default()).ok()
    }

    /// Test of proteins with the sample that `surface` and `ingest` take: gzipped structure files
    /// of the folder that PROTOMER_STRUCTURES names, or the bundled ones.
    #[test]
    fn proteins_are_as_far_off_as_all_seven_points_say() {
        let bundled = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../data/structures");
        let folder = std::env::var("PROTOMER_STRUCTURES").unwrap_or_else(|_| bundled.into());
        let entries = std::fs::read_dir(folder).unwrap();
        let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
        files.sort();
        let mut proteins = 0;
        for file in files {
            let Some(surface) = surface_of_protein(&file) else {
                continue;
            };
            proteins += 1;
            let (mesh, solid, found) = (&surface.mesh, surface.solid(), surface.deviation());
            let all = sampled(mesh, solid, surface.expected_squares(), 1);
            let relative = found.rms_angstrom / all.rms_angstrom - 1.0;
            let largest = found.largest_angstrom / all.largest_angstrom;
            println!(
                "{}: {} triangles, rms {:.4} Å, found {:+.2} %, largest {:.3} Å, found {largest:.3} of it",
                file.display(),
                mesh.triangles.len(),
                all.rms_angstrom,
                100.0 * relative,
                all.largest_angstrom
            );
            assert!(relative.abs() < 0.02, "{relative}");
            assert!(largest > 0.95 && largest <= 1.0, "{largest}");
        }
        assert!(proteins > 0);
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
        let moved = Deviation::measure(&larger, surface.solid());
        assert!((moved.rms_angstrom - 0.5).abs() < 0.02, "{moved:?}");
        assert!((moved.largest_angstrom - 0.5).abs() < 0.02, "{moved:?}");
    }
}
