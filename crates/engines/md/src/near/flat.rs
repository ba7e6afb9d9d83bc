//! Forces between polygons and disks in a plane.
//!
//! The normals of the faces of two polygons are all the directions in which they can be told apart,
//! and one of the closest points is a corner. So a face that separates the pair by more than the
//! reach says that there is no force; it is tried first, because it was so a step before. If there is
//! none, the best face says which corners of the other body, and of its own, can be near at all.

use super::{Felt, Hint, Law, SURELY_BEYOND, TurnedPart};
use crate::pair::Form;
use crate::pair::features::{on_segment, precedes};
use protomer_kernel::Vec3;

/// A plane that separates two bodies.
struct Separation {
    /// Normal of the plane, from the body with the face to the other.
    normal: Vec3,
    /// Distance along the normal between the highest point of the body with the face and the lowest
    /// of the other.
    gap: f64,
    top: f64,
    /// Whether the face is of the second body.
    is_of_second: bool,
}

/// The energy, force and torques of two bodies in a plane; `between` leads from the centre of the
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
    // Spheres first: no look at corners for pairs that are far apart.
    if between.norm_squared() > apart * apart {
        return Felt::nothing();
    }
    let mut sum = Sum {
        law,
        between,
        felt: Felt::nothing(),
    };
    if first.part.is_round() || second.part.is_round() {
        return of_disks(&first, &second, sum);
    }
    // A margin on the reach: a pair that is surely beyond leaves no force, whatever the rounding.
    let separation = match separation(&first, &second, between, law.reach * SURELY_BEYOND, hint) {
        Some(separation) if separation.gap <= 0.0 => return Felt::touching(),
        Some(separation) => separation,
        None => return Felt::nothing(),
    };
    let mut closest = ((f64::INFINITY, 0), Vec3::zeros(), Vec3::zeros());
    let mut note = |candidate: (f64, usize), on_first: Vec3, on_second: Vec3| {
        if precedes(candidate, closest.0) {
            closest = (candidate, on_first, on_second);
        }
    };
    let (with_face, other, way) = match separation.is_of_second {
        false => (&first, &second, between),
        true => (&second, &first, -between),
    };
    let bottom = separation.top + separation.gap;
    for corner in other.corners {
        let place = way + corner;
        // Higher above the face than the reach: no point of the body with the face is near enough.
        if separation.normal.dot(&place) - separation.top >= law.reach {
            continue;
        }
        // A corner inside the other body: they overlap.
        let Some((foot, dimensions)) = foot(with_face, &place) else {
            return Felt::touching();
        };
        let [on_first, on_second] = match separation.is_of_second {
            false => [foot, *corner],
            true => [*corner, foot],
        };
        let distance = sum.distance(&on_first, &on_second);
        note((distance, dimensions), on_first, on_second);
        if form == Form::Smooth {
            sum.repel(on_first, on_second, distance);
        }
    }
    // Now the corners of the body with the face, against the other body.
    for corner in with_face.corners {
        if bottom - separation.normal.dot(corner) >= law.reach {
            continue;
        }
        let Some((foot, dimensions)) = foot(other, &(corner - way)) else {
            return Felt::touching();
        };
        let [on_first, on_second] = match separation.is_of_second {
            false => [*corner, foot],
            true => [foot, *corner],
        };
        let distance = sum.distance(&on_first, &on_second);
        note((distance, dimensions), on_first, on_second);
        if form == Form::Smooth {
            sum.repel(on_first, on_second, distance);
        }
    }
    let ((distance, _), on_first, on_second) = closest;
    // `Smooth` has added every corner above; the others act between the closest points.
    if distance < law.reach {
        match form {
            Form::Smooth => {}
            Form::Contact => sum.repel(on_first, on_second, distance),
            Form::FaceSum => sum.add_faces(&first, &second, on_first, on_second),
        }
    }
    sum.felt
}

/// The face that separates the bodies most; `None` if one does by more than the reach. Without any,
/// the gap is not positive.
fn separation(
    first: &TurnedPart<'_>,
    second: &TurnedPart<'_>,
    between: Vec3,
    reach: f64,
    hint: &mut Hint,
) -> Option<Separation> {
    let faces = first.normals.len();
    let gap = |face: usize| {
        let (body, other, way, number) = match face < faces {
            true => (first, second, between, face),
            false => (second, first, -between, face - faces),
        };
        let normal = body.normals[number];
        let mut lowest = f64::INFINITY;
        for corner in other.corners {
            lowest = lowest.min(normal.x * corner.x + normal.y * corner.y);
        }
        lowest + normal.dot(&way) - body.part.offsets[number]
    };
    // The number may be of other bodies if the list has changed; it is only a place to begin.
    let remembered = (hint.face as usize).min(faces + second.normals.len() - 1);
    let mut best = (remembered, gap(remembered));
    // Still separated by the same face: one pass over corners, no search.
    if best.1 > reach {
        return None;
    }
    for face in 0..faces + second.normals.len() {
        let gap = gap(face);
        if gap > best.1 {
            best = (face, gap);
            // Beyond the reach: no better face is needed.
            if gap > reach {
                break;
            }
        }
    }
    hint.face = best.0 as u32;
    let is_of_second = best.0 >= faces;
    let (body, number) = match is_of_second {
        false => (first, best.0),
        true => (second, best.0 - faces),
    };
    // A face that separates by more than the reach was remembered above for the next step.
    (best.1 <= reach).then(|| Separation {
        normal: body.normals[number],
        gap: best.1,
        top: body.part.offsets[number],
        is_of_second,
    })
}

