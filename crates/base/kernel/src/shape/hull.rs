//! Convex hulls: the monotone chain in a plane, and in space point after point, the farthest first.

use crate::{TriangleMesh, Vec3};
use std::collections::{HashMap, HashSet};

/// Distance to a face below which points lie in it, as a part of the size.
const IN_PLANE: f64 = 1e-12;
/// Thickness below which a hull is flat, as a part of its size.
const FLAT: f64 = 1e-9;

/// The convex hull of points in space.
///
/// ```
/// use protomer_kernel::Vec3;
/// use protomer_kernel::shape::{Shape, hull::Hull};
/// let on_a_line = Shape::solid(&[Vec3::zeros(), 2.0 * Vec3::x(), Vec3::x()])?;
/// let Shape::Solid(Hull::Segment(ends)) = on_a_line else { panic!("no segment") };
/// assert_eq!((ends[1] - ends[0]).norm(), 2.0);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Hull {
    /// A single point: the hull of coincident points.
    Point(Vec3),
    /// The ends of a segment: the hull of points on a line.
    Segment([Vec3; 2]),
    /// The corners of a polygon, in order: the hull of points in a plane.
    Polygon(Vec<Vec3>),
    /// Triangles with outward normals; a face with more corners is several triangles.
    Polyhedron(TriangleMesh),
}

impl Hull {
    /// The hull of points, of which there must be one or more.
    pub(super) fn from_points(points: &[Vec3]) -> Self {
        let Some(extent) = Extent::from_points(points) else {
            return Hull::Point(points.first().copied().unwrap_or_default());
        };
        let Some(third) = extent.third else {
            return Hull::Segment([points[extent.first], points[extent.second]]);
        };
        let Some(fourth) = extent.fourth else {
            return extent.polygon(points, third);
        };
        let mut faces = Faces::tetrahedron(
            points,
            [extent.first, extent.second, third, fourth],
            extent.size,
        );
        for corner in by_distance(points) {
            faces.add(corner);
        }
        Hull::Polyhedron(faces.mesh())
    }

    /// The corners.
    ///
    /// ```
    /// use protomer_kernel::{Vec3, shape::Shape};
    /// let in_line = Shape::solid(&[Vec3::zeros(), Vec3::x(), 2.0 * Vec3::x()])?;
    /// let Shape::Solid(hull) = in_line else { panic!() };
    /// assert_eq!(hull.corners().len(), 2, "the point between the ends is no corner");
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn corners(&self) -> Vec<Vec3> {
        match self {
            Hull::Point(corner) => vec![*corner],
            Hull::Segment(ends) => ends.to_vec(),
            Hull::Polygon(corners) => corners.clone(),
            Hull::Polyhedron(mesh) => mesh.vertices.clone(),
        }
    }
}

/// The corners of the hull of points in a plane, counter-clockwise, without those inside an edge
/// (Andrew, Inf. Process. Lett. 9, 216 (1979)).
pub(super) fn polygon(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = points.to_vec();
    // Sorted by x, then y: the chains run once to the right and once to the left.
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let mut lower = chain(sorted.iter());
    let mut upper = chain(sorted.iter().rev());
    // The end points belong to both chains.
    lower.pop();
    upper.pop();
    lower.extend(upper);
    lower
}

fn chain<'a>(points: impl Iterator<Item = &'a [f64; 2]>) -> Vec<[f64; 2]> {
    let mut chain: Vec<[f64; 2]> = Vec::new();
    for point in points {
        while let [.., a, b] = chain[..]
            // Turns to the right and straight lines both go, so no corner lies inside an edge.
            && cross(a, b, *point) <= 0.0
        {
            chain.pop();
        }
        chain.push(*point);
    }
    chain
}

/// Twice the area of a triangle, positive counter-clockwise.
fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Points that are far apart and show the number of dimensions.
struct Extent {
    first: usize,
    second: usize,
    third: Option<usize>,
    fourth: Option<usize>,
    size: f64,
}

impl Extent {
    /// Finds the extent; `None` if all points coincide.
    fn from_points(points: &[Vec3]) -> Option<Self> {
        // Two passes give corners that are far apart; the exact diameter is not needed.
        let first = farthest(points, |x| (x - points[0]).norm())?.0;
        let (second, size) = farthest(points, |x| (x - points[first]).norm())?;
        if size == 0.0 {
            return None;
        }
        let direction = (points[second] - points[first]) / size;
        let from_line = |x: &Vec3| (x - points[first]).cross(&direction).norm();
        let (third, width) = farthest(points, from_line)?;
        let mut extent = Self {
            first,
            second,
            third: None,
            fourth: None,
            size,
        };
        // Widths below 1e-9 of the size are rounding of
        // points on a line; a sliver has no stable normal.
        if width <= FLAT * size {
            return Some(extent);
        }
        extent.third = Some(third);
        let normal = direction
            .cross(&(points[third] - points[first]))
            .normalize();
        let (fourth, height) = farthest(points, |x| (x - points[first]).dot(&normal).abs())?;
        extent.fourth = (height > FLAT * size).then_some(fourth);
        Some(extent)
    }

    fn polygon(&self, points: &[Vec3], third: usize) -> Hull {
        let origin = points[self.first];
        let x = (points[self.second] - origin).normalize();
        let z = x.cross(&(points[third] - origin)).normalize();
        let y = z.cross(&x);
        let flat = points.iter().map(|point| {
            let d = point - origin;
            [d.dot(&x), d.dot(&y)]
        });
        let corners = polygon(&flat.collect::<Vec<_>>()).into_iter();
        Hull::Polygon(corners.map(|[a, b]| origin + a * x + b * y).collect())
    }
}

