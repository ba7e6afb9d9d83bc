//! Whether a cavity is an enclosed interior.
//!
//! A *cavity* is a void that no probe can leave. Most are holes of a few waters between side
//! chains, but the inside of a closed capsid is one as well, and other bodies may be in there. The
//! criterion: an *enclosed interior* is a cavity into which a ball of a stated radius fits.
//!
//! The ball fits if some point inside the shell is at least its radius R away from the wall. The
//! search halves cubes (branch and bound). With δ the distance from the middle of a cube to the
//! wall and h half of the cube's diagonal, no point of the cube is farther from the wall than
//! δ + h, so the cube is given up if δ + h < R, and also if its middle lies outside and δ > h, for
//! then all of it does. Distances are those to the vertices of the wall, which are at most L/√3
//! larger than those to triangles with edges up to L.

use protomer_kernel::{TriangleMesh, Vec3};
use std::f64::consts::PI;

/// Cubes with a smaller half-edge are not halved, Å.
const RESOLUTION_ANGSTROM: f64 = 0.25;

/// Whether a ball of this radius fits inside a closed shell, whichever way its triangles face.
///
/// ```
/// use protomer_body::surface::{MeshSettings, ball_fits_inside, solvent_excluded_surface};
/// use protomer_kernel::Vec3;
/// let settings = MeshSettings::default();
/// let ball = solvent_excluded_surface(&[Vec3::zeros()], &[5.0], 1.4, &settings)?.mesh;
/// assert!(ball_fits_inside(&ball, 4.5) && !ball_fits_inside(&ball, 5.5));
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
pub fn ball_fits_inside(shell: &TriangleMesh, radius_angstrom: f64) -> bool {
    let ball = 4.0 / 3.0 * PI * radius_angstrom.powi(3);
    // The cheapest test: most cavities have less volume than the ball.
    // False for a radius that is infinite or not a number.
    let has_volume = ball <= shell.volume_angstrom3().abs();
    if !has_volume {
        return false;
    }
    let search = Search {
        shell,
        radius_angstrom,
        margin_angstrom: longest_edge(shell) / 3_f64.sqrt(),
    };
    let (low, high) = bounds(&shell.vertices);
    let cube = Cube {
        middle: 0.5 * (low + high),
        half_edge: 0.5 * (high - low).amax(),
    };
    search.finds_room(&cube, &shell.vertices, None)
}

struct Search<'a> {
    shell: &'a TriangleMesh,
    radius_angstrom: f64,
    /// Largest excess of a distance to the vertices over that to the triangles, Å.
    margin_angstrom: f64,
}

#[derive(Clone, Copy)]
struct Cube {
    middle: Vec3,
    half_edge: f64,
}

/// The middle of a cube, a lower bound of its distance from the wall, and the side on which it
/// lies.
#[derive(Clone, Copy)]
struct Known {
    place: Vec3,
    clearance: f64,
    is_inside: bool,
}

impl Search<'_> {
    /// Whether the cube holds a point inside the shell that is far enough from the wall. `vertices`
    /// has every vertex that is nearest to a point of the cube; `parent` is what is known of the
    /// cube that this one is an eighth of.
    fn finds_room(&self, cube: &Cube, vertices: &[Vec3], parent: Option<Known>) -> bool {
        let half_diagonal = 3_f64.sqrt() * cube.half_edge;
        let distance = distance_to(&cube.middle, vertices);
        // Even the point of the cube that is farthest from the wall is too near.
        if distance + half_diagonal < self.radius_angstrom {
            return false;
        }
        let sample = Known {
            place: cube.middle,
            clearance: distance - self.margin_angstrom,
            is_inside: self.is_inside(&cube.middle, parent),
        };
        if sample.is_inside && distance >= self.radius_angstrom {
            return true;
        }
        // All of the cube is outside: the wall is farther away than its corners.
        if !sample.is_inside && sample.clearance > half_diagonal {
            return false;
        }
        if cube.half_edge < RESOLUTION_ANGSTROM {
            return false;
        }
        let mut near = Vec::new();
        for vertex in vertices {
            // The nearest vertex of a point in the cube is within
            // δ + h of it, so within δ + 2 h of the middle.
            if (vertex - cube.middle).norm() <= distance + 2.0 * half_diagonal {
                near.push(*vertex);
            }
        }
        (0..8).any(|octant| self.finds_room(&cube.octant(octant), &near, Some(sample)))
    }

    /// Whether a place lies inside the wall. It lies on the same side as the middle of the parent
    /// cube if the wall is farther from that middle than the place is.
    fn is_inside(&self, place: &Vec3, parent: Option<Known>) -> bool {
        match parent {
            // A winding number visits all triangles; this spares it for nearly all cubes.
            Some(sample) if (place - sample.place).norm() < sample.clearance => sample.is_inside,
            _ => winding_number(self.shell, place).abs() > 0.5,
        }
    }
}

