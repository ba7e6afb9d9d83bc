//! What the unit tests of several modules need.

use protomer_kernel::TriangleMesh;

/// A regular octahedron about the origin with corners on the axes, Å.
pub(crate) fn octahedron(reach_angstrom: f64) -> TriangleMesh {
    TriangleMesh::octahedron(reach_angstrom)
}

/// A regular tetrahedron about the origin with corners (±size, ±size, ±size), Å.
pub(crate) fn tetrahedron(size_angstrom: f64) -> TriangleMesh {
    TriangleMesh::tetrahedron(size_angstrom)
}
