//! Forces between polyhedra and balls.
//!
//! The direction in which the pair was apart a step ago is tried first; if it does not separate the
//! bodies by more than the reach, the walk to the closest points begins where it ended a step ago.
//! The direction between the closest points then says which corners and edges can be near at all.

use super::{Felt, Hint, Law, SURELY_BEYOND, TurnedPart};
use crate::pair::Form;
use crate::pair::features::{EQUAL, precedes, replaces};
use crate::pair::smooth::Crossing;
use crate::pair::terms::Terms;
use protomer_kernel::Vec3;
use protomer_kernel::shape::closest::ClosestPoints;
use protomer_kernel::shape::polytope::Face;
use protomer_kernel::shape::remembered::{Bodies, Found};

/// Distance beyond the closest points within which features are looked at again, as a part of the
/// size of the bodies.
const ROUNDING: f64 = 1e-6;

/// The energy, force and torques of two bodies in space; `between` leads from the centre of the
/// first to that of the second.
pub fn felt(
    first: TurnedPart<'_>,
    second: TurnedPart<'_>,
    between: Vec3,
    law: &Law,
    form: Form,
    hint: &mut Hint,
) -> Felt {
    let apart = first.part.circumradius + second.part.circumradius + law.radial.range();
    if between.norm_squared() > apart * apart {
        return Felt::nothing();
    }
    let reach = law.reach * SURELY_BEYOND;
    // The direction of the last step: one pass over the corners of each.
    if gap(&first, &second, &between, &hint.direction) > reach {
        return Felt::nothing();
    }
    let bodies = Bodies {
        first: first.corners,
        second: second.corners,
        between,
    };
    let points = match bodies.closest(reach, &mut hint.simplex) {
        Found::At(points) => points,
        Found::Beyond(direction) => {
            hint.direction = direction;
            return Felt::nothing();
        }
        Found::Touching => return Felt::touching(),
    };
    let distance = points.distance();
    // Layers touch: the cores are apart by no more than both radii.
    if distance <= law.radii {
        return Felt::touching();
    }
    let direction = -points.separation() / distance;
    hint.direction = direction;
    // Exactly at the reach: the wider test above let it pass.
    if distance >= law.reach {
        return Felt::nothing();
    }
    let mut sum = Sum {
        law,
        terms: Terms::about([Vec3::zeros(), between], law.radial, law.radii),
    };
    let is_ball = first.part.is_round() || second.part.is_round();
    match form {
        // The closest points of two balls, or of a ball and a body, are unique and exact.
        _ if is_ball => sum.repel(&points),
        Form::Contact => {
            let points = exact(&first, &second, between, &direction, points);
            sum.repel(&points);
        }
        Form::FaceSum => sum.add_faces(&first, &second, between, &points, &direction),
        Form::Smooth => {
            if !sum.add_all(&first, &second, between, &direction) {
                return Felt::touching();
            }
        }
    }
    Felt {
        energy: sum.terms.energy,
        force: sum.terms.force,
        torques: sum.terms.torques,
    }
}

