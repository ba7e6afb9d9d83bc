//! Hydrodynamic radii from the electrostatic capacity.
//!
//! The Stokes friction of a body, averaged over its orientations, is 6πη C to about a percent, where
//! C is the capacity of a conductor of the same shape (in units in which a sphere has its radius):
//! Hubbard and Douglas, Phys. Rev. E 47, R2983 (1993); Douglas, Zhou and Hubbard, Phys. Rev. E 49, 5319
//! (1994). The two are equal for spheres and ellipsoids; for two touching spheres C is 2 ln 2 = 1.386
//! radii. The capacity has no noise and takes milliseconds for a cluster. Random walks need 10⁵
//! steps for 0.3 %.
//!
//! C is the charge of the surface at unit potential. The surface is a set of patches with charges q_i
//! that solve Σ_j G_ij q_j = 1. G_ij is the potential between Gaussian charges, erf(r/w)/r with w² =
//! w_i² + w_j²: 1/r for all but overlapping patches, and positive definite however close they come.
//! The width of a patch of area A makes its own potential M/√A. Then a plane of evenly spread patches
//! has the energy of a plane of even charge: M is the Madelung constant of a plane lattice, between
//! 3.900 (square) and 3.921 (triangles) (Bonsall and Maradudin, Phys. Rev. B 15, 1959 (1977)).

use protomer_kernel::{Pose, TriangleMesh, Vec3};
use std::f64::consts::PI;

/// Potential of a patch with unit charge in itself, times the root of its area.
const MADELUNG: f64 = 3.91;
/// Parts of triangles that make a patch, at least.
const PLACES_PER_PATCH: f64 = 16.0;
/// Least mean cosine between the normal at a vertex and those of its triangles; a corner of a cube
/// has 0.58.
const LEAST_COSINE: f64 = 0.5;
/// Steps in which patches become equal.
const LLOYD_STEPS: usize = 4;
/// The charges of patches are found to this fraction.
const RESIDUAL: f64 = 1e-7;
/// Largest number of steps in which they are found.
const MOST_STEPS: usize = 500;
/// Beyond this, erf(x) is 1 to rounding.
const FAR: f64 = 6.0;

/// The surface of a body as patches, in the frame of the body.
///
/// ```
/// use protomer_kernel::{Pose, TriangleMesh, Vec3};
/// use protomer_mc::scattering::capacity::{Patches, capacity_angstrom};
/// let cube = TriangleMesh::cuboid(&Vec3::repeat(-5.0), &Vec3::repeat(5.0));
/// let patches = Patches::new(&cube, 0.0, 400);
/// let capacity = capacity_angstrom(&[(&patches, Pose::identity())]);
/// // A cube of edge a has 0.6607 a.
/// assert!(capacity.is_some_and(|angstrom| (angstrom / 6.607 - 1.0).abs() < 0.02));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Patches {
    centres_angstrom: Vec<Vec3>,
    areas_angstrom2: Vec<f64>,
}

