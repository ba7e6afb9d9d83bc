//! A convex polygon or polyhedron about its centroid, with its faces and edges.
//!
//! A face of a polygon is an edge. Triangles of the hull that lie in one plane are one face.

use super::Shape;
use super::hull::Hull;
use crate::{KernelError, Pose, Result, TriangleMesh, Vec3};
use std::collections::{BTreeMap, HashMap};

/// Length of the cross product of normals below which they belong to one face.
const ONE_FACE: f64 = 1e-9;

/// A convex polygon (its corners in the plane z = 0) or polyhedron; its centroid is at the origin.
///
/// ```
/// use protomer_kernel::shape::{builders, polytope::Polytope};
/// let cube = Polytope::from_shape(&builders::by_name("cube")?)?;
/// assert_eq!((cube.corners.len(), cube.edges.len(), cube.faces.len()), (8, 12, 6));
/// assert!((cube.inradius() - 0.5).abs() < 1e-12);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Polytope {
    /// Number of dimensions, 2 or 3.
    pub dimension: usize,
    /// The corners, from the centroid.
    pub corners: Vec<Vec3>,
    /// The edges of a polyhedron, as pairs of corners; a polygon's edges are its faces.
    pub edges: Vec<[usize; 2]>,
    /// The faces.
    pub faces: Vec<Face>,
}

/// A face of a polyhedron, or an edge of a polygon.
///
/// ```
/// use protomer_kernel::shape::{builders::by_name, polytope::Polytope};
/// let cuboid = Polytope::from_shape(&by_name("cuboid:2,4,6")?)?;
/// let mut offsets: Vec<f64> = cuboid.faces.iter().map(|face| face.offset).collect();
/// offsets.sort_by(f64::total_cmp);
/// assert!((offsets[0] - 1.0).abs() < 1e-12 && (offsets[5] - 3.0).abs() < 1e-12);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// Corners of the face, counter-clockwise from outside.
    pub corners: Vec<usize>,
    /// Outward normal of the face, of length one.
    pub normal: Vec3,
    /// Distance of the plane of the face from the centroid.
    pub offset: f64,
}

impl Polytope {
    /// The polytope that is the hull of points.
    ///
    /// ```
    /// use protomer_kernel::shape::{Shape, builders::by_name, polytope::Polytope};
    /// let cube = Polytope::from_shape(&by_name("cube")?)?;
    /// assert_eq!((cube.corners.len(), cube.edges.len(), cube.faces.len()), (8, 12, 6));
    /// assert!(Polytope::from_shape(&Shape::flat(&[[0.0, 0.0], [1.0, 0.0]])?).is_err(), "a segment has no area");
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// [`KernelError::BadShape`] for a shape without area or volume.
    pub fn from_shape(shape: &Shape) -> Result<Self> {
        match shape {
            Shape::Flat(corners) if corners.len() > 2 => Ok(Self::of_polygon(corners)),
            Shape::Solid(Hull::Polyhedron(mesh)) => Ok(Self::of_mesh(mesh)),
            _ => Err(KernelError::BadShape(
                "its points lie in a plane, on a line or in one place, so it has no faces; add \
                 points"
                    .into(),
            )),
        }
    }

    /// The polytope of a shape, and the position of its centroid in the shape.
    ///
    /// ```
    /// use protomer_kernel::shape::{Shape, polytope::Polytope};
    /// use protomer_kernel::Vec3;
    /// let square = Shape::flat(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])?;
    /// let (polytope, centroid) = Polytope::placed(&square)?;
    /// assert!((centroid - Vec3::new(1.0, 1.0, 0.0)).norm() < 1e-12);
    /// assert!((polytope.corners[0].norm() - 2.0_f64.sqrt()).abs() < 1e-12);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Polytope::from_shape`].
    pub fn placed(shape: &Shape) -> Result<(Self, Vec3)> {
        let polytope = Self::from_shape(shape)?;
        let centroid = shape.corner_points()[0] - polytope.corners[0];
        Ok((polytope, centroid))
    }

    fn of_polygon(corners: &[[f64; 2]]) -> Self {
        let centroid = centroid_of_polygon(corners);
        let relative_corner = |[x, y]: &[f64; 2]| Vec3::new(*x, *y, 0.0) - centroid;
        let corners: Vec<Vec3> = corners.iter().map(relative_corner).collect();
        let mut faces = Vec::new();
        for from in 0..corners.len() {
            let to = (from + 1) % corners.len();
            let edge = corners[to] - corners[from];
            // Counter-clockwise corners: the edge turned by -90 degrees points outwards.
            let normal = Vec3::new(edge.y, -edge.x, 0.0).normalize();
            faces.push(Face {
                offset: normal.dot(&corners[from]),
                normal,
                corners: vec![from, to],
            });
        }
        Self {
            dimension: 2,
            corners,
            edges: Vec::new(),
            faces,
        }
    }