/// The closest points among the features near the plane between the bodies. The walk to the closest
/// points ends where a step gains less than rounding of their distance; along nearly parallel features
/// their places are then good to 1e-8 only.
fn exact(
    first: &TurnedPart<'_>,
    second: &TurnedPart<'_>,
    between: Vec3,
    direction: &Vec3,
    walked: ClosestPoints,
) -> ClosestPoints {
    let size = first.part.circumradius + second.part.circumradius;
    let reach = walked.distance() + ROUNDING * size;
    // The walk knows no feature, so all of them come before it.
    let mut best = ((reach, 0), walked);
    let mut note = |dimensions: usize, points: ClosestPoints| {
        let candidate = (points.distance(), dimensions);
        if precedes(candidate, best.0) {
            best = (candidate, points);
        }
    };
    let [top, bottom] = limits(first, second, &between, direction);
    let mut near = [0, 0];
    for corner in first.corners {
        if bottom - corner.dot(direction) > reach {
            // Below the plane through the other body's lowest
            // corner by more than the reach: cannot be nearest.
            continue;
        }
        // Counted, as edges matter only if more than one corner is near.
        near[0] += 1;
        if let Some((foot, dimensions)) = foot(second, &(corner - between)) {
            let on_second = foot + between;
            note(
                dimensions,
                ClosestPoints {
                    on_first: *corner,
                    on_second,
                },
            );
        }
    }
    for corner in second.corners {
        let corner = corner + between;
        if corner.dot(direction) - top > reach {
            continue;
        }
        near[1] += 1;
        if let Some((foot, dimensions)) = foot(first, &corner) {
            note(
                dimensions,
                ClosestPoints {
                    on_first: foot,
                    on_second: corner,
                },
            );
        }
    }
    // Where one corner alone is near the plane, edges hardly cross another; if they do, the walk says so.
    let edges = match near.contains(&1) {
        true => &[],
        false => first.part.polytope.edges.as_slice(),
    };
    for edge in edges {
        let edge = edge.map(|corner| first.corners[corner]);
        let high = edge[0].dot(direction).max(edge[1].dot(direction));
        if bottom - high > reach {
            continue;
        }
        for other in &second.part.polytope.edges {
            let other = other.map(|corner| second.corners[corner] + between);
            let low = other[0].dot(direction).min(other[1].dot(direction));
            if low - high <= reach
                && let Some(points) = crossing(edge, other)
            {
                note(2, points);
            }
        }
    }
    let ((distance, _), points) = best;
    // The walk wins only if it is clearly nearer: features are exact, the walk is not.
    match walked.distance() < distance * (1.0 - EQUAL) {
        true => walked,
        false => points,
    }
}

/// The closest points of the lines through two edges, if they lie within both.
fn crossing(first: [Vec3; 2], second: [Vec3; 2]) -> Option<ClosestPoints> {
    let (u, v) = (first[1] - first[0], second[1] - second[0]);
    let r = first[0] - second[0];
    let normal = u.cross(&v);
    let squared = normal.norm_squared();
    // Cramer's rule for the common perpendicular; parallel edges divide by zero and are not within.
    let s = v.cross(&r).dot(&normal) / squared;
    let t = u.cross(&r).dot(&normal) / squared;
    let is_within = (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
    is_within.then(|| ClosestPoints {
        on_first: first[0] + s * u,
        on_second: second[0] + t * v,
    })
}

/// Nearest point of a part, which lies on a face that the given point sees, and the dimension of its
/// feature.
fn foot(body: &TurnedPart<'_>, point: &Vec3) -> Option<(Vec3, usize)> {
    let faces = &body.part.polytope.faces;
    let heights = body.normals.iter().zip(&body.part.offsets);
    let heights = heights.map(|(normal, offset)| normal.dot(point) - offset);
    // The face that sees the point highest is the likeliest to carry its foot.
    let (highest, top) = heights
        .clone()
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    // Inside: below every face.
    if top <= 0.0 {
        return None;
    }
    let mut best = foot_on_face(body, (highest, &faces[highest]), point);
    let mut distance = (best.0 - point).norm();
    // Above the inside of a face, or next to an edge of it by rounding, no other face is nearer.
    if best.1 > 0 && distance <= top * (1.0 + EQUAL) {
        return Some(best);
    }
    // Faces that see the point may be nearer at their rims.
    for (number, height) in heights.enumerate() {
        if number == highest || height <= 0.0 {
            continue;
        }
        let place = foot_on_face(body, (number, &faces[number]), point);
        let separation = (place.0 - point).norm();
        if replaces((separation, place.1), (distance, best.1)) {
            (best, distance) = (place, separation);
        }
    }
    Some(best)
}

/// Gap between the bodies across a plane at right angles to this direction, of length one; not
/// positive for the zero vector.
fn gap(first: &TurnedPart<'_>, second: &TurnedPart<'_>, between: &Vec3, direction: &Vec3) -> f64 {
    let [top, bottom] = limits(first, second, between, direction);
    bottom - top
}

/// The highest point of the first body and the lowest of the second along a direction.
fn limits(
    first: &TurnedPart<'_>,
    second: &TurnedPart<'_>,
    between: &Vec3,
    direction: &Vec3,
) -> [f64; 2] {
    let heights = |body: &TurnedPart<'_>, from: f64, keep: fn(f64, f64) -> f64| {
        let corners = body.corners.iter();
        corners.fold(from, |limit, corner| keep(limit, corner.dot(direction)))
    };
    let top = heights(first, f64::NEG_INFINITY, f64::max);
    let bottom = heights(second, f64::INFINITY, f64::min);
    [top, bottom + between.dot(direction)]
}

