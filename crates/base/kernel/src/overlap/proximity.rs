//! Whether two surfaces come nearer than a distance.
//!
//! The two trees are descended together. Discs at least the distance apart are dropped; triangles
//! decide what is left, and the first pair that is near enough ends the descent. The pair of nodes
//! whose discs are nearest is always visited next, so that surfaces in contact are found on the way
//! to the first few triangles.

use super::lanes::{Bits, Lanes, Motion, negative_lanes, separations};
use super::shape::CollisionShape;
use super::traversal::{push_in_front, rounding_angstrom};
use super::triangle::{Triangle, triangles_intersect};
use super::triangle_distance::triangle_distance;
use crate::pose::RelativePose;
use crate::vectorised;

/// Whether points of two surfaces are closer than `distance_angstrom`, or the surfaces meet.
pub(super) fn surfaces_come_within(
    first: &CollisionShape,
    second: &CollisionShape,
    pose: &RelativePose,
    distance_angstrom: f64,
) -> bool {
    Search::new(first, second, pose, distance_angstrom).run()
}

struct Search<'a> {
    first: &'a CollisionShape,
    second: &'a CollisionShape,
    pose: &'a RelativePose,
    motion: Motion,
    /// Allowance for rounding in every disc test, Å.
    rounding: f32,
    distance_angstrom: f64,
    /// The requested distance, rounded up: discs at least this far apart are dropped.
    threshold: f32,
    /// Pairs of nodes that are still to be visited.
    stack: Vec<(u32, u32)>,
}

impl<'a> Search<'a> {
    fn new(
        first: &'a CollisionShape,
        second: &'a CollisionShape,
        pose: &'a RelativePose,
        distance_angstrom: f64,
    ) -> Self {
        Self {
            first,
            second,
            pose,
            motion: Motion::new(pose),
            rounding: rounding_angstrom(first, second, pose),
            distance_angstrom,
            // Rounded up: a disc gap at the threshold or above
            // is then no less than the distance in double.
            threshold: (distance_angstrom as f32).next_up(),
            stack: vec![(first.tree.root(), second.tree.root())],
        }
    }

    vectorised!(
        narrow_fused
        /// Whether two triangles are nearer than the distance.
        fn run[run_avx2, visit_all](self: &mut Self) -> bool
    );

    #[inline(always)]
    fn visit_all(&mut self) -> bool {
        while let Some((a, b)) = self.stack.pop() {
            if self.visit(a, b) {
                return true;
            }
        }
        false
    }

    /// Tests the children of two nodes against each other. Near nodes go on the stack, the nearest
    /// last; near triangles are decided.
    #[inline(always)]
    fn visit(&mut self, index_a: u32, index_b: u32) -> bool {
        let (a, b) = (
            &self.first.tree.nodes[index_a as usize],
            &self.second.tree.nodes[index_b as usize],
        );
        // A leaf holds triangles, not nodes; only the inner node is opened until both are leaves.
        if a.is_leaf != b.is_leaf {
            self.expand_one(index_a, index_b);
            return false;
        }
        let mut nearest = f32::INFINITY;
        let second_discs = self.motion.block(&b.discs);
        let rows = separations(&self.motion.disc(&b.bound), &a.discs, self.rounding);
        // One disc of a against the eight of b at a time, so that the loop over lanes is vectorised;
        // discs of a that are far from b as a whole are dropped first, which spares most rows.
        for row in Bits(self.near(&rows)) {
            let separations = separations(&a.discs.disc(row), &second_discs, self.rounding);
            for lane in Bits(self.near(&separations)) {
                let (child_a, child_b) = (a.children[row], b.children[lane]);
                if !a.is_leaf {
                    push_in_front(
                        &mut self.stack,
                        (child_a, child_b),
                        separations[lane],
                        &mut nearest,
                    );
                } else if self.triangles_come_within(child_a, child_b) {
                    return true;
                }
            }
        }
        false
    }

    /// Tests a leaf against the children of an inner node.
    #[inline(always)]
    fn expand_one(&mut self, index_a: u32, index_b: u32) {
        let (a, b) = (
            &self.first.tree.nodes[index_a as usize],
            &self.second.tree.nodes[index_b as usize],
        );
        let mut nearest = f32::INFINITY;
        let separations = if a.is_leaf {
            separations(&a.bound, &self.motion.block(&b.discs), self.rounding)
        } else {
            separations(&self.motion.disc(&b.bound), &a.discs, self.rounding)
        };
        for lane in Bits(self.near(&separations)) {
            let (child_a, child_b) = if a.is_leaf {
                (index_a, b.children[lane])
            } else {
                (a.children[lane], index_b)
            };
            push_in_front(
                &mut self.stack,
                (child_a, child_b),
                separations[lane],
                &mut nearest,
            );
        }
    }

    /// A bit for each lane nearer than the threshold.
    #[inline(always)]
    fn near(&self, separations: &Lanes) -> u32 {
        negative_lanes(separations.map(|separation| separation - self.threshold))
    }

    fn triangles_come_within(&self, first: u32, second: u32) -> bool {
        let first: Triangle = self.first.mesh.corners(first as usize);
        let second: Triangle = self
            .second
            .mesh
            .corners(second as usize)
            .map(|corner| self.pose.transform_point(&corner));
        // The distance is one of edges and corners: where triangles cross it is not zero.
        triangle_distance(&first, &second) < self.distance_angstrom
            || triangles_intersect(&first, &second)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::CounterRng;
    use crate::{Pose, TriangleMesh};

    #[test]
    fn both_compilations_find_the_same() {
        let mesh = TriangleMesh::tetrahedron(8.0);
        let shape = CollisionShape::new(&mesh).unwrap();
        let mut near = 0;
        for case in 0..400 {
            let mut rng = CounterRng::new(11, 0, case);
            let pose = Pose {
                position: rng.unit_vector() * 24.0,
                rotation: rng.rotation(),
            };
            let relative = RelativePose::from(&pose);
            let search = || Search::new(&shape, &shape, &relative, 5.0);
            let found = search().run();
            assert_eq!(found, search().visit_all());
            near += usize::from(found);
        }
        assert!((40..360).contains(&near), "{near}");
    }
}
