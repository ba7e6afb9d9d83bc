//! The closest points of two convex hulls of points (Gilbert, Johnson and Keerthi, IEEE J. Robot.
//! Autom. 4, 193 (1988)).
//!
//! The difference of two convex bodies is convex, and its point nearest to the origin is the
//! difference of the closest points. A simplex of at most four corners of the difference walks
//! towards it: at every step the corner farthest towards the origin joins, and those that do not
//! carry the nearest point leave. The nearest point of a simplex is found among the projections of
//! the origin on all its faces: fifteen at most, none of which needs a separate case.

use crate::Vec3;

/// Convergence criterion of the walk, which ends when a step would shorten the squared distance by
/// less than this part of the squared size.
pub(super) const CONVERGED: f64 = 1e-15;
/// Distance below which bodies touch, as a part of their size.
pub(super) const TOUCHING: f64 = 1e-14;
/// Limit on the number of steps: the walk visits a corner of the difference at most once, but for
/// rounding.
pub(super) const MOST_STEPS: usize = 500;

/// Squared sine of an angle above which a triangle is no sliver.
const WIDE: f64 = 1e-6;

/// The closest points of two bodies.
///
/// ```
/// use protomer_kernel::{Vec3, shape::closest::ClosestPoints};
/// let points = ClosestPoints { on_first: Vec3::new(3.0, 4.0, 0.0), on_second: Vec3::zeros() };
/// assert_eq!((points.separation(), points.distance()), (Vec3::new(3.0, 4.0, 0.0), 5.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosestPoints {
    /// The point of the first body.
    pub on_first: Vec3,
    /// The point of the second body.
    pub on_second: Vec3,
}

impl ClosestPoints {
    /// The vector from the second body to the first.
    ///
    /// ```
    /// use protomer_kernel::{Vec3, shape::closest::closest_points};
    /// let segment = [Vec3::zeros(), Vec3::x()];
    /// let closest = closest_points(&segment, &[Vec3::new(0.5, 2.0, 0.0)]);
    /// assert_eq!(closest.map(|points| points.separation()), Some(Vec3::new(0.0, -2.0, 0.0)));
    /// ```
    pub fn separation(&self) -> Vec3 {
        self.on_first - self.on_second
    }

    /// The distance between the bodies.
    ///
    /// ```
    /// use protomer_kernel::{Vec3, shape::closest::closest_points};
    /// let segment = [Vec3::zeros(), Vec3::x()];
    /// let closest = closest_points(&segment, &[Vec3::new(4.0, 4.0, 0.0)]);
    /// assert_eq!(closest.map(|points| points.distance()), Some(5.0), "from the end at (1, 0)");
    /// ```
    pub fn distance(&self) -> f64 {
        self.separation().norm()
    }
}

/// A corner of the difference, with the corners of the bodies whose difference it is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corner {
    pub(super) first: Vec3,
    pub(super) second: Vec3,
    pub(super) difference: Vec3,
}

