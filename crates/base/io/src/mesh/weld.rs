//! Corners at one place made one vertex.
//!
//! STL has no vertices, and other programs write a vertex per corner where normals or colours differ.
//! Either way the triangles around a place share nothing but their coordinates.

use protomer_kernel::{TriangleMesh, Vec3};
use std::collections::{HashMap, HashSet};

/// The mesh, its vertices at exactly the same place made one if it is open without that. A mesh that
/// is closed as it stands is left alone: vertices at one place may be where two parts touch.
pub(super) fn closed(mesh: TriangleMesh) -> TriangleMesh {
    match is_closed(&mesh) || has_one_vertex_per_place(&mesh) {
        true => mesh,
        false => welded(&mesh),
    }
}

fn has_one_vertex_per_place(mesh: &TriangleMesh) -> bool {
    let mut taken = HashSet::with_capacity(mesh.vertices.len());
    mesh.vertices
        .iter()
        .all(|vertex| taken.insert(place(vertex)))
}

/// Whether each edge of each triangle has a triangle on its other side.
fn is_closed(mesh: &TriangleMesh) -> bool {
    let edges = |[a, b, c]: &[u32; 3]| [(*a, *b), (*b, *c), (*c, *a)];
    let all: HashSet<(u32, u32)> = mesh.triangles.iter().flat_map(edges).collect();
    // In a closed surface every edge is run through once in each direction.
    all.iter().all(|(from, to)| all.contains(&(*to, *from)))
}

/// The mesh with one vertex per place, in the order of their first use, and without triangles that
/// have lost their area by that.
pub(super) fn welded(mesh: &TriangleMesh) -> TriangleMesh {
    let mut welded = TriangleMesh::default();
    let mut vertex_at: HashMap<[u64; 3], u32> = HashMap::new();
    for corners in &mesh.triangles {
        let corners = corners.map(|corner| {
            let position = mesh.vertices[corner as usize];
            // Bits, not a distance: a tolerance would join what is apart on purpose.
            *vertex_at.entry(place(&position)).or_insert_with(|| {
                welded.vertices.push(position);
                welded.vertices.len() as u32 - 1
            })
        });
        let [a, b, c] = corners;
        // Two corners at one place: an edge is left, which its neighbours share.
        if a != b && b != c && c != a {
            welded.triangles.push(corners);
        }
    }
    welded
}

/// A key for the place. Adding zero turns -0 into 0, which is the same place.
fn place(position: &Vec3) -> [u64; 3] {
    [position.x, position.y, position.z].map(|coordinate| (coordinate + 0.0).to_bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vertex_per_corner_becomes_a_vertex_per_place() {
        let places = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let corners = faces
            .as_flattened()
            .iter()
            .map(|corner: &usize| places[*corner]);
        let split = TriangleMesh {
            vertices: corners.collect(),
            triangles: (0..4)
                .map(|face| [3 * face, 3 * face + 1, 3 * face + 2])
                .collect(),
        };
        let mesh = closed(split);
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (4, 4));
        assert!((mesh.volume_angstrom3() - 1.0 / 6.0).abs() < 1e-15);
    }

    #[test]
    fn parts_that_touch_in_a_corner_stay_apart() {
        let places = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let mirrored = faces.map(|[a, b, c]| [a + 4, b + 4, c + 4]);
        let mesh = TriangleMesh {
            // Turned half about z and half about x: a rotation, so the faces stay outward.
            vertices: [places, places.map(|v| Vec3::new(-v.x, -v.y, v.z))].concat(),
            triangles: [faces, mirrored].concat(),
        };
        assert_eq!(closed(mesh.clone()), mesh);
    }
}
