//! Moves the vertices off the surface so that the flat triangles have the right area and volume.
//!
//! A mesh with its vertices *on* a curved surface cuts every bulge and fills every hollow: a sphere
//! of 42 vertices loses 13 % of its volume and 8 % of its area. The cure has a local and a global
//! part.
//!
//! Locally, let d(x) be the signed distance of a point of a triangle. Moving each vertex v along
//! its normal by
//!
//! ```text
//! s_v = - ∫ d dA / ∫ dA          over the triangles at v
//! ```
//!
//! makes the volume right to first order everywhere, since the linear interpolant of s integrates
//! to -∫ d dA. The facets then straddle the surface, and at equal volume flat facets have more area
//! than the smooth surface.
//!
//! Globally, with an exact area and volume to aim at, the vertices move by the least amount (in the
//! mean square) that gives the mesh both. By Lagrange's rule that displacement is a combination of
//! the gradients of the two measures; per unit of area these are 1 for the volume and the discrete
//! mean curvature κ_v (twice the mean curvature) for the area:
//!
//! ```text
//! u_v = λ (κ_v - κ̄) + δ ,   δ = ΔV / A ,   λ = (ΔA - κ̄ ΔV) / ∫ (κ - κ̄)² dA
//! ```
//!
//! taken in a few steps, volume last, so that it is met to rounding. On a sphere κ differs only by
//! the unevenness of the triangles; there the area keeps what a polyhedron of that volume must have
//! at least (isoperimetric inequality). All displacements fall as 1/density.

use super::implicit::ImplicitSolid;
use super::remesh::HalfEdgeMesh;
use protomer_kernel::Vec3;

/// Area and volume that a mesh should have, over its whole surface, cavities included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Surface area, Å².
    pub area_angstrom2: f64,
    /// Enclosed volume, Å³.
    pub volume_angstrom3: f64,
}

/// Largest displacement of a vertex, as a fraction of the edge length around it.
const FARTHEST: f64 = 0.3;
/// Largest λ of one step, as a fraction of the squared edge length; explicit diffusion is stable
/// below about 1/6.
const LARGEST_STEP: f64 = 0.08;
/// Fraction of its area vector that a triangle must keep so as not to count as folded.
const FOLDED: f64 = 0.3;
/// Largest number of searches for folded triangles.
const UNFOLDINGS: usize = 6;
/// Steps towards the area, and towards the volume after them.
const STEPS: usize = 12;
/// Number of edges for whose middles distances are found at once.
const AT_ONCE: usize = 4096;
/// Relative errors that need no further step.
const CLOSE: f64 = 1e-9;

/// Displaces the vertices of `mesh`, which lie on the surface of `solid`. Returns an estimate of the
/// mean squared distance from the surface on each displaced triangle, Å², in the order of the triangles.
pub(crate) fn calibrate(
    mesh: &mut HalfEdgeMesh,
    solid: &dyn ImplicitSolid,
    target: Option<Target>,
) -> Vec<f64> {
    let mut facets = Facets::new(mesh);
    facets.straddle(mesh, solid);
    for _ in 0..UNFOLDINGS {
        if let Some(target) = target {
            facets.aim(target);
        }
        if !facets.tighten_folds() {
            break;
        }
    }
    mesh.positions.copy_from_slice(&facets.position);
    facets.expected_squares()
}

/// The triangles of a mesh and how far each vertex has moved along its normal.
struct Facets {
    triangles: Vec<[u32; 3]>,
    /// Distances of the middles of each triangle's edges before the displacement, Å, each edge at the
    /// corner where it starts.
    middles: Vec<[f64; 3]>,
    vertices: Vec<u32>,
    start: Vec<Vec3>,
    /// Unit normal of each vertex.
    normal: Vec<Vec3>,
    /// Mean squared edge length around each vertex, Å².
    scale: Vec<f64>,
    /// Largest displacement of each vertex, Å.
    farthest: Vec<f64>,
    /// Displacement along the normal, Å.
    offset: Vec<f64>,
    /// Positions after the displacement, Å.
    position: Vec<Vec3>,
}

/// Area and volume of a mesh and what changes them.
struct Measures {
    area: f64,
    volume: f64,
    /// A third of the area around each vertex, Å².
    share: Vec<f64>,
    /// Rate of area with the displacement of each vertex, per unit of `share`: the discrete mean
    /// curvature κ, 1/Å.
    curvature: Vec<f64>,
}

