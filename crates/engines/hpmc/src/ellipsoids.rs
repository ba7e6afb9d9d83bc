//! Whether two ellipsoids, or in a plane ellipses, overlap, and whether one covers the centre of a depletant.
//!
//! With the turned half axes of a body as the columns of a matrix H, the body is the set of H u with |u| ≤ 1, and
//! A = H Hᵀ. For two bodies at a distance r, and λ between 0 and 1, let
//!
//! ```text
//! M = (1 - λ) A + λ B,  x = M⁻¹ r,  p = xᵀ A x,  q = xᵀ B x
//! ```
//!
//! (Perram and Wertheim, J. Comput. Phys. 58, 409 (1985)). The point (1 - λ) A x from the centre of the first body lies
//! in it if (1 - λ)² p ≤ 1, and in the second if λ² q ≤ 1: then they overlap. The direction x separates them if
//! r·x > √p + √q: then they do not. Both are proofs, whatever λ is. At the root of (1 - λ)² p - λ² q, which falls
//! with λ, one of them holds, but for bodies that touch to within rounding; these count as overlapping. The root is
//! sought by Newton's method between its bounds.

use protomer_kernel::shape::separation::{Block, LANES, dot};

/// Largest number of steps: bisection alone narrows the bounds to rounding by then.
const MOST_STEPS: usize = 60;

/// Squared reach of a body with these half axes along a direction.
#[inline]
fn squared_reach<const D: usize>(axes: &Block<D>, direction: &[f64; D]) -> f64 {
    // The half axes lie in lanes: one factor, all of them, one vector operation.
    let mut heights = [0.0; LANES];
    for (row, factor) in axes.iter().zip(direction) {
        for (height, x) in heights.iter_mut().zip(row) {
            *height += factor * x;
        }
    }
    heights[..D].iter().map(|height| height * height).sum()
}

