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

/// Density from which edges count as short: 1 Å or less, shorter than the radius of an atom or a
/// probe.
pub(super) const SHORT_EDGES_PER_ANGSTROM2: f64 = 1.0;
/// Relaxations of vertices in each round of relax, split, collapse and flip, and after the last.
struct Relaxations {
    rounds: &'static [Onto],
    afterwards: Onto,
}

const WITH_LONG_EDGES: Relaxations = Relaxations {
    rounds: &[Onto::About; 3],
    afterwards: Onto::About,
};
/// Relaxations for short edges: a vertex left in the plane of its neighbours strays little from the
/// surface, and the next relaxation pulls it back. A third round changes neither the distance from
/// the surface nor the shape of the triangles by more than 2 %.
const WITH_SHORT_EDGES: Relaxations = Relaxations {
    rounds: &[Onto::PlaneWhereFlat, Onto::About],
    afterwards: Onto::PlaneWhereFlat,
};

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
    let relaxations = if density_per_angstrom2 < SHORT_EDGES_PER_ANGSTROM2 {
        WITH_LONG_EDGES
    } else {
        WITH_SHORT_EDGES
    };
    for onto in relaxations.rounds {
        remesher.relax(*onto);
        remesher.grade_lengths();
        remesher.adjust_lengths();
        remesher.split_long_edges();
        remesher.collapse_short_edges();
        remesher.flip_towards_six();
    }
    remesher.relax(relaxations.afterwards);
    remesher.flip_towards_equal_angles();
    remesher.relax(Onto::Exactly);
    remesher.remove_slivers();
    Ok(remesher.into_mesh())
}
