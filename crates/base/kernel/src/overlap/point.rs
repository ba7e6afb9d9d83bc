//! Whether a point is within a distance of a solid.
//!
//! The tree is descended from the root. A node whose disc is farther than the distance is dropped; triangles decide what
//! is left. A point that no triangle is near may still lie inside, which a ray decides.

use super::disc::Disc;
use super::shape::CollisionShape;
use super::triangle::Triangle;
use crate::Vec3;

/// Rounding of the distance from a disc, relative to the lengths in it: discs have single precision, and the least
/// distance from one must not be too large.
const ROUNDING: f64 = 1e-6;

impl CollisionShape {
    /// Whether a point (Å, in the body's frame) is closer to the solid than `distance_angstrom`, or in it. This is
    /// whether a ball about the point and the body overlap.
    ///
    /// ```
    /// use protomer_kernel::{CollisionShape, TriangleMesh, Vec3};
    /// let cube = CollisionShape::new(&TriangleMesh::cuboid(&Vec3::zeros(), &Vec3::repeat(2.0)))?;
    /// assert!(cube.is_within(&Vec3::repeat(1.0), 0.1), "deep inside");
    /// assert!(cube.is_within(&Vec3::new(5.0, 6.0, 1.0), 5.01), "3 and 4 from an edge");
    /// assert!(!cube.is_within(&Vec3::new(5.0, 6.0, 1.0), 4.99));
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn is_within(&self, point: &Vec3, distance_angstrom: f64) -> bool {
        if point.norm() - self.radius > distance_angstrom.max(1e-9 * self.radius) {
            return false;
        }
        self.surface_is_within(point, distance_angstrom) || self.contains_point(point)
    }

    fn surface_is_within(&self, point: &Vec3, distance_angstrom: f64) -> bool {
        let mut stack = vec![self.tree.root()];
        while let Some(node) = stack.pop() {
            let node = &self.tree.nodes[node as usize];
            for (lane, child) in node.children.iter().enumerate() {
                if least_distance(&node.discs.disc(lane), point) >= distance_angstrom {
                    continue;
                }
                if !node.is_leaf {
                    stack.push(*child);
                    continue;
                }
                let triangle = self.mesh.corners(*child as usize);
                if squared_distance(&triangle, point) < distance_angstrom * distance_angstrom {
                    return true;
                }
            }
        }
        false
    }
}

/// A lower bound on the distance of a point from a disc, Å; infinite for an unused lane.
fn least_distance(disc: &Disc, point: &Vec3) -> f64 {
    if disc.radius < 0.0 {
        return f64::INFINITY;
    }
    let offset = point - Vec3::from(disc.centre.map(f64::from));
    let normal = Vec3::from(disc.normal.map(f64::from));
    let height = offset.dot(&normal);
    let above = (height.abs() - f64::from(disc.half_thickness)).max(0.0);
    let lateral = ((offset - height * normal).norm() - f64::from(disc.radius)).max(0.0);
    // Coordinates are too small to overflow, and `hypot` takes several times as long.
    (above * above + lateral * lateral).sqrt() - ROUNDING * (offset.norm() + f64::from(disc.radius))
}

