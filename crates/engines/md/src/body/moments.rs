//! Volume, centroid and second moments of polygons and polyhedra, and of their Minkowski sums with a
//! disk or a ball.
//!
//! The sum with a ball of radius r is the core, a prism of height r on each face, a wedge of a
//! cylinder on each edge and a cone of a ball at each corner (Steiner). The first three are
//! polynomials and arcs. The cone at a corner holds the normals of its faces; its moments
//!
//! ```text
//! ∫ 1 dΩ,  ∫ u dΩ,  ∫ u uᵀ dΩ   over the directions u between the normals
//! ```
//!
//! come from Gauss-Legendre points on flat, narrow triangles between the normals, whose point p stands for
//! the directions dΩ = det(n₁, n₂, n₃)/|p|³ d²λ.

use nalgebra::Matrix3;
use protomer_kernel::Vec3;
use protomer_kernel::quadrature::{Node, gauss_legendre};
use protomer_kernel::shape::polytope::{Face, Polytope};

/// Gauss-Legendre points along an edge of a triangle of directions.
const POINTS: usize = 12;
/// Cosine of the angle beyond which triangles of directions are divided.
const NARROW: f64 = 0.8;

/// The integrals ∫ dV, ∫ x dV and ∫ x xᵀ dV over a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moments {
    pub(crate) volume: f64,
    pub(crate) first: Vec3,
    pub(crate) second: Matrix3<f64>,
}

impl Moments {
    fn none() -> Self {
        Self {
            volume: 0.0,
            first: Vec3::zeros(),
            second: Matrix3::zeros(),
        }
    }

    /// The moments of a polygon or a polyhedron with its layer, about the origin of the corners.
    pub(crate) fn from_polytope(polytope: &Polytope, radius: f64) -> Self {
        let mut moments = Self::none();
        match polytope.dimension {
            2 => moments.add_polygon(polytope, radius),
            _ => moments.add_polyhedron(polytope, radius),
        }
        moments
    }

    pub(crate) fn centroid(&self) -> Vec3 {
        self.first / self.volume
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.volume += other.volume;
        self.first += other.first;
        self.second += other.second;
    }

    /// The moments about another origin.
    pub(crate) fn seen_from(&self, origin: &Vec3) -> Self {
        let cross = self.first * origin.transpose();
        Self {
            volume: self.volume,
            first: self.first - self.volume * origin,
            second: self.second - cross - cross.transpose()
                + self.volume * origin * origin.transpose(),
        }
    }

    /// The inertia tensor about the origin; in a plane the last element is the polar moment.
    pub(crate) fn inertia(&self) -> Matrix3<f64> {
        Matrix3::identity() * self.second.trace() - self.second
    }

    /// Adds the simplex of some points (and the origin of space or of a plane among them) of this
    /// volume: ∫ x xᵀ = V/((n+1)(n+2)) (s sᵀ + Σ x xᵀ) with the sum s of the n + 1 points.
    fn add_simplex(&mut self, volume: f64, points: &[Vec3]) {
        let count = points.len() as f64;
        let sum: Vec3 = points.iter().sum();
        self.volume += volume;
        self.first += volume / count * sum;
        let mut squares = sum * sum.transpose();
        for x in points {
            squares += x * x.transpose();
        }
        self.second += volume / (count * (count + 1.0)) * squares;
    }

    /// Adds points a + ρ u with the radius ρ up to r, from ∫ dω, ∫ u dω and ∫ u uᵀ dω over the
    /// directions in a space of this dimension, spread along a segment from a to b (or at a point).
    fn add_fan(&mut self, ends: [Vec3; 2], radius: f64, dimension: i32, fan: &Fan) {
        let edge = ends[1] - ends[0];
        let middle = 0.5 * (ends[0] + ends[1]);
        let over = |power: i32| radius.powi(dimension + power) / f64::from(dimension + power);
        let line = middle * middle.transpose() + edge * edge.transpose() / 12.0;
        let first = over(1) * fan.first;
        self.volume += over(0) * fan.measure;
        self.first += over(0) * fan.measure * middle + first;
        let cross = middle * first.transpose();
        self.second +=
            over(0) * fan.measure * line + cross + cross.transpose() + over(2) * fan.second;
    }

    fn add_polygon(&mut self, polytope: &Polytope, radius: f64) {
        let origin = Vec3::zeros();
        let count = polytope.corners.len();
        for (number, face) in polytope.faces.iter().enumerate() {
            let [a, b] = [face.corners[0], face.corners[1]].map(|corner| polytope.corners[corner]);
            self.add_simplex(0.5 * (a.x * b.y - a.y * b.x), &[origin, a, b]);
            if radius == 0.0 {
                continue;
            }
            // A rectangle, as two triangles.
            let [c, d] = [a, b].map(|corner| corner + radius * face.normal);
            let half = 0.5 * radius * (b - a).norm();
            self.add_simplex(half, &[a, c, d]);
            self.add_simplex(half, &[a, d, b]);
            let before = polytope.faces[(number + count - 1) % count].normal;
            self.add_fan([a; 2], radius, 2, &Fan::arc(&before, &face.normal));
        }
    }

