//! What is known exactly of ellipsoids and ellipses.
//!
//! An element of the sphere with the normal u becomes one of the ellipsoid with half axes a, b, c whose area is
//! the length of (bc u_x, ca u_y, ab u_z), and the support of the ellipsoid along u is the length of
//! (a u_x, b u_y, c u_z). So the surface is 4π times the mean of the first length over the sphere and the
//! integrated mean curvature 4π times that of the second. Such means are Carlson's symmetric integral
//! R_G of the squares (Carlson, Numer. Algorithms 10, 13 (1995)); the perimeter of an ellipse is
//! 8 R_G(0, a², b²).

use super::measures::{Measures, check_rounding, rounded_in_plane, rounded_in_space};
use crate::error::require;
use crate::{KernelError, Result};
use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// Range of half axes whose fourth powers neither overflow nor vanish.
const HALF_AXES: RangeInclusive<f64> = 1e-50..=1e50;

/// Measures of the Minkowski sum of an ellipse (two half axes) or an ellipsoid (three) with a disk
/// or a ball of this radius.
///
/// # Errors
/// [`KernelError::OutOfRange`] for a half axis outside 1e-50 to 1e50 or a negative radius,
/// [`KernelError::BadShape`] for a number of axes that is neither two nor three, and for a radius so
/// large that the measures overflow.
///
/// ```
/// use protomer_kernel::shape::ellipsoid::measures_of_ellipsoid;
/// let ball = measures_of_ellipsoid(&[0.5, 0.5, 0.5], 0.0)?;
/// assert!((ball.b2 - 4.0 * ball.volume).abs() < 1e-12);
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
pub fn measures_of_ellipsoid(half_axes: &[f64], rounding_radius: f64) -> Result<Measures> {
    check_rounding(rounding_radius)?;
    for axis in half_axes {
        let holds = HALF_AXES.contains(axis);
        require("a half axis", *axis, "1e-50 to 1e50", holds)?;
    }
    let measures = match half_axes {
        [a, b] => {
            let perimeter = 8.0 * symmetric_integral([0.0, a * a, b * b]);
            rounded_in_plane(PI * a * b, perimeter, rounding_radius)
        }
        [a, b, c] => {
            let ball = 4.0 * PI;
            let squares = [b * c, c * a, a * b].map(|x| x * x);
            rounded_in_space(
                ball / 3.0 * a * b * c,
                ball * symmetric_integral(squares),
                ball * symmetric_integral([a * a, b * b, c * c]),
                rounding_radius,
            )
        }
        _ => {
            let reason = "an ellipse has two half axes and an ellipsoid three";
            return Err(KernelError::BadShape(reason.into()));
        }
    };
    measures.if_finite()
}

/// Carlson's R_G: the mean over the unit sphere of √(x u_x² + y u_y² + z u_z²), for numbers of
/// which two are positive.
fn symmetric_integral(mut numbers: [f64; 3]) -> f64 {
    numbers.sort_unstable_by(f64::total_cmp);
    // In parts of the largest, so that no product overflows or vanishes; the formula wants the middle one
    // last, where it loses no digits.
    let largest = numbers[2];
    let [x, z, y] = numbers.map(|number| number / largest);
    let product = (x * y / z).sqrt();
    let correction = (x - z) * (y - z) / 3.0 * second_kind([x, y, z]);
    0.5 * largest.sqrt() * (z * first_kind([x, y, z]) - correction + product)
}

/// Relative error of both integrals.
const PRECISION: f64 = 1e-16;

/// Carlson's R_F, by duplication.
fn first_kind(numbers: [f64; 3]) -> f64 {
    let mean = numbers.iter().sum::<f64>() / 3.0;
    let largest = largest_distance(&numbers, mean);
    // Carlson's criterion: once `bound` is below the average, the series errs less than that.
    let mut bound = (3.0 * PRECISION).powf(-1.0 / 6.0) * largest;
    let (mut arguments, mut average) = (numbers, mean);
    while bound >= average.abs() {
        let step = duplication(&arguments);
        arguments = arguments.map(|x| 0.25 * (x + step));
        average = 0.25 * (average + step);
        // Each duplication brings the arguments four times as near to each other.
        bound *= 0.25;
    }
    let [x, y, _] = arguments.map(|number| (average - number) / average);
    let z = -x - y;
    let (e2, e3) = (x * y - z * z, x * y * z);
    // Terms up to the fifth order in the distances from the average (Carlson 1995).
    (1.0 - e2 / 10.0 + e3 / 14.0 + e2 * e2 / 24.0 - 3.0 * e2 * e3 / 44.0) / average.sqrt()
}

/// Carlson's R_D, by duplication.
fn second_kind(numbers: [f64; 3]) -> f64 {
    let mean = (numbers[0] + numbers[1] + 3.0 * numbers[2]) / 5.0;
    let largest = largest_distance(&numbers, mean);
    let mut bound = (0.25 * PRECISION).powf(-1.0 / 6.0) * largest;
    let (mut arguments, mut average) = (numbers, mean);
    let (mut sum, mut power) = (0.0, 1.0);
    while bound >= average.abs() {
        let step = duplication(&arguments);
        sum += power / (arguments[2].sqrt() * (arguments[2] + step));
        arguments = arguments.map(|x| 0.25 * (x + step));
        average = 0.25 * (average + step);
        power *= 0.25;
        bound *= 0.25;
    }
    let [x, y, _] = arguments.map(|number| (average - number) / average);
    let z = -(x + y) / 3.0;
    let e2 = x * y - 6.0 * z * z;
    let e3 = (3.0 * x * y - 8.0 * z * z) * z;
    let e4 = 3.0 * (x * y - z * z) * z * z;
    let e5 = x * y * z.powi(3);
    let series = 1.0 - 3.0 * e2 / 14.0 + e3 / 6.0 + 9.0 * e2 * e2 / 88.0
        - 3.0 * e4 / 22.0
        - 9.0 * e2 * e3 / 52.0
        + 3.0 * e5 / 26.0;
    power * series / (average * average.sqrt()) + 3.0 * sum
}