/// Closest points of the convex hulls of two sets of points; `None` if the hulls touch or overlap,
/// or if a set is empty. Points in a plane are points with z = 0.
///
/// Where the closest points are not unique, as between parallel faces, these are some of them.
///
/// ```
/// use protomer_kernel::{Vec3, shape::closest::closest_points};
/// let segment = [Vec3::zeros(), Vec3::x()];
/// let point = [Vec3::new(0.25, 2.0, 0.0)];
/// let found = closest_points(&segment, &point).map(|points| points.on_first);
/// assert_eq!(found, Some(Vec3::new(0.25, 0.0, 0.0)));
/// ```
pub fn closest_points(first: &[Vec3], second: &[Vec3]) -> Option<ClosestPoints> {
    let corner = |direction: &Vec3| -> Option<Corner> {
        let first = *farthest(first, direction)?;
        let second = *farthest(second, &-direction)?;
        Some(Corner {
            first,
            second,
            difference: first - second,
        })
    };
    // The direction between two corners is as good a start as any, and never empty.
    let mut simplex = vec![corner(&(second.first()? - first.first()?))?];
    let mut size_squared = simplex[0].difference.norm_squared();
    let mut nearest = Nearest::from_simplex(&simplex);
    for _ in 0..MOST_STEPS {
        let squared = nearest.point.norm_squared();
        if squared <= TOUCHING * TOUCHING * size_squared {
            return None;
        }
        // The support of the difference towards the origin: no corner is farther that way.
        let next = corner(&-nearest.point)?;
        size_squared = size_squared.max(next.difference.norm_squared());
        let gain = squared - nearest.point.dot(&next.difference);
        let is_known = |corner: &Corner| corner.difference == next.difference;
        // A known corner cannot bring the point nearer; without this test, rounding could cycle.
        if gain <= CONVERGED * size_squared || simplex.iter().any(is_known) {
            break;
        }
        // At most three corners carry a point outside the origin, so the new one is the fourth.
        nearest.keep_carriers(&mut simplex);
        simplex.push(next);
        let closer = Nearest::from_simplex(&simplex);
        if closer.point.norm_squared() >= squared {
            // Rounding: the simplex is as near as numbers can tell.
            simplex.pop();
            // The weights must belong to the corners that are left.
            nearest = Nearest::from_simplex(&simplex);
            break;
        }
        nearest = closer;
    }
    let mut points = ClosestPoints {
        on_first: Vec3::zeros(),
        on_second: Vec3::zeros(),
    };
    for (weight, corner) in nearest.weights.iter().zip(&simplex) {
        points.on_first += *weight * corner.first;
        points.on_second += *weight * corner.second;
    }
    Some(points)
}

/// The corner farthest in a direction; of several, the first.
fn farthest<'a>(corners: &'a [Vec3], direction: &Vec3) -> Option<&'a Vec3> {
    let mut best = corners.first()?;
    let mut height = best.dot(direction);
    for corner in &corners[1..] {
        let projection = corner.dot(direction);
        if projection > height {
            (best, height) = (corner, projection);
        }
    }
    Some(best)
}

/// The point of a simplex nearest to the origin, as a mean of the corners with these weights.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearest {
    pub(super) point: Vec3,
    pub(super) weights: [f64; 4],
}

impl Nearest {
    pub(super) fn from_simplex(simplex: &[Corner]) -> Self {
        let mut best = Self {
            point: Vec3::repeat(f64::INFINITY),
            weights: [0.0; 4],
        };
        // The bits of `face` are corners: every subset but the empty one.
        for face in 1..1_usize << simplex.len() {
            if let Some(candidate) = Self::on_face(simplex, face)
                && candidate.point.norm_squared() < best.point.norm_squared()
            {
                best = candidate;
            }
        }
        best
    }

    /// Variant of [`Nearest::from_simplex`] for a simplex that probably carries its nearest point with all of
    /// its corners. The nearest point of the plane, line or point through them is the nearest of
    /// all, if it is inside. Slivers, whose projection suffers from rounding, are left to `of`.
    pub(super) fn of_carriers(simplex: &[Corner]) -> Self {
        let is_wide = match simplex {
            [a, b, c] => {
                let e = b.difference - a.difference;
                let f = c.difference - a.difference;
                let squared = e.cross(&f).norm_squared();
                squared > WIDE * e.norm_squared() * f.norm_squared()
            }
            [_, _] | [_] => true,
            _ => false,
        };
        let whole = (1 << simplex.len()) - 1;
        let candidate = is_wide.then(|| Self::on_face(simplex, whole)).flatten();
        candidate.unwrap_or_else(|| Self::from_simplex(simplex))
    }

