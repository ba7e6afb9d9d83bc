//! Whether two triangles intersect, exactly.

use crate::Vec3;
use robust::{Coord, Coord3D};

/// The three corners of a triangle, Å.
pub(super) type Triangle = [Vec3; 3];

/// Whether two closed triangles have a point in common, decided exactly for the coordinates given:
/// all signs come from adaptive exact predicates (Shewchuk, Discrete Comput. Geom. 18, 305 (1997)).
///
/// Two triangles in different planes meet if and only if an edge of one meets the other. The test of
/// the six edges also settles coplanar triangles, unless one holds the other; then any corner
/// decides.
pub(super) fn triangles_intersect(first: &Triangle, second: &Triangle) -> bool {
    // Floating-point heights with a bound on their error end nearly all calls before exact signs.
    if clearly_on_one_side(first, second) || clearly_on_one_side(second, first) {
        return false;
    }
    let sides_of_second = sides_of_plane(first, second);
    if on_one_side(sides_of_second) {
        return false;
    }
    let sides_of_first = sides_of_plane(second, first);
    if on_one_side(sides_of_first) {
        return false;
    }
    // In one plane all orientations vanish and decide nothing; the test goes on in a projection.
    if sides_of_second == [0; 3] && sides_of_first == [0; 3] {
        return coplanar_triangles_intersect(first, second);
    }
    // Both ways round: an edge of either may pierce the face of the other.
    an_edge_meets_triangle(second, sides_of_second, first)
        || an_edge_meets_triangle(first, sides_of_first, second)
}

/// Whether a closed segment and a closed triangle have a point in common.
pub(super) fn segment_meets_triangle(p: &Vec3, q: &Vec3, triangle: &Triangle) -> bool {
    let [a, b, c] = triangle;
    match [p, q].map(|point| orientation(a, b, c, point)) {
        [0, 0] => coplanar_segment_meets_triangle(p, q, triangle),
        [side_p, side_q] if side_p == side_q => false,
        // Ends on different sides, or one in the plane:
        // the line meets the plane within the segment.
        _ => line_meets_triangle(p, q, triangle),
    }
}

/// Whether two triangles over one edge lie in one plane and on the same side of the edge.
pub(super) fn are_folded(from: &Vec3, to: &Vec3, first: &Vec3, second: &Vec3) -> bool {
    orientation(from, to, first, second) == 0
        // A shadow without area says nothing, as its turns are zero; any other axis decides.
        && (0..3).any(|axis| {
            let [p, q, a, b] = [from, to, first, second].map(|point| shadow(point, axis));
            turn(p, q, a) * turn(p, q, b) > 0
        })
}

/// Whether all points lie on one side of the plane of a triangle beyond any doubt of rounding: the
/// error of each height is within some tens of roundings of the product of the lengths.
fn clearly_on_one_side([a, b, c]: &Triangle, points: &Triangle) -> bool {
    let normal = (b - a).cross(&(c - a));
    let [p, q, r] = points.each_ref().map(|point| (point - a).dot(&normal));
    let [first, second, third] = points;
    let reach = a.amax() + first.amax().max(second.amax()).max(third.amax());
    let size = (b - a).amax() * (c - a).amax();
    // Far wider than the error, at little cost: what is in doubt goes to the exact signs.
    let doubt = 1e-13 * reach * size;
    (p > doubt && q > doubt && r > doubt) || (p < -doubt && q < -doubt && r < -doubt)
}

/// Sign of the orientation of (a, b, c, d): on which side of the plane (a, b, c) the point d lies.
pub(super) fn orientation(a: &Vec3, b: &Vec3, c: &Vec3, d: &Vec3) -> i8 {
    let [a, b, c, d] = [a, b, c, d].map(coordinates);
    sign(robust::orient3d(a, b, c, d))
}

fn coordinates(point: &Vec3) -> Coord3D<f64> {
    Coord3D {
        x: point.x,
        y: point.y,
        z: point.z,
    }
}

fn sides_of_plane([a, b, c]: &Triangle, points: &Triangle) -> [i8; 3] {
    points.each_ref().map(|point| orientation(a, b, c, point))
}

