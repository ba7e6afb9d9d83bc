//! The simultaneous descent of two disc trees.

use super::lanes::{Bits, DiscBlock, Lanes, Motion, WIDTH, negative_lanes, separations};
use super::shape::CollisionShape;
use super::tree::Node;
use super::triangle::{Triangle, triangles_intersect};
use super::triangle_distance::separation_along_axes;
use crate::pose::RelativePose;
use crate::vectorised;
use std::cell::RefCell;

/// The rounding error of a separation in `f32` relative to the size of the coordinates: some fifty
/// operations, each within 2⁻²⁴.
pub(super) const ROUNDING: f64 = 64.0 * (f32::EPSILON as f64 / 2.0);

/// The allowance for rounding in every disc test of two bodies, Å.
pub(super) fn rounding_angstrom(
    first: &CollisionShape,
    second: &CollisionShape,
    pose: &RelativePose,
) -> f32 {
    // Both radii and the offset bound every coordinate, so one number serves all discs of the pair.
    ((first.radius + second.radius + pose.translation.norm()) * ROUNDING) as f32
}

/// Puts a pair of nodes on a stack; the one with the least key of those that a visit pushes stays on top.
#[inline(always)]
pub(super) fn push_in_front<T>(stack: &mut Vec<T>, pair: T, key: f32, least: &mut f32) {
    stack.push(pair);
    let top = stack.len() - 1;
    if key < *least {
        *least = key;
    } else if top > 0 {
        stack.swap(top - 1, top);
    }
}

/// Result of a descent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum SurfaceRelation {
    /// The surfaces have a point in common.
    Intersecting,
    /// The surfaces are at least this far apart, Å; not more than the ceiling of the search.
    Apart(f64),
}

/// Decides whether the surfaces intersect and bounds their separation from below, up to a ceiling
/// in Å. A ceiling of zero asks for the decision alone.
pub(super) fn relate_surfaces(
    first: &CollisionShape,
    second: &CollisionShape,
    pose: &RelativePose,
    ceiling_angstrom: f64,
) -> SurfaceRelation {
    // In f32 like the discs: every bound that leaves
    // here carries the allowance for rounding already.
    let mut descent = Descent::new(first, second, pose, ceiling_angstrom.max(0.0) as f32);
    if SCRATCH.with_borrow_mut(|scratch| descent.run(scratch)) {
        SurfaceRelation::Intersecting
    } else {
        SurfaceRelation::Apart(f64::from(descent.bound()))
    }
}

/// Two nodes to be tested against each other.
#[derive(Debug, Clone, Copy)]
struct NodePair {
    /// Lower bound on the separation of the nodes, Å.
    separation: f32,
    a: u32,
    b: u32,
}

/// Pairs of nodes visited together.
const BATCH: usize = 8;

thread_local! {
    /// Working memory, kept from query to query: a query of a microsecond has no time to allocate.
    static SCRATCH: RefCell<Scratch> = RefCell::new(Scratch::new());
}

struct Scratch {
    stack: Vec<NodePair>,
    batch: Batch,
}

impl Scratch {
    fn new() -> Self {
        Self {
            stack: Vec::new(),
            batch: Batch::new(),
        }
    }
}

/// The working memory of one visit.
struct Batch {
    pairs: Vec<NodePair>,
    /// The children of each b in the frame of the first body.
    second_discs: [DiscBlock; BATCH],
    near_rows: [u32; BATCH],
    /// Pair and child, for each child of an a that is near its b.
    rows: Vec<(u8, u8)>,
    /// Near children of b, and the separations of all, for each of these rows.
    hits: Vec<(u32, Lanes)>,
}

impl Batch {
    fn new() -> Self {
        Self {
            pairs: Vec::with_capacity(BATCH),
            second_discs: [const { DiscBlock::EMPTY }; BATCH],
            near_rows: [0; BATCH],
            rows: Vec::with_capacity(BATCH * WIDTH),
            hits: Vec::with_capacity(BATCH * WIDTH),
        }
    }
}

struct Descent<'a> {
    first: &'a CollisionShape,
    second: &'a CollisionShape,
    pose: &'a RelativePose,
    motion: Motion,
    /// Allowance for rounding in every disc test, Å.
    rounding: f32,
    /// The least separation met so far, lane by lane, Å.
    bound: Lanes,
    /// The descent stops at pairs at least this far apart, Å. Any value gives a true bound; see
    /// [`threshold_for`].
    threshold: f32,
}

impl<'a> Descent<'a> {
    fn new(
        first: &'a CollisionShape,
        second: &'a CollisionShape,
        pose: &'a RelativePose,
        ceiling: f32,
    ) -> Self {
        Descent {
            first,
            second,
            pose,
            motion: Motion::new(pose),
            rounding: rounding_angstrom(first, second, pose),
            bound: [ceiling; WIDTH],
            threshold: threshold_for(ceiling),
        }
    }

