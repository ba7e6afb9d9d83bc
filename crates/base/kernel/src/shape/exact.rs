//! Whether two polytopes overlap, decided exactly.
//!
//! The bodies are the convex hulls of their corners as the floating-point numbers say them, which is not
//! quite what they were before they were turned. Two polytopes are apart if and only if the normal of a
//! face of their difference separates them: the normal of a face of either, or the cross product of an
//! edge of each (Gottschalk, Lin and Manocha, SIGGRAPH 96, 171). The corners of a face that was flat may
//! no longer lie in a plane, so all triangles of its corners are taken for faces, and all pairs of its
//! corners for edges. Axes too many do no harm: one that separates the bodies proves that they are apart.
//!
//! Most axes are decided by ordinary numbers and a bound on their error. The others are sums of products
//! of differences, and have exact expansions (`expansion`).

use super::expansion::Expansion;
use super::separation::{Block, LANES, Pair};
use crate::Vec3;
use std::cmp::Ordering;

/// Rounding of a triple product of differences of coordinates, as a part of the product of their sizes:
/// a few dozen operations.
const OF_A_PRODUCT: f64 = 64.0 * f64::EPSILON;

/// Faces of a polytope by the numbers of their corners; for a polygon, its edges.
pub type Faces = [Vec<usize>];

/// Whether two polytopes that are not rounded overlap or touch. It is slow where they touch, and
/// meant for pairs about which [`Pair::overlap`] cannot tell.
///
/// ```
/// use protomer_kernel::shape::exact::overlap_exactly;
/// use protomer_kernel::shape::separation::{Pair, error_of_heights, pack};
/// let square = pack(&[[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]]);
/// let edges = [vec![0, 1], vec![1, 2], vec![2, 3], vec![3, 0]];
/// let touches = |x: f64| {
///     let (offset, error) = ([x, 0.25], error_of_heights(4.0));
///     let pair = Pair { first: &square, second: &square, offset, reach: 0.0, error };
///     overlap_exactly(&pair, [&edges, &edges])
/// };
/// assert!(touches(1.0) && !touches(1.0 + f64::EPSILON));
/// ```
pub fn overlap_exactly<const D: usize>(pair: &Pair<'_, D>, faces: [&Faces; 2]) -> bool {
    let places = Places::from_pair(pair);
    let sides = [&places.first, &places.second];
    let edges = [0, 1].map(|body: usize| edges_of(sides[body], faces[body]));
    // In a plane the axes are the normals of the edges.
    if D == 2 {
        let mut all = edges[0].iter().chain(&edges[1]);
        return !all.any(|edge| places.are_separated(&[*edge, out_of_plane()]));
    }
    // Faces first: there are fewer of them than pairs of edges.
    for body in [0, 1] {
        let mut triangles = triangles_of(sides[body], faces[body]).into_iter();
        if triangles.any(|sides| places.are_separated(&sides)) {
            return false;
        }
    }
    let mut crosses = edges[0]
        .iter()
        .flat_map(|a| edges[1].iter().map(move |b| [*a, *b]));
    !crosses.any(|sides| places.are_separated(&sides))
}

/// A vector given by its two end points, from one to the other.
type Difference = [Vec3; 2];

/// A difference at right angles to the plane of polygons: its cross product with an edge is at
/// right angles to the edge.
fn out_of_plane() -> Difference {
    [Vec3::zeros(), Vec3::z()]
}

