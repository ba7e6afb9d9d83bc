//! How far two triangles are apart.

use super::triangle::Triangle;
use crate::Vec3;

/// A lower bound on the distance of two triangles: the widest gap between their shadows on an axis,
/// over the two normals, the nine cross products of edges and the line between the centres. It is not
/// above zero if they intersect.
pub(super) fn separation_along_axes(first: &Triangle, second: &Triangle) -> f64 {
    let (e, f) = (edges(first), edges(second));
    // Three times the vector between the centres; only its direction counts.
    let between_centres = second.iter().sum::<Vec3>() - first.iter().sum::<Vec3>();
    let mut widest = f64::MIN;
    for axis in [e[0].cross(&e[1]), f[0].cross(&f[1]), between_centres] {
        widest = widest.max(separation_along(&axis, first, second));
    }
    for u in &e {
        for v in &f {
            widest = widest.max(separation_along(&u.cross(v), first, second));
        }
    }
    widest
}

fn edges([a, b, c]: &Triangle) -> [Vec3; 3] {
    [b - a, c - b, a - c]
}

fn separation_along(axis: &Vec3, first: &Triangle, second: &Triangle) -> f64 {
    let squared = axis.norm_squared();
    // Parallel edges give no axis. The others decide, so a small axis is left out, not normalised.
    if squared < 1e-20 {
        return f64::MIN;
    }
    let (low1, high1) = shadow(first, axis);
    let (low2, high2) = shadow(second, axis);
    (low2 - high1).max(low1 - high2) / squared.sqrt()
}

/// The ends of the shadow of a triangle on an axis, in lengths of the axis.
fn shadow([a, b, c]: &Triangle, axis: &Vec3) -> (f64, f64) {
    let (a, b, c) = (a.dot(axis), b.dot(axis), c.dot(axis));
    (a.min(b).min(c), a.max(b).max(c))
}

/// Distance of two triangles that do not intersect, Å: the least over the nine pairs of edges and
/// the six pairs of a corner and the other triangle.
pub(super) fn triangle_distance(first: &Triangle, second: &Triangle) -> f64 {
    let mut least = f64::MAX;
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        for (k, l) in [(0, 1), (1, 2), (2, 0)] {
            let edges = ((first[i], first[j]), (second[k], second[l]));
            least = least.min(segment_distance_squared(edges.0, edges.1));
        }
    }
    for i in 0..3 {
        least = least.min(corner_distance_squared(&first[i], second));
        least = least.min(corner_distance_squared(&second[i], first));
    }
    least.sqrt()
}

/// Squared distance from a point to the plane of a triangle if the foot lies in the triangle;
/// infinite otherwise, where an edge is nearer.
fn corner_distance_squared(point: &Vec3, [a, b, c]: &Triangle) -> f64 {
    let normal = (b - a).cross(&(c - a));
    for (from, to) in [(a, b), (b, c), (c, a)] {
        // The foot lies inside if it is on the inner side of all three edges.
        let is_inside = (to - from).cross(&(point - from)).dot(&normal) >= 0.0;
        if !is_inside {
            return f64::INFINITY;
        }
    }
    if normal.norm_squared() > 0.0 {
        (point - a).dot(&normal).powi(2) / normal.norm_squared()
    } else {
        f64::INFINITY
    }
}

/// Squared distance between the segments pq and ab, by clamping the closest points of their lines.
fn segment_distance_squared((p, q): (Vec3, Vec3), (a, b): (Vec3, Vec3)) -> f64 {
    let (u, v, w) = (q - p, b - a, p - a);
    let (uu, uv, vv) = (u.norm_squared(), u.dot(&v), v.norm_squared());
    let (uw, vw) = (u.dot(&w), v.dot(&w));
    // Parallel segments have the divisor zero and begin at p; the next two lines still find the
    // nearest points, as one clamp follows the other
    // (Ericson, Real-Time Collision Detection, 5.1.9).
    let along_first = part(uv * vw - vv * uw, uu * vv - uv * uv);
    let along_second = part(uv * along_first + vw, vv);
    let along_first = part(uv * along_second - uw, uu);
    (w + u * along_first - v * along_second).norm_squared()
}

/// A quotient clamped to 0..1; zero if the divisor is not positive.
fn part(above: f64, below: f64) -> f64 {
    if below > 0.0 {
        (above / below).clamp(0.0, 1.0)
    } else {
        0.0
    }
}