    vectorised!(
        narrow_bits
        /// Whether two triangles intersect.
        fn run[run_avx2, visit_all](self: &mut Self, scratch: &mut Scratch) -> bool
    );

    /// Takes pairs of nodes from the stack, a few at a time so that the arithmetic of one hides the
    /// latency of another, until an intersection is found.
    #[inline(always)]
    fn visit_all(&mut self, scratch: &mut Scratch) -> bool {
        let Scratch { stack, batch } = scratch;
        stack.clear();
        stack.push(NodePair {
            // The roots carry no bound yet: MIN keeps them below any threshold.
            separation: f32::MIN,
            a: self.first.tree.root(),
            b: self.second.tree.root(),
        });
        while !stack.is_empty() {
            batch.pairs.clear();
            while batch.pairs.len() < BATCH
                && let Some(pair) = stack.pop()
            {
                // The threshold may have fallen since this pair
                // was pushed. What is dropped unseen must still
                // count, or the bound of the whole search would be too large.
                if pair.separation >= self.threshold {
                    self.bound[0] = self.bound[0].min(pair.separation);
                } else {
                    batch.pairs.push(pair);
                }
            }
            if self.visit_batch(batch, stack) {
                return true;
            }
        }
        false
    }

    /// Tests the children of some pairs of nodes against each other: near nodes go on the stack, near
    /// triangles are decided. True if two triangles intersect.
    #[inline(always)]
    fn visit_batch(&mut self, batch: &mut Batch, stack: &mut Vec<NodePair>) -> bool {
        self.find_near_rows(batch, stack);
        self.find_hits(batch);
        // All hits are known before anything is pushed: no load of a node waits for a comparison.
        for (&(slot, row), (near, separations)) in batch.rows.iter().zip(&batch.hits) {
            let pair = batch.pairs[slot as usize];
            let a = &self.first.tree.nodes[pair.a as usize];
            let b = &self.second.tree.nodes[pair.b as usize];
            for lane in Bits(*near) {
                let (child_a, child_b) = (a.children[row as usize], b.children[lane]);
                let separation = separations[lane];
                if !a.is_leaf {
                    stack.push(NodePair {
                        separation,
                        a: child_a,
                        b: child_b,
                    });
                // Triangles whose discs are apart need no exact
                // test; the gap of the discs is their bound.
                } else if separation > 0.0 {
                    self.lower(separation);
                } else if self.visit_triangles(child_a, child_b) {
                    return true;
                }
            }
        }
        false
    }

    /// Finds the children of a that are near b as a whole.
    #[inline(always)]
    fn find_near_rows(&mut self, batch: &mut Batch, stack: &mut Vec<NodePair>) {
        let (first, second) = (self.first, self.second);
        batch.rows.clear();
        for (slot, pair) in batch.pairs.iter().enumerate() {
            let a = &first.tree.nodes[pair.a as usize];
            let b = &second.tree.nodes[pair.b as usize];
            // Turned once per pair here and used for up to eight rows in `find_hits`.
            batch.second_discs[slot] = self.motion.block(&b.discs);
            let b_bound = self.motion.disc(&b.bound);
            // One test against b as a whole drops most
            // children of a before any of the 64 child pairs.
            let separations = separations(&b_bound, &a.discs, self.rounding);
            batch.near_rows[slot] = self.near(&separations);
            // Trees of different depth meet here. The eight
            // lanes of the leaf are triangles, not nodes, so
            // only the inner node is opened.
            if a.is_leaf != b.is_leaf {
                self.expand_one(*pair, a, b, &batch.second_discs[slot], stack);
                batch.near_rows[slot] = 0;
            }
        }
        // A second loop: the rows of all pairs in one list let `find_hits` run without branches.
        for slot in 0..batch.pairs.len() {
            for row in Bits(batch.near_rows[slot]) {
                batch.rows.push((slot as u8, row as u8));
            }
        }
    }

    /// Finds the children of b that are near each of these rows.
    #[inline(always)]
    fn find_hits(&mut self, batch: &mut Batch) {
        batch.hits.clear();
        for &(slot, row) in &batch.rows {
            let pair = batch.pairs[slot as usize];
            let a = &self.first.tree.nodes[pair.a as usize];
            let disc = a.discs.disc(row as usize);
            let separations = separations(&disc, &batch.second_discs[slot as usize], self.rounding);
            let near = self.near(&separations);
            // Stored, not pushed, so that this loop has no
            // side effects and the vector work overlaps.
            batch.hits.push((near, separations));
        }
    }

    /// Tests a leaf against the children of an inner node.
    #[inline(always)]
    fn expand_one(
        &mut self,
        pair: NodePair,
        a: &Node,
        b: &Node,
        second_discs: &DiscBlock,
        stack: &mut Vec<NodePair>,
    ) {
        let separations = if a.is_leaf {
            separations(&a.bound, second_discs, self.rounding)
        } else {
            separations(&self.motion.disc(&b.bound), &a.discs, self.rounding)
        };
        for lane in Bits(self.near(&separations)) {
            let (a, b) = if a.is_leaf {
                (pair.a, b.children[lane])
            } else {
                (a.children[lane], pair.b)
            };
            stack.push(NodePair {
                separation: separations[lane],
                a,
                b,
            });
        }
    }

