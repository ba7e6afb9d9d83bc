//! How far a body travels along a line before its surface meets that of another.
//!
//! The two trees are descended together once. A pair of discs is dropped if the moving one passes the
//! other, or reaches it no sooner than surfaces that have been found to meet; triangles that are left
//! are projected along the line, in double precision. The pair of nodes that could meet first is
//! always visited next, so that the first few triangles already bound the answer from above.

use super::disc::Disc;
use super::lanes::{Bits, DiscBlock, Lanes, Motion, WIDTH, inverse_root_below, larger, root};
use super::shape::CollisionShape;
use super::traversal::{push_in_front, rounding_angstrom};
use super::triangle::Triangle;
use crate::pose::RelativePose;
use crate::{Vec3, vectorised};
use nalgebra::Unit;

/// Distance that the second body travels along a direction before its surface meets that of the first, Å;
/// `None` if it passes, or travels `limit_angstrom` first. The direction is given in the frame of the first.
///
/// The bodies must be apart at the start. A body in a cavity of the other meets the wall from inside. One descent of
/// both trees gives the answer to rounding in double precision.
///
/// ```
/// use nalgebra::Unit;
/// use protomer_kernel::overlap::free_travel;
/// use protomer_kernel::{CollisionShape, Pose, RelativePose, TriangleMesh, Vec3};
/// let cube = CollisionShape::new(&TriangleMesh::cuboid(&Vec3::zeros(), &Vec3::repeat(1.0)))?;
/// let travel = |y: f64| {
///     let start = Pose { position: Vec3::new(5.0, y, 0.2), ..Pose::identity() };
///     free_travel(&cube, &cube, &RelativePose::from(&start), &-Vec3::x_axis(), 10.0)
/// };
/// assert!(travel(0.3).is_some_and(|travel| (travel - 4.0).abs() < 1e-12));
/// assert!(travel(1.1).is_none(), "it passes");
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
pub fn free_travel(
    first: &CollisionShape,
    second: &CollisionShape,
    start: &RelativePose,
    direction: &Unit<Vec3>,
    limit_angstrom: f64,
) -> Option<f64> {
    let mut search = Search::new(first, second, start, direction, limit_angstrom);
    search.run();
    search.found
}

struct Search<'a> {
    first: &'a CollisionShape,
    second: &'a CollisionShape,
    start: &'a RelativePose,
    motion: Motion,
    /// Direction of travel, in the precision of the discs.
    direction: [f32; 3],
    line: Line,
    /// Allowance for rounding in every disc test, Å.
    rounding: f32,
    /// Travel until the nearest surfaces found so far meet, Å.
    found: Option<f64>,
    /// The same, or the limit, rounded up: discs that meet later are dropped.
    threshold: f32,
    /// Pairs of nodes that are still to be visited, and a bound on the travel before they meet, Å.
    stack: Vec<(f32, u32, u32)>,
}

impl<'a> Search<'a> {
    fn new(
        first: &'a CollisionShape,
        second: &'a CollisionShape,
        start: &'a RelativePose,
        direction: &Unit<Vec3>,
        limit_angstrom: f64,
    ) -> Self {
        Self {
            first,
            second,
            start,
            motion: Motion::new(start),
            direction: direction.into_inner().cast::<f32>().into(),
            line: Line::new(direction),
            // Coordinates reach farther by the travel, and the quotients err once more.
            rounding: 2.0
                * (rounding_angstrom(first, second, start) + 4e-6 * limit_angstrom as f32),
            found: None,
            threshold: (limit_angstrom as f32).next_up(),
            stack: vec![(0.0, first.tree.root(), second.tree.root())],
        }
    }

    vectorised!(
        narrow_fused
        /// Finds the least travel until two triangles meet.
        fn run[run_avx2, visit_all](self: &mut Self)
    );

    #[inline(always)]
    fn visit_all(&mut self) {
        while let Some((entry, a, b)) = self.stack.pop() {
            // Surfaces found since then may meet sooner.
            if entry < self.threshold {
                self.visit(a, b);
            }
        }
    }