fn farthest(points: &[Vec3], distance: impl Fn(&Vec3) -> f64) -> Option<(usize, f64)> {
    let distances = points.iter().map(distance).enumerate();
    distances.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Indices of the points, the farthest from the centre first: points within an edge or a face then
/// come after its corners.
fn by_distance(points: &[Vec3]) -> Vec<usize> {
    let centre = points.iter().sum::<Vec3>() / points.len() as f64;
    let mut order: Vec<usize> = (0..points.len()).collect();
    let distance = |index: &usize| (points[*index] - centre).norm_squared();
    // Ties by number: the same points give the same mesh on every machine.
    order.sort_by(|a, b| distance(b).total_cmp(&distance(a)).then(a.cmp(b)));
    order
}

/// The faces of a growing hull.
struct Faces<'a> {
    points: &'a [Vec3],
    faces: Vec<[usize; 3]>,
    /// Height above a face beyond which a point is outside.
    above: f64,
}

impl<'a> Faces<'a> {
    fn tetrahedron(points: &'a [Vec3], [a, b, c, d]: [usize; 4], size: f64) -> Self {
        let mut faces = Self {
            points,
            faces: vec![[a, b, c], [a, c, d], [a, d, b], [b, d, c]],
            above: IN_PLANE * size,
        };
        // Outward normals: no corner of a tetrahedron lies above the face across from it.
        if faces.height(&[a, b, c], d) > 0.0 {
            for face in &mut faces.faces {
                face.swap(0, 1);
            }
        }
        faces
    }

    /// Height of a point above a face.
    fn height(&self, [a, b, c]: &[usize; 3], point: usize) -> f64 {
        let [a, b, c] = [a, b, c].map(|corner| self.points[*corner]);
        let normal = (b - a).cross(&(c - a)).normalize();
        normal.dot(&(self.points[point] - a))
    }

    /// Replaces the faces that a point sees by those from it to their rim.
    fn add(&mut self, point: usize) {
        // Points in the plane of a face do not see it, so flat faces are not split again.
        let sees = |face: &[usize; 3]| self.height(face, point) > self.above;
        let (visible, mut faces): (Vec<[usize; 3]>, Vec<[usize; 3]>) =
            self.faces.iter().partition(|face| sees(face));
        if visible.is_empty() {
            return;
        }
        let edges: HashSet<(usize, usize)> = visible.iter().flat_map(edges_of).collect();
        for (from, to) in visible.iter().flat_map(edges_of) {
            // An edge whose reverse is not visible too is on the rim.
            if !edges.contains(&(to, from)) {
                faces.push([from, to, point]);
            }
        }
        self.faces = faces;
    }

    fn mesh(&self) -> TriangleMesh {
        let (mut numbers, mut vertices) = (HashMap::new(), Vec::new());
        let mut number = |corner: usize| {
            *numbers.entry(corner).or_insert_with(|| {
                vertices.push(self.points[corner]);
                vertices.len() as u32 - 1
            })
        };
        let triangles = self
            .faces
            .iter()
            .map(|face| face.map(&mut number))
            .collect();
        TriangleMesh {
            vertices,
            triangles,
        }
    }
}

fn edges_of([a, b, c]: &[usize; 3]) -> [(usize, usize); 3] {
    [(*a, *b), (*b, *c), (*c, *a)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::CounterRng;

    #[test]
    fn points_inside_and_on_edges_and_faces_are_no_corners() {
        let mut points = Vec::new();
        for place in 0..125 {
            let corner = [place % 5, place / 5 % 5, place / 25].map(f64::from);
            points.push(Vec3::from(corner));
        }
        let Hull::Polyhedron(mesh) = Hull::from_points(&points) else {
            panic!("a cube is a polyhedron");
        };
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (8, 12));
        assert!((mesh.volume_angstrom3() - 64.0).abs() < 1e-9);
        let square: Vec<[f64; 2]> = (0..25).map(|n| [n % 5, n / 5].map(f64::from)).collect();
        assert_eq!(
            polygon(&square),
            [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]
        );
    }

    #[test]
    fn no_point_is_outside_and_the_hull_is_closed() {
        let mut rng = CounterRng::new(11, 0, 0);
        for number in [4, 5, 8, 30, 200] {
            let points: Vec<Vec3> = (0..number).map(|_| rng.vector_in_ball(1.0)).collect();
            let Hull::Polyhedron(mesh) = Hull::from_points(&points) else {
                panic!("{number} random points are a polyhedron");
            };
            for triangle in 0..mesh.triangles.len() {
                let [a, b, c] = mesh.corners(triangle);
                let normal = (b - a).cross(&(c - a)).normalize();
                assert!(points.iter().all(|x| normal.dot(&(x - a)) < 1e-12));
            }
            let corners = mesh.vertices.len();
            assert_eq!(mesh.triangles.len(), 2 * corners - 4, "Euler");
        }
    }

    #[test]
    fn thin_hulls_are_what_they_are() {
        let point = Vec3::new(1.0, 2.0, 3.0);
        assert_eq!(Hull::from_points(&[point, point]), Hull::Point(point));
        let line = [0.0, 2.0, 1.0].map(|t| point + t * Vec3::new(1.0, 1.0, 0.0));
        assert_eq!(Hull::from_points(&line).corners().len(), 2);
        let tilted = |x: f64, y: f64| Vec3::new(x, y, 0.3 * x - 0.2 * y);
        let flat = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.5, 0.5)];
        let hull = Hull::from_points(&flat.map(|(x, y)| tilted(x, y)));
        assert!(matches!(&hull, Hull::Polygon(corners) if corners.len() == 4));
    }
}
