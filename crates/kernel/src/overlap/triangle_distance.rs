//! How far two triangles are apart.

use super::triangle::Triangle;
use crate::Vec3;

/// A lower bound on the distance of two triangles: the widest gap between their shadows on a
/// separating axis, over the two normals, the nine cross products of edges and the line between the
/// centres. Not above zero if they intersect.
pub(super) fn separation_along_axes(first: &Triangle, second: &Triangle) -> f64 {
    let edges = |t: &Triangle| [t[1] - t[0], t[2] - t[1], t[0] - t[2]];
    let (e, f) = (edges(first), edges(second));
    let centres: Vec3 = second.iter().sum::<Vec3>() - first.iter().sum::<Vec3>();
    let simple = [e[0].cross(&e[1]), f[0].cross(&f[1]), centres];
    let crossed = e.iter().flat_map(|u| f.iter().map(|v| u.cross(v)));
    simple
        .into_iter()
        .chain(crossed)
        .map(|axis| separation_along(&axis, first, second))
        .fold(f64::MIN, f64::max)
}

fn separation_along(axis: &Vec3, first: &Triangle, second: &Triangle) -> f64 {
    let squared = axis.norm_squared();
    if squared < 1e-20 {
        return f64::MIN;
    }
    let shadow = |t: &Triangle| {
        let [a, b, c] = t.each_ref().map(|corner| corner.dot(axis));
        (a.min(b).min(c), a.max(b).max(c))
    };
    let ((low1, high1), (low2, high2)) = (shadow(first), shadow(second));
    (low2 - high1).max(low1 - high2) / squared.sqrt()
}

/// Distance of two triangles that do not intersect, Å: the least over the nine pairs of edges and
/// the six pairs of a corner and the other triangle.
pub(super) fn triangle_distance(first: &Triangle, second: &Triangle) -> f64 {
    let edge = |t: &Triangle, i: usize| (t[i], t[(i + 1) % 3]);
    let edges = (0..9).map(|k| segment_distance_squared(edge(first, k / 3), edge(second, k % 3)));
    let corners = (0..3).map(|i| {
        corner_distance_squared(&first[i], second).min(corner_distance_squared(&second[i], first))
    });
    edges.chain(corners).fold(f64::MAX, f64::min).sqrt()
}

/// Squared distance from a point to the plane of a triangle where its foot lies in the triangle,
/// else infinite: the edges answer for the rest.
fn corner_distance_squared(point: &Vec3, [a, b, c]: &Triangle) -> f64 {
    let normal = (b - a).cross(&(c - a));
    let inside = |from: &Vec3, to: &Vec3| (to - from).cross(&(point - from)).dot(&normal) >= 0.0;
    if inside(a, b) && inside(b, c) && inside(c, a) && normal.norm_squared() > 0.0 {
        (point - a).dot(&normal).powi(2) / normal.norm_squared()
    } else {
        f64::INFINITY
    }
}

/// Squared distance of the segments pq and ab, by clamping the closest points of their lines.
fn segment_distance_squared((p, q): (Vec3, Vec3), (a, b): (Vec3, Vec3)) -> f64 {
    let (u, v, w) = (q - p, b - a, p - a);
    let (uu, uv, vv, uw, vw) = (
        u.norm_squared(),
        u.dot(&v),
        v.norm_squared(),
        u.dot(&w),
        v.dot(&w),
    );
    let ratio = |above: f64, below: f64| {
        if below > 0.0 {
            (above / below).clamp(0.0, 1.0)
        } else {
            0.0
        }
    };
    let along_first = ratio(uv * vw - vv * uw, uu * vv - uv * uv);
    let along_second = ratio(uv * along_first + vw, vv);
    let along_first = ratio(uv * along_second - uw, uu);
    (w + u * along_first - v * along_second).norm_squared()
}