    /// Tests the children of two nodes against each other. Nodes that may meet go on the stack, the
    /// soonest last; triangles are decided.
    #[inline(always)]
    fn visit(&mut self, index_a: u32, index_b: u32) {
        let (a, b) = (
            &self.first.tree.nodes[index_a as usize],
            &self.second.tree.nodes[index_b as usize],
        );
        let b_bound = self.motion.disc(&b.bound);
        let mut soonest = f32::INFINITY;
        // A leaf holds triangles, not nodes; only the inner node is opened until both are leaves.
        if a.is_leaf && !b.is_leaf {
            let entries = self.entries(&a.bound, &self.motion.block(&b.discs), 1.0);
            for lane in Bits(self.sooner(&entries)) {
                push_in_front(
                    &mut self.stack,
                    (entries[lane], index_a, b.children[lane]),
                    entries[lane],
                    &mut soonest,
                );
            }
            return;
        }
        // One disc of a against the eight of b at a time, so that the loop over lanes is vectorised;
        // discs of a that b as a whole does not meet are dropped first, which spares most rows.
        let rows = self.entries(&b_bound, &a.discs, -1.0);
        if b.is_leaf && !a.is_leaf {
            for lane in Bits(self.sooner(&rows)) {
                push_in_front(
                    &mut self.stack,
                    (rows[lane], a.children[lane], index_b),
                    rows[lane],
                    &mut soonest,
                );
            }
            return;
        }
        let second_discs = self.motion.block(&b.discs);
        for row in Bits(self.sooner(&rows)) {
            let entries = self.entries(&a.discs.disc(row), &second_discs, 1.0);
            for lane in Bits(self.sooner(&entries)) {
                if a.is_leaf {
                    self.visit_triangles(a.children[row], b.children[lane]);
                } else {
                    push_in_front(
                        &mut self.stack,
                        (entries[lane], a.children[row], b.children[lane]),
                        entries[lane],
                        &mut soonest,
                    );
                }
            }
        }
    }

    /// A bit for each lane that may meet sooner than what has been found.
    #[inline(always)]
    fn sooner(&self, entries: &Lanes) -> u32 {
        let mut bits = 0;
        for (lane, entry) in entries.iter().enumerate() {
            bits |= u32::from(*entry < self.threshold) << lane;
        }
        bits
    }

    /// Lower bounds on the travel before a disc meets eight others that move along the direction
    /// times `sign` in its frame, Å; infinite for those that pass it.
    #[inline(always)]
    fn entries(&self, disc: &Disc, block: &DiscBlock, sign: f32) -> Lanes {
        entries(
            disc,
            block,
            self.direction.map(|axis| sign * axis),
            self.rounding,
        )
    }

    /// Lowers the answer to the travel at which two triangles meet, if they do.
    fn visit_triangles(&mut self, first: u32, second: u32) {
        let first: Triangle = self.first.mesh.corners(first as usize);
        let second: Triangle = self
            .second
            .mesh
            .corners(second as usize)
            .map(|corner| self.start.transform_point(&corner));
        if let Some(travel) = self.line.travel_angstrom(&first, &second)
            && travel < f64::from(self.threshold)
            && self.found.is_none_or(|found| travel < found)
        {
            self.found = Some(travel);
            self.threshold = (travel as f32).next_up();
        }
    }
}

/// Lower bounds on the travel along `u` before each of eight discs meets another at rest, Å; infinite
/// for those that pass it.
///
/// With d from the disc at rest to the other, and e the sum of their half-extents along an axis a, the
/// discs are apart along a unless |(d + x u)·a| ≤ e, which holds in an interval of the travel x. Three
/// such intervals (a is either normal, or u) must have a point in common, and the part of d across u
/// must not exceed the half-extents along it.
#[inline(always)]
fn entries(disc: &Disc, block: &DiscBlock, u: [f32; 3], rounding: f32) -> Lanes {
    let dot = |x: [f32; 3], y: [f32; 3]| x[0].mul_add(y[0], x[1].mul_add(y[1], x[2] * y[2]));
    let m = disc.normal;
    let u_on_m = dot(u, m);
    let m_across_u = root(u_on_m.mul_add(-u_on_m, 1.0 + SLACK));
    let disc_on_u = disc
        .half_thickness
        .mul_add(u_on_m.abs(), disc.radius * m_across_u);
    let mut result = [0.0; WIDTH];
    for (lane, result) in result.iter_mut().enumerate() {
        let d = [0, 1, 2].map(|axis| block.centre[axis][lane] - disc.centre[axis]);
        let n = [0, 1, 2].map(|axis| block.normal[axis][lane]);
        let (radius, half_thickness) = (block.radius[lane], block.half_thickness[lane]);
        let (d_on_m, d_on_n, d_on_u) = (dot(d, m), dot(d, n), dot(d, u));
        let (u_on_n, m_on_n) = (dot(u, n), dot(m, n));
        let sine = root(m_on_n.mul_add(-m_on_n, 1.0 + SLACK));
        let n_across_u = root(u_on_n.mul_add(-u_on_n, 1.0 + SLACK));
        // Half-extents of both discs along m, n and u.
        let on_m = disc.half_thickness + radius.mul_add(sine, half_thickness * m_on_n.abs());
        let on_n = half_thickness
            + disc
                .radius
                .mul_add(sine, disc.half_thickness * m_on_n.abs());
        let on_u = disc_on_u + radius.mul_add(n_across_u, half_thickness * u_on_n.abs());
        let [enter_m, leave_m] = interval(d_on_m, u_on_m, on_m + rounding);
        let [enter_n, leave_n] = interval(d_on_n, u_on_n, on_n + rounding);
        let (enter_u, leave_u) = (-d_on_u - on_u - rounding, on_u - d_on_u + rounding);
        let enter = larger(larger(enter_m, enter_n), larger(enter_u, 0.0));
        let leave = -larger(larger(-leave_m, -leave_n), -leave_u);
        // The part of d across u, and the half-extents along it, each times its length.
        let w = [0, 1, 2].map(|axis| (-d_on_u).mul_add(u[axis], d[axis]));
        let squared = dot(w, w);
        let (w_on_m, w_on_n) = (dot(w, m), dot(w, n));
        let enlarged = squared * (1.0 + SLACK);
        let across_m = root(w_on_m.mul_add(-w_on_m, enlarged));
        let across_n = root(w_on_n.mul_add(-w_on_n, enlarged));
        let extents = disc.radius.mul_add(
            across_m,
            disc.half_thickness.mul_add(
                w_on_m.abs(),
                radius.mul_add(across_n, half_thickness * w_on_n.abs()),
            ),
        );
        // Without an offset across u the discs are in line; a number that is not one compares false.
        let apart_across = (squared - extents) * inverse_root_below(squared) > rounding;
        let passes = apart_across || enter > leave + rounding;
        *result = if passes {
            f32::INFINITY
        } else {
            enter - rounding
        };
    }
    result
}