/// Sum of repulsions. Points are seen from the centre of the first body.
struct Sum<'a> {
    law: &'a Law,
    terms: Terms,
}

impl Sum<'_> {
    fn repel(&mut self, points: &ClosestPoints) {
        let separation = points.separation();
        let squared = separation.norm_squared();
        if squared >= self.law.reach * self.law.reach {
            return;
        }
        let distance = squared.sqrt();
        let [energy, slope] = self.law.radial.energy_and_slope(distance - self.law.radii);
        self.terms.energy += energy;
        let force = separation * (-slope / distance);
        self.terms.push([points.on_first, points.on_second], force);
    }

    /// Adds all features of the two faces that look at each other.
    fn add_faces(
        &mut self,
        first: &TurnedPart<'_>,
        second: &TurnedPart<'_>,
        between: Vec3,
        points: &ClosestPoints,
        direction: &Vec3,
    ) {
        let reach = self.law.reach;
        let faces = [
            towards(first, &points.on_second),
            towards(second, &(points.on_first - between)),
        ];
        let [a, b] = [faces[0].1, faces[1].1];
        let shifted = |number: usize| second.corners[number] + between;
        // The highest of the first face and the lowest of the second; no feature is nearer.
        let heights = |number: &usize| first.corners[*number].dot(direction);
        let top = a
            .corners
            .iter()
            .map(heights)
            .fold(f64::NEG_INFINITY, f64::max);
        let depths = |number: &usize| shifted(*number).dot(direction);
        let bottom = b.corners.iter().map(depths).fold(f64::INFINITY, f64::min);
        for number in &a.corners {
            let corner = first.corners[*number];
            if bottom - corner.dot(direction) < reach {
                let foot = on_face(second, faces[1], &(corner - between)) + between;
                self.repel(&ClosestPoints {
                    on_first: corner,
                    on_second: foot,
                });
            }
        }
        for number in &b.corners {
            let corner = shifted(*number);
            if corner.dot(direction) - top < reach {
                self.repel(&ClosestPoints {
                    on_first: on_face(first, faces[0], &corner),
                    on_second: corner,
                });
            }
        }
        for (from, to) in rim(a) {
            let edge = [first.corners[from], first.corners[to]];
            let high = edge[0].dot(direction).max(edge[1].dot(direction));
            if bottom - high >= reach {
                continue;
            }
            for (from, to) in rim(b) {
                let other = [shifted(from), shifted(to)];
                let low = other[0].dot(direction).min(other[1].dot(direction));
                if low - high < reach {
                    self.repel(&between_segments(edge, other));
                }
            }
        }
    }

    /// Adds all corners and edges, smoothly; false if a corner is inside the other body.
    fn add_all(
        &mut self,
        first: &TurnedPart<'_>,
        second: &TurnedPart<'_>,
        between: Vec3,
        direction: &Vec3,
    ) -> bool {
        let reach = self.law.reach;
        let [top, bottom] = limits(first, second, &between, direction);
        for corner in first.corners {
            if bottom - corner.dot(direction) >= reach {
                continue;
            }
            // Inside the other body: no smooth energy.
            let Some(foot) = nearest(second, &(corner - between)) else {
                return false;
            };
            self.repel(&ClosestPoints {
                on_first: *corner,
                on_second: foot + between,
            });
        }
        for corner in second.corners {
            let corner = corner + between;
            if corner.dot(direction) - top >= reach {
                continue;
            }
            let Some(foot) = nearest(first, &corner) else {
                return false;
            };
            self.repel(&ClosestPoints {
                on_first: foot,
                on_second: corner,
            });
        }
        for edge in &first.part.polytope.edges {
            let edge = edge.map(|corner| first.corners[corner]);
            let high = edge[0].dot(direction).max(edge[1].dot(direction));
            if bottom - high >= reach {
                continue;
            }
            for other in &second.part.polytope.edges {
                let other = other.map(|corner| second.corners[corner] + between);
                let low = other[0].dot(direction).min(other[1].dot(direction));
                if low - high >= reach {
                    continue;
                }
                // Edges against edges, where neither ends at a corner that has been counted.
                if let Some(crossing) = Crossing::find(edge, other, reach) {
                    crossing.add(&mut self.terms);
                }
            }
        }
        true
    }
}

