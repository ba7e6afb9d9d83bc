//! The closest points of two bodies that moved little since they were last looked at.
//!
//! The walk is that of [`closest`](super::closest). It begins at the simplex where the last one
//! ended, so bodies in slow motion cost one step. It stops early once a plane shows that the bodies
//! are farther apart than the caller asks, and it allocates nothing.

use super::closest::{CONVERGED, ClosestPoints, Corner, MOST_STEPS, Nearest, TOUCHING};
use crate::Vec3;
use serde::{Deserialize, Serialize};

/// The corners, of both bodies, at which a walk ended.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Simplex {
    count: usize,
    corners: [[u32; 2]; 4],
}

/// Result of a walk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Found {
    /// The bodies touch or overlap.
    Touching,
    /// The bodies are farther apart than asked: a plane across this direction of length one, from
    /// the first to the second, shows it.
    Beyond(Vec3),
    /// The closest points.
    At(ClosestPoints),
}

/// Two bodies: corners about a centre each, and the vector from the first centre to the second.
#[derive(Debug, Clone, Copy)]
pub struct Bodies<'a> {
    /// Corners of the first body, from its centre.
    pub first: &'a [Vec3],
    /// Corners of the second body, from its centre.
    pub second: &'a [Vec3],
    /// Vector from the centre of the first body to that of the second.
    pub between: Vec3,
}

impl Bodies<'_> {
    /// The closest points, from the centre of the first body, if they are nearer than `reach`. The
    /// simplex is where the last walk ended, or the default one; the corners must be as many as they
    /// were then.
    ///
    /// ```
    /// use protomer_kernel::{Vec3, shape::remembered::{Bodies, Found, Simplex}};
    /// let segment = [-Vec3::x(), Vec3::x()];
    /// let bodies = Bodies { first: &segment, second: &[Vec3::zeros()], between: 2.0 * Vec3::y() };
    /// let mut simplex = Simplex::default();
    /// let Found::At(points) = bodies.closest(3.0, &mut simplex) else { panic!() };
    /// assert_eq!(points.distance(), 2.0);
    /// assert_eq!(bodies.closest(1.0, &mut simplex), Found::Beyond(Vec3::y()));
    /// ```
    pub fn closest(&self, reach: f64, simplex: &mut Simplex) -> Found {
        let mut corners = [self.corner([0, 0]); 4];
        // The default simplex has no corner yet; it begins with the first of each body.
        let count = simplex.count.clamp(1, 4);
        for (corner, numbers) in corners.iter_mut().zip(simplex.corners).take(count) {
            *corner = self.corner(numbers);
        }
        let mut walk = Walk {
            count,
            corners,
            numbers: simplex.corners,
        };
        let outcome = self.walk(reach, &mut walk);
        *simplex = Simplex {
            count: walk.count,
            corners: walk.numbers,
        };
        outcome
    }

    fn walk(&self, reach: f64, walk: &mut Walk) -> Found {
        let mut size_squared = 0.0_f64;
        for corner in &walk.corners[..walk.count] {
            size_squared = size_squared.max(corner.difference.norm_squared());
        }
        let mut nearest = Nearest::of_carriers(&walk.corners[..walk.count]);
        for _ in 0..MOST_STEPS {
            let squared = nearest.point.norm_squared();
            if squared <= TOUCHING * TOUCHING * size_squared {
                return Found::Touching;
            }
            // One pass over the corners of each body: the dominant cost of a step.
            let numbers = self.farthest(&-nearest.point);
            let next = self.corner(numbers);
            size_squared = size_squared.max(next.difference.norm_squared());
            // The plane through this corner, across the nearest point, separates the bodies.
            let height = nearest.point.dot(&next.difference);
            // Farther than asked: the direction is all the
            // caller needs, and the points are not sought.
            if height > 0.0 && height * height > reach * reach * squared {
                return Found::Beyond(-nearest.point / squared.sqrt());
            }
            let is_known = walk.numbers[..walk.count].contains(&numbers);
            if squared - height <= CONVERGED * size_squared || is_known {
                break;
            }
            // A copy of the whole walk: a step that rounding makes worse is taken back.
            let before = *walk;
            walk.keep_carriers(&nearest);
            walk.push(next, numbers);
            let closer = Nearest::of_carriers(&walk.corners[..walk.count]);
            if closer.point.norm_squared() >= squared {
                // Rounding: the simplex is as near as numbers can tell.
                *walk = before;
                break;
            }
            nearest = closer;
        }
        let mut points = ClosestPoints {
            on_first: Vec3::zeros(),
            on_second: Vec3::zeros(),
        };
        for (weight, corner) in nearest.weights.iter().zip(&walk.corners[..walk.count]) {
            points.on_first += *weight * corner.first;
            points.on_second += *weight * corner.second;
        }
        walk.keep_carriers(&nearest);
        Found::At(points)
    }

    fn corner(&self, [first, second]: [u32; 2]) -> Corner {
        let first = self.first[first as usize];
        let second = self.second[second as usize] + self.between;
        Corner {
            first,
            second,
            difference: first - second,
        }
    }

    /// The corners of the difference farthest in a direction.
    fn farthest(&self, direction: &Vec3) -> [u32; 2] {
        [
            highest(self.first, direction),
            highest(self.second, &-direction),
        ]
    }
}

