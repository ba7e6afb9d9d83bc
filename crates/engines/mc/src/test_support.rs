//! What the unit tests of several modules need.

use protomer_kernel::{TriangleMesh, Vec3};

/// A regular octahedron about the origin with corners on the axes, Å.
pub(crate) fn octahedron(reach_angstrom: f64) -> TriangleMesh {
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()].map(|axis| reach_angstrom * axis);
    TriangleMesh {
        vertices: axes.iter().flat_map(|corner| [*corner, -corner]).collect(),
        triangles: vec![
            [0, 2, 4],
            [2, 1, 4],
            [1, 3, 4],
            [3, 0, 4],
            [2, 0, 5],
            [1, 2, 5],
            [3, 1, 5],
            [0, 3, 5],
        ],
    }
}

/// A regular tetrahedron about the origin with corners (±size, ±size, ±size), Å.
pub(crate) fn tetrahedron(size_angstrom: f64) -> TriangleMesh {
    let corners = [
        [1.0, 1.0, 1.0],
        [1.0, -1.0, -1.0],
        [-1.0, 1.0, -1.0],
        [-1.0, -1.0, 1.0],
    ];
    TriangleMesh {
        vertices: corners
            .map(|corner| size_angstrom * Vec3::from(corner))
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
    }
}
