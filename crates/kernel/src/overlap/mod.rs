//! Overlap of two rigid bodies bounded by closed, nonconvex triangle meshes.
//!
//! Two bodies overlap if their surfaces have a point in common or one solid lies inside the other.
//! Solids are closed sets: bodies that touch overlap. [`overlaps`] answers this exactly for the
//! corner positions in double precision.
//!
//! | module | one idea |
//! |---|---|
//! | `disc` | a flat cylinder around a patch of surface |
//! | `lanes` | lower bounds on the distance of one disc from eight others |
//! | `tree` | eight-way tree of discs over the triangles of a body |
//! | `traversal` | simultaneous descent of two trees: what discs cannot separate, triangles decide |
//! | `triangle`, `triangle_distance` | exact intersection of two triangles; how far they are apart |
//! | `containment` | which shells lie inside the other solid, where the surfaces do not meet |
//! | `carried_bound` | what is left of a separation after the bodies have moved |
//!
//! # Why it is built like this
//!
//! In hard-particle Monte Carlo of an assembly nearly all the time goes into pairs whose surfaces
//! are 0.05-2 Å apart over a contact patch. There
//! * the bounding volume must be thin along the surface normal: spheres as large as the gap are far
//!   too many. A disc needs eight numbers, is turned by turning two vectors, and three axes (both
//!   normals, the line of the centres) separate two of them with a few dozen operations and no
//!   stored matrix. Without the third axis a third more pairs survive;
//! * one rotation matrix per pair of bodies, in `f32`, with an allowance for every rounding. A disc
//!   test can only say "provably apart"; what it leaves goes to predicates with exact signs. The
//!   answer is that of brute force, always;
//! * roots and quotients would fill the divider, so they are replaced by one-sided approximations
//!   within 0.2 %;
//! * latency and mispredicted branches cost more than arithmetic. A child of one node is first held
//!   against the other node whole (two of eight remain), several pairs of nodes are in flight
//!   together, and nothing is sorted;
//! * a bound as good as the true distance costs several times the decision. [`separation_bound`]
//!   looks only into pairs nearer than a quarter of the least separation met so far, and takes the
//!   least of all it has skipped: nearly free, and [`CarriedBound`] spends it on the trials to
//!   come. Nearer than about 0.1 Å only the decision is made: a bound that a single step outruns is
//!   worth nothing.
//!
//! Distance fields were considered and left out: a value is exact only to the size of a cell, so
//! near contact, where the time goes, they decide nothing. So were lists of near triangles kept
//! from trial to trial: a rotation of 0.04 rad moves a far point of a body by 1 Å, and lists with
//! so much room are rebuilt every few trials at the cost of several queries.

mod carried_bound;
mod containment;
mod disc;
mod lanes;
mod traversal;
mod tree;
mod triangle;
mod triangle_distance;

use crate::pose::RelativePose;
use crate::{KernelError, Result, TriangleMesh, Vec3};
pub use carried_bound::CarriedBound;
use containment::{Shell, solid_contains};
use traversal::{SurfaceRelation, relate_surfaces};
use tree::DiscTree;

/// A hard body prepared for overlap tests; immutable, to be shared.
#[derive(Debug, Clone)]
pub struct CollisionShape {
    mesh: TriangleMesh,
    tree: DiscTree,
    shells: Vec<Shell>,
    radius: f64,
}

impl CollisionShape {
    /// Prepares a body.
    ///
    /// # Errors
    /// [`KernelError::BadMesh`] unless the mesh is closed, 2-manifold and outward-oriented, with at
    /// least one triangle.
    pub fn new(mesh: &TriangleMesh) -> Result<Self> {
        mesh.topology()?;
        if mesh.triangles.is_empty() {
            return Err(KernelError::BadMesh("it has no triangles".into()));
        }
        Ok(Self {
            tree: DiscTree::new(mesh),
            shells: Shell::of_mesh(mesh)?,
            radius: mesh.radius_about_origin_angstrom(),
            mesh: mesh.clone(),
        })
    }

    /// Radius of the smallest sphere about the body's origin that holds it, Å.
    pub fn bounding_radius_angstrom(&self) -> f64 {
        self.radius
    }

