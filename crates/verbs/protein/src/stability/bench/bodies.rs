//! Bodies that the benchmark makes itself: barrels with bumps and dents, and point charges inside
//! them.

use anyhow::Result;
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::{TriangleMesh, Vec3};
use protomer_mc::BodyType;
use std::collections::HashMap;
use std::sync::Arc;

/// Half the width of the barrel without its bumps, Å.
const HALF_WIDTH_ANGSTROM: f64 = 12.5;
/// Half the height of the barrel without its bumps, Å.
const HALF_HEIGHT_ANGSTROM: f64 = 19.5;
/// Number of bumps and dents.
const BUMPS: usize = 60;
/// Largest height of a bump or depth of a dent, Å.
const BUMP_HEIGHT_ANGSTROM: f64 = 2.5;
/// Reach of a bump or dent, as 1 - cosine of the angle.
const BUMP_REACH: f64 = 0.1;
/// Charges stay this far below the surface, Å, measured towards the middle.
const DEPTH_ANGSTROM: f64 = 1.0;
/// Charges before their sum is set are uniform between this and its negative, e.
const LARGEST_CHARGE_E: f64 = 0.6;
/// Sums of the charges of the two kinds of bodies, e.
const NET_CHARGES_E: [f64; 2] = [30.0, -20.0];

/// A body seen from its middle: one radius per direction, so its surface never meets itself.
pub(super) struct Barrel {
    bumps: Vec<(Vec3, f64)>,
}

impl Barrel {
    /// The barrel of this seed.
    pub(super) fn new(seed: u64) -> Self {
        let mut rng = CounterRng::for_purpose(seed, 0, 0, Purpose::Object);
        let bump = |_| {
            (
                rng.unit_vector(),
                rng.uniform_in(-BUMP_HEIGHT_ANGSTROM, BUMP_HEIGHT_ANGSTROM),
            )
        };
        Self {
            bumps: (0..BUMPS).map(bump).collect(),
        }
    }

    /// Distance of the surface from the middle along a unit vector, Å: (ρ⁴/a⁴ + z⁴/c⁴)^(-1/4) for
    /// the barrel, and h (1 - (1 - cos θ)/w)² for each bump nearer than its reach w.
    fn radius_angstrom(&self, direction: &Vec3) -> f64 {
        let equatorial_term =
            (direction.x * direction.x + direction.y * direction.y) / HALF_WIDTH_ANGSTROM.powi(2);
        let axial_term = direction.z * direction.z / HALF_HEIGHT_ANGSTROM.powi(2);
        let barrel = (equatorial_term * equatorial_term + axial_term * axial_term)
            .sqrt()
            .sqrt()
            .recip();
        let bump = |(middle, height): &(Vec3, f64)| {
            let nearness = 1.0 - (1.0 - middle.dot(direction)) / BUMP_REACH;
            height * nearness.max(0.0).powi(2)
        };
        barrel + self.bumps.iter().map(bump).sum::<f64>()
    }

    /// The closed surface with 8 · `edge_divisions`² triangles.
    pub(super) fn mesh(&self, edge_divisions: i32) -> TriangleMesh {
        octahedron(edge_divisions).map_vertices(|vertex| {
            let direction = vertex.normalize();
            direction * self.radius_angstrom(&direction)
        })
    }

    /// Whether a point lies deep enough inside to carry a charge.
    fn holds(&self, point: &Vec3) -> bool {
        let distance = point.norm();
        distance == 0.0 || distance < self.radius_angstrom(&(point / distance)) - DEPTH_ANGSTROM
    }

    /// Random charges (Å, e) inside, with this sum.
    pub(super) fn charges(
        &self,
        count: usize,
        net_charge_e: f64,
        rng: &mut CounterRng,
    ) -> Vec<(Vec3, f64)> {
        let largest = Vec3::new(
            HALF_WIDTH_ANGSTROM,
            HALF_WIDTH_ANGSTROM,
            HALF_HEIGHT_ANGSTROM,
        )
        .add_scalar(5.0);
        let mut charges = Vec::with_capacity(count);
        while charges.len() < count {
            let point = largest.map(|length| length * rng.uniform_in(-1.0, 1.0));
            let charge = rng.uniform_in(-LARGEST_CHARGE_E, LARGEST_CHARGE_E);
            if self.holds(&point) {
                charges.push((point, charge));
            }
        }
        let sum: f64 = charges.iter().map(|(_, charge)| charge).sum();
        let excess = (sum - net_charge_e) / count.max(1) as f64;
        charges.iter_mut().for_each(|(_, charge)| *charge -= excess);
        charges
    }
}