/// Pairs of corners that share a face, each once.
fn edges_of(corners: &[Vec3], faces: &Faces) -> Vec<Difference> {
    let mut pairs = Vec::new();
    for face in faces {
        for (number, a) in face.iter().enumerate() {
            pairs.extend(face[number + 1..].iter().map(|b| [*a.min(b), *a.max(b)]));
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    let edge = |[a, b]: [usize; 2]| [corners[a], corners[b]];
    pairs.into_iter().map(edge).collect()
}

/// Two sides of each triangle of corners that share a face.
fn triangles_of(corners: &[Vec3], faces: &Faces) -> Vec<[Difference; 2]> {
    let mut triangles = Vec::new();
    for face in faces {
        for (i, a) in face.iter().enumerate() {
            for (j, b) in face.iter().enumerate().skip(i + 1) {
                for c in &face[j + 1..] {
                    let side = |to: &usize| [corners[*a], corners[*to]];
                    triangles.push([side(b), side(c)]);
                }
            }
        }
    }
    triangles
}

/// The corners of two bodies, each from the centre of its body.
struct Places {
    first: Vec<Vec3>,
    second: Vec<Vec3>,
    offset: Vec3,
    /// The largest sum of coordinates in a difference of corners.
    size: f64,
}

impl Places {
    fn from_pair<const D: usize>(pair: &Pair<'_, D>) -> Self {
        let mut offset = Vec3::zeros();
        for (axis, x) in pair.offset.iter().enumerate() {
            offset[axis] = *x;
        }
        let (first, second) = (unpack(pair.first), unpack(pair.second));
        let longest = |corners: &[Vec3]| corners.iter().map(Vec3::norm).fold(0.0, f64::max);
        let size = longest(&first) + longest(&second) + offset.norm();
        Self {
            first,
            second,
            offset,
            size,
        }
    }

    /// Whether the cross product of two differences separates the bodies, in either sense.
    fn are_separated(&self, sides: &[Difference; 2]) -> bool {
        // Rounded like any numbers: this axis only filters; near zero the exact one follows.
        let [a, b] = sides.map(|[from, to]| to - from);
        let axis = a.cross(&b);
        let doubt = OF_A_PRODUCT * a.norm() * b.norm() * self.size;
        let heights = |corners: &[Vec3]| {
            let heights = corners.iter().map(|corner| corner.dot(&axis));
            heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], height| {
                [low.min(height), high.max(height)]
            })
        };
        let (first, second) = (heights(&self.first), heights(&self.second));
        let between = self.offset.dot(&axis);
        let gap = f64::max(
            between + second[0] - first[1],
            first[0] - second[1] - between,
        );
        // Beyond the bound on the error the sign is proven.
        if gap.abs() > doubt {
            return gap > 0.0;
        }
        self.are_separated_exactly(sides)
    }

    /// Whether all corners of the second body are strictly on one side of all corners of the first,
    /// decided exactly.
    fn are_separated_exactly(&self, sides: &[Difference; 2]) -> bool {
        let [a, b] = sides.map(|[from, to]| exact_difference(&from, &to));
        let minor = |i: usize, j: usize| a[i].times(&b[j]).minus(&a[j].times(&b[i]));
        let axis = [minor(1, 2), minor(2, 0), minor(0, 1)];
        let mut side = Ordering::Equal;
        for p in &self.first {
            for q in &self.second {
                let mut height = Expansion::default();
                for (axis, component) in axis.iter().enumerate() {
                    let mut apart = Expansion::of_difference(q[axis], p[axis]);
                    // Exact: q - p is an expansion, to which
                    // the offset is added before the product.
                    apart.add(self.offset[axis]);
                    height = height.plus(&apart.times(component));
                }
                let sign = height.sign();
                if sign == Ordering::Equal || (side != Ordering::Equal && sign != side) {
                    return false;
                }
                side = sign;
            }
        }
        side != Ordering::Equal
    }
}

fn exact_difference(from: &Vec3, to: &Vec3) -> [Expansion; 3] {
    [0, 1, 2].map(|axis: usize| Expansion::of_difference(to[axis], from[axis]))
}

/// Corners of packed blocks; the last may come several times.
fn unpack<const D: usize>(blocks: &[Block<D>]) -> Vec<Vec3> {
    let mut corners = Vec::with_capacity(LANES * blocks.len());
    for block in blocks {
        for lane in 0..LANES {
            let mut corner = Vec3::zeros();
            for (axis, lanes) in block.iter().enumerate() {
                corner[axis] = lanes[lane];
            }
            corners.push(corner);
        }
    }
    corners
}