impl Facets {
    fn new(mesh: &HalfEdgeMesh) -> Self {
        let count = mesh.positions.len();
        let triangles: Vec<[u32; 3]> = mesh.triangles().map(|t| mesh.triangle(t)).collect();
        let (mut normal, mut area) = (vec![Vec3::zeros(); count], vec![0.0; count]);
        for triangle in &triangles {
            let vector = area_vector(triangle, &mesh.positions);
            for &vertex in triangle {
                normal[vertex as usize] += vector;
                area[vertex as usize] += 0.5 * vector.norm();
            }
        }
        let vertices: Vec<u32> = mesh.vertices().collect();
        for normal in &mut normal {
            *normal = normal.try_normalize(f64::MIN_POSITIVE).unwrap_or_default();
        }
        // `area` has the fan's whole area: each triangle counts at all three corners.
        // A fan of six equilateral triangles of edge L has the area 6 (√3/4) L².
        // From the area, not from edges: it is at hand, and slivers do not spoil it.
        let scale: Vec<f64> = area.iter().map(|area| area / (1.5 * 3f64.sqrt())).collect();
        let farthest: Vec<f64> = scale.iter().map(|l2| FARTHEST * l2.sqrt()).collect();
        let start = mesh.positions.clone();
        let (position, offset) = (start.clone(), vec![0.0; count]);
        Self {
            middles: Vec::with_capacity(triangles.len()),
            triangles,
            vertices,
            start,
            normal,
            scale,
            farthest,
            offset,
            position,
        }
    }

    /// The local part: s_v, with d integrated by its values at the middles of the edges, exact for
    /// quadratic d.
    fn straddle(&mut self, mesh: &HalfEdgeMesh, solid: &dyn ImplicitSolid) {
        let mut distance = vec![0.0; mesh.half_edge_bound() as usize];
        let (mut middles, mut values) = (Vec::with_capacity(AT_ONCE), Vec::new());
        let edges = (0..mesh.half_edge_bound()).filter(|half_edge| mesh.is_edge(*half_edge));
        let edges: Vec<u32> = edges.collect();
        // In parts, since the solid answers many points at a time and memory stays small.
        for some in edges.chunks(AT_ONCE) {
            middles.clear();
            for &half_edge in some {
                let (a, b) = mesh.ends(half_edge);
                middles.push(0.5 * (mesh.position(a) + mesh.position(b)));
            }
            solid.signed_distances(&middles, &mut values);
            for (&half_edge, value) in some.iter().zip(&values) {
                // Both half-edges: a triangle looks up each side at its own corner.
                distance[half_edge as usize] = *value;
                distance[mesh.twin(half_edge) as usize] = *value;
            }
        }
        let (mut gap, mut area) = (vec![0.0; self.start.len()], vec![0.0; self.start.len()]);
        for triangle in mesh.triangles() {
            let size = mesh.area_vector(triangle).norm();
            let first = 3 * triangle as usize;
            let middles = [0, 1, 2].map(|side| distance[first + side]);
            self.middles.push(middles);
            // The rule of the edges' middles has equal weights.
            let mean = middles.iter().sum::<f64>() / 3.0;
            for vertex in mesh.triangle(triangle) {
                gap[vertex as usize] += size * mean;
                area[vertex as usize] += size;
            }
        }
        for &vertex in &self.vertices {
            let i = vertex as usize;
            // Outwards is positive: where the triangles lie
            // inside the surface on average, d > 0 there.
            self.offset[i] = -gap[i] / area[i].max(f64::MIN_POSITIVE);
        }
        self.update();
    }

    /// The global part: λ and δ towards the target.
    fn aim(&mut self, target: Target) {
        for step in 0..2 * STEPS {
            let now = self.measure();
            let volume_gap = target.volume_angstrom3 - now.volume;
            let area_gap = target.area_angstrom2 - now.area;
            let volume_is_close = volume_gap.abs() <= CLOSE * target.volume_angstrom3.abs();
            let area_is_close = area_gap.abs() <= CLOSE * target.area_angstrom2;
            // The last steps are for the volume alone.
            let is_last = step >= STEPS;
            if now.area <= 0.0 || volume_is_close && (is_last || area_is_close) {
                break;
            }
            let (mean, variance) = self.curvature_moments(&now);
            let delta = volume_gap / now.area;
            let lambda = if is_last {
                0.0
            } else {
                // Newton's step for both at once: δ changes the area by κ̄
                // times the volume, and λ (κ - κ̄) leaves the volume as it is.
                (area_gap - mean * volume_gap) / variance.max(f64::MIN_POSITIVE)
            };
            for &vertex in &self.vertices {
                let i = vertex as usize;
                // Explicit diffusion of the offset would swing up beyond this.
                let largest = LARGEST_STEP * self.scale[i];
                self.offset[i] +=
                    lambda.clamp(-largest, largest) * (now.curvature[i] - mean) + delta;
            }
            self.update();
        }
    }