fn highest(corners: &[Vec3], direction: &Vec3) -> u32 {
    let (mut best, mut height) = (0, f64::NEG_INFINITY);
    for (number, corner) in corners.iter().enumerate() {
        let projection = corner.dot(direction);
        if projection > height {
            (best, height) = (number, projection);
        }
    }
    best as u32
}

#[derive(Debug, Clone, Copy)]
struct Walk {
    count: usize,
    corners: [Corner; 4],
    numbers: [[u32; 2]; 4],
}

impl Walk {
    fn keep_carriers(&mut self, nearest: &Nearest) {
        let mut count = 0;
        for place in 0..self.count {
            if nearest.weights[place] > 0.0 {
                self.corners[count] = self.corners[place];
                self.numbers[count] = self.numbers[place];
                count += 1;
            }
        }
        self.count = count;
    }

    fn push(&mut self, corner: Corner, numbers: [u32; 2]) {
        self.corners[self.count] = corner;
        self.numbers[self.count] = numbers;
        self.count += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::super::builders::by_name;
    use super::super::closest::closest_points;
    use super::super::polytope::Polytope;
    use super::*;
    use crate::Pose;
    use crate::random::CounterRng;

    /// Moves two bodies past each other; each step begins where the last one ended.
    #[test]
    fn it_agrees_with_the_walk_from_nothing_along_a_path() {
        let mut rng = CounterRng::new(5, 0, 0);
        for name in ["cube", "octahedron", "prism:5,0.2", "icosahedron"] {
            let body = Polytope::from_shape(&by_name(name).unwrap()).unwrap();
            let reach = 2.0 * body.circumradius();
            let mut simplex = Simplex::default();
            let (mut seen, mut touching) = (0, 0);
            let mut place = reach * rng.unit_vector();
            let mut turns = [rng.rotation(), rng.rotation()];
            for _ in 0..4000 {
                place += 0.04 * rng.unit_vector();
                place *= place.norm().clamp(0.2 * reach, 0.9 * reach) / place.norm();
                turns = turns.map(|turn| rng.small_rotation(0.05) * turn);
                let corners = |n: usize, position: Vec3| {
                    let rotation = turns[n];
                    body.corners_at(&Pose { position, rotation })
                };
                let expected = closest_points(&corners(0, Vec3::zeros()), &corners(1, place));
                let bodies = Bodies {
                    first: &corners(0, Vec3::zeros()),
                    second: &corners(1, Vec3::zeros()),
                    between: place,
                };
                match (bodies.closest(0.5 * reach, &mut simplex), expected) {
                    (Found::Touching, None) => touching += 1,
                    (Found::Beyond(direction), Some(points)) => {
                        assert!(points.distance() > 0.5 * reach);
                        let heights = |n: usize| corners(n, Vec3::zeros()).into_iter();
                        let top = heights(0).map(|x| x.dot(&direction)).fold(-9.0, f64::max);
                        let low = heights(1).map(|x| x.dot(&direction)).fold(9.0, f64::min);
                        assert!(low + place.dot(&direction) - top > 0.5 * reach - 1e-12);
                    }
                    (Found::At(found), Some(points)) => {
                        assert!((found.distance() - points.distance()).abs() < 1e-12);
                        seen += 1;
                    }
                    (found, expected) => panic!("{name}: {found:?} {expected:?}"),
                }
            }
            assert!(seen > 300 && touching > 30, "{name}: {seen} {touching}");
        }
    }
}