fn on_one_side(sides: [i8; 3]) -> bool {
    sides == [1; 3] || sides == [-1; 3]
}

/// Whether an edge of a triangle meets another triangle; `sides` are the sides of the other's plane
/// on which the corners lie.
fn an_edge_meets_triangle(owner: &Triangle, sides: [i8; 3], other: &Triangle) -> bool {
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let (p, q) = (&owner[i], &owner[j]);
        let meets = match (sides[i], sides[j]) {
            // Both in the plane: no single crossing point, the segment itself is compared.
            (0, 0) => coplanar_segment_meets_triangle(p, q, other),
            (side_p, side_q) if side_p == side_q => false,
            _ => line_meets_triangle(p, q, other),
        };
        if meets {
            return true;
        }
    }
    false
}

/// Whether the line through p and q, which crosses or touches the triangle's plane in one point,
/// passes through the closed triangle: the three edges are not on different sides of it.
fn line_meets_triangle(p: &Vec3, q: &Vec3, [a, b, c]: &Triangle) -> bool {
    let turns = [
        orientation(p, q, a, b),
        orientation(p, q, b, c),
        orientation(p, q, c, a),
    ];
    // Zeros are allowed: the line then passes through an edge or a corner of the closed triangle.
    !(turns.contains(&1) && turns.contains(&-1))
}

fn coplanar_triangles_intersect(first: &Triangle, second: &Triangle) -> bool {
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        if coplanar_segment_meets_triangle(&second[i], &second[j], first)
            || coplanar_segment_meets_triangle(&first[i], &first[j], second)
        {
            return true;
        }
    }
    false
}

/// Whether a closed segment and a closed triangle in one plane meet. A triangle without area does
/// not count here: all its points lie on edges of its neighbours.
fn coplanar_segment_meets_triangle(p: &Vec3, q: &Vec3, triangle: &Triangle) -> bool {
    for axis in 0..3 {
        let [a, b, c] = triangle.each_ref().map(|corner| shadow(corner, axis));
        // A projection along which the triangle keeps an area keeps all incidences of its plane.
        if turn(a, b, c) != 0 {
            return segment_meets_shadow(shadow(p, axis), shadow(q, axis), [a, b, c]);
        }
    }
    false
}

/// Variant of [`coplanar_segment_meets_triangle`] for shadows in a plane.
fn segment_meets_shadow(p: Coord<f64>, q: Coord<f64>, [a, b, c]: [Coord<f64>; 3]) -> bool {
    let turns = [turn(a, b, p), turn(b, c, p), turn(c, a, p)];
    let starts_inside = !(turns.contains(&1) && turns.contains(&-1));
    starts_inside
        || segments_meet(p, q, a, b)
        || segments_meet(p, q, b, c)
        || segments_meet(p, q, c, a)
}

fn segments_meet(p: Coord<f64>, q: Coord<f64>, a: Coord<f64>, b: Coord<f64>) -> bool {
    let turns = [turn(p, q, a), turn(p, q, b), turn(a, b, p), turn(a, b, q)];
    // All four on one line, where turns say nothing. Both axes, as the line may be upright.
    if turns == [0; 4] {
        return ranges_meet([p.x, q.x], [a.x, b.x]) && ranges_meet([p.y, q.y], [a.y, b.y]);
    }
    turns[0] * turns[1] <= 0 && turns[2] * turns[3] <= 0
}

/// Whether two closed ranges, each given by its ends in either order, have a number in common.
fn ranges_meet([p, q]: [f64; 2], [a, b]: [f64; 2]) -> bool {
    p.max(q) >= a.min(b) && a.max(b) >= p.min(q)
}

/// The shadow of a point along a coordinate axis.
fn shadow(point: &Vec3, axis: usize) -> Coord<f64> {
    Coord {
        x: point[(axis + 1) % 3],
        y: point[(axis + 2) % 3],
    }
}

/// Sign of the turn from a over b to c.
fn turn(a: Coord<f64>, b: Coord<f64>, c: Coord<f64>) -> i8 {
    sign(robust::orient2d(a, b, c))
}

fn sign(value: f64) -> i8 {
    (value > 0.0) as i8 - (value < 0.0) as i8
}