/// The two kinds of bodies of the benchmark: one shape, charges of opposite sign.
///
/// # Errors
/// If the mesh bounds no solid.
pub fn two_kinds(charges: usize, edge_divisions: i32, seed: u64) -> Result<Vec<Arc<BodyType>>> {
    let barrel = Barrel::new(seed);
    let mesh = barrel.mesh(edge_divisions);
    let kinds = ["a", "b"].into_iter().zip(NET_CHARGES_E).zip(0..);
    kinds
        .map(|((name, net_charge_e), index)| {
            let mut rng =
                CounterRng::for_purpose(seed, index, charges as u64, Purpose::BenchmarkCharges);
            let charges = barrel.charges(charges, net_charge_e, &mut rng);
            Ok(Arc::new(BodyType::new(name, &mesh, &charges)?))
        })
        .collect()
}

/// The octahedron |x| + |y| + |z| = n with every face divided into n² triangles: its vertices are
/// the points of the integer lattice on it.
fn octahedron(n: i32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let mut numbers: HashMap<[i32; 3], u32> = HashMap::new();
    let mut vertex = |point: [i32; 3], vertices: &mut Vec<Vec3>| {
        *numbers.entry(point).or_insert_with(|| {
            vertices.push(Vec3::from(point.map(f64::from)));
            vertices.len() as u32 - 1
        })
    };
    const POINTING_OUT: [[i32; 3]; 3] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    const POINTING_IN: [[i32; 3]; 3] = [[0, 1, 1], [1, 0, 1], [1, 1, 0]];
    for octant in 0..8 {
        let signs = [0, 1, 2].map(|axis| 1 - 2 * (octant >> axis & 1));
        let mirrored = signs.iter().product::<i32>() < 0;
        for (corners, taken) in [(POINTING_OUT, 1), (POINTING_IN, 2)] {
            for a in 0..=n - taken {
                for b in 0..=n - taken - a {
                    let from = [a, b, n - taken - a - b];
                    let point = |corner: [i32; 3]| {
                        [0, 1, 2].map(|axis| signs[axis] * (from[axis] + corner[axis]))
                    };
                    let [p, q, r] = corners.map(|corner| vertex(point(corner), &mut mesh.vertices));
                    mesh.triangles
                        .push(if mirrored { [p, r, q] } else { [p, q, r] });
                }
            }
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mesh_is_one_closed_outward_barrel_with_dents() {
        let mesh = Barrel::new(1).mesh(14);
        assert_eq!(
            (mesh.triangles.len(), mesh.vertices.len()),
            (8 * 14 * 14, 4 * 14 * 14 + 2)
        );
        let topology = mesh.topology().unwrap();
        assert_eq!(
            (topology.components, topology.genus, topology.cavities),
            (1, 0, 0)
        );
        let extent = |axis: usize| {
            let coordinate = |vertex: &Vec3| vertex[axis];
            let high = mesh
                .vertices
                .iter()
                .map(coordinate)
                .fold(f64::MIN, f64::max);
            high - mesh
                .vertices
                .iter()
                .map(coordinate)
                .fold(f64::MAX, f64::min)
        };
        assert!(
            (23.0..30.0).contains(&extent(0)) && (23.0..30.0).contains(&extent(1)),
            "{} {}",
            extent(0),
            extent(1)
        );
        assert!((37.0..45.0).contains(&extent(2)), "{}", extent(2));
        // A convex body lies behind each of its faces.
        let dented = (0..mesh.triangles.len()).any(|triangle| {
            let [a, b, c] = mesh.corners(triangle);
            let normal = (b - a).cross(&(c - a)).normalize();
            mesh.vertices
                .iter()
                .any(|vertex| normal.dot(&(vertex - a)) > 0.5)
        });
        assert!(dented);
    }

    #[test]
    fn charges_are_inside_and_have_their_sum() {
        let kinds = two_kinds(400, 14, 3).unwrap();
        for (kind, net) in kinds.iter().zip(NET_CHARGES_E) {
            assert_eq!(kind.charges.len(), 400);
            assert!((kind.charges.net_charge_e() - net).abs() < 1e-9);
            assert!(
                kind.charges
                    .iter()
                    .all(|(place, _)| kind.shape.contains_point(&place))
            );
        }
    }

    #[test]
    fn a_seed_is_a_body() {
        let bits = |seed| Barrel::new(seed).mesh(4).vertices;
        assert_eq!(bits(1), bits(1));
        assert_ne!(bits(1), bits(2));
    }
}