    /// The projection of the origin on the plane through the corners whose bits are set; `None` if
    /// it is outside of them, or if they do not span a plane.
    fn on_face(simplex: &[Corner], face: usize) -> Option<Self> {
        let mut members = [0; 4];
        let mut count = 0;
        for number in 0..simplex.len() {
            if face >> number & 1 == 1 {
                members[count] = number;
                count += 1;
            }
        }
        let origin = simplex[members[0]].difference;
        let edge = |place: usize| simplex[members[place]].difference - origin;
        let mut weights = [0.0; 4];
        let mut coordinates = [0.0; 3];
        match count {
            1 => {}
            2 => {
                let e = edge(1);
                coordinates[0] = -origin.dot(&e) / e.norm_squared();
            }
            3 => {
                // Areas of the partial triangles, signed along the normal, over that of the whole.
                let [e, f] = [edge(1), edge(2)];
                let normal = e.cross(&f);
                let squared = normal.norm_squared();
                coordinates[0] = f.cross(&origin).dot(&normal) / squared;
                coordinates[1] = origin.cross(&e).dot(&normal) / squared;
            }
            _ => {
                // Cramer's rule. A flat tetrahedron divides by
                // zero, and its weights pass no comparison.
                let [e, f, g] = [edge(1), edge(2), edge(3)];
                let volume = e.dot(&f.cross(&g));
                coordinates[0] = -origin.dot(&f.cross(&g)) / volume;
                coordinates[1] = -e.dot(&origin.cross(&g)) / volume;
                coordinates[2] = -e.dot(&f.cross(&origin)) / volume;
            }
        }
        let first = 1.0 - coordinates.iter().sum::<f64>();
        let mut point = origin;
        weights[members[0]] = first;
        for place in 1..count {
            weights[members[place]] = coordinates[place - 1];
            point += coordinates[place - 1] * edge(place);
        }
        // Four corners with weights all positive hold the
        // origin itself; the sum would leave rounding.
        if count == 4 {
            point = Vec3::zeros();
        }
        let is_inside = weights.iter().all(|weight| *weight >= 0.0);
        (is_inside && point.norm_squared().is_finite()).then_some(Self { point, weights })
    }

    /// Drops the corners without weight.
    fn keep_carriers(&self, simplex: &mut Vec<Corner>) {
        let mut weights = self.weights.iter();
        simplex.retain(|_| weights.next().is_some_and(|weight| *weight > 0.0));
    }
}

#[cfg(test)]
mod tests {
    use super::super::builders::by_name;
    use super::super::polytope::Polytope;
    use super::*;
    use crate::random::CounterRng;
    use crate::{Pose, Rotation};

    fn on_segment(point: &Vec3, [a, b]: [Vec3; 2]) -> Vec3 {
        let along = b - a;
        let t = (point - a).dot(&along) / along.norm_squared();
        a + t.clamp(0.0, 1.0) * along
    }

    /// The nearest distance of two polytopes that do not overlap, by trying all features; zero if
    /// no face, and no pair of edges, has a plane that separates them.
    fn by_features(bodies: [&Polytope; 2], poses: [&Pose; 2]) -> f64 {
        let corners = [0, 1].map(|n| bodies[n].corners_at(poses[n]));
        let mut directions = Vec::new();
        let mut nearest = f64::INFINITY;
        for (n, other) in [(0, 1), (1, 0)] {
            for face in &bodies[n].faces {
                let normal = poses[n].rotation * face.normal;
                directions.push(normal);
                for point in &corners[other] {
                    let height = normal.dot(&(point - corners[n][face.corners[0]]));
                    let foot = point - height * normal;
                    let next = face.corners.iter().cycle().skip(1);
                    let is_inside = face.corners.iter().zip(next).all(|(from, to)| {
                        let along = corners[n][*to] - corners[n][*from];
                        match bodies[n].dimension {
                            2 => along.dot(&(foot - corners[n][*from])) >= 0.0,
                            _ => normal.dot(&along.cross(&(foot - corners[n][*from]))) >= 0.0,
                        }
                    });
                    if is_inside && height > 0.0 {
                        nearest = nearest.min(height);
                    }
                    for place in 0..face.corners.len() {
                        let ends = [place, (place + 1) % face.corners.len()];
                        let ends = ends.map(|end| corners[n][face.corners[end]]);
                        nearest = nearest.min((on_segment(point, ends) - point).norm());
                    }
                }
            }
        }
        for [a, b] in &bodies[0].edges {
            for [c, d] in &bodies[1].edges {
                let [a, b] = [corners[0][*a], corners[0][*b]];
                let [c, d] = [corners[1][*c], corners[1][*d]];
                let across = (b - a).cross(&(d - c));
                if across.norm() < 1e-9 {
                    continue;
                }
                let normal = across.normalize();
                directions.extend([normal, -normal]);
                let height = normal.dot(&(c - a));
                // The lines cross if the ends of each edge lie on both sides of the other.
                let side =
                    |x: &Vec3, from: &Vec3, to: &Vec3| normal.dot(&(to - from).cross(&(x - from)));
                let crosses = side(&a, &c, &d) * side(&b, &c, &d) <= 0.0
                    && side(&c, &a, &b) * side(&d, &a, &b) <= 0.0;
                if crosses {
                    nearest = nearest.min(height.abs());
                }
            }
        }
        let separates = |direction: &Vec3| {
            let heights = |n: usize| corners[n].iter().map(|x| x.dot(direction));
            let top = heights(0).fold(f64::NEG_INFINITY, f64::max);
            let bottom = heights(1).fold(f64::INFINITY, f64::min);
            bottom > top
        };
        let is_apart = directions
            .iter()
            .any(|direction| separates(direction) || separates(&-direction));
        if is_apart { nearest } else { 0.0 }
    }