/// Squared distance of a point from a triangle: the least from its corners, its edges and, where the foot lies in it, its
/// plane.
fn squared_distance([a, b, c]: &Triangle, point: &Vec3) -> f64 {
    let normal = (b - a).cross(&(c - a));
    let mut least = f64::INFINITY;
    let mut is_above = normal.norm_squared() > 0.0;
    for (from, to) in [(a, b), (b, c), (c, a)] {
        let (edge, way) = (to - from, point - from);
        let squared = edge.norm_squared();
        let part = match squared > 0.0 {
            true => (way.dot(&edge) / squared).clamp(0.0, 1.0),
            false => 0.0,
        };
        least = least.min((way - part * edge).norm_squared());
        // The foot lies in the triangle if it is on the inner side of all three edges.
        is_above &= edge.cross(&way).dot(&normal) >= 0.0;
    }
    match is_above {
        true => least.min((point - a).dot(&normal).powi(2) / normal.norm_squared()),
        false => least,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TriangleMesh;
    use crate::overlap::triangle_distance::triangle_distance;
    use crate::random::CounterRng;

    /// A cube of edge 10 Å that holds a cubic cavity of edge 4 Å.
    fn hollow() -> TriangleMesh {
        let mut outer = TriangleMesh::cuboid(&Vec3::repeat(-5.0), &Vec3::repeat(5.0));
        let inner = TriangleMesh::cuboid(&Vec3::repeat(-2.0), &Vec3::repeat(2.0));
        let first = outer.vertices.len() as u32;
        outer.vertices.extend(inner.vertices);
        // The inner shell looks the other way.
        let turned = |[a, b, c]: [u32; 3]| [first + a, first + c, first + b];
        outer
            .triangles
            .extend(inner.triangles.into_iter().map(turned));
        outer
    }

    /// A bumpy ball of many triangles, whose tree has several levels.
    fn bumpy() -> TriangleMesh {
        let (rings, around) = (16, 24);
        let place = |theta: f64, phi: f64| {
            let radius = 8.0 + 2.0 * (3.0 * phi).cos() * theta.sin().powi(3) + (4.0 * theta).cos();
            let across = radius * theta.sin();
            Vec3::new(across * phi.cos(), across * phi.sin(), radius * theta.cos())
        };
        let mut vertices = vec![place(0.0, 0.0)];
        for ring in 1..rings {
            for step in 0..around {
                let theta = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
                vertices.push(place(
                    theta,
                    std::f64::consts::TAU * f64::from(step) / f64::from(around),
                ));
            }
        }
        vertices.push(place(std::f64::consts::PI, 0.0));
        let (last, around) = (vertices.len() as u32 - 1, around as u32);
        let vertex = |ring: u32, step: u32| 1 + (ring - 1) * around + step % around;
        let mut triangles = Vec::new();
        for step in 0..around {
            triangles.push([0, vertex(1, step), vertex(1, step + 1)]);
            for ring in 1..rings as u32 - 1 {
                let corners = [vertex(ring, step), vertex(ring, step + 1)];
                let below = [vertex(ring + 1, step), vertex(ring + 1, step + 1)];
                triangles.push([corners[0], below[0], below[1]]);
                triangles.push([corners[0], below[1], corners[1]]);
            }
            let bottom = rings as u32 - 1;
            triangles.push([vertex(bottom, step), last, vertex(bottom, step + 1)]);
        }
        TriangleMesh {
            vertices,
            triangles,
        }
    }

    fn brute_force(shape: &CollisionShape, point: &Vec3) -> f64 {
        if shape.contains_point(point) {
            return 0.0;
        }
        let triangles = 0..shape.mesh.triangles.len();
        let distances = triangles
            .map(|triangle| triangle_distance(&shape.mesh.corners(triangle), &[*point; 3]));
        distances.fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn points_are_within_a_distance_as_all_triangles_say() {
        for (mesh, reach) in [(hollow(), 9.0), (bumpy(), 13.0)] {
            let shape = CollisionShape::new(&mesh).unwrap();
            let mut rng = CounterRng::new(5, 0, 0);
            let mut inside = 0;
            for _ in 0..600 {
                let point = Vec3::from_fn(|_, _| reach * rng.uniform_in(-1.0, 1.0));
                let distance = brute_force(&shape, &point);
                inside += usize::from(distance == 0.0);
                // Just below and above the distance, where a bound that is not one would show.
                for limit in [
                    0.5 * distance,
                    distance - 1e-9,
                    distance + 1e-9,
                    2.0 * distance + 0.1,
                ] {
                    let expected = distance < limit || distance == 0.0;
                    assert_eq!(
                        shape.is_within(&point, limit),
                        expected,
                        "{point:?}, {distance}, {limit}"
                    );
                }
            }
            assert!((30..500).contains(&inside), "{inside}");
        }
    }

    /// Every disc is at most as far as the triangles in it.
    #[test]
    fn no_disc_is_farther_than_its_triangles() {
        let mesh = bumpy();
        let shape = CollisionShape::new(&mesh).unwrap();
        let mut rng = CounterRng::new(6, 0, 0);
        for node in &shape.tree.nodes {
            if !node.is_leaf {
                continue;
            }
            let used = node
                .children
                .iter()
                .filter(|child| **child != u32::MAX)
                .count();
            for _ in 0..40 {
                let point = Vec3::from_fn(|_, _| 30.0 * rng.uniform_in(-1.0, 1.0));
                let mut least = f64::INFINITY;
                for lane in 0..used {
                    let triangle = mesh.corners(node.children[lane] as usize);
                    let exact = squared_distance(&triangle, &point).sqrt();
                    assert!((exact - triangle_distance(&triangle, &[point; 3])).abs() < 1e-9);
                    assert!(least_distance(&node.discs.disc(lane), &point) <= exact);
                    least = least.min(exact);
                }
                assert!(least_distance(&node.bound, &point) <= least);
            }
        }
    }
}