    /// The surface.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// Memory held, bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of::<Self>()
            + size_of_val(self.mesh.vertices.as_slice())
            + size_of_val(self.mesh.triangles.as_slice())
            + size_of_val(self.tree.nodes.as_slice())
    }

    /// Whether a point (Å, in the body's frame) lies in the solid or on its surface.
    pub fn contains_point(&self, point: &Vec3) -> bool {
        point.norm() <= self.radius && solid_contains(&self.mesh, &self.tree, self.radius, point)
    }
}

/// Whether two bodies overlap: their surfaces have a point in common or one solid lies inside the
/// other. Touching is overlap: the solids are closed sets. A body inside a cavity of another does
/// not overlap it.
///
/// ```
/// use protomer_kernel::{CollisionShape, Pose, RelativePose, TriangleMesh, Vec3, overlap::overlaps};
/// let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
/// let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// let shape = CollisionShape::new(&TriangleMesh { vertices, triangles })?;
/// let beside = |x: f64| {
///     let second = Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::identity() };
///     RelativePose::new(&Pose::identity(), &second, &second.position)
/// };
/// assert!(overlaps(&shape, &shape, &beside(0.5)));
/// assert!(!overlaps(&shape, &shape, &beside(1.5)));
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
pub fn overlaps(
    first: &CollisionShape,
    second: &CollisionShape,
    second_in_first: &RelativePose,
) -> bool {
    separation_bound(first, second, second_in_first, 0.0).is_none()
}

/// A lower bound on the separation of two bodies, Å, at most `ceiling_angstrom`; `None` if they
/// overlap, exactly as [`overlaps`] decides.
///
/// The bound never exceeds the true [`distance`]. It is what can be had for little more than the
/// decision; a ceiling of a few times the longest trial step is a good choice.
pub fn separation_bound(
    first: &CollisionShape,
    second: &CollisionShape,
    second_in_first: &RelativePose,
    ceiling_angstrom: f64,
) -> Option<f64> {
    let between_spheres = second_in_first.translation.norm() - first.radius - second.radius;
    if between_spheres > ceiling_angstrom.max(1e-9 * (first.radius + second.radius)) {
        return Some(ceiling_angstrom);
    }
    match relate_surfaces(first, second, second_in_first, ceiling_angstrom) {
        SurfaceRelation::Intersecting => None,
        SurfaceRelation::Apart(_) if one_holds_the_other(first, second, second_in_first) => None,
        SurfaceRelation::Apart(bound) => Some(bound.max(between_spheres).min(ceiling_angstrom)),
    }
}

/// Whether a shell of one body lies inside the other, for surfaces that do not meet.
fn one_holds_the_other(
    first: &CollisionShape,
    second: &CollisionShape,
    second_in_first: &RelativePose,
) -> bool {
    let first_in_second = second_in_first.inverse();
    second
        .shells
        .iter()
        .any(|shell| holds(first, shell, second_in_first))
        || first
            .shells
            .iter()
            .any(|shell| holds(second, shell, &first_in_second))
}

fn holds(shape: &CollisionShape, shell: &Shell, pose: &RelativePose) -> bool {
    let corners = || {
        shell
            .corners
            .iter()
            .map(|corner| pose.transform_point(corner))
    };
    corners().all(|corner| corner.norm() <= shape.radius)
        && corners().next().is_some_and(|c| shape.contains_point(&c))
}

/// Distance between two surfaces, Å: zero if they intersect. Exact and slow (every pair of
/// triangles): for reports and tests. A body inside another keeps its distance to the other's
/// surface.
pub fn distance(
    first: &CollisionShape,
    second: &CollisionShape,
    second_in_first: &RelativePose,
) -> f64 {
    let moved = second
        .mesh
        .map_vertices(|vertex| second_in_first.transform_point(vertex));
    let mut nearest = f64::INFINITY;
    for a in 0..first.mesh.triangles.len() {
        let a = first.mesh.corners(a);
        for b in 0..moved.triangles.len() {
            let b = moved.corners(b);
            if triangle::triangles_intersect(&a, &b) {
                return 0.0;
            }
            nearest = nearest.min(triangle_distance::triangle_distance(&a, &b));
        }
    }
    nearest
}
