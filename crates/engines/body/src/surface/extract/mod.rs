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

/// The mean area of the tile of a plain cube, in units of the squared edge of the cube: a plane with
/// unit normal n crosses |n_x| + |n_y| + |n_z| cubes per unit of area, 3/2 on average over all directions.
const TILE_AREA: f64 = 2.0 / 3.0;

/// Edge lengths of the first mesh.
pub struct FirstEdges {
    /// Area from which a shell counts as large, Å².
    pub large_shell_angstrom2: f64,
    /// Approximate length of edges in large shells, Å.
    pub in_large_shells_angstrom: f64,
    /// Approximate length of edges in all other shells, Å.
    pub in_small_shells_angstrom: f64,
}

/// The surface of `solid` on a lattice of cubes of edge `spacing_angstrom`, placed in `frame`, with
/// vertices as far apart as `edges` says where that keeps the topology; they lie on the surface to
/// about a tenth of that.
///
/// # Errors
/// [`crate::BodyError::Invalid`] if the solid needs more lattice blocks than there is room for.
pub fn extract(
    solid: &dyn ImplicitSolid,
    frame: &Frame,
    spacing_angstrom: f64,
    edges: &FirstEdges,
) -> Result<TriangleMesh> {
    let lattice = lattice::SparseLattice::around(solid, frame, spacing_angstrom)?;
    let dual = dual::quadrangles(&lattice);
    let tile_angstrom2 = TILE_AREA * (2.0 * spacing_angstrom).powi(2);
    let widths = coarsen::Widths {
        of_large_shells: width(edges.in_large_shells_angstrom / spacing_angstrom),
        of_small_shells: width(edges.in_small_shells_angstrom / spacing_angstrom),
        tiles_of_large_shells: (edges.large_shell_angstrom2 / tile_angstrom2) as usize,
    };
    Ok(polygons::triangulate(&lattice, &dual, &widths))
}

/// The width of patches with edges of this length, both in cells; plain cubes have two along an edge.
fn width(edge: f64) -> i32 {
    2 * (0.5 * edge).round().clamp(1.0, 8.0) as i32
}