    /// Mean κ̄ of the curvature over the area, and ∫ (κ - κ̄)² dA.
    fn curvature_moments(&self, now: &Measures) -> (f64, f64) {
        let mut sum = 0.0;
        for &vertex in &self.vertices {
            let i = vertex as usize;
            sum += now.share[i] * now.curvature[i];
        }
        let mean = sum / now.area;
        let mut variance = 0.0;
        for &vertex in &self.vertices {
            let i = vertex as usize;
            variance += now.share[i] * (now.curvature[i] - mean).powi(2);
        }
        (mean, variance)
    }

    /// Positions after the displacement, which is bounded.
    fn update(&mut self) {
        for &vertex in &self.vertices {
            let i = vertex as usize;
            // Beyond this share of an edge triangles begin to fold.
            self.offset[i] = self.offset[i].clamp(-self.farthest[i], self.farthest[i]);
            self.position[i] = self.start[i] + self.normal[i] * self.offset[i];
        }
    }

    fn measure(&self) -> Measures {
        let count = self.start.len();
        // Relative to a vertex of the mesh: far from the origin the volume would cancel.
        let origin = match self.vertices.first() {
            Some(&vertex) => self.start[vertex as usize],
            None => Vec3::zeros(),
        };
        let (mut area, mut volume) = (0.0, 0.0);
        let (mut share, mut curvature) = (vec![0.0; count], vec![0.0; count]);
        for triangle in &self.triangles {
            let corners = triangle.map(|vertex| self.position[vertex as usize]);
            let vector = area_vector(triangle, &self.position);
            let size = vector.norm();
            area += 0.5 * size;
            volume += (corners[0] - origin).dot(&vector) / 6.0;
            let facing = vector / size.max(f64::MIN_POSITIVE);
            for i in 0..3 {
                // The area grows by half the opposite side per unit of height above that side.
                let opposite = corners[(i + 2) % 3] - corners[(i + 1) % 3];
                let vertex = triangle[i] as usize;
                curvature[vertex] += 0.5 * facing.cross(&opposite).dot(&self.normal[vertex]);
                // `size` is twice the area, and a third of it belongs to each corner.
                share[vertex] += size / 6.0;
            }
        }
        for (rate, share) in curvature.iter_mut().zip(&share) {
            *rate /= share.max(f64::MIN_POSITIVE);
        }
        Measures {
            area,
            volume,
            share,
            curvature,
        }
    }

    /// The mean of d² over each triangle, with d of the middles of its edges changed by the displacement
    /// of their ends.
    fn expected_squares(&self) -> Vec<f64> {
        let squares = self.triangles.iter().zip(&self.middles);
        let squares = squares.map(|(corners, middles)| {
            let [a, b, c] = corners.map(|vertex| self.offset[vertex as usize]);
            let offsets = [a + b, b + c, c + a].map(|sum| 0.5 * sum);
            // d is 1-Lipschitz and about linear in the normal:
            // d after is d before plus the displacement.
            let square = |side: usize| (middles[side] + offsets[side]).powi(2);
            (square(0) + square(1) + square(2)) / 3.0
        });
        squares.collect()
    }

    /// Halves the displacement, and its bound, at every triangle that has turned over or nearly
    /// vanished; whether there was one.
    fn tighten_folds(&mut self) -> bool {
        let mut has_fold = false;
        for triangle in &self.triangles {
            let before = area_vector(triangle, &self.start);
            let after = area_vector(triangle, &self.position);
            if before.dot(&after) < FOLDED * before.norm_squared() {
                has_fold = true;
                for &vertex in triangle {
                    // The bound only falls, so a fold cannot come back with the next aim.
                    self.farthest[vertex as usize] = 0.5 * self.offset[vertex as usize].abs();
                }
            }
        }
        if has_fold {
            self.update();
        }
        has_fold
    }
}

/// Twice the area vector of a triangle, pointing out.
fn area_vector(triangle: &[u32; 3], positions: &[Vec3]) -> Vec3 {
    let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
    (b - a).cross(&(c - a))
}