/// Allowance added to squares under a root that cancels, relative to their size.
const SLACK: f32 = 4e-6;
/// The least cosine between an axis and the direction of travel: below, the travel moves no point along the axis
/// by more than the allowance for rounding.
const LEAST_COSINE: f32 = 1e-6;

/// Travel x at which |offset + x cosine| ≤ extent, from and to.
#[inline(always)]
fn interval(offset: f32, cosine: f32, extent: f32) -> [f32; 2] {
    let inverse = 1.0 / larger(cosine.abs(), LEAST_COSINE).copysign(cosine);
    let (middle, half) = (-offset * inverse, extent * inverse.abs());
    [middle - half, middle + half]
}

/// Coordinates along and across the direction of travel.
struct Line {
    across: [Vec3; 2],
    along: Vec3,
}

/// A point seen along the line.
#[derive(Clone, Copy)]
struct Point {
    across: [f64; 2],
    along: f64,
}

impl Line {
    fn new(direction: &Unit<Vec3>) -> Self {
        let along = direction.into_inner();
        let axis = if along.x.abs() < 0.6 {
            Vec3::x()
        } else {
            Vec3::y()
        };
        let first = along.cross(&axis).normalize();
        Self {
            across: [first, along.cross(&first)],
            along,
        }
    }

    fn project(&self, triangle: &Triangle) -> [Point; 3] {
        triangle.map(|corner| Point {
            across: self.across.map(|axis| corner.dot(&axis)),
            along: corner.dot(&self.along),
        })
    }

    /// Travel of the second triangle until it meets the first, Å; `None` if it never does.
    ///
    /// Seen along the line, the travel is a linear function on the common part of the two triangles,
    /// whose least value is at a corner of that part: a corner of one triangle in the other, or a point
    /// where two edges cross.
    fn travel_angstrom(&self, first: &Triangle, second: &Triangle) -> Option<f64> {
        let (first, second) = (self.project(first), self.project(second));
        let mut least = f64::INFINITY;
        // What lies behind is left; closed surfaces that are apart at the start do not get there.
        let mut consider = |travel: f64| {
            if travel >= 0.0 && travel < least {
                least = travel;
            }
        };
        for i in 0..3 {
            if let Some(along) = height_above(&first, &second[i]) {
                consider(along - second[i].along);
            }
            if let Some(along) = height_above(&second, &first[i]) {
                consider(first[i].along - along);
            }
            for j in 0..3 {
                let edges = [
                    [first[i], first[(i + 1) % 3]],
                    [second[j], second[(j + 1) % 3]],
                ];
                if let Some([along_first, along_second]) = crossing(&edges) {
                    consider(along_first - along_second);
                }
            }
        }
        least.is_finite().then_some(least)
    }
}

/// Twice the area of the triangle from the origin over two points across the line.
fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn minus(a: &Point, b: &Point) -> [f64; 2] {
    [a.across[0] - b.across[0], a.across[1] - b.across[1]]
}

