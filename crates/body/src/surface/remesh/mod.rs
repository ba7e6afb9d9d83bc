//! Isotropic remeshing: triangles of nearly equal, nearly equilateral shape at a requested density.
//!
//! Rounds of splitting long edges, collapsing short ones, flipping towards six neighbours per
//! vertex, and relaxing vertices along the surface (Botsch and Kobbelt, Symp. Geometry Processing
//! 2004, 185), each a local operation that keeps the topology: no shell is lost, no handle closed.

mod half_edge;
mod operations;
mod sizing;

pub(crate) use half_edge::HalfEdgeMesh;

use super::implicit::ImplicitSolid;
use crate::Result;
use operations::{Onto, Remesher};
use protomer_kernel::TriangleMesh;

/// From this density on, edges are short: 1 Å or less, shorter than the radius of an atom or a probe.
pub(super) const SHORT_EDGES_PER_ANGSTROM2: f64 = 1.0;
/// Rounds of relax, split, collapse and flip.
const ROUNDS: [Onto; 3] = [Onto::About; 3];
/// With short edges, a vertex left in the plane of its neighbours strays little from the surface, and
/// the next round pulls it back.
const ROUNDS_WITH_SHORT_EDGES: [Onto; 3] =
    [Onto::PlaneWhereFlat, Onto::About, Onto::PlaneWhereFlat];

/// The same surface at `density_per_angstrom2` vertices per Å², with at least `fewest_vertices` on
/// every shell.
///
/// # Errors
/// [`crate::BodyError::Invalid`] if `mesh` is not closed.
pub(crate) fn remesh(
    mesh: TriangleMesh,
    solid: &dyn ImplicitSolid,
    density_per_angstrom2: f64,
    fewest_vertices: usize,
) -> Result<HalfEdgeMesh> {
    let start = |mesh| Remesher::new(mesh, solid, density_per_angstrom2, fewest_vertices);
    let mut coarse = start(HalfEdgeMesh::new(mesh)?);
    coarse.collapse_short_edges();
    // Where the first mesh is finer than the last, few vertices are left: renumber them.
    let mut remesher = start(coarse.into_mesh().compacted());
    let rounds = if density_per_angstrom2 < SHORT_EDGES_PER_ANGSTROM2 {
        ROUNDS
    } else {
        ROUNDS_WITH_SHORT_EDGES
    };
    for onto in rounds {
        remesher.relax(onto);
        remesher.grade_lengths();
        remesher.adjust_lengths();
        remesher.split_long_edges();
        remesher.collapse_short_edges();
        remesher.flip_towards_six();
    }
    remesher.relax(Onto::About);
    remesher.flip_towards_equal_angles();
    remesher.relax(Onto::Exactly);
    remesher.remove_slivers();
    Ok(remesher.into_mesh())
}