impl Cube {
    fn octant(&self, octant: usize) -> Cube {
        let half_edge = 0.5 * self.half_edge;
        let side = |axis: usize| if octant >> axis & 1 == 1 { 1.0 } else { -1.0 };
        Cube {
            middle: self.middle + half_edge * Vec3::new(side(0), side(1), side(2)),
            half_edge,
        }
    }
}

fn distance_to(place: &Vec3, vertices: &[Vec3]) -> f64 {
    let mut least = f64::INFINITY;
    for vertex in vertices {
        least = (vertex - place).norm_squared().min(least);
    }
    least.sqrt()
}

fn longest_edge(mesh: &TriangleMesh) -> f64 {
    let mut longest = 0.0_f64;
    for triangle in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(triangle);
        for edge in [b - a, c - b, a - c] {
            longest = longest.max(edge.norm());
        }
    }
    longest
}

fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    let mut low = Vec3::repeat(f64::INFINITY);
    let mut high = Vec3::repeat(f64::NEG_INFINITY);
    for point in points {
        (low, high) = (low.inf(point), high.sup(point));
    }
    (low, high)
}

/// Winding number of a closed surface about a place: the solid angles of its triangles over 4π,
/// each by tan(Ω/2) = a·(b×c) / (abc + (a·b)c + (b·c)a + (c·a)b) (van Oosterom and Strackee, IEEE
/// Trans. Biomed. Eng. 30, 125 (1983)).
fn winding_number(mesh: &TriangleMesh, place: &Vec3) -> f64 {
    let mut solid_angle = 0.0;
    for triangle in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(triangle).map(|corner| corner - place);
        let [x, y, z] = [a, b, c].map(|arm| arm.norm());
        let numerator = a.dot(&b.cross(&c));
        let denominator = x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y;
        solid_angle += 2.0 * numerator.atan2(denominator);
    }
    solid_angle / (4.0 * PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of these half-edges with a grid of vertices on its faces, turned by an angle.
    fn cuboid(half_edges: [f64; 3], angle: f64) -> TriangleMesh {
        const STEPS: usize = 24;
        let mut mesh = TriangleMesh::default();
        for face in 0..6 {
            let (axis, side) = (face % 3, if face < 3 { 1.0 } else { -1.0 });
            let first = mesh.vertices.len() as u32;
            for i in 0..=STEPS {
                for j in 0..=STEPS {
                    let mut place = Vec3::zeros();
                    place[axis] = side * half_edges[axis];
                    for (k, step) in [(1, i), (2, j)] {
                        let other = (axis + k) % 3;
                        place[other] = half_edges[other] * (2.0 * step as f64 / STEPS as f64 - 1.0);
                    }
                    let turn = protomer_kernel::Rotation::new(Vec3::new(0.3, 1.0, -0.4) * angle);
                    mesh.vertices
                        .push(turn * place + Vec3::new(40.0, -7.0, 3.0));
                }
            }
            let row = STEPS as u32 + 1;
            for i in 0..STEPS as u32 {
                for j in 0..STEPS as u32 {
                    let a = first + i * row + j;
                    let [b, c, d] = [a + row, a + row + 1, a + 1];
                    if side > 0.0 {
                        mesh.triangles.extend([[a, b, c], [a, c, d]]);
                    } else {
                        mesh.triangles.extend([[a, c, b], [a, d, c]]);
                    }
                }
            }
        }
        mesh
    }

    #[test]
    fn the_ball_in_a_box_is_as_large_as_its_shortest_edge() {
        for angle in [0.0, 0.7] {
            let slab = cuboid([14.0, 9.0, 20.0], angle);
            assert!(ball_fits_inside(&slab, 8.8), "{angle}");
            assert!(!ball_fits_inside(&slab, 9.3), "{angle}");
            // It has the volume for this ball, but not the width.
            assert!(!ball_fits_inside(&slab, 12.0), "{angle}");
        }
    }

    #[test]
    fn the_way_the_triangles_face_does_not_matter() {
        let mut wall = cuboid([9.0, 9.0, 9.0], 0.2);
        wall.triangles
            .iter_mut()
            .for_each(|triangle| triangle.reverse());
        assert!(wall.volume_angstrom3() < 0.0);
        assert!(ball_fits_inside(&wall, 8.8) && !ball_fits_inside(&wall, 9.3));
    }

    #[test]
    fn radii_that_are_not_finite_fit_nowhere() {
        let wall = cuboid([9.0, 9.0, 9.0], 0.0);
        assert!(!ball_fits_inside(&wall, f64::INFINITY) && !ball_fits_inside(&wall, f64::NAN));
    }

    /// The largest ball in an L of two 8 x 8 bars touches the two outer walls and the inner edge:
    /// with the corner at (8, 8) its centre (r, r) is √2 (8 - r) from the edge, so r = 8 √2 / (1 +
    /// √2) = 4.69, more than half of the width.
    #[test]
    fn the_ball_in_a_bent_channel_may_use_the_corner() {
        let mut shell = TriangleMesh::default();
        // The L lies in the xy plane, drawn by its outline and extruded from z = -10 to 10.
        let outline = [
            [0.0, 0.0],
            [24.0, 0.0],
            [24.0, 8.0],
            [8.0, 8.0],
            [8.0, 24.0],
            [0.0, 24.0],
        ];
        let steps = 40;
        let mut quad = |corners: [Vec3; 4]| {
            let first = shell.vertices.len() as u32;
            for i in 0..=steps {
                for j in 0..=steps {
                    let (s, t) = (
                        f64::from(i) / f64::from(steps),
                        f64::from(j) / f64::from(steps),
                    );
                    let below = corners[0] * (1.0 - s) + corners[1] * s;
                    let above = corners[3] * (1.0 - s) + corners[2] * s;
                    shell.vertices.push(below * (1.0 - t) + above * t);
                }
            }
            let row = steps + 1;
            for i in 0..steps {
                for j in 0..steps {
                    let a = first + i * row + j;
                    let [b, c, d] = [a + row, a + row + 1, a + 1];
                    shell.triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        };
        for (k, from) in outline.iter().enumerate() {
            let to = outline[(k + 1) % outline.len()];
            let point = |[x, y]: [f64; 2], z: f64| Vec3::new(x, y, z);
            quad([
                point(*from, -10.0),
                point(to, -10.0),
                point(to, 10.0),
                point(*from, 10.0),
            ]);
        }
        for (z, is_top) in [(10.0, true), (-10.0, false)] {
            for [x, y, u, v] in [[0.0, 0.0, 24.0, 8.0], [0.0, 8.0, 8.0, 24.0]] {
                let corners = [[x, y], [u, y], [u, v], [x, v]].map(|[x, y]| Vec3::new(x, y, z));
                let [a, b, c, d] = corners;
                quad(if is_top { [a, b, c, d] } else { [a, d, c, b] });
            }
        }
        assert!((shell.volume_angstrom3() - 20.0 * 320.0).abs() < 1e-6);
        assert!(ball_fits_inside(&shell, 4.55) && !ball_fits_inside(&shell, 4.95));
    }
}
