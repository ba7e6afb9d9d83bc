//! Whether polygons and meshes are convex, so that their hull is the body that was drawn.
//!
//! Of a convex body the volume inside the faces is that of the hull of the corners, and of a polygon no corner
//! lies inside the hull. Both are held to [`TOLERANCE`], which is more than coordinates with five digits lose.

use super::hull::Hull;
use super::measures::of_hull;
use super::{Shape, require_finite};
use crate::{KernelError, Result, TriangleMesh, Vec3};

/// Largest part of its volume that a convex mesh lacks in its hull, and largest depth of a corner of a convex
/// polygon inside its hull, as a part of the size of the polygon.
pub const TOLERANCE: f64 = 1e-4;

impl Shape {
    /// A convex polygon by its corners, in any order.
    ///
    /// # Errors
    /// As [`Shape::flat`]; also [`KernelError::NotConvex`] for a point inside the hull of the others, as every
    /// concave polygon has one.
    ///
    /// ```
    /// use protomer_kernel::shape::Shape;
    /// let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
    /// assert!(Shape::polygon(&corners).is_ok());
    /// let dart = [[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]];
    /// assert!(Shape::polygon(&dart).is_err());
    /// ```
    pub fn polygon(points: &[[f64; 2]]) -> Result<Self> {
        let shape = Self::flat(points)?;
        if let Shape::Flat(corners) = &shape
            && let Some((number, [x, y])) = point_inside(points, corners)
        {
            return Err(KernelError::NotConvex(format!(
                "point {} ({x}, {y}) lies inside the hull of the others",
                number + 1
            )));
        }
        Ok(shape)
    }

    /// A convex polyhedron by its faces. A mesh without faces is the hull of its vertices, and one whose vertices
    /// lie in a plane is a thin polygon.
    ///
    /// # Errors
    /// As [`Shape::solid`]; also [`KernelError::NotConvex`] for faces that do not enclose the volume of the hull of
    /// their corners (of thin polygons: do not cover its area).
    ///
    /// ```
    /// use protomer_kernel::TriangleMesh;
    /// use protomer_kernel::Vec3;
    /// use protomer_kernel::shape::Shape;
    /// let mut mesh = TriangleMesh {
    ///     vertices: vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()],
    ///     triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    /// };
    /// assert!(Shape::mesh(&mesh).is_ok());
    /// mesh.triangles.pop();
    /// assert!(Shape::mesh(&mesh).is_err(), "it is open");
    /// ```
    pub fn mesh(mesh: &TriangleMesh) -> Result<Self> {
        if mesh.triangles.is_empty() {
            return Self::solid(&mesh.vertices);
        }
        let numbers: Vec<f64> = mesh.vertices.iter().flat_map(|x| [x.x, x.y, x.z]).collect();
        require_finite(&numbers)?;
        let hull = Hull::from_points(&vertices_of_faces(mesh));
        match hull {
            Hull::Polyhedron(_) => require_volume_of(&hull, mesh)?,
            Hull::Polygon(_) => require_area_of(&hull, mesh)?,
            Hull::Point(_) | Hull::Segment(_) => {}
        }
        Ok(Shape::Solid(hull))
    }
}

/// The vertices that faces have, in their order.
fn vertices_of_faces(mesh: &TriangleMesh) -> Vec<Vec3> {
    // Stray vertices are no part of the body, so they must not enlarge the hull.
    let mut is_corner = vec![false; mesh.vertices.len()];
    for corner in mesh.triangles.as_flattened() {
        is_corner[*corner as usize] = true;
    }
    let vertices = mesh.vertices.iter().zip(is_corner);
    vertices
        .filter_map(|(vertex, is_corner)| is_corner.then_some(*vertex))
        .collect()
}

/// The first point that lies inside a convex polygon.
fn point_inside(points: &[[f64; 2]], corners: &[[f64; 2]]) -> Option<(usize, [f64; 2])> {
    if corners.len() < 3 {
        return None;
    }
    let distance = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let size = corners
        .iter()
        .map(|corner| distance(corner, &corners[0]))
        .fold(0.0, f64::max);
    let depth = |point: &[f64; 2]| {
        let edges = corners.iter().zip(corners.iter().cycle().skip(1));
        let heights = edges.map(|(a, b)| {
            let twice_area = (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0]);
            twice_area / distance(a, b)
        });
        heights.fold(f64::INFINITY, f64::min)
    };
    let mut numbered = points.iter().copied().enumerate();
    numbered.find(|(_, point)| depth(point) > TOLERANCE * size)
}

/// The sum over the faces of area times normal: zero for a closed mesh.
fn area_vector(mesh: &TriangleMesh) -> Vec3 {
    let vectors = (0..mesh.triangles.len()).map(|triangle| {
        let [a, b, c] = mesh.corners(triangle);
        0.5 * (b - a).cross(&(c - a))
    });
    vectors.sum()
}

fn require_volume_of(hull: &Hull, mesh: &TriangleMesh) -> Result<()> {
    // A closed mesh has no area vector; a hole or a flipped triangle leaves one.
    let gap = area_vector(mesh).norm();
    if gap > TOLERANCE * mesh.area_angstrom2() {
        return Err(KernelError::NotConvex(
            "its faces do not close, or do not all look outward, so that it has no inside".into(),
        ));
    }
    let (mesh_volume, of_hull) = (mesh.volume_angstrom3().abs(), of_hull(hull, 0.0).volume);
    require_equal("volume inside its faces", mesh_volume, of_hull)
}

