//! The first mesh of a solid: dual marching cubes on a sparse cubic lattice, with simple parts of
//! the surface merged.
//!
//! ```text
//! cover --lattice--> signs at the nodes near the surface --cycles, dual--> quadrangles --coarsen, polygons--> triangles
//! ```
//!
//! Every node is inside (value < 0) or outside (value >= 0). In every cell the sheets separate the
//! inside corners from the outside corners; those of neighbouring cells meet in whole edges, so
//! they tile a closed 2-manifold for *any* function. Only what is thinner than the lattice is lost:
//! a gap, wall or handle narrower than about the spacing may be closed, opened or cut. The mesh is
//! dual to that tiling, after tiles have been merged into larger disks: it has the same topology
//! with a fraction of the vertices.

mod coarsen;
mod cube;
mod cycles;
mod dual;
mod lattice;
mod polygons;

use super::frame::Frame;
use super::implicit::ImplicitSolid;
use crate::Result;
use protomer_kernel::TriangleMesh;

/// The surface of `solid` on a lattice of cubes of edge `spacing_angstrom`, placed in `frame`, with
/// vertices about `edge_angstrom` apart where that keeps the topology; they lie on the surface to
/// about a tenth of that.
///
/// # Errors
/// [`crate::BodyError::Invalid`] if the solid needs more lattice blocks than there is room for.
pub fn extract(
    solid: &dyn ImplicitSolid,
    frame: &Frame,
    spacing_angstrom: f64,
    edge_angstrom: f64,
) -> Result<TriangleMesh> {
    let lattice = lattice::SparseLattice::around(solid, frame, spacing_angstrom)?;
    // In cells; plain cubes have two along an edge.
    let width = 2.0
        * (0.5 * edge_angstrom / spacing_angstrom)
            .round()
            .clamp(1.0, 8.0);
    let dual = dual::quadrangles(&lattice);
    Ok(polygons::triangulate(&lattice, &dual, width as i32))
}
