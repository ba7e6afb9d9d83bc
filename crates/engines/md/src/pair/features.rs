//! The closest points of two bodies by their features: slow, plain and exact to rounding.
//!
//! The point of a body nearest to a point is the best of those on the faces that the point sees. On a
//! face it is the foot, if that lies inside, or else the best of the edges outside of which the foot lies. The closest points of two bodies are the best of all corners of one against the other body
//! and, in space, of all pairs of edges whose lines come closest within both.
//!
//! A foot inside an edge is nearer than the ends, and one inside a face nearer than its edges, even if
//! rounding does not show it: a shift of 10⁻¹⁰ along the surface changes the distance by 10⁻²⁰ and the
//! direction by 10⁻¹⁰. So among equals those on features of more dimensions count: a corner above the
//! inside of a face and two edges that cross have two, a corner next to an edge one.

use protomer_kernel::shape::closest::ClosestPoints;
use protomer_kernel::shape::polytope::Polytope;
use protomer_kernel::{Pose, Vec3};

/// Distances that differ by less than this part are equal: they are differences of places ten times as
/// large, each of which is rounded.
pub(crate) const EQUAL: f64 = 5e-14;

/// A body in place: its corners, edges and faces.
pub struct Features {
    /// Corners.
    pub corners: Vec<Vec3>,
    /// Edges, from end to end; none in a plane, where they are the faces.
    pub edges: Vec<[Vec3; 2]>,
    /// Faces with their outward normals and the corners of their rims in order.
    faces: Vec<(Vec3, Vec<Vec3>)>,
}

impl Features {
    /// The features of a body in a pose.
    pub fn from_polytope(body: &Polytope, pose: &Pose) -> Self {
        let corners = body.corners_at(pose);
        let corner = |number: &usize| corners[*number];
        let faces = body.faces.iter().map(|face| {
            let rim = face.corners.iter().map(corner).collect();
            (pose.rotation * face.normal, rim)
        });
        let edges = body.edges.iter();
        Self {
            faces: faces.collect(),
            edges: edges.map(|[from, to]| [corner(from), corner(to)]).collect(),
            corners,
        }
    }

    /// The point of the body nearest to a point outside.
    pub fn nearest(&self, point: &Vec3) -> Vec3 {
        self.foot(point).0
    }

    /// The point nearest to a point outside, with the dimension of the feature it lies on. The face
    /// above which the point is highest comes before others that are equally near to rounding.
    fn foot(&self, point: &Vec3) -> (Vec3, usize) {
        let height = |(normal, rim): &(Vec3, Vec<Vec3>)| normal.dot(&(point - rim[0]));
        let mut visible: Vec<_> = self
            .faces
            .iter()
            .filter(|face| height(face) > 0.0)
            .collect();
        visible.sort_by(|a, b| height(b).total_cmp(&height(a)));
        let mut best = (f64::INFINITY, (*point, 0));
        for (normal, rim) in visible {
            let foot = on_face(normal, rim, point);
            let distance = (foot.0 - point).norm();
            if replaces((distance, foot.1), (best.0, best.1.1)) {
                best = (distance, foot);
            }
        }
        best.1
    }

    /// The closest points of two bodies that are apart.
    pub fn closest(&self, other: &Self) -> Option<ClosestPoints> {
        let mut candidates = Vec::new();
        let mut add = |dimensions: usize, points: ClosestPoints| {
            candidates.push((points.distance(), dimensions, points));
        };
        for corner in &self.corners {
            let (on_second, dimensions) = other.foot(corner);
            add(
                dimensions,
                ClosestPoints {
                    on_first: *corner,
                    on_second,
                },
            );
        }
        for corner in &other.corners {
            let (on_first, dimensions) = self.foot(corner);
            add(
                dimensions,
                ClosestPoints {
                    on_first,
                    on_second: *corner,
                },
            );
        }
        for edge in &self.edges {
            for other in &other.edges {
                if let Some(points) = crossing(edge, other) {
                    add(2, points);
                }
            }
        }
        best(candidates.into_iter())
    }
}

