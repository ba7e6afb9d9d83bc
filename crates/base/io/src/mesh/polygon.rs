//! Polygons to triangles.

use protomer_kernel::Vec3;

/// Triangulates a polygon by cutting off ears, keeping its orientation; a polygon with n corners
/// gives n - 2 triangles.
///
/// An ear is a corner whose triangle is convex with respect to the polygon's normal and holds no
/// other corner. Where no ear exists (self-intersecting or flat polygons) the first corner is cut,
/// so that the boundary edges are always used exactly once and closed meshes stay closed.
pub(super) fn triangulate(vertices: &[Vec3], corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let mut remaining = corners.to_vec();
    let normal = newell_normal(vertices, corners);
    while remaining.len() > 3 {
        let is_ear = |middle: &usize| is_ear(vertices, &remaining, *middle, &normal);
        // A polygon that crosses itself may have no ear; cutting any corner still ends.
        let ear = (0..remaining.len()).find(is_ear).unwrap_or(0);
        triangles.push(around(&remaining, ear));
        remaining.remove(ear);
    }
    if let [a, b, c] = remaining[..] {
        triangles.push([a, b, c]);
    }
}

/// A corner between its neighbours.
fn around(corners: &[u32], middle: usize) -> [u32; 3] {
    let count = corners.len();
    [
        corners[(middle + count - 1) % count],
        corners[middle],
        corners[(middle + 1) % count],
    ]
}

/// Newell's normal, Σ (pᵢ - p₀) × (pᵢ₊₁ - p₀): twice the vector area, defined for polygons that are
/// not quite planar.
fn newell_normal(vertices: &[Vec3], corners: &[u32]) -> Vec3 {
    let vertex = |corner: u32| vertices[corner as usize];
    let mut normal = Vec3::zeros();
    if let [first, others @ ..] = corners {
        // Relative to the first corner: far from the origin the products would cancel.
        for side in others.windows(2) {
            normal += (vertex(side[0]) - vertex(*first)).cross(&(vertex(side[1]) - vertex(*first)));
        }
    }
    normal
}

fn is_ear(vertices: &[Vec3], remaining: &[u32], middle: usize, normal: &Vec3) -> bool {
    let corners = around(remaining, middle);
    let [a, b, c] = corners.map(|corner| vertices[corner as usize]);
    let turn =
        // Seen along the polygon's own normal, so the test works in any plane.
        |from: &Vec3, to: &Vec3, point: &Vec3| (to - from).cross(&(point - from)).dot(normal);
    let is_convex = turn(&a, &b, &c) > 0.0;
    if !is_convex {
        return false;
    }
    for corner in remaining {
        let point = &vertices[*corner as usize];
        // Points on an edge count as inside: an ear over them would overlap what is left.
        let is_inside = [(&a, &b), (&b, &c), (&c, &a)]
            .into_iter()
            .all(|(from, to)| turn(from, to, point) >= 0.0);
        if is_inside && !corners.contains(corner) {
            return false;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(vertices: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
        triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| vertices[v as usize]);
                0.5 * (b - a).cross(&(c - a)).z
            })
            .sum()
    }

    #[test]
    fn a_concave_polygon_keeps_its_area_with_no_triangle_folded_over() {
        // An arrow head: a fan from the first corner would fold over the notch.
        let vertices =
            [[0.0, 0.0], [4.0, 2.0], [0.0, 4.0], [1.0, 2.0]].map(|[x, y]| Vec3::new(x, y, 1.0));
        for start in 0..4 {
            let corners: Vec<u32> = (0..4).map(|i| (i + start) % 4).collect();
            let mut triangles = Vec::new();
            triangulate(&vertices, &corners, &mut triangles);
            assert_eq!(triangles.len(), 2);
            assert!(
                triangles.iter().all(|t| area(&vertices, &[*t]) > 0.0),
                "start {start}: {triangles:?}"
            );
            assert!((area(&vertices, &triangles) - 6.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_star_is_triangulated_inside() {
        let vertices: Vec<Vec3> = (0..10)
            .map(|i| {
                let (angle, radius) = (
                    i as f64 * std::f64::consts::PI / 5.0,
                    if i % 2 == 0 { 2.0 } else { 0.5 },
                );
                Vec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
            })
            .collect();
        let shoelace: f64 = (0..10)
            .map(|i| (vertices[i], vertices[(i + 1) % 10]))
            .map(|(p, q)| 0.5 * (p.x * q.y - q.x * p.y))
            .sum();
        let mut triangles = Vec::new();
        triangulate(&vertices, &(0..10).collect::<Vec<_>>(), &mut triangles);
        assert!(triangles.iter().all(|t| area(&vertices, &[*t]) > 0.0));
        assert!((area(&vertices, &triangles) - shoelace).abs() < 1e-12);
    }

    #[test]
    fn a_flat_polygon_still_gives_a_triangle_per_corner_but_two() {
        let vertices: Vec<Vec3> = (0..6).map(|i| Vec3::new(i as f64, 0.0, 0.0)).collect();
        let mut triangles = Vec::new();
        triangulate(&vertices, &[0, 1, 2, 3, 4, 5], &mut triangles);
        assert_eq!(triangles.len(), 4);
    }
}