impl Patches {
    /// About `count` patches of the surface that lies `hydration_angstrom` outside a mesh: the water
    /// that moves with the body.
    pub fn new(mesh: &TriangleMesh, hydration_angstrom: f64, count: usize) -> Self {
        let vertices = moved_outward(mesh, hydration_angstrom);
        let corners = |triangle: &[u32; 3]| triangle.map(|corner| vertices[corner as usize]);
        let area = |[a, b, c]: [Vec3; 3]| 0.5 * (b - a).cross(&(c - a)).norm();
        let total: f64 = mesh
            .triangles
            .iter()
            .map(|triangle| area(corners(triangle)))
            .sum();
        // Small against a patch, so that patches may become round and equal.
        let largest = total / (PLACES_PER_PATCH * count as f64);
        let (mut places, mut areas) = (Vec::new(), Vec::new());
        for triangle in &mesh.triangles {
            let whole = corners(triangle);
            // In cuts² parts that are not larger than this.
            // Triangles of a mesh differ in size; parts are nearly equal in area.
            let cuts = (area(whole) / largest).sqrt().ceil().max(1.0);
            let parts = parts(whole, cuts as usize);
            areas.resize(areas.len() + parts.len(), area(whole) / parts.len() as f64);
            places.extend(parts);
        }
        let mut centres = far_apart(&places, count);
        let mut owners = nearest(&places, &centres);
        // Lloyd's iteration: centres to the middle of their places, places to the nearest centre.
        for _ in 0..LLOYD_STEPS {
            centres = middles(&places, &areas, &owners, &centres);
            owners = nearest(&places, &centres);
        }
        let mut sums = vec![0.0; centres.len()];
        for (owner, area) in owners.iter().zip(&areas) {
            sums[*owner] += area;
        }
        // A centre may lose all its places to its neighbours.
        let filled = centres
            .into_iter()
            .zip(sums)
            .filter(|(_, area)| *area > 0.0);
        let (centres_angstrom, areas_angstrom2) = filled.unzip();
        Self {
            centres_angstrom,
            areas_angstrom2,
        }
    }

    /// Number of patches.
    pub fn len(&self) -> usize {
        self.centres_angstrom.len()
    }

    /// Whether there is no surface.
    pub fn is_empty(&self) -> bool {
        self.centres_angstrom.is_empty()
    }
}

/// The capacity of several bodies together, Å: that of one conductor, which they form with whatever
/// is between overlapping surfaces. `None` if the charges are not found, as for patches without area.
pub fn capacity_angstrom(bodies: &[(&Patches, Pose)]) -> Option<f64> {
    let (mut centres, mut widths_squared) = (Vec::new(), Vec::new());
    for (patches, pose) in bodies {
        for (centre, area) in patches
            .centres_angstrom
            .iter()
            .zip(&patches.areas_angstrom2)
        {
            centres.push(pose.transform_point(centre));
            // 2/(√π √2 w) = M/√A.
            widths_squared.push(2.0 * area / (PI * MADELUNG * MADELUNG));
        }
    }
    let matrix = Matrix::new(&centres, &widths_squared);
    let charges = matrix.solved_for_ones()?;
    Some(charges.iter().sum())
}

/// A symmetric matrix, row by row.
struct Matrix {
    size: usize,
    entries: Vec<f64>,
}

impl Matrix {
    fn new(centres: &[Vec3], widths_squared: &[f64]) -> Self {
        let size = centres.len();
        let mut entries = vec![0.0; size * size];
        for i in 0..size {
            // Only the lower half is computed; the matrix is symmetric.
            for j in 0..=i {
                let distance = (centres[i] - centres[j]).norm();
                let width = (widths_squared[i] + widths_squared[j]).sqrt();
                let value = potential(distance, width);
                entries[i * size + j] = value;
                entries[j * size + i] = value;
            }
        }
        Self { size, entries }
    }

    fn times(&self, vector: &[f64]) -> Vec<f64> {
        let rows = self.entries.chunks(self.size);
        rows.map(|row| dot(row, vector)).collect()
    }