    fn add_polyhedron(&mut self, polytope: &Polytope, radius: f64) {
        let origin = Vec3::zeros();
        for face in &polytope.faces {
            let corner = |place: usize| polytope.corners[face.corners[place]];
            for place in 1..face.corners.len().saturating_sub(1) {
                let [a, b, c] = [corner(0), corner(place), corner(place + 1)];
                self.add_simplex(a.dot(&b.cross(&c)) / 6.0, &[origin, a, b, c]);
                if radius > 0.0 {
                    self.add_prism([a, b, c], radius * face.normal);
                }
            }
        }
        if radius == 0.0 {
            return;
        }
        for edge in &polytope.edges {
            let ends = edge.map(|corner| polytope.corners[corner]);
            let normals = normals_at_edge(polytope, edge);
            if let [first, second] = normals.as_slice() {
                let fan = Fan::arc(first, second);
                // The wedge is as long as the edge; the fan is per length.
                self.add_fan(ends, radius, 2, &fan.times((ends[1] - ends[0]).norm()));
            }
        }
        for (number, corner) in polytope.corners.iter().enumerate() {
            let normals = normals_at_corner(polytope, number);
            for place in 1..normals.len().saturating_sub(1) {
                let triangle = [normals[0], normals[place], normals[place + 1]];
                self.add_fan([*corner; 2], radius, 3, &Fan::triangle(triangle));
            }
        }
    }

    /// Adds a triangle, drawn out along a height, as three tetrahedra.
    fn add_prism(&mut self, base: [Vec3; 3], height: Vec3) {
        let [a, b, c] = base;
        let [d, e, f] = base.map(|corner| corner + height);
        let volume = ((b - a).cross(&(c - a)).dot(&height) / 6.0).abs();
        for points in [[a, b, c, d], [b, c, d, e], [c, d, e, f]] {
            self.add_simplex(volume, &points);
        }
    }
}

/// The integrals ∫ dω, ∫ u dω and ∫ u uᵀ dω over directions u.
struct Fan {
    measure: f64,
    first: Vec3,
    second: Matrix3<f64>,
}

impl Fan {
    fn times(self, factor: f64) -> Self {
        Self {
            measure: factor * self.measure,
            first: factor * self.first,
            second: factor * self.second,
        }
    }

    /// The arc between two directions less than half a turn apart.
    fn arc(from: &Vec3, to: &Vec3) -> Self {
        let angle = from.cross(to).norm().atan2(from.dot(to));
        let tangent = (to - from * from.dot(to)).try_normalize(0.0);
        let tangent = tangent.unwrap_or_else(Vec3::zeros);
        // u = cos φ · from + sin φ · tangent.
        let (sine, cosine) = angle.sin_cos();
        let first = sine * from + (1.0 - cosine) * tangent;
        let squares = [
            0.5 * (angle + sine * cosine),
            0.5 * (angle - sine * cosine),
            0.5 * sine * sine,
        ];
        let cross = from * tangent.transpose();
        Self {
            measure: angle,
            first,
            second: squares[0] * from * from.transpose()
                + squares[1] * tangent * tangent.transpose()
                + squares[2] * (cross + cross.transpose()),
        }
    }

    /// The spherical triangle of directions between three.
    fn triangle([a, b, c]: [Vec3; 3]) -> Self {
        let widest = a.dot(&b).min(b.dot(&c)).min(c.dot(&a));
        if widest >= NARROW {
            return Self::narrow_triangle([a, b, c]);
        }
        let middle = |x: &Vec3, y: &Vec3| (x + y).normalize();
        let [d, e, f] = [middle(&a, &b), middle(&b, &c), middle(&c, &a)];
        let mut fan = Self::none();
        for triangle in [[a, d, f], [d, b, e], [f, e, c], [d, e, f]] {
            let part = Self::triangle(triangle);
            fan.measure += part.measure;
            fan.first += part.first;
            fan.second += part.second;
        }
        fan
    }

    fn narrow_triangle([a, b, c]: [Vec3; 3]) -> Self {
        let determinant = a.dot(&b.cross(&c)).abs();
        let mut fan = Self::none();
        let points = unit_rule();
        for (x, weight) in &points {
            for (y, other) in &points {
                // From the square to the triangle: the second coordinate shrinks with the first.
                let p = a + *x * (b - a) + *x * *y * (c - b);
                let length = p.norm();
                let share = weight * other * x * determinant / length.powi(3);
                let u = p / length;
                fan.measure += share;
                fan.first += share * u;
                fan.second += share * u * u.transpose();
            }
        }
        fan
    }

    fn none() -> Self {
        Self {
            measure: 0.0,
            first: Vec3::zeros(),
            second: Matrix3::zeros(),
        }
    }
}

/// The rule of Gauss and Legendre between 0 and 1: places and weights.
pub(crate) fn unit_rule() -> Vec<(f64, f64)> {
    let nodes = gauss_legendre(POINTS).into_iter();
    let from_zero = |node: Node| (0.5 * (1.0 + node.place), 0.5 * node.weight);
    nodes.map(from_zero).collect()
}

/// Normals of the faces that share an edge.
fn normals_at_edge(polytope: &Polytope, edge: &[usize; 2]) -> Vec<Vec3> {
    let has = |face: &&Face| edge.iter().all(|corner| face.corners.contains(corner));
    let faces = polytope.faces.iter().filter(has);
    faces.map(|face| face.normal).collect()
}

/// Normals of the faces at a corner, in their order around it.
fn normals_at_corner(polytope: &Polytope, corner: usize) -> Vec<Vec3> {
    // Each face with the corners before and after this one on its rim.
    let mut faces: Vec<(usize, usize, Vec3)> = Vec::new();
    for face in &polytope.faces {
        if let Some(place) = face.corners.iter().position(|other| *other == corner) {
            let count = face.corners.len();
            let before = face.corners[(place + count - 1) % count];
            faces.push((before, face.corners[(place + 1) % count], face.normal));
        }
    }
    let mut normals = Vec::with_capacity(faces.len());
    let mut next = faces.first().map(|(before, ..)| *before);
    while let Some(towards) = next
        && normals.len() < faces.len()
    {
        let face = faces.iter().find(|(_, after, _)| *after == towards);
        normals.extend(face.map(|(.., normal)| *normal));
        next = face.map(|(before, ..)| *before);
    }
    normals
}
