//! The first mesh of a solid: marching tetrahedra on a sparse body-centred cubic lattice.
//!
//! ```text
//! cover --lattice--> blocks near the surface, signs at their nodes --tetrahedra--> triangles
//! ```
//!
//! Every node is inside (value < 0) or outside (value >= 0); every tetrahedron holds at most one sheet, which separates
//! its inside corners from its outside corners. The sheets of neighbouring tetrahedra meet in whole edges, so the mesh is
//! closed, 2-manifold and free of self-intersections for *any* function; only what is thinner than the lattice is lost:
//! a gap, wall or handle narrower than about the spacing may be closed, opened or cut.

mod lattice;
mod tetrahedra;

use super::frame::Frame;
use super::implicit::ImplicitSolid;
use crate::Result;
use protomer_kernel::TriangleMesh;

/// The surface of `solid` on a lattice of cubes of edge `spacing_angstrom`, placed in `frame`; vertices lie on the
/// surface to about a tenth of the spacing.
///
/// # Errors
/// [`crate::BodyError::Invalid`] if the solid has no surface that the lattice can see, or needs more lattice blocks than
/// there is room for.
pub fn extract(solid: &dyn ImplicitSolid, frame: &Frame, spacing_angstrom: f64) -> Result<TriangleMesh> {
    let lattice = lattice::SparseLattice::around(solid, frame, spacing_angstrom)?;
    Ok(tetrahedra::march(solid, &lattice))
}