    /// The vector x with Ax = (1, 1, ...), by conjugate gradients with the diagonal as a guess of A.
    fn solved_for_ones(&self) -> Option<Vec<f64>> {
        // Jacobi preconditioning: patches differ in area and so in their own potential.
        let diagonal: Vec<f64> = (0..self.size)
            .map(|i| self.entries[i * self.size + i])
            .collect();
        let scaled = |vector: &[f64]| -> Vec<f64> {
            vector
                .iter()
                .zip(&diagonal)
                .map(|(value, diagonal_entry)| value / diagonal_entry)
                .collect()
        };
        let mut solution = vec![0.0; self.size];
        let mut residual = vec![1.0; self.size];
        let mut direction = scaled(&residual);
        let mut size = dot(&residual, &direction);
        // In the norm of the preconditioner, in which `size` is measured.
        let goal = RESIDUAL * RESIDUAL * size;
        for _ in 0..MOST_STEPS {
            let image = self.times(&direction);
            let step = size / dot(&direction, &image);
            for place in 0..self.size {
                solution[place] += step * direction[place];
                residual[place] -= step * image[place];
            }
            let next = scaled(&residual);
            let next_size = dot(&residual, &next);
            // Patches without area have a diagonal of infinity.
            if !next_size.is_finite() {
                return None;
            }
            if next_size <= goal {
                return Some(solution);
            }
            let share = next_size / size;
            for (old, new) in direction.iter_mut().zip(&next) {
                *old = new + share * *old;
            }
            size = next_size;
        }
        None
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// erf(r/w)/r.
fn potential(distance: f64, width: f64) -> f64 {
    let x = distance / width;
    match x {
        // erf is one to rounding: most pairs take this way.
        _ if x > FAR => 1.0 / distance,
        // The limit 2/(√π w), as erf(x)/r would divide zero by zero.
        _ if x < 1e-4 => 2.0 / (PI.sqrt() * width),
        _ => erf(x) / distance,
    }
}

/// The error function for 0 < x < 6, by its series (Abramowitz and Stegun 7.1.6), whose terms are all
/// positive.
fn erf(x: f64) -> f64 {
    let (mut term, mut sum, mut n) = (x, x, 0.0);
    // All terms positive: no cancellation, whatever x.
    while term > 1e-17 * sum {
        n += 1.0;
        term *= 2.0 * x * x / (2.0 * n + 1.0);
        sum += term;
    }
    2.0 / PI.sqrt() * (-x * x).exp() * sum
}

/// The centres of the `cuts`² equal parts of a triangle.
fn parts([a, b, c]: [Vec3; 3], cuts: usize) -> Vec<Vec3> {
    let point = |i: f64, j: f64| a + ((b - a) * i + (c - a) * j) / cuts as f64;
    let mut centres = Vec::with_capacity(cuts * cuts);
    for i in 0..cuts {
        for j in 0..cuts - i {
            let (row, column) = (i as f64, j as f64);
            centres.push(point(row + 1.0 / 3.0, column + 1.0 / 3.0));
            // Upright triangles and, but for the last of a row, inverted ones: cuts² in all.
            if i + j + 1 < cuts {
                centres.push(point(row + 2.0 / 3.0, column + 2.0 / 3.0));
            }
        }
    }
    centres
}

/// Vertices along the mean normals of their triangles, so far that the triangles are moved by this
/// distance on average. At a cusp they go less far.
fn moved_outward(mesh: &TriangleMesh, distance: f64) -> Vec<Vec3> {
    let mut normals = vec![Vec3::zeros(); mesh.vertices.len()];
    let mut angles = vec![0.0; mesh.vertices.len()];
    for triangle in &mesh.triangles {
        let corners = triangle.map(|corner| mesh.vertices[corner as usize]);
        let [a, b, c] = corners;
        // A triangle without area has no normal and no weight.
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else {
            continue;
        };
        for place in 0..3 {
            let [own, next, last] = [0, 1, 2].map(|step| corners[(place + step) % 3]);
            // With angles as weights it does not matter how a plane is cut into triangles.
            let angle = (next - own).angle(&(last - own));
            normals[triangle[place] as usize] += normal * angle;
            angles[triangle[place] as usize] += angle;
        }
    }
    let mut vertices = Vec::with_capacity(mesh.vertices.len());
    for ((vertex, normal), angle) in mesh.vertices.iter().zip(&normals).zip(&angles) {
        // The mean cosine between the mean normal and those of the triangles.
        let cosine = (normal.norm() / angle).max(LEAST_COSINE);
        let direction = normal.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
        vertices.push(vertex + direction * (distance / cosine));
    }
    vertices
}

/// Places far from each other: each the farthest from those before it.
fn far_apart(places: &[Vec3], count: usize) -> Vec<Vec3> {
    let mut chosen = Vec::new();
    let mut squared = vec![f64::INFINITY; places.len()];
    // Each new centre only shortens distances, so one array of squares is kept up to date.
    while chosen.len() < count.min(places.len()) {
        let farthest = (0..places.len()).max_by(|a, b| squared[*a].total_cmp(&squared[*b]));
        let Some(farthest) = farthest else { break };
        let centre = places[farthest];
        for (place, squared) in places.iter().zip(&mut squared) {
            *squared = squared.min((place - centre).norm_squared());
        }
        chosen.push(centre);
    }
    chosen
}

/// For each place the index of the nearest centre.
fn nearest(places: &[Vec3], centres: &[Vec3]) -> Vec<usize> {
    let mut owners = Vec::with_capacity(places.len());
    for place in places {
        let (mut best, mut least) = (0, f64::INFINITY);
        for (index, centre) in centres.iter().enumerate() {
            let squared = (place - centre).norm_squared();
            if squared < least {
                (best, least) = (index, squared);
            }
        }
        // `<`: of equally near centres, the first.
        owners.push(best);
    }
    owners
}

/// The middle of each patch, on the surface: the place nearest to the mean of its places.
fn middles(places: &[Vec3], areas: &[f64], owners: &[usize], centres: &[Vec3]) -> Vec<Vec3> {
    let mut sums = vec![(Vec3::zeros(), 0.0); centres.len()];
    for ((place, area), owner) in places.iter().zip(areas).zip(owners) {
        sums[*owner].0 += place * *area;
        sums[*owner].1 += area;
    }
    // A place of the surface, not the mean, which lies inside the body.
    let mut middles = centres.to_vec();
    let mut least = vec![f64::INFINITY; centres.len()];
    for (place, owner) in places.iter().zip(owners) {
        let (sum, area) = sums[*owner];
        let squared = (place - sum / area).norm_squared();
        if squared < least[*owner] {
            (middles[*owner], least[*owner]) = (*place, squared);
        }
    }
    middles
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use std::collections::HashMap;
    use std::f64::consts::LN_2;

    /// An octahedron whose faces are cut into four `times` times, on a sphere of radius 1 with each
    /// axis stretched.
    fn ellipsoid(axes: [f64; 3], times: usize) -> TriangleMesh {
        let mut mesh = TriangleMesh::octahedron(1.0);
        for _ in 0..times {
            let (mut cut, mut halves) = (Vec::new(), HashMap::new());
            for [a, b, c] in std::mem::take(&mut mesh.triangles) {
                let mut half = |first: u32, second: u32| {
                    let edge = (first.min(second), first.max(second));
                    *halves.entry(edge).or_insert_with(|| {
                        let [first, second] =
                            [first, second].map(|end| mesh.vertices[end as usize]);
                        mesh.vertices.push((first + second).normalize());
                        mesh.vertices.len() as u32 - 1
                    })
                };
                let (d, e, f) = (half(a, b), half(b, c), half(c, a));
                cut.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
            }
            mesh.triangles = cut;
        }
        for vertex in &mut mesh.vertices {
            *vertex = vertex.component_mul(&Vec3::from(axes));
        }
        mesh
    }

    fn capacity(mesh: &TriangleMesh, count: usize) -> f64 {
        capacity_angstrom(&[(&Patches::new(mesh, 0.0, count), Pose::identity())]).unwrap()
    }

    #[test]
    fn a_sphere_has_its_radius() {
        let sphere = ellipsoid([20.0; 3], 5);
        for (count, error) in [(12, 0.015), (40, 0.005), (128, 0.003), (400, 0.002)] {
            let relative = capacity(&sphere, count) / 20.0 - 1.0;
            println!("sphere, {count} patches: {relative:+.5}");
            assert!(relative.abs() < error, "{count}: {relative}");
        }
        // Water around it adds its thickness.
        let wet = Patches::new(&sphere, 2.5, 128);
        let wet = capacity_angstrom(&[(&wet, Pose::identity())]).unwrap();
        assert!((wet / 22.5 - 1.0).abs() < 0.003, "{wet}");
    }

    #[test]
    fn touching_spheres_have_the_capacity_of_maxwell() {
        let sphere = Patches::new(&ellipsoid([20.0; 3], 5), 0.0, 128);
        let moved = Pose {
            position: Vec3::new(0.0, 0.0, 40.0),
            ..Pose::identity()
        };
        let both = capacity_angstrom(&[(&sphere, Pose::identity()), (&sphere, moved)]).unwrap();
        println!("two spheres: {:.5} radii", both / 20.0);
        assert!((both / 20.0 / (2.0 * LN_2) - 1.0).abs() < 0.004, "{both}");
        // Apart by d they have 2/(1 + a/d) radii up to (a/d)³, and together in one place one radius.
        let far = Pose {
            position: Vec3::new(0.0, 400.0, 0.0),
            ..Pose::identity()
        };
        let apart = capacity_angstrom(&[(&sphere, Pose::identity()), (&sphere, far)]).unwrap();
        assert!((apart / 20.0 / (2.0 / 1.05) - 1.0).abs() < 0.004, "{apart}");
        let same = capacity_angstrom(&[(&sphere, Pose::identity()); 2]).unwrap();
        assert!((same / 20.0 - 1.0).abs() < 0.05, "{same}");
    }

    #[test]
    fn ellipsoids_have_the_capacity_of_theory() {
        // Prolate: √(a² - b²)/arcosh(a/b); oblate: √(a² - b²)/arccos(b/a).
        let cases = [
            ([40.0, 10.0, 10.0], 1500_f64.sqrt() / 4_f64.acosh()),
            ([20.0, 20.0, 5.0], 375_f64.sqrt() / 0.25_f64.acos()),
        ];
        for (axes, exact) in cases {
            let found = capacity(&ellipsoid(axes, 5), 200);
            println!("{axes:?}: {:+.5}", found / exact - 1.0);
            assert!(
                (found / exact - 1.0).abs() < 0.005,
                "{axes:?}: {found} {exact}"
            );
        }
    }

    #[test]
    fn a_cube_has_its_published_capacity_however_coarse_its_mesh() {
        let cube = TriangleMesh::cuboid(&Vec3::zeros(), &Vec3::repeat(10.0));
        // Hwang and Mascagni, J. Appl. Phys. 95, 3798 (2004): 0.660 678 edges.
        let found = capacity(&cube, 128) / 10.0;
        println!("cube: {found:.5} edges");
        assert!((found / 0.660_678 - 1.0).abs() < 0.01, "{found}");
        let wet = Patches::new(&cube, 1.0, 128);
        let wet = capacity_angstrom(&[(&wet, Pose::identity())]).unwrap();
        assert!((wet / 12.0 / found - 1.0).abs() < 0.002, "{wet}");
    }

    #[test]
    fn charges_are_those_of_a_direct_solution() {
        let patches = Patches::new(&ellipsoid([10.0, 14.0, 25.0], 4), 1.0, 60);
        let centres = &patches.centres_angstrom;
        let matrix = DMatrix::from_fn(centres.len(), centres.len(), |i, j| {
            let own = |k: usize| 2.0 * patches.areas_angstrom2[k] / (PI * MADELUNG * MADELUNG);
            potential((centres[i] - centres[j]).norm(), (own(i) + own(j)).sqrt())
        });
        let charges = matrix
            .lu()
            .solve(&DVector::from_element(centres.len(), 1.0))
            .unwrap();
        let found = capacity_angstrom(&[(&patches, Pose::identity())]).unwrap();
        assert!((found - charges.sum()).abs() < 1e-6 * found);
    }

    #[test]
    fn the_error_function_has_its_published_values() {
        for (x, value) in [
            (0.1, 0.112_462_916_0),
            (1.0, 0.842_700_792_9),
            (3.0, 0.999_977_909_5),
        ] {
            assert!((erf(x) - value).abs() < 1e-9);
        }
    }
}