/// Coordinate along the line of the point of a triangle that a point covers; `None` beyond the triangle, and for a
/// triangle seen from the side, whose edges decide.
fn height_above(triangle: &[Point; 3], point: &Point) -> Option<f64> {
    let [a, b, c] = triangle.each_ref().map(|corner| minus(corner, point));
    let weights = [cross(b, c), cross(c, a), cross(a, b)];
    let covered = weights.iter().all(|w| *w >= 0.0) || weights.iter().all(|w| *w <= 0.0);
    let total: f64 = weights.iter().sum();
    let along = weights
        .iter()
        .zip(triangle)
        .map(|(weight, corner)| weight * corner.along);
    (covered && total != 0.0).then(|| along.sum::<f64>() / total)
}

/// Coordinates along the line, on either edge, of the point where two edges cross as seen along it.
fn crossing([[a, b], [c, d]]: &[[Point; 2]; 2]) -> Option<[f64; 2]> {
    let (first, second, offset) = (minus(b, a), minus(d, c), minus(c, a));
    let area = cross(first, second);
    let parts = [cross(offset, second) / area, cross(offset, first) / area];
    // Parallel edges give no number here; their ends decide.
    parts
        .iter()
        .all(|part| (0.0..=1.0).contains(part))
        .then(|| {
            [
                a.along + parts[0] * (b.along - a.along),
                c.along + parts[1] * (d.along - c.along),
            ]
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::CounterRng;
    use crate::{Pose, TriangleMesh};
    use std::f64::consts::{PI, TAU};

    /// A ball with a corrugated surface, which is not convex: rings of twelve vertices between two poles.
    fn corrugated(radius: f64, waves: f64) -> CollisionShape {
        const RINGS: u32 = 8;
        const AROUND: u32 = 12;
        let mut vertices = vec![Vec3::z(), -Vec3::z()];
        let vertex = |ring: u32, k: u32| 2 + ring * AROUND + k % AROUND;
        let mut triangles = Vec::new();
        for ring in 0..RINGS {
            let polar = f64::from(ring + 1) / f64::from(RINGS + 1) * PI;
            for k in 0..AROUND {
                let (sine, cosine) = (f64::from(k) / f64::from(AROUND) * TAU).sin_cos();
                vertices.push(Vec3::new(
                    polar.sin() * cosine,
                    polar.sin() * sine,
                    polar.cos(),
                ));
                let (next, below) = (vertex(ring, k + 1), vertex(ring + 1, k));
                if ring + 1 < RINGS {
                    triangles.push([vertex(ring, k), below, next]);
                    triangles.push([next, below, vertex(ring + 1, k + 1)]);
                }
            }
        }
        for k in 0..AROUND {
            triangles.push([0, vertex(0, k), vertex(0, k + 1)]);
            triangles.push([1, vertex(RINGS - 1, k + 1), vertex(RINGS - 1, k)]);
        }
        for vertex in &mut vertices {
            let height = (waves * vertex.x).sin() * (waves * vertex.y).cos();
            *vertex *= radius * (1.0 + 0.2 * height);
        }
        CollisionShape::new(&TriangleMesh {
            vertices,
            triangles,
        })
        .unwrap()
    }

    /// The least travel over all pairs of triangles.
    fn over_all_pairs(search: &Search<'_>) -> Option<f64> {
        let mut least = f64::INFINITY;
        for a in 0..search.first.mesh.triangles.len() {
            let a = search.first.mesh.corners(a);
            for b in 0..search.second.mesh.triangles.len() {
                let b = search
                    .second
                    .mesh
                    .corners(b)
                    .map(|corner| search.start.transform_point(&corner));
                least = least.min(search.line.travel_angstrom(&a, &b).unwrap_or(f64::INFINITY));
            }
        }
        least.is_finite().then_some(least)
    }

    #[test]
    fn one_descent_finds_what_all_pairs_of_triangles_give() {
        let (first, second) = (corrugated(9.0, 5.0), corrugated(5.0, 3.0));
        let mut met = 0;
        for case in 0..200 {
            let mut rng = CounterRng::new(3, 0, case);
            let from = rng.unit_vector() * 22.0;
            let pose = Pose {
                position: from,
                rotation: rng.rotation(),
            };
            let aim = rng.vector_in_ball(16.0);
            let start = RelativePose::from(&pose);
            let direction = Unit::new_normalize(aim - from);
            let mut search = Search::new(&first, &second, &start, &direction, 60.0);
            let expected = over_all_pairs(&search);
            search.run();
            let mut portable = Search::new(&first, &second, &start, &direction, 60.0);
            portable.visit_all();
            assert_eq!(search.found, expected, "case {case}");
            assert_eq!(portable.found, expected, "case {case}");
            met += usize::from(expected.is_some());
        }
        assert!((50..195).contains(&met), "{met}");
    }
}