/// The point of a polygon nearest to a point outside; `None` for a point inside.
fn nearest(body: &TurnedPart<'_>, point: &Vec3) -> Option<Vec3> {
    foot(body, point).map(|(foot, _)| foot)
}

/// Variant of [`nearest`] that also returns the dimension of the feature the point lies on: an edge
/// or a corner.
fn foot(body: &TurnedPart<'_>, point: &Vec3) -> Option<(Vec3, usize)> {
    let (normals, corners) = (body.normals, body.corners);
    // The face that sees the point best: its foot is on it or near.
    let mut best = (0, f64::NEG_INFINITY);
    for (face, normal) in normals.iter().enumerate() {
        let height = normal.x * point.x + normal.y * point.y - body.part.offsets[face];
        if height > best.1 {
            best = (face, height);
        }
    }
    if best.1 <= 0.0 {
        return None;
    }
    // From face to face towards the foot of the point; a corner is where it turns back.
    let count = corners.len();
    let mut face = best.0;
    let mut came = 0;
    for _ in 0..count {
        let from = corners[face];
        // The next corner without a division.
        let edge = corners[if face + 1 == count { 0 } else { face + 1 }] - from;
        let place = (point - from).dot(&edge) / edge.norm_squared();
        if place < 0.0 {
            // Came from the other side: the foot is the corner between.
            if came > 0 {
                return Some((from, 0));
            }
            came = -1;
            face = if face == 0 { count - 1 } else { face - 1 };
        } else if place > 1.0 {
            if came < 0 {
                return Some((from + edge, 0));
            }
            came = 1;
            face = if face + 1 == count { 0 } else { face + 1 };
        } else {
            return Some((from + place * edge, 1));
        }
    }
    Some((corners[face], 0))
}

/// Interaction of two disks, or of a disk and a polygon: the centre of a disk repels the other
/// body.
fn of_disks(first: &TurnedPart<'_>, second: &TurnedPart<'_>, mut sum: Sum<'_>) -> Felt {
    let centre = Vec3::zeros();
    let (on_first, on_second) = match (first.part.is_round(), second.part.is_round()) {
        (true, true) => (Some(centre), Some(centre)),
        (true, false) => (Some(centre), nearest(second, &-sum.between)),
        (false, _) => (nearest(first, &sum.between), Some(centre)),
    };
    let (Some(on_first), Some(on_second)) = (on_first, on_second) else {
        return Felt::touching();
    };
    let distance = sum.distance(&on_first, &on_second);
    sum.repel(on_first, on_second, distance);
    sum.felt
}

/// Sum of the repulsions of points.
struct Sum<'a> {
    law: &'a Law,
    between: Vec3,
    felt: Felt,
}

impl Sum<'_> {
    fn distance(&self, on_first: &Vec3, on_second: &Vec3) -> f64 {
        (on_first - on_second - self.between).norm()
    }

    /// Adds the repulsion of two points, each from the centre of its body.
    fn repel(&mut self, on_first: Vec3, on_second: Vec3, distance: f64) {
        if distance >= self.law.reach {
            return;
        }
        let x = distance - self.law.radii;
        // Cores that touch through their layers: no finite energy.
        if x <= 0.0 {
            self.felt = Felt::touching();
            return;
        }
        let [energy, slope] = self.law.radial.energy_and_slope(x);
        self.felt.energy += energy;
        let separation = on_first - on_second - self.between;
        let force = separation * (-slope / distance);
        self.felt.force += force;
        // Torques in a plane have one component.
        self.felt.torques[0].z += on_first.x * force.y - on_first.y * force.x;
        self.felt.torques[1].z -= on_second.x * force.y - on_second.y * force.x;
    }

    /// Adds the corners of the two faces that look at each other, each against the other face.
    fn add_faces(
        &mut self,
        first: &TurnedPart<'_>,
        second: &TurnedPart<'_>,
        on_first: Vec3,
        on_second: Vec3,
    ) {
        let faces = [
            towards(first, &(on_second + self.between)),
            towards(second, &(on_first - self.between)),
        ];
        for corner in faces[0] {
            let foot = on_segment(&faces[1], &(corner - self.between));
            self.repel(corner, foot, self.distance(&corner, &foot));
        }
        for corner in faces[1] {
            let foot = on_segment(&faces[0], &(corner + self.between));
            self.repel(foot, corner, self.distance(&foot, &corner));
        }
    }
}

/// The face through which a ray from the centre leaves.
fn towards(body: &TurnedPart<'_>, direction: &Vec3) -> [Vec3; 2] {
    let mut best = (0, f64::NEG_INFINITY);
    for (face, normal) in body.normals.iter().enumerate() {
        let inverse_length = normal.dot(direction) / body.part.offsets[face];
        if inverse_length > best.1 {
            best = (face, inverse_length);
        }
    }
    let next = (best.0 + 1) % body.corners.len();
    [body.corners[best.0], body.corners[next]]
}