/// Checks the area of a thin polygon, which has one side or two.
fn require_area_of(hull: &Hull, mesh: &TriangleMesh) -> Result<()> {
    // A sheet drawn on one side has an area vector; one drawn
    // on both sides cancels, and half of its area counts.
    let mesh_area = area_vector(mesh).norm().max(0.5 * mesh.area_angstrom2());
    require_equal(
        "area of its faces",
        mesh_area,
        0.5 * of_hull(hull, 0.0).surface,
    )
}

fn require_equal(quantity: &str, of_mesh: f64, of_hull: f64) -> Result<()> {
    if (of_mesh - of_hull).abs() <= TOLERANCE * of_hull {
        return Ok(());
    }
    Err(KernelError::NotConvex(format!(
        "the {quantity} is {of_mesh:.6}, that of its convex hull {of_hull:.6}"
    )))
}

#[cfg(test)]
mod tests {
    use super::super::builders::by_name;
    use super::*;
    use crate::random::CounterRng;

    /// A prism over a polygon whose caps are fans about the first corner.
    fn prism(polygon: &[[f64; 2]], height: f64) -> TriangleMesh {
        let count = polygon.len() as u32;
        let level = |z: f64| polygon.iter().map(move |[x, y]| Vec3::new(*x, *y, z));
        let mut triangles = Vec::new();
        for i in 1..count - 1 {
            triangles.extend([[0, i + 1, i], [count, count + i, count + i + 1]]);
        }
        for i in 0..count {
            let next = (i + 1) % count;
            triangles.extend([[i, next, count + next], [i, count + next, count + i]]);
        }
        TriangleMesh {
            vertices: level(0.0).chain(level(height)).collect(),
            triangles,
        }
    }

    const ELL: [[f64; 2]; 6] = [
        [0.0, 0.0],
        [2.0, 0.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [0.0, 2.0],
    ];

    #[test]
    fn an_ell_is_refused_with_both_volumes() {
        let words = Shape::mesh(&prism(&ELL, 1.0)).unwrap_err().to_string();
        assert!(
            words.contains("3.000000") && words.contains("3.500000"),
            "{words}"
        );
        let words = Shape::polygon(&ELL).unwrap_err().to_string();
        assert!(words.contains("point 4 (1, 1)"), "{words}");
        // Without its faces it is the hull of its vertices.
        let cloud = TriangleMesh {
            triangles: Vec::new(),
            ..prism(&ELL, 1.0)
        };
        assert_eq!(Shape::mesh(&cloud).unwrap().corners(), 10);
        let sheet = TriangleMesh {
            vertices: ELL.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]],
        };
        let words = Shape::mesh(&sheet).unwrap_err().to_string();
        assert!(words.contains("area"), "{words}");
    }

    #[test]
    fn faces_may_be_concave_where_all_corners_are_those_of_the_hull() {
        // The polyhedron of Schönhardt: a twisted prism that folds inward along three diagonals.
        let corner = |i: usize, turn: f64, z: f64| {
            let angle = turn + 2.0 * std::f64::consts::PI * i as f64 / 3.0;
            Vec3::new(angle.cos(), angle.sin(), z)
        };
        let mut mesh = TriangleMesh {
            vertices: (0..6)
                .map(|i| corner(i % 3, if i < 3 { 0.0 } else { 0.5 }, (i / 3) as f64))
                .collect(),
            triangles: vec![[0, 2, 1], [3, 4, 5]],
        };
        let twisted = |inward: bool| {
            (0..3u32).flat_map(move |i| {
                let (a, b, c, d) = (i, (i + 1) % 3, 3 + (i + 1) % 3, 3 + i);
                match inward {
                    true => [[a, b, c], [a, c, d]],
                    false => [[a, b, d], [b, c, d]],
                }
            })
        };
        let caps = mesh.triangles.clone();
        mesh.triangles.extend(twisted(true));
        assert_eq!(Hull::from_points(&mesh.vertices).corners().len(), 6);
        let first = Shape::mesh(&mesh).is_ok();
        mesh.triangles = caps;
        mesh.triangles.extend(twisted(false));
        assert_ne!(
            first,
            Shape::mesh(&mesh).is_ok(),
            "one diagonal folds in, the other out"
        );
    }

    #[test]
    fn convex_meshes_pass_whatever_their_place_their_size_and_their_digits() {
        let mut rng = CounterRng::new(5, 0, 0);
        for name in [
            "cube",
            "dodecahedron",
            "truncated-octahedron",
            "cuboid:1,2,30",
        ] {
            let Shape::Solid(Hull::Polyhedron(mesh)) = by_name(name).unwrap() else {
                unreachable!("{name}")
            };
            for scale in [1e-3, 1.0, 1e5] {
                let (turn, shift) = (rng.rotation(), 10.0 * scale * rng.unit_vector());
                let digits = |x: f64| (x / scale * 1e5).round() * scale / 1e5;
                let place = |x: &Vec3| (scale * (turn * x) + shift).map(digits);
                let mut moved = mesh.clone();
                moved.vertices = mesh.vertices.iter().map(place).collect();
                assert!(Shape::mesh(&moved).is_ok(), "{name} {scale}");
                for triangle in &mut moved.triangles {
                    triangle.swap(0, 1);
                }
                assert!(Shape::mesh(&moved).is_ok(), "{name}, inside out");
                // A vertex that no face has is no part of the body.
                moved.vertices.push(Vec3::repeat(100.0 * scale));
                assert!(Shape::mesh(&moved).is_ok(), "{name}, with a stray vertex");
            }
        }
        let (points, mut order) = ([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], Vec::new());
        order.extend([
            points[2],
            points[0],
            points[3],
            points[1],
            [0.333_33, 1.0],
            [0.5, 1e-6],
        ]);
        assert!(
            Shape::polygon(&order).is_ok(),
            "any order, and points on edges"
        );
    }
}