/// The nearest of candidates with their distances and dimensions; among those that are equal to
/// rounding, one of the most dimensions.
fn best<T>(candidates: impl Iterator<Item = (f64, usize, T)>) -> Option<T> {
    let mut best: Option<(f64, usize, T)> = None;
    for (distance, dimensions, candidate) in candidates {
        if best
            .as_ref()
            .is_none_or(|(least, most, _)| precedes((distance, dimensions), (*least, *most)))
        {
            best = Some((distance, dimensions, candidate));
        }
    }
    best.map(|(.., candidate)| candidate)
}

/// Whether the foot on another face comes before that on the highest: only if it is nearer by more
/// than rounding, or if it lies inside an edge that has the other foot as an end.
pub(crate) fn replaces(candidate: (f64, usize), incumbent: (f64, usize)) -> bool {
    let is_inner = candidate.1 > incumbent.1 && candidate.0 <= incumbent.0 * (1.0 + EQUAL);
    is_inner || candidate.0 < incumbent.0 * (1.0 - EQUAL)
}

/// Whether a distance, or at equal distances the dimensions of its features, come before others.
pub(crate) fn precedes(candidate: (f64, usize), incumbent: (f64, usize)) -> bool {
    match candidate.1 > incumbent.1 {
        true => candidate.0 <= incumbent.0 * (1.0 + EQUAL),
        false => {
            candidate.0 < incumbent.0 * (1.0 - EQUAL)
                || (candidate.1 == incumbent.1 && candidate.0 < incumbent.0)
        }
    }
}

/// The point of a face nearest to a point, with the dimensions of the feature it lies on. In a plane a
/// face is a segment.
pub fn on_face(normal: &Vec3, rim: &[Vec3], point: &Vec3) -> (Vec3, usize) {
    if let [from, to] = rim {
        return on_edge(&[*from, *to], point);
    }
    let foot = point - normal * normal.dot(&(point - rim[0]));
    let next = rim.iter().cycle().skip(1);
    let edges = rim.iter().zip(next).map(|(from, to)| [*from, *to]);
    let is_outside = |[from, to]: &[Vec3; 2]| normal.dot(&(to - from).cross(&(foot - from))) < 0.0;
    let feet = edges.filter(is_outside).map(|edge| on_edge(&edge, point));
    let nearest = best(feet.map(|foot| ((foot.0 - point).norm(), foot.1, foot)));
    nearest.unwrap_or((foot, 2))
}

/// Variant of [`on_face`] for an edge.
fn on_edge([from, to]: &[Vec3; 2], point: &Vec3) -> (Vec3, usize) {
    let edge = to - from;
    let place = (point - from).dot(&edge) / edge.norm_squared();
    let is_within = place > 0.0 && place < 1.0;
    (from + place.clamp(0.0, 1.0) * edge, usize::from(is_within))
}

/// The point of a segment nearest to a point.
pub fn on_segment(segment: &[Vec3; 2], point: &Vec3) -> Vec3 {
    on_edge(segment, point).0
}

/// The closest points of the lines through two edges, if they lie within both.
fn crossing([a, b]: &[Vec3; 2], [c, d]: &[Vec3; 2]) -> Option<ClosestPoints> {
    let (u, v, r) = (b - a, d - c, a - c);
    let normal = u.cross(&v);
    let squared = normal.norm_squared();
    let places = [v.cross(&r), u.cross(&r)].map(|x| x.dot(&normal) / squared);
    let is_within = places.iter().all(|place| (0.0..=1.0).contains(place));
    is_within.then(|| ClosestPoints {
        on_first: a + places[0] * u,
        on_second: c + places[1] * v,
    })
}

/// The closest points of two segments.
pub fn between_segments(first: &[Vec3; 2], second: &[Vec3; 2]) -> ClosestPoints {
    let first_ends = first.iter().map(|end| ClosestPoints {
        on_first: *end,
        on_second: on_segment(second, end),
    });
    let second_ends = second.iter().map(|end| ClosestPoints {
        on_first: on_segment(first, end),
        on_second: *end,
    });
    let inner = crossing(first, second).map(|points| (points.distance(), 1, points));
    let ends = first_ends
        .chain(second_ends)
        .map(|points| (points.distance(), 0, points));
    best(inner.into_iter().chain(ends)).unwrap_or(ClosestPoints {
        on_first: first[0],
        on_second: second[0],
    })
}
