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
//! | `shape` | a body prepared for overlap tests |
//! | `traversal` | simultaneous descent of two trees: what discs cannot separate, triangles decide |
//! | `proximity` | simultaneous descent that asks whether surfaces come nearer than a distance |
//! | `travel` | simultaneous descent that finds how far one body travels along a line before it meets another |
//! | `point` | whether a point is within a distance of a solid |
//! | `triangle` | exact intersection of two triangles |
//! | `triangle_distance` | how far two triangles are apart |
//! | `containment` | which points lie inside a solid |
//! | `embedding` | whether a surface meets itself, and how its shells nest |
//! | `carried_bound` | what is left of a separation after the bodies have moved |
//!
//! # Why it is built like this
//!
//! In hard-particle Monte Carlo of an assembly nearly all the time goes into pairs whose surfaces
//! are 0.05-2 Å apart over a contact patch. For such pairs:
//! * The bounding volume must be thin along the surface normal; far too many spheres as small as the
//!   gap would be needed. A disc takes eight numbers and is turned by turning two vectors. Three axes
//!   (both normals and the line of the centres) separate two discs with a few dozen operations and
//!   no stored matrix; without the third axis a third more pairs survive.
//! * There is one rotation matrix per pair of bodies, in `f32`, with an allowance for every rounding.
//!   A disc test can only say "provably apart"; all other pairs go to predicates with exact signs.
//!   The answer is always that of brute force.
//! * Products and sums are fused, and square roots are exact: the divider works while the
//!   multipliers do. A root and a quotient for the line of the centres would be too much for it, so
//!   a one-sided approximation within 0.2 % stands there. Processors without fused operations find
//!   the same bits, more slowly.
//! * Latency and mispredicted branches cost more than arithmetic. A child of one node is first tested
//!   against the other node as a whole (two of eight remain), several pairs of nodes are in flight
//!   together, and nothing is sorted.
//! * A bound as good as the true distance costs several times the decision. [`separation_bound`]
//!   descends only into pairs nearer than a quarter of the least separation met so far, and takes the
//!   least of all it has skipped. That is nearly free, and [`CarriedBound`] uses it in later trials.
//!   Nearer than about 0.1 Å only the decision is made, because a single step would use up the bound.
//!
//! Alternatives that were rejected:
//! * Distance fields are exact only to the size of a cell, so near contact, where the time goes, they
//!   decide nothing.
//! * Lists of near triangles kept from trial to trial need too much room: a rotation of 0.04 rad
//!   moves a far point of a body by 1 Å, so lists are rebuilt every few trials at the cost of several
//!   queries. With a skin of 0.7 Å and 0.05 rad about the contact, and separate limits for every part
//!   that was skipped, a test of the list of two bodies in contact costs less than the descent, but a
//!   list has hundreds of pairs and takes some 40 µs to make: sixteen bodies close to contact made
//!   21 000 moves per CPU-second instead of 42 000, the same decisions (2026-11-24).
//! * A separating plane remembered for each pair of nodes at which the descent stopped, tested eight
//!   at a time and fitted again where it fails: on sixteen bodies close to contact a trial move
//!   then visits 47 pairs of nodes instead of 258, but testing and fitting the planes costs what
//!   that saves (42 300 instead of 40 000 moves per CPU-second, one prototype in one run, with the
//!   former arithmetic). Planes without fitting visit 74 pairs and gain nothing.
//! * Other trees, in moves per CPU-second of one run, 46 300 as it is: triangles divided by centres
//!   and normals together 33 300 to 44 500, normals of discs refined by search 47 700 (and six times
//!   as many discs tried when a body is prepared), another weight of the radius 46 100 to 46 400.

mod carried_bound;
mod containment;
mod disc;
mod embedding;
mod lanes;
mod point;
mod proximity;
mod shape;
mod travel;
mod traversal;
mod tree;
mod triangle;
mod triangle_distance;

pub use carried_bound::CarriedBound;
pub use embedding::check_embedding;
pub use shape::CollisionShape;
pub use travel::free_travel;

use crate::pose::RelativePose;
use proximity::surfaces_come_within;
use traversal::{SurfaceRelation, relate_surfaces};
use triangle::triangles_intersect;
use triangle_distance::triangle_distance;