    fn of_mesh(mesh: &TriangleMesh) -> Self {
        let centroid = centroid_of_mesh(mesh);
        let corners: Vec<Vec3> = mesh.vertices.iter().map(|x| x - centroid).collect();
        let mut faces = Vec::new();
        for triangles in coplanar(mesh) {
            let rim = rim(mesh, &triangles);
            let normal = normal(mesh, triangles[0]);
            faces.push(Face {
                offset: normal.dot(&corners[rim[0]]),
                normal,
                corners: rim,
            });
        }
        let mut edges = Vec::new();
        for face in &faces {
            let next = face.corners.iter().cycle().skip(1);
            for (from, to) in face.corners.iter().zip(next) {
                // Every edge belongs to two faces, in opposite
                // directions; one of them has from < to.
                if from < to {
                    edges.push([*from, *to]);
                }
            }
        }
        Self {
            dimension: 3,
            corners,
            edges,
            faces,
        }
    }

    /// The radius of the largest ball about the centroid that fits in.
    ///
    /// ```
    /// use protomer_kernel::shape::{builders::by_name, polytope::Polytope};
    /// let cuboid = Polytope::from_shape(&by_name("cuboid:2,4,6")?)?;
    /// assert!((cuboid.inradius() - 1.0).abs() < 1e-12, "half of the shortest edge");
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn inradius(&self) -> f64 {
        let offsets = self.faces.iter().map(|face| face.offset);
        offsets.fold(f64::INFINITY, f64::min)
    }

    /// The radius of the smallest ball about the centroid that holds the polytope.
    ///
    /// ```
    /// use protomer_kernel::shape::{builders::by_name, polytope::Polytope};
    /// let cuboid = Polytope::from_shape(&by_name("cuboid:2,4,4")?)?;
    /// assert!((cuboid.circumradius() - 3.0).abs() < 1e-12);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn circumradius(&self) -> f64 {
        self.corners.iter().map(Vec3::norm).fold(0.0, f64::max)
    }

    /// The corners in a pose.
    ///
    /// ```
    /// use protomer_kernel::shape::{builders::by_name, polytope::Polytope};
    /// use protomer_kernel::{Pose, Vec3};
    /// let cube = Polytope::from_shape(&by_name("cuboid:2,2,2")?)?;
    /// let pose = Pose { position: Vec3::new(10.0, 0.0, 0.0), ..Pose::identity() };
    /// assert!(cube.corners_at(&pose).iter().all(|corner| (corner.x - 10.0).abs() < 1.0 + 1e-12));
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn corners_at(&self, pose: &Pose) -> Vec<Vec3> {
        let transform = |corner| pose.transform_point(corner);
        self.corners.iter().map(transform).collect()
    }

    /// The face through which a ray from the centroid leaves the body; the direction is in the
    /// frame of the body.
    ///
    /// ```
    /// use protomer_kernel::shape::{builders::by_name, polytope::Polytope};
    /// use protomer_kernel::Vec3;
    /// let cuboid = Polytope::from_shape(&by_name("cuboid:2,4,6")?)?;
    /// let face = cuboid.face_towards(&Vec3::new(1.0, 1.0, 1.0));
    /// assert!((face.normal - Vec3::x()).norm() < 1e-12, "the nearest face is met first");
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn face_towards(&self, direction: &Vec3) -> &Face {
        let mut best = (&self.faces[0], f64::NEG_INFINITY);
        for face in &self.faces {
            // The plane n·x = h is met at t = h/(n·d), so the
            // largest inverse is met first; h > 0 seen from the centroid.
            let inverse_length = face.normal.dot(direction) / face.offset;
            if inverse_length > best.1 {
                best = (face, inverse_length);
            }
        }
        best.0
    }
}

fn centroid_of_polygon(corners: &[[f64; 2]]) -> Vec3 {
    let (mut area, mut moment) = (0.0, [0.0; 2]);
    // Relative to a corner: far from the origin, products of coordinates would cancel.
    let origin = corners[0];
    for pair in corners.windows(2) {
        let [a, b] = [pair[0], pair[1]].map(|x| [x[0] - origin[0], x[1] - origin[1]]);
        let twice = a[0] * b[1] - a[1] * b[0];
        area += twice;
        for axis in 0..2 {
            moment[axis] += twice * (a[axis] + b[axis]) / 3.0;
        }
    }
    let [x, y] = moment.map(|moment| moment / area);
    Vec3::new(origin[0] + x, origin[1] + y, 0.0)
}

fn centroid_of_mesh(mesh: &TriangleMesh) -> Vec3 {
    let origin = mesh.vertices[0];
    let (mut volume, mut moment) = (0.0, Vec3::zeros());
    for triangle in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(triangle).map(|corner| corner - origin);
        let six_volumes = a.dot(&b.cross(&c));
        volume += six_volumes;
        moment += six_volumes * (a + b + c) / 4.0;
    }
    origin + moment / volume
}