/// The face through which a ray from the centre leaves, with its number.
fn towards<'a>(body: &TurnedPart<'a>, direction: &Vec3) -> (usize, &'a Face) {
    let mut best = (0, f64::NEG_INFINITY);
    for (face, normal) in body.normals.iter().enumerate() {
        let inverse_length = normal.dot(direction) / body.part.offsets[face];
        if inverse_length > best.1 {
            best = (face, inverse_length);
        }
    }
    (best.0, &body.part.polytope.faces[best.0])
}

/// The edges of a face.
fn rim(face: &Face) -> impl Iterator<Item = (usize, usize)> {
    let next = face.corners.iter().cycle().skip(1);
    face.corners.iter().copied().zip(next.copied())
}

/// The point of a face nearest to a point.
fn on_face(body: &TurnedPart<'_>, face: (usize, &Face), point: &Vec3) -> Vec3 {
    foot_on_face(body, face, point).0
}

/// Variant of [`on_face`] that also returns the dimension of the feature the point lies on: the
/// face, an edge or a corner.
#[inline]
fn foot_on_face(
    body: &TurnedPart<'_>,
    (number, face): (usize, &Face),
    point: &Vec3,
) -> (Vec3, usize) {
    let normal = body.normals[number];
    let height = normal.dot(point) - body.part.offsets[number];
    let foot = point - height * normal;
    let mut best = (f64::INFINITY, foot);
    let mut dimensions = 2;
    for (from, to) in rim(face) {
        let (from, to) = (body.corners[from], body.corners[to]);
        // Outside this edge of the face: its foot is on the edge or at a corner.
        if normal.dot(&(to - from).cross(&(foot - from))) < 0.0 {
            let edge = to - from;
            let place = (point - from).dot(&edge) / edge.norm_squared();
            let on_edge = from + place.clamp(0.0, 1.0) * edge;
            let squared = (on_edge - point).norm_squared();
            let is_within = usize::from(place > 0.0 && place < 1.0);
            if precedes((squared, is_within), (best.0, dimensions % 2)) {
                best = (squared, on_edge);
                dimensions = is_within;
            }
        }
    }
    (best.1, dimensions)
}

/// The point of a polyhedron nearest to a point outside; `None` for a point inside.
fn nearest(body: &TurnedPart<'_>, point: &Vec3) -> Option<Vec3> {
    foot(body, point).map(|(foot, _)| foot)
}

/// The closest points of two segments (Ericson, Real-Time Collision Detection (2005), 5.1.9).
fn between_segments(first: [Vec3; 2], second: [Vec3; 2]) -> ClosestPoints {
    let (u, v) = (first[1] - first[0], second[1] - second[0]);
    let r = first[0] - second[0];
    let (a, b, c) = (u.norm_squared(), u.dot(&v), v.norm_squared());
    let (d, e) = (u.dot(&r), v.dot(&r));
    let determinant = a * c - b * b;
    // Parallel: any point of the first serves, and the clamps find its partner.
    let mut s = match determinant > f64::EPSILON * a * c {
        true => ((b * e - c * d) / determinant).clamp(0.0, 1.0),
        false => 0.0,
    };
    let mut t = (b * s + e) / c;
    // Where t leaves its segment, s is found again for the clamped end.
    if t < 0.0 {
        t = 0.0;
        s = (-d / a).clamp(0.0, 1.0);
    } else if t > 1.0 {
        t = 1.0;
        s = ((b - d) / a).clamp(0.0, 1.0);
    }
    ClosestPoints {
        on_first: first[0] + s * u,
        on_second: second[0] + t * v,
    }
}