/// Whether two bodies overlap: their surfaces have a point in common or one solid lies inside the
/// other. Touching is overlap: the solids are closed sets. A body inside a cavity of another does
/// not overlap it.
///
/// ```
/// use protomer_kernel::overlap::overlaps;
/// use protomer_kernel::{CollisionShape, Pose, RelativePose, TriangleMesh, Vec3};
/// let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
/// let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// let shape = CollisionShape::new(&TriangleMesh { vertices, triangles })?;
/// let beside = |x: f64| {
///     let second = Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::identity() };
///     RelativePose::from(&second)
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
/// The bound never exceeds the true [`distance`] and costs little more than the decision. A ceiling
/// of a few times the longest trial step is a good choice.
///
/// ```
/// use protomer_kernel::overlap::{distance, separation_bound};
/// use protomer_kernel::{CollisionShape, Pose, RelativePose, TriangleMesh, Vec3};
/// let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
/// let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// let shape = CollisionShape::new(&TriangleMesh { vertices, triangles })?;
/// let second = Pose { position: Vec3::new(1.5, 0.0, 0.0), ..Pose::identity() };
/// let pose = RelativePose::from(&second);
/// let bound = separation_bound(&shape, &shape, &pose, 3.0);
/// assert!(bound.is_some_and(|bound| bound <= distance(&shape, &shape, &pose)));
/// assert!((distance(&shape, &shape, &pose) - 0.5).abs() < 1e-12);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
pub fn separation_bound(
    first: &CollisionShape,
    second: &CollisionShape,
    second_in_first: &RelativePose,
    ceiling_angstrom: f64,
) -> Option<f64> {
    let between_spheres = second_in_first.translation.norm() - first.radius - second.radius;
    // The second limit is the rounding of the difference itself; below it the descent decides.
    if between_spheres > ceiling_angstrom.max(1e-9 * (first.radius + second.radius)) {
        return Some(ceiling_angstrom);
    }
    match relate_surfaces(first, second, second_in_first, ceiling_angstrom) {
        SurfaceRelation::Intersecting => None,
        // Only for surfaces apart: where they meet, a shell is neither wholly inside nor outside.
        SurfaceRelation::Apart(_)
            if first.holds_a_shell_of(second, second_in_first)
                || second.holds_a_shell_of(first, &second_in_first.inverse()) =>
        {
            None
        }
        // The bound of the spheres may be the better one where the descent stopped early.
        SurfaceRelation::Apart(bound) => Some(bound.max(between_spheres).min(ceiling_angstrom)),
    }
}

/// Whether two bodies are closer than `distance_angstrom`: a point of one surface is nearer than that
/// to a point of the other, or the bodies overlap, as [`overlaps`] decides. A body inside another is
/// near it at any distance; one inside a cavity only if the surfaces are.
///
/// Distances of triangles decide, in double precision, so the answer does not depend on how finely a
/// surface is meshed. Brute force is [`distance`].
///
/// ```
/// use protomer_kernel::overlap::comes_within;
/// use protomer_kernel::{CollisionShape, Pose, RelativePose, TriangleMesh, Vec3};
/// let vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
/// let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// let shape = CollisionShape::new(&TriangleMesh { vertices, triangles })?;
/// let second = Pose { position: Vec3::new(1.5, 0.0, 0.0), ..Pose::identity() };
/// let pose = RelativePose::from(&second);
/// assert!(comes_within(&shape, &shape, &pose, 0.51));
/// assert!(!comes_within(&shape, &shape, &pose, 0.49));
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
pub fn comes_within(
    first: &CollisionShape,
    second: &CollisionShape,
    second_in_first: &RelativePose,
    distance_angstrom: f64,
) -> bool {
    let between_spheres = second_in_first.translation.norm() - first.radius - second.radius;
    // Rounding of the difference of the radii must not call touching bodies far.
    if between_spheres > distance_angstrom.max(1e-9 * (first.radius + second.radius)) {
        return false;
    }
    surfaces_come_within(first, second, second_in_first, distance_angstrom)
        || first.holds_a_shell_of(second, second_in_first)
        || second.holds_a_shell_of(first, &second_in_first.inverse())
}

/// Distance between two surfaces, Å; zero if they intersect. It is exact and slow (every pair of
/// triangles), for reports and tests. The distance of a body inside another is that from the other's
/// surface.
///
/// ```
/// use protomer_kernel::overlap::distance;
/// use protomer_kernel::{CollisionShape, Pose, RelativePose, TriangleMesh, Vec3};
/// let cube = CollisionShape::new(&TriangleMesh::cuboid(&Vec3::zeros(), &Vec3::repeat(1.0)))?;
/// let pose = Pose::identity();
/// let diagonal = RelativePose::new(&pose, &pose, &Vec3::new(4.0, 5.0, 0.0));
/// assert!((distance(&cube, &cube, &diagonal) - 5.0).abs() < 1e-12);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
pub fn distance(
    first: &CollisionShape,
    second: &CollisionShape,
    second_in_first: &RelativePose,
) -> f64 {
    let into_first = |vertex: &_| second_in_first.transform_point(vertex);
    let second_mesh = second.mesh.map_vertices(into_first);
    let mut nearest = f64::INFINITY;
    for a in 0..first.mesh.triangles.len() {
        let a = first.mesh.corners(a);
        for b in 0..second_mesh.triangles.len() {
            let b = second_mesh.corners(b);
            if triangles_intersect(&a, &b) {
                return 0.0;
            }
            nearest = nearest.min(triangle_distance(&a, &b));
        }
    }
    nearest
}