fn normal(mesh: &TriangleMesh, triangle: usize) -> Vec3 {
    let [a, b, c] = mesh.corners(triangle);
    (b - a).cross(&(c - a)).normalize()
}

/// Groups of triangles that share a plane, by their first triangle.
fn coplanar(mesh: &TriangleMesh) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for triangle in 0..mesh.triangles.len() {
        let triangle_normal = normal(mesh, triangle);
        // A convex body has one face to a normal.
        let same = groups.iter_mut().find(|group| {
            let group_normal = normal(mesh, group[0]);
            // Parallel and antiparallel faces have the same
            // cross product; the sign tells them apart.
            triangle_normal.dot(&group_normal) > 0.0
                && triangle_normal.cross(&group_normal).norm() < ONE_FACE
        });
        match same {
            Some(group) => group.push(triangle),
            None => groups.push(vec![triangle]),
        }
    }
    groups
}

/// The corners around triangles of one plane, in order.
fn rim(mesh: &TriangleMesh, triangles: &[usize]) -> Vec<usize> {
    let mut next = BTreeMap::new();
    let mut inner = HashMap::new();
    for triangle in triangles {
        let [a, b, c] = mesh.triangles[*triangle].map(|corner| corner as usize);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            inner.insert((from, to), ());
        }
    }
    for (from, to) in inner.keys() {
        // An edge without its reverse in the group is on the rim.
        if !inner.contains_key(&(*to, *from)) {
            next.insert(*from, *to);
        }
    }
    let Some(first) = next.keys().next().copied() else {
        return Vec::new();
    };
    let mut rim = vec![first];
    while let Some(corner) = rim.last().and_then(|corner| next.get(corner))
        && *corner != first
    {
        rim.push(*corner);
    }
    rim
}

#[cfg(test)]
mod tests {
    use super::super::builders::by_name;
    use super::*;

    #[test]
    fn solids_have_their_faces_and_edges() {
        for (name, corners, edges, faces) in [
            ("tetrahedron", 4, 6, 4),
            ("octahedron", 6, 12, 8),
            ("dodecahedron", 20, 30, 12),
            ("icosahedron", 12, 30, 20),
            ("truncated-tetrahedron:0.6667", 12, 18, 8),
            ("truncated-octahedron", 24, 36, 14),
            ("rhombic-dodecahedron", 14, 24, 12),
            ("prism:6,1", 12, 18, 8),
        ] {
            let body = Polytope::from_shape(&by_name(name).unwrap()).unwrap();
            let counted = (body.corners.len(), body.edges.len(), body.faces.len());
            assert_eq!(counted, (corners, edges, faces), "{name}");
            for face in &body.faces {
                let heights = body.corners.iter().map(|x| face.normal.dot(x));
                assert!(heights.clone().all(|height| height < face.offset + 1e-12));
                let in_plane = heights.filter(|height| (height - face.offset).abs() < 1e-12);
                assert_eq!(in_plane.count(), face.corners.len(), "{name}");
            }
        }
        let hexagon = Polytope::from_shape(&by_name("polygon:6").unwrap()).unwrap();
        assert_eq!((hexagon.corners.len(), hexagon.faces.len()), (6, 6));
        assert!(hexagon.faces.iter().all(|face| face.offset > 0.0));
    }

    #[test]
    fn the_centroid_is_the_origin() {
        let shift = Vec3::new(3.0, -2.0, 5.0);
        let points = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()].map(|x| x + shift);
        let body = Polytope::from_shape(&Shape::solid(&points).unwrap()).unwrap();
        assert!(body.corners.iter().sum::<Vec3>().norm() < 1e-12);
        // A right triangle: the mean of its corners.
        let triangle = Shape::flat(&[[1.0, 1.0], [4.0, 1.0], [1.0, 7.0]]).unwrap();
        let body = Polytope::from_shape(&triangle).unwrap();
        assert!((body.corners[0] - Vec3::new(-1.0, -2.0, 0.0)).norm() < 1e-12);
        // A trapezium, whose centroid is not the mean of its corners.
        let wide = Shape::flat(&[[0.0, 0.0], [3.0, 0.0], [1.0, 1.0], [0.0, 1.0]]).unwrap();
        let body = Polytope::from_shape(&wide).unwrap();
        let height = -body.corners[0].y;
        assert!((height - 5.0 / 12.0).abs() < 1e-12, "{height}");
    }

    #[test]
    fn a_ray_leaves_through_the_face_it_meets() {
        let cube = Polytope::from_shape(&by_name("cuboid:1,2,3").unwrap()).unwrap();
        let face = cube.face_towards(&Vec3::new(0.4, 0.9, 0.1));
        assert!((face.normal - Vec3::y()).norm() < 1e-12);
        let face = cube.face_towards(&Vec3::new(-0.6, 0.9, 0.1));
        assert!((face.normal + Vec3::x()).norm() < 1e-12);
        assert!(Polytope::from_shape(&Shape::flat(&[[0.0, 0.0], [1.0, 0.0]]).unwrap()).is_err());
    }
}
