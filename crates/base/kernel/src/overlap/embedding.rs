//! Whether a closed mesh bounds a solid once: its surface does not meet itself, and its shells nest
//! as walls and cavities do.
//!
//! The volume of a mesh counts what lies in two overlapping shells twice, and the parity of a ray
//! counts it as outside. Both are right only for a surface that passes these tests.

use super::disc::Disc;
use super::lanes::separations;
use super::shape::CollisionShape;
use super::traversal::ROUNDING;
use super::tree::DiscTree;
use super::triangle::{Triangle, are_folded, segment_meets_triangle, triangles_intersect};
use crate::{KernelError, Result, TriangleMesh, Vec3};

/// Checks that a mesh bounds a solid once.
///
/// Triangles may share corners and edges, also where two shells touch there; any other contact of
/// two triangles is refused, decided exactly for the coordinates given. A shell inside an odd number
/// of others must be the wall of a cavity, with its triangles turned inwards; every other shell must
/// be turned outwards.
///
/// ```
/// use protomer_kernel::overlap::check_embedding;
/// use protomer_kernel::{TriangleMesh, Vec3};
/// let one = TriangleMesh {
///     vertices: vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()],
///     triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// };
/// assert!(check_embedding(&one).is_ok());
/// let mut two = one.clone();
/// two.vertices.extend(one.vertices.iter().map(|vertex| vertex + Vec3::repeat(0.1)));
/// two.triangles.extend(one.triangles.iter().map(|corners| corners.map(|corner| corner + 4)));
/// assert!(check_embedding(&two).is_err());
/// ```
///
/// # Errors
/// [`KernelError::BadMesh`] as [`TriangleMesh::topology`], and names the triangles that meet or the
/// shell that is turned the wrong way.
pub fn check_embedding(mesh: &TriangleMesh) -> Result<()> {
    let shape = CollisionShape::new(mesh)?;
    if let Some([first, second]) = meeting_triangles(&shape) {
        let [x, y, z] = mesh.corners(first as usize)[0].into();
        return Err(KernelError::BadMesh(format!(
            "its triangles {first} and {second}, near ({x:.3}, {y:.3}, {z:.3}), touch or cross each \
             other, so that its volume is not defined; unite the parts that overlap, or move them \
             apart"
        )));
    }
    check_nesting(&mesh.shells()?)
}

/// A part of the tree.
#[derive(Clone, Copy)]
enum Part {
    Node(u32),
    Triangle(u32),
}

/// The first two triangles found that meet elsewhere than in common corners and edges.
fn meeting_triangles(shape: &CollisionShape) -> Option<[u32; 2]> {
    let (mesh, tree) = (&shape.mesh, &shape.tree);
    // One body at rest: its coordinates reach twice its radius, and there is no offset.
    let rounding = (2.0 * shape.radius * ROUNDING) as f32;
    // The tree against itself; every pair of triangles comes twice, and `first < second` takes one.
    let mut stack = vec![[Part::Node(tree.root()); 2]];
    while let Some(pair) = stack.pop() {
        match pair {
            [Part::Triangle(first), Part::Triangle(second)] => {
                let corners = [first, second].map(|triangle| mesh.corners(triangle as usize));
                if first < second && meet_beyond_common_corners(&corners) {
                    return Some([first, second]);
                }
            }
            [Part::Node(node), other] | [other, Part::Node(node)] => {
                let near = near_children(tree, node, other, mesh, rounding);
                stack.extend(near.into_iter().map(|child| [other, child]));
            }
        }
    }
    None
}

/// The children of a node that are not surely apart from another part.
fn near_children(
    tree: &DiscTree,
    node: u32,
    other: Part,
    mesh: &TriangleMesh,
    rounding: f32,
) -> Vec<Part> {
    let node = &tree.nodes[node as usize];
    let disc = match other {
        Part::Node(other) => tree.nodes[other as usize].bound,
        Part::Triangle(triangle) => Disc::around_triangle(&mesh.corners(triangle as usize)),
    };
    let separations = separations(&disc, &node.discs, rounding);
    let lanes = separations.iter().zip(node.children);
    // Parts with one centre have no line of centres, and no number there.
    let is_near = |separation: f32| separation.is_nan() || separation <= 0.0;
    let near = lanes.filter(|(separation, child)| is_near(**separation) && *child != u32::MAX);
    near.map(|(_, child)| match node.is_leaf {
        true => Part::Triangle(child),
        false => Part::Node(child),
    })
    .collect()
}