/// Reach of a body with these half axes along the last coordinate.
pub(crate) fn reach_along_last<const D: usize>(axes: &Block<D>) -> f64 {
    axes[D - 1][..D].iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Whether a direction proves that two bodies are apart.
#[inline]
pub(crate) fn is_separated_along<const D: usize>(
    first: &Block<D>,
    second: &Block<D>,
    offset: &[f64; D],
    direction: &[f64; D],
) -> bool {
    let height = dot(offset, direction);
    // Without roots, which would cost as much as the rest: h > a + b with h, a, b ≥ 0 is h² - a² - b² > 2 a b.
    let [p, q] = [first, second].map(|axes| squared_reach(axes, direction));
    let excess = height * height - p - q;
    height > 0.0 && excess > 0.0 && excess * excess > 4.0 * p * q
}

/// Whether two bodies with these half axes overlap, the second at an offset from the first. Of bodies that do not, the direction is set
/// to one that separates them.
pub(crate) fn overlap<const D: usize>(
    first: &Block<D>,
    second: &Block<D>,
    offset: &[f64; D],
    direction: &mut [f64; D],
) -> bool {
    let (a, b) = (squared(first), squared(second));
    let mut bounds = [0.0, 1.0];
    let mut lambda = 0.5;
    for _ in 0..MOST_STEPS {
        let mut matrix = [[0.0; D]; D];
        for row in 0..D {
            for column in 0..D {
                matrix[row][column] = (1.0 - lambda) * a[row][column] + lambda * b[row][column];
            }
        }
        let factor = Factor::from_matrix(&matrix);
        let x = factor.solve(offset);
        let (ax, bx) = (times(&a, &x), times(&b, &x));
        let (p, q) = (dot(&x, &ax), dot(&x, &bx));
        let (inside_first, inside_second) = ((1.0 - lambda).powi(2) * p, lambda * lambda * q);
        if inside_first <= 1.0 && inside_second <= 1.0 {
            return true;
        }
        let height = dot(offset, &x);
        if height > p.sqrt() + q.sqrt() {
            *direction = x;
            return false;
        }
        let excess = inside_first - inside_second;
        bounds[usize::from(excess <= 0.0)] = lambda;
        // x' = -y with M y = (B - A) x, and with it the slope of the excess.
        let mut change = [0.0; D];
        for axis in 0..D {
            change[axis] = bx[axis] - ax[axis];
        }
        let y = factor.solve(&change);
        let slope = -2.0 * (1.0 - lambda) * p
            - 2.0 * lambda * q
            - 2.0 * (1.0 - lambda).powi(2) * dot(&y, &ax)
            + 2.0 * lambda * lambda * dot(&y, &bx);
        let next = lambda - excess / slope;
        let middle = 0.5 * (bounds[0] + bounds[1]);
        // A step out of the bounds, or no number.
        lambda = match bounds[0] < next && next < bounds[1] {
            true => next,
            false => middle,
        };
    }
    true
}

/// Whether a point is within a radius of the body with these half axes: whether a ball about the point and the body overlap.
pub(crate) fn covers<const D: usize>(axes: &Block<D>, point: &[f64; D], radius: f64) -> bool {
    let mut ball = [[0.0; LANES]; D];
    for (axis, row) in ball.iter_mut().enumerate() {
        row[axis] = radius;
    }
    overlap(axes, &ball, point, &mut { *point })
}

/// The matrix H Hᵀ of half axes.
#[inline]
fn squared<const D: usize>(axes: &Block<D>) -> [[f64; D]; D] {
    let mut matrix = [[0.0; D]; D];
    for row in 0..D {
        for column in 0..=row {
            let products = axes[row][..D].iter().zip(&axes[column]).map(|(x, y)| x * y);
            let sum: f64 = products.sum();
            matrix[row][column] = sum;
            matrix[column][row] = sum;
        }
    }
    matrix
}

#[inline]
fn times<const D: usize>(matrix: &[[f64; D]; D], vector: &[f64; D]) -> [f64; D] {
    let mut product = [0.0; D];
    for (out, row) in product.iter_mut().zip(matrix) {
        *out = dot(row, vector);
    }
    product
}

/// A symmetric positive definite matrix as L D Lᵀ.
struct Factor<const D: usize> {
    lower: [[f64; D]; D],
    inverse_diagonal: [f64; D],
}

impl<const D: usize> Factor<D> {
    #[inline]
    fn from_matrix(matrix: &[[f64; D]; D]) -> Self {
        let (mut lower, mut inverse_diagonal) = ([[0.0; D]; D], [0.0; D]);
        let mut diagonal = [0.0; D];
        for column in 0..D {
            let mut sum = matrix[column][column];
            for before in 0..column {
                sum -= lower[column][before] * lower[column][before] * diagonal[before];
            }
            diagonal[column] = sum;
            inverse_diagonal[column] = 1.0 / sum;
            for row in column + 1..D {
                let mut sum = matrix[row][column];
                for before in 0..column {
                    sum -= lower[row][before] * lower[column][before] * diagonal[before];
                }
                lower[row][column] = sum * inverse_diagonal[column];
            }
        }
        Self {
            lower,
            inverse_diagonal,
        }
    }

    #[inline]
    fn solve(&self, right: &[f64; D]) -> [f64; D] {
        let mut solution = *right;
        for row in 0..D {
            for before in 0..row {
                solution[row] -= self.lower[row][before] * solution[before];
            }
        }
        for row in (0..D).rev() {
            solution[row] *= self.inverse_diagonal[row];
            for after in row + 1..D {
                solution[row] -= self.lower[after][row] * solution[after];
            }
        }
        solution
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::HardBody;
    use protomer_kernel::bisection::halved;
    use protomer_kernel::random::{CounterRng, Purpose};
    use protomer_kernel::shape::ellipsoid::measures_of_ellipsoid;
    use protomer_kernel::{Rotation, Vec3};

    /// The largest of r·n - |Hₐᵀ n| - |H_bᵀ n| over unit vectors n: positive for bodies apart. It is concave along great circles about its
    /// largest value, so a search from the best of many directions finds it.
    fn gap<const D: usize>(first: &Block<D>, second: &Block<D>, offset: &[f64; D]) -> f64 {
        let value = |n: &[f64; D]| {
            let length = dot(n, n).sqrt();
            let n = n.map(|x| x / length);
            let reach = |axes| squared_reach(axes, &n).sqrt();
            dot(offset, &n) - reach(first) - reach(second)
        };
        let mut rng = CounterRng::for_purpose(7, 0, 0, Purpose::HardBodyStart);
        let mut best = *offset;
        let mut largest = value(&best);
        let mut width = 1.0;
        for step in 0..6000 {
            let trial: [f64; D] = std::array::from_fn(|axis| {
                best[axis] / dot(&best, &best).sqrt() + width * rng.normal_pair()[0]
            });
            let height = value(&trial);
            if height > largest {
                (best, largest) = (trial, height);
            }
            if step % 100 == 99 {
                width *= 0.75;
            }
        }
        largest
    }

    fn random_rotation<const D: usize>(rng: &mut CounterRng) -> Rotation {
        let [w, x] = rng.normal_pair();
        let [y, z] = rng.normal_pair();
        match D {
            2 => Rotation::from_scaled_axis(w * 3.0 * Vec3::z()),
            _ => Rotation::new_normalize(nalgebra::Quaternion::new(w, x, y, z)),
        }
    }

    fn compare<const D: usize>(kinds: &[[f64; D]], pairs: u64) {
        let bodies: Vec<HardBody<D>> = kinds
            .iter()
            .map(|axes| HardBody::ellipsoid(*axes).unwrap())
            .collect();
        let (mut apart, mut together) = (0, 0);
        for pair in 0..pairs {
            let mut rng = CounterRng::for_purpose(11, D as u32, pair, Purpose::HardBodyStart);
            let [one, other] = [
                &bodies[pair as usize % bodies.len()],
                &bodies[(pair / 2) as usize % bodies.len()],
            ];
            let mut axes = [[[[0.0; 4]; D]; 1]; 2];
            one.turned_into(&random_rotation::<D>(&mut rng), &mut axes[0]);
            other.turned_into(&random_rotation::<D>(&mut rng), &mut axes[1]);
            let normal: [f64; D] = std::array::from_fn(|_| rng.normal_pair()[0]);
            let length = dot(&normal, &normal).sqrt();
            let inner = one.inner_radius + other.inner_radius;
            let outer = one.outer_radius + other.outer_radius;
            let distance =
                inner + (outer - inner) * (0.5 + 0.35 * rng.normal_pair()[0]).clamp(0.0, 1.0);
            let offset = normal.map(|x| x / length * distance);
            let gap = gap(&axes[0][0], &axes[1][0], &offset);
            if gap.abs() < 1e-4 {
                continue;
            }
            let mut direction = offset;
            let overlaps = overlap(&axes[0][0], &axes[1][0], &offset, &mut direction);
            assert_eq!(overlaps, gap < 0.0, "pair {pair}: {gap}");
            assert_eq!(
                overlaps,
                one.overlaps_at(other, &axes[0], &axes[1], &offset)
            );
            if overlaps {
                together += 1;
            } else {
                apart += 1;
                assert!(is_separated_along(
                    &axes[0][0],
                    &axes[1][0],
                    &offset,
                    &direction
                ));
            }
        }
        assert!(
            apart.min(together) > pairs / 5,
            "{apart} apart, {together} together"
        );
    }

    #[test]
    fn decisions_are_those_of_the_best_separating_direction() {
        compare::<3>(&[[1.0, 1.0, 3.0], [0.4, 1.0, 1.5], [1.0; 3]], 400);
        compare::<2>(&[[1.0, 4.0], [0.5, 0.5]], 300);
    }

    #[test]
    fn balls_meet_at_the_sum_of_their_radii() {
        let bodies = [0.7, 1.1].map(|radius| HardBody::<3>::ellipsoid([radius; 3]).unwrap());
        let axes = bodies.each_ref().map(|body| {
            let mut axes = [[[0.0; 4]; 3]];
            body.turned_into(&Rotation::identity(), &mut axes);
            axes[0]
        });
        for (distance, expected) in [(1.8 - 1e-12, true), (1.8 + 1e-12, false)] {
            let mut direction = [0.0; 3];
            let offset = [0.6 * distance, 0.0, 0.8 * distance];
            assert_eq!(
                overlap(&axes[0], &axes[1], &offset, &mut direction),
                expected
            );
        }
    }

    /// Long bodies, tip to tip and tip to side, where λ is far from the middle.
    #[test]
    fn needles_and_plates_are_decided_close_to_contact() {
        for half_axes in [[1.0, 1.0, 100.0], [100.0, 100.0, 1.0]] {
            let body = HardBody::<3>::ellipsoid(half_axes).unwrap();
            let mut upright = [[[0.0; 4]; 3]];
            body.turned_into(&Rotation::identity(), &mut upright);
            let mut lying = upright;
            let quarter = Rotation::from_scaled_axis(std::f64::consts::FRAC_PI_2 * Vec3::x());
            body.turned_into(&quarter, &mut lying);
            for (second, contact) in [
                (&upright, 2.0 * half_axes[2]),
                (&lying, half_axes[2] + half_axes[1]),
            ] {
                for (factor, expected) in [(1.0 - 1e-9, true), (1.0 + 1e-9, false)] {
                    let offset = [0.0, 0.0, contact * factor];
                    let mut direction = offset;
                    let decision = overlap(&upright[0], &second[0], &offset, &mut direction);
                    assert_eq!(decision, expected, "{half_axes:?} at {factor}");
                }
            }
        }
    }

    /// The distance of a point from the surface of a body with half axes along the coordinates: the nearest point is
    /// (hᵢ² xᵢ / (hᵢ² + t))ᵢ, and t is where it lies on the surface (Hart, Graphics Gems IV (1994), 113). By bisection.
    fn distance<const D: usize>(half_axes: &[f64; D], point: &[f64; D]) -> f64 {
        let nearest = |t: f64| -> [f64; D] {
            std::array::from_fn(|axis| {
                let squared = half_axes[axis] * half_axes[axis];
                squared * point[axis] / (squared + t)
            })
        };
        let is_outside = |t: f64| {
            let parts = nearest(t).into_iter().zip(half_axes).map(|(x, h)| x / h);
            parts.map(|part| part * part).sum::<f64>() > 1.0
        };
        let foot = nearest(halved([0.0, 1e6], 200, is_outside)[0]);
        let apart: [f64; D] = std::array::from_fn(|axis| point[axis] - foot[axis]);
        match is_outside(0.0) {
            true => dot(&apart, &apart).sqrt(),
            false => 0.0,
        }
    }

    fn compare_cover<const D: usize>(half_axes: [f64; D], radius: f64) {
        let body = HardBody::ellipsoid(half_axes).unwrap();
        let mut axes = [[[0.0; 4]; D]];
        let mut covered = 0;
        for number in 0..4000 {
            let mut rng = CounterRng::for_purpose(13, D as u32, number, Purpose::HardBodyStart);
            let rotation = random_rotation::<D>(&mut rng);
            body.turned_into(&rotation, &mut axes);
            let point: [f64; D] = std::array::from_fn(|axis| {
                (half_axes[axis] + 1.5 * radius) * rng.uniform_in(-1.0, 1.0)
            });
            let turn = protomer_kernel::shape::separation::matrix::<D>(&rotation);
            let turned: [f64; D] = std::array::from_fn(|row| dot(&turn[row], &point));
            let distance = distance(&half_axes, &point);
            let expected = distance < radius;
            assert_eq!(
                body.covers(&axes, &turned, radius),
                expected,
                "{point:?} at {distance} of {half_axes:?}"
            );
            covered += usize::from(expected);
        }
        assert!((400..3600).contains(&covered), "{covered}");
    }

    /// Flat, long and triaxial bodies, and depletants smaller and larger than they.
    #[test]
    fn points_are_covered_that_are_nearer_than_the_radius() {
        for radius in [0.05, 0.3, 2.0] {
            compare_cover([1.0, 1.0, 3.0], radius);
            compare_cover([0.4, 1.0, 1.5], radius);
            compare_cover([1.0, 1.0, 0.1], radius);
            compare_cover([1.0, 4.0], radius);
        }
    }

    /// The second virial coefficient by random pairs is that of the measures (Isihara).
    #[test]
    fn the_second_virial_coefficient_is_that_of_convex_bodies() {
        for half_axes in [[1.0, 1.0, 3.0], [0.5, 1.0, 1.6], [1.0, 1.0, 0.25]] {
            let body = HardBody::<3>::ellipsoid(half_axes).unwrap();
            let edge = 2.0 * body.outer_radius;
            let (mut hits, trials) = (0_u32, 40_000);
            for trial in 0..trials {
                let mut rng = CounterRng::for_purpose(5, 0, trial, Purpose::HardBodyStart);
                let mut axes = [[[[0.0; 4]; 3]; 1]; 2];
                for axes in &mut axes {
                    body.turned_into(&random_rotation::<3>(&mut rng), axes);
                }
                let offset = std::array::from_fn(|_| edge * (2.0 * rng.uniform() - 1.0));
                hits += u32::from(body.overlaps_at(&body, &axes[0], &axes[1], &offset));
            }
            let part = f64::from(hits) / trials as f64;
            let volume = (2.0 * edge).powi(3);
            let [b2, error] =
                [part, (part * (1.0 - part) / trials as f64).sqrt()].map(|x| 0.5 * x * volume);
            let exact = measures_of_ellipsoid(&half_axes, 0.0).unwrap().b2;
            assert!(
                (b2 - exact).abs() < 4.0 * error,
                "{half_axes:?}: {b2} ± {error}, {exact}"
            );
            assert!(error < 0.03 * exact);
        }
    }
}
