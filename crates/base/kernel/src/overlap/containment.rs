//! Which points lie inside a solid.
//!
//! Where the surfaces of two bodies have no point in common, every shell of one lies wholly inside
//! or wholly outside the other, so one corner of each shell decides whether the solids overlap.

use super::disc::Disc;
use super::tree::DiscTree;
use super::triangle::{Triangle, orientation};
use crate::{Result, TriangleMesh, Vec3};

/// The extreme corners of one shell along the coordinate axes: any of them decides for all, so the
/// one that is decided first counts.
#[derive(Debug, Clone)]
pub(super) struct Shell {
    pub corners: Vec<Vec3>,
}

impl Shell {
    /// The shells of a closed mesh.
    pub fn of_mesh(mesh: &TriangleMesh) -> Result<Vec<Shell>> {
        Ok(mesh.shells()?.iter().map(Shell::new).collect())
    }

    fn new(mesh: &TriangleMesh) -> Self {
        // Extreme corners: the most likely ones to lie outside
        // the other's sphere, which costs nothing to ask.
        let mut corners = Vec::with_capacity(6);
        for axis in 0..3 {
            let ascending = |p: &&Vec3, q: &&Vec3| p[axis].total_cmp(&q[axis]);
            corners.extend(mesh.vertices.iter().max_by(ascending));
            corners.extend(mesh.vertices.iter().min_by(ascending));
        }
        Self { corners }
    }
}

/// Whether a point lies in the closed solid bounded by a mesh: a ray from a point inside leaves it
/// through an odd number of triangles. All signs are exact; a ray that meets an edge or a corner is
/// replaced by another.
pub(super) fn solid_contains(
    mesh: &TriangleMesh,
    tree: &DiscTree,
    radius: f64,
    point: &Vec3,
) -> bool {
    const ATTEMPTS: usize = 64;
    // Beyond the far side of the body from any point that passed the test of its sphere.
    let reach = 4.0 * radius + point.norm();
    // The first direction nearly always decides; points on axes of symmetric meshes need a few.
    for attempt in 0..ATTEMPTS {
        let far = point + direction(attempt) * reach;
        if let Some(is_inside) = ray_parity(mesh, tree, point, &far) {
            return is_inside;
        }
    }
    false
}

/// Directions spread over the sphere by the golden angle, none along a coordinate axis.
fn direction(attempt: usize) -> Vec3 {
    const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;
    const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
    let z = ((attempt as f64 + 0.382) * GOLDEN_RATIO).fract() * 1.9 - 0.95;
    let (sine, cosine) = (GOLDEN_ANGLE * (attempt as f64 + 0.3)).sin_cos();
    let axis_distance = (1.0 - z * z).sqrt();
    Vec3::new(axis_distance * cosine, axis_distance * sine, z)
}

/// Whether the ray leaves the solid an odd number of times; `None` if it meets an edge or a corner.
fn ray_parity(mesh: &TriangleMesh, tree: &DiscTree, from: &Vec3, to: &Vec3) -> Option<bool> {
    let mut inside = false;
    let mut stack = vec![tree.root()];
    while let Some(node) = stack.pop() {
        let node = &tree.nodes[node as usize];
        for (lane, &child) in node.children.iter().enumerate() {
            // The sphere around the disc, not the disc
            // itself: a ray test is rare, and simple is safe.
            if !ray_comes_near(&node.discs.disc(lane), from, to) {
                continue;
            }
            if !node.is_leaf {
                stack.push(child);
                continue;
            }
            match crossing(&mesh.corners(child as usize), from, to) {
                // Parity, not a count of signs: it is right for walls and cavities alike.
                Crossing::None => {}
                Crossing::Proper => inside = !inside,
                // A start on the surface is inside: the solid is closed.
                Crossing::AtStart => return Some(true),
                Crossing::Degenerate => return None,
            }
        }
    }
    Some(inside)
}

/// Ways in which a segment can meet a triangle.
enum Crossing {
    None,
    Proper,
    AtStart,
    Degenerate,
}

fn crossing([a, b, c]: &Triangle, from: &Vec3, to: &Vec3) -> Crossing {
    let turns = [
        orientation(from, to, a, b),
        orientation(from, to, b, c),
        orientation(from, to, c, a),
    ];
    if turns.contains(&1) && turns.contains(&-1) {
        return Crossing::None;
    }
    match (orientation(a, b, c, from), orientation(a, b, c, to)) {
        // The ray runs in the plane of the triangle; another direction decides.
        (0, 0) => Crossing::Degenerate,
        // The start lies in the plane, and the turns above say that it lies within the triangle.
        (0, _) => Crossing::AtStart,
        (near, far) if near == far => Crossing::None,
        // Through an edge or corner: two triangles would count it, or one, or none.
        _ if turns.contains(&0) => Crossing::Degenerate,
        _ => Crossing::Proper,
    }
}

/// Whether a segment meets the sphere around a disc, with room for rounding; never for an unused
/// lane.
fn ray_comes_near(disc: &Disc, from: &Vec3, to: &Vec3) -> bool {
    const ROUNDING: f64 = 1e-6;
    let segment = to - from;
    let offset = Vec3::from(disc.centre.map(f64::from)) - from;
    let nearest = segment * (offset.dot(&segment) / segment.norm_squared()).clamp(0.0, 1.0);
    let (across, along) = (f64::from(disc.radius), f64::from(disc.half_thickness));
    let radius = (across * across + along * along).sqrt() * (1.0 + ROUNDING);
    // Unused lanes have a negative radius, whose square would be large.
    disc.radius >= 0.0 && (offset - nearest).norm() <= radius + ROUNDING * offset.norm()
}