/// Whether two triangles have a point in common that lies on no corner or edge which both have.
fn meet_beyond_common_corners([first, second]: &[Triangle; 2]) -> bool {
    let is_common = |corner: &Vec3, other: &Triangle| other.contains(corner);
    let (mut common, mut remainder) = (Vec::new(), Vec::new());
    for corner in first {
        match is_common(corner, second) {
            true => common.push(corner),
            false => remainder.push(corner),
        }
    }
    // Equal coordinates, not equal numbers: shells that touch have vertices of their own.
    let others: Vec<_> = second
        .iter()
        .filter(|corner| !is_common(corner, first))
        .collect();
    match (&common[..], &remainder[..], &others[..]) {
        ([], ..) => triangles_intersect(first, second),
        // Two triangles that meet beyond a common corner do so along a line from it, which leaves
        // the smaller one through the opposite edge.
        ([_], [a, b], [p, q]) => {
            segment_meets_triangle(a, b, second) || segment_meets_triangle(p, q, first)
        }
        // Over a common edge, triangles meet beyond it only if they lie folded onto each other.
        ([from, to], [a], [p]) => are_folded(from, to, a, p),
        // The same triangle, seen from both sides: parts that touch.
        _ => false,
    }
}

/// Whether walls and cavities alternate from outside to inside.
fn check_nesting(shells: &[TriangleMesh]) -> Result<()> {
    // A single shell has nothing to nest in; its orientation was checked with the topology.
    if let [_] = shells {
        return Ok(());
    }
    let mut solids = Vec::with_capacity(shells.len());
    // Turned outwards, as the shape wants it; whether
    // the shell is a wall or a cavity is asked below.
    for shell in shells {
        solids.push(CollisionShape::new(&outward(shell))?);
    }
    for (number, shell) in shells.iter().enumerate() {
        let mut depth = 0;
        for (other, solid) in solids.iter().enumerate() {
            let is_inside = other != number && holds(solid, shell);
            depth += usize::from(is_inside);
        }
        let is_wall = shell.volume_angstrom3() > 0.0;
        // An even depth is outside of all material, where only a wall may begin.
        if is_wall == (depth % 2 == 0) {
            continue;
        }
        let [x, y, z] = shell.vertices[0].into();
        let cause = match is_wall {
            true => {
                "lies inside another and is turned outwards like it, so that its volume counts \
                 twice; reverse the corner order of its triangles to make it a cavity, or leave it \
                 out"
            }
            false => {
                "is turned inwards like the wall of a cavity, but lies in no solid; reverse the \
                 corner order of its triangles"
            }
        };
        return Err(KernelError::BadMesh(format!(
            "its shell {number}, with a vertex at ({x:.3}, {y:.3}, {z:.3}), {cause}"
        )));
    }
    Ok(())
}

/// Whether a shell that has no more than corners and edges in common with a solid lies in it: any
/// vertex that is not common decides.
fn holds(solid: &CollisionShape, shell: &TriangleMesh) -> bool {
    let is_separate = |vertex: &&Vec3| !solid.mesh.vertices.contains(vertex);
    shell
        .vertices
        .iter()
        .find(is_separate)
        .is_some_and(|vertex| solid.contains_point(vertex))
}