    fn random_pose(rng: &mut CounterRng, dimension: usize, reach: f64) -> Pose {
        let mut position = rng.vector_in_ball(reach);
        let mut rotation = rng.rotation();
        if dimension == 2 {
            position.z = 0.0;
            rotation = Rotation::from_axis_angle(&Vec3::z_axis(), 7.0 * rng.uniform());
        }
        Pose { position, rotation }
    }

    fn compare(names: &[&str], poses: usize, seed: u64) {
        let shapes: Vec<Polytope> = names
            .iter()
            .map(|name| Polytope::from_shape(&by_name(name).unwrap()).unwrap())
            .collect();
        let mut rng = CounterRng::new(seed, 0, 0);
        let mut overlaps = 0;
        for number in 0..poses {
            let bodies = [0, 1].map(|n| &shapes[(number / (n * 2 + 1) + n) % shapes.len()]);
            if bodies[0].dimension != bodies[1].dimension {
                continue;
            }
            let reach = bodies[0].circumradius() + bodies[1].circumradius();
            let first = random_pose(&mut rng, bodies[0].dimension, 0.1);
            let mut second = random_pose(&mut rng, bodies[1].dimension, 1.2 * reach);
            if number % 3 == 0 {
                second.rotation = first.rotation; // parallel faces and edges
            }
            let expected = by_features(bodies, [&first, &second]);
            let corners = [bodies[0].corners_at(&first), bodies[1].corners_at(&second)];
            let found = closest_points(&corners[0], &corners[1]);
            let found = found.map_or(0.0, |points| points.distance());
            overlaps += usize::from(expected == 0.0);
            assert!(
                (found - expected).abs() < 1e-12,
                "{number}: {found} {expected}"
            );
        }
        assert!(
            overlaps > poses / 20 && overlaps < poses * 19 / 20,
            "{overlaps}"
        );
    }

    #[test]
    fn it_agrees_with_trying_all_features() {
        compare(
            &["cube", "octahedron", "tetrahedron", "prism:5,0.2"],
            4000,
            1,
        );
        compare(&["polygon:3", "polygon:4", "polygon:7"], 4000, 2);
    }

    #[test]
    #[ignore = "half a minute; run by name"]
    fn it_agrees_with_trying_all_features_a_million_times() {
        compare(
            &[
                "cube",
                "octahedron",
                "tetrahedron",
                "prism:5,0.2",
                "truncated-tetrahedron:0.6667",
            ],
            1_000_000,
            3,
        );
    }

    #[test]
    fn equal_bodies_at_equal_heights_give_the_gap() {
        let cube = Polytope::from_shape(&by_name("cube").unwrap()).unwrap();
        for shift in [0.0, 0.3, 0.999, 1.0] {
            let above = Pose {
                position: Vec3::new(shift, 0.2, 1.25),
                ..Pose::identity()
            };
            let points = closest_points(&cube.corners, &cube.corners_at(&above)).unwrap();
            assert!((points.distance() - 0.25).abs() < 1e-15);
            assert!((points.separation() + 0.25 * Vec3::z()).norm() < 1e-15);
        }
        let touching = Pose {
            position: Vec3::z(),
            ..Pose::identity()
        };
        assert_eq!(
            closest_points(&cube.corners, &cube.corners_at(&touching)),
            None
        );
        assert_eq!(closest_points(&cube.corners, &[]), None);
    }
}
