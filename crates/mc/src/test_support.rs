//! What the unit tests of several modules need.

use protomer_kernel::{TriangleMesh, Vec3};

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