/// The shell with its triangles turned outwards.
fn outward(shell: &TriangleMesh) -> TriangleMesh {
    let mut outward = shell.clone();
    if shell.volume_angstrom3() < 0.0 {
        for [_, b, c] in &mut outward.triangles {
            std::mem::swap(b, c);
        }
    }
    outward
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::CounterRng;

    fn cuboid(low: [f64; 3], high: [f64; 3]) -> TriangleMesh {
        TriangleMesh::cuboid(&Vec3::from(low), &Vec3::from(high))
    }

    fn together(parts: &[TriangleMesh]) -> TriangleMesh {
        let mut all = TriangleMesh::default();
        for part in parts {
            let first = all.vertices.len() as u32;
            all.vertices.extend(&part.vertices);
            let shifted = part
                .triangles
                .iter()
                .map(|corners| corners.map(|c| c + first));
            all.triangles.extend(shifted);
        }
        all
    }

    fn reversed(mesh: &TriangleMesh) -> TriangleMesh {
        TriangleMesh {
            triangles: mesh
                .triangles
                .iter()
                .map(|[a, b, c]| [*a, *c, *b])
                .collect(),
            ..mesh.clone()
        }
    }

    fn refusal(parts: &[TriangleMesh]) -> String {
        check_embedding(&together(parts)).unwrap_err().to_string()
    }

    #[test]
    fn overlapping_boxes_are_refused_and_boxes_apart_are_not() {
        let first = cuboid([0.0; 3], [10.0; 3]);
        for (low, high) in [
            ([5.0, 0.0, 0.0], [15.0, 10.0, 10.0]),
            ([5.0; 3], [15.0; 3]),
            ([2.0, 2.0, -5.0], [8.0, 8.0, 15.0]),
            ([10.0, 0.0, 0.0], [20.0, 10.0, 9.0]),
            ([2.0, 2.0, 8.0], [8.0, 8.0, 10.0]),
        ] {
            let message = refusal(&[first.clone(), cuboid(low, high)]);
            assert!(message.contains("touch or cross"), "{message}");
        }
        for (low, high) in [
            ([10.5, 0.0, 0.0], [20.0, 10.0, 10.0]),
            ([10.0; 3], [12.0; 3]),
        ] {
            let parts = together(&[first.clone(), cuboid(low, high)]);
            assert_eq!(check_embedding(&parts), Ok(()));
        }
    }

    #[test]
    fn shells_alternate_from_outside_to_inside() {
        let boxes: Vec<TriangleMesh> = (0..3)
            .map(|number| cuboid([f64::from(number); 3], [10.0 - f64::from(number); 3]))
            .collect();
        let cavity = reversed(&boxes[1]);
        let island = together(&[boxes[0].clone(), cavity.clone(), boxes[2].clone()]);
        assert_eq!(check_embedding(&island), Ok(()));
        let message = refusal(&[boxes[0].clone(), boxes[1].clone()]);
        assert!(message.contains("turned outwards"), "{message}");
        let message = refusal(&[boxes[0].clone(), cavity.clone(), reversed(&boxes[2])]);
        assert!(message.contains("turned inwards"), "{message}");
        let elsewhere = cavity.map_vertices(|vertex| vertex + Vec3::x() * 50.0);
        let message = refusal(&[boxes[0].clone(), elsewhere]);
        assert!(message.contains("in no solid"), "{message}");
    }

    #[test]
    fn a_vertex_pushed_through_the_far_side_is_found() {
        let mut mesh = cuboid([0.0; 3], [10.0; 3]);
        assert_eq!(check_embedding(&mesh), Ok(()));
        mesh.vertices[0] = Vec3::new(12.0, 7.0, 6.0);
        assert!(check_embedding(&mesh).is_err());
    }

    /// Tests all pairs of triangles, without a tree.
    fn meet_somewhere(mesh: &TriangleMesh) -> bool {
        let count = mesh.triangles.len();
        (0..count).any(|second| {
            (0..second).any(|first| {
                meet_beyond_common_corners(&[mesh.corners(first), mesh.corners(second)])
            })
        })
    }

    #[test]
    fn the_tree_finds_what_all_pairs_find() {
        let mut found = [0, 0];
        for number in 0..300 {
            let mut rng = CounterRng::new(7, 0, number);
            let mut parts = Vec::new();
            for _ in 0..6 {
                let rotation = rng.rotation();
                let offset = Vec3::from_fn(|_, _| 9.0 * rng.uniform());
                let part = cuboid([0.0; 3], [1.0, 2.0, 3.0]);
                parts.push(part.map_vertices(|vertex| rotation * vertex + offset));
            }
            let mesh = together(&parts);
            let shape = CollisionShape::new(&mesh).unwrap();
            let meets = meet_somewhere(&mesh);
            assert_eq!(meeting_triangles(&shape).is_some(), meets, "{number}");
            found[usize::from(meets)] += 1;
        }
        assert!(found.iter().all(|count| *count > 20), "{found:?}");
    }
}