fn largest_distance(numbers: &[f64; 3], mean: f64) -> f64 {
    let distances = numbers.iter().map(|x| (mean - x).abs());
    distances.fold(0.0, f64::max)
}

/// The sum √(xy) + √(yz) + √(zx).
fn duplication([x, y, z]: &[f64; 3]) -> f64 {
    let [x, y, z] = [x, y, z].map(|number| number.sqrt());
    x * y + y * z + z * x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: f64, expected: f64) {
        assert!(
            (found / expected - 1.0).abs() < 1e-13,
            "{found} instead of {expected}"
        );
    }

    /// Compares the measures of spheroids with formulas in elementary functions.
    #[test]
    fn spheroids_have_their_elementary_formulas() {
        for ratio in [1.001_f64, 1.3, 4.0, 100.0] {
            let e = (1.0 - 1.0 / (ratio * ratio)).sqrt();
            let oblate = 2.0 * PI * ratio * ratio + PI / e * ((1.0 + e) / (1.0 - e)).ln();
            let prolate = 2.0 * PI * (1.0 + ratio / e * e.asin());
            let surface = |axes: [f64; 3]| measures_of_ellipsoid(&axes, 0.0).unwrap().surface;
            assert_near(surface([ratio, 1.0, ratio]), oblate);
            assert_near(surface([1.0, ratio, 1.0]), prolate);
        }
    }

    /// Compares with means over the sphere, computed slowly by many points in z and angle.
    #[test]
    fn three_axes_have_their_means_over_the_sphere() {
        let axes = [0.7, 1.1, 1.9];
        let found = measures_of_ellipsoid(&axes, 0.0).unwrap();
        let (nodes, parts) = (4000, 400);
        let mean = |weights: [f64; 3]| {
            let mut sum = 0.0;
            for i in 0..nodes {
                // Simpson would do as well; the midpoints of equal parts of z converge as their square.
                let z = -1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(nodes);
                let across = (1.0 - z * z).sqrt();
                for j in 0..parts {
                    let angle = 2.0 * PI * f64::from(j) / f64::from(parts);
                    let u = [across * angle.cos(), across * angle.sin(), z];
                    let terms = u.iter().zip(weights);
                    sum += terms.map(|(u, w)| (u * w).powi(2)).sum::<f64>().sqrt();
                }
            }
            4.0 * PI * sum / f64::from(nodes * parts)
        };
        let [a, b, c] = axes;
        assert!((found.surface / mean([b * c, c * a, a * b]) - 1.0).abs() < 1e-7);
        assert!((found.integrated_mean_curvature / mean(axes) - 1.0).abs() < 1e-7);
        assert_near(found.volume, 4.0 / 3.0 * PI * a * b * c);
    }

    #[test]
    fn balls_disks_and_ellipses() {
        let ball = measures_of_ellipsoid(&[2.0; 3], 0.5).unwrap();
        assert_near(ball.surface, 4.0 * PI * 6.25);
        assert_near(ball.integrated_mean_curvature, 4.0 * PI * 2.5);
        assert_near(ball.b2, 4.0 * ball.volume);
        let disk = measures_of_ellipsoid(&[1.5; 2], 0.0).unwrap();
        assert_near(disk.b2, 2.0 * disk.volume);
        // 4 E(e) with e² = 3/4.
        let ellipse = measures_of_ellipsoid(&[1.0, 0.5], 0.0).unwrap();
        assert_near(ellipse.surface, 4.844_224_110_273_838);
        // As thin as a needle: twice its length.
        let needle = measures_of_ellipsoid(&[1.0, 1e-9], 0.0).unwrap();
        assert_near(needle.surface, 4.0);
        for wrong in [&[1.0, 0.0][..], &[1.0], &[1.0, f64::NAN, 1.0], &[1.0; 4]] {
            assert!(measures_of_ellipsoid(wrong, 0.0).is_err());
        }
        assert!(measures_of_ellipsoid(&[1.0; 2], -0.1).is_err());
    }

    /// The integrals come to an end for every shape that is let in, and are those of the limits.
    #[test]
    fn shapes_of_every_size_and_ratio_are_measured_or_refused() {
        let (small, large) = (1e-50, 1e50);
        for wrong in [1e-300, 1e51, f64::INFINITY] {
            assert!(measures_of_ellipsoid(&[wrong, 1.0, 1.0], 0.0).is_err());
            assert!(measures_of_ellipsoid(&[1.0, wrong], 0.0).is_err());
        }
        assert!(measures_of_ellipsoid(&[1.0; 3], 1e200).is_err());
        let surface = |axes: &[f64]| measures_of_ellipsoid(axes, 0.0).unwrap().surface;
        // A needle: π² a b; a disk: both sides; a line: twice its length.
        assert_near(surface(&[small, small, large]), PI * PI);
        assert_near(surface(&[small, large, large]), 2.0 * PI * large * large);
        assert_near(surface(&[small, large]), 4.0 * large);
        for size in [1e-49, 1e49] {
            assert_near(surface(&[size; 3]), 4.0 * PI * size * size);
            let three = [1.0, 2.0, 3.0].map(|axis| axis * size);
            assert_near(surface(&three) / (size * size), 48.882_146_302_582_06);
        }
    }
}