    /// The lanes nearer than the threshold; the separations of the others enter the bound.
    #[inline(always)]
    fn near(&mut self, separations: &Lanes) -> u32 {
        let mut excess = [0.0; WIDTH];
        for lane in 0..WIDTH {
            excess[lane] = separations[lane] - self.threshold;
            // Selected without a branch: lanes below the
            // threshold are examined further and must not enter.
            let skipped = if excess[lane] < 0.0 {
                f32::MAX
            } else {
                separations[lane]
            };
            self.bound[lane] = self.bound[lane].min(skipped);
        }
        negative_lanes(excess)
    }

    /// The least separation met; not negative, as the ceiling is not, and what was skipped is
    /// beyond the threshold.
    fn bound(&self) -> f32 {
        self.bound.iter().copied().fold(f32::MAX, f32::min)
    }

    /// Records a separation and stops the descent into pairs much farther apart.
    #[inline(always)]
    fn lower(&mut self, separation: f32) {
        self.bound[0] = self.bound[0].min(separation);
        self.threshold = self.threshold.min(threshold_for(separation));
    }

    /// Decides two triangles; if they do not intersect their separation lowers the threshold.
    fn visit_triangles(&mut self, first: u32, second: u32) -> bool {
        let first: Triangle = self.first.mesh.corners(first as usize);
        let second: Triangle = self
            .second
            .mesh
            // In double precision from the original corners:
            // only discs may be rounded, triangles are exact.
            .corners(second as usize)
            .map(|corner| self.pose.transform_point(&corner));
        if triangles_intersect(&first, &second) {
            return true;
        }
        // Without a use for the bound, the fifteen projections are left out.
        let bound_is_wanted = self.threshold > f32::MIN_POSITIVE;
        let separation = if bound_is_wanted {
            separation_along_axes(&first, &second) as f32 - self.rounding
        } else {
            0.0
        };
        // A negative gap means that no axis separates, not
        // that they meet: exact signs said they do not.
        self.lower(separation.max(0.0));
        false
    }
}

/// Separation of pairs at which the descent stops, for a separation of interest: a compromise
/// between the cost of a query and the quality of its bound. Below `FLOOR` only the decision
/// counts.
fn threshold_for(separation: f32) -> f32 {
    const SHARE: f32 = 0.25;
    const FLOOR: f32 = 0.1;
    let threshold = SHARE * separation;
    // Not zero: discs with a positive gap, however
    // small, must be dropped and overlapping ones kept.
    if threshold < FLOOR {
        f32::MIN_POSITIVE
    } else {
        threshold
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Pose, TriangleMesh, Vec3};

    /// A tetrahedron with its base cut into `n` slices: long thin triangles.
    fn sliced_tetrahedron(n: u32) -> TriangleMesh {
        let mut vertices = vec![Vec3::new(0.0, 0.0, 8.0), Vec3::new(0.0, 0.0, -1.0)];
        vertices.extend((0..n).map(|i| {
            let (sine, cosine) = (f64::from(i) * std::f64::consts::TAU / f64::from(n)).sin_cos();
            Vec3::new(9.0 * cosine, 5.0 * sine, f64::from(i % 2))
        }));
        let rim = |i: u32| 2 + i % n;
        let triangles = (0..n)
            .flat_map(|i| [[0, rim(i), rim(i + 1)], [1, rim(i + 1), rim(i)]])
            .collect();
        TriangleMesh {
            vertices,
            triangles,
        }
    }

    #[test]
    fn both_compilations_find_the_same_to_the_last_bit() {
        let (first, second) = (sliced_tetrahedron(300), sliced_tetrahedron(17));
        let (first, second) = (
            CollisionShape::new(&first).unwrap(),
            CollisionShape::new(&second).unwrap(),
        );
        let mut intersecting = 0;
        for k in 0..400 {
            let x = f64::from(k);
            let quaternion = [x.sin(), (2.0 * x).cos(), (3.0 * x).sin(), 0.1];
            let position = Vec3::new((5.0 * x).sin(), (7.0 * x).cos(), (11.0 * x).sin()) * 14.0;
            let placed = Pose::from_wxyz(position, quaternion);
            let pose = RelativePose::new(&Pose::identity(), &placed, &position);
            let results = [true, false].map(|portable| {
                let mut descent = Descent::new(&first, &second, &pose, 3.0);
                let mut scratch = Scratch::new();
                let met = if portable {
                    descent.visit_all(&mut scratch)
                } else {
                    descent.run(&mut scratch)
                };
                (met, descent.bound().to_bits())
            });
            assert_eq!(results[0], results[1]);
            assert!(f32::from_bits(results[0].1) >= 0.0);
            intersecting += usize::from(results[0].0);
        }
        assert!((40..360).contains(&intersecting), "{intersecting}");
    }
}
