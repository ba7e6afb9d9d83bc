//! Far charges seen from a small ball: one polynomial.
//!
//! The Taylor coefficients b_k = ∂^k φ / k! of φ = s/|d|, d from the charge to the middle of the ball,
//! follow from each other (Duan and Krasny, J. Comput. Chem. 22, 184 (2001)),
//!
//! |k| d² b_k = -(2|k| - 1) Σ_i d_i b_{k - e_i} - (|k| - 1) Σ_i b_{k - 2e_i},
//!
//! and since φ is harmonic, those of the first two powers of the third coordinate give all others. They
//! are summed over charges in single precision, thirty-two at a time. What is left out of a charge
//! at a distance r, in a ball of radius a, is at most (a/r)^{p+1} / (1 - a/r) of s/r, with p the
//! degree, [`DEGREE`], and p + 1 times that over a of a slope. Charges count as far from
//! r = [`FAR_IN_RADII`] a on. Most are farther, their signs differ, and most places are not on the
//! sphere: in the tests, with charges at the density of a protein, 10⁻⁵ Σ |s_i|/r_i of a potential and
//! 3 · 10⁻⁵ Σ |s_i|/r_i² of a slope are not exceeded.

use crate::edge_charges::{AtEdge, EdgePlace};
use crate::point_charges::Source;
use protomer_kernel::Vec3;
use protomer_kernel::vectorised;

/// Degree of the polynomial.
const DEGREE: usize = 6;
/// Powers of a coordinate.
const POWERS: usize = DEGREE + 1;
/// Charges in a group: the longer, the less its loops cost compared with what they do.
const LANES: usize = 32;
/// Charges at least this many radii of a ball from its middle are far.
pub(crate) const FAR_IN_RADII: f64 = 4.3;

/// The potential of far charges in a ball, by the powers of the coordinates from its middle.
#[derive(Debug, Clone)]
pub(crate) struct FarCharges {
    middle: Vec3,
    coefficients: Coefficients,
}

/// Coefficients by the powers of x, y and z.
type Coefficients = [[[f64; POWERS]; POWERS]; POWERS];
/// Distance in a list between coefficients of successive powers of each coordinate.
const STRIDES: [usize; 3] = [POWERS * POWERS, POWERS, 1];

/// Charges; unused lanes have no strength and are at a distance.
#[derive(Debug, Clone)]
struct Group {
    /// Offsets from the charge to the middle, by axis.
    offsets: [[f32; LANES]; 3],
    strength: [f32; LANES],
}

/// Charges about a middle.
struct Groups(Vec<Group>);

impl FarCharges {
    /// The potential of these charges near a place.
    pub fn new(sources: &[Source], middle: Vec3) -> Self {
        let mut groups = Vec::with_capacity(sources.len().div_ceil(LANES));
        for sources in sources.chunks(LANES) {
            // Unused lanes stand at (1, 1, 1): the loops divide by the distance.
            let mut group = Group {
                offsets: [[1.0; LANES]; 3],
                strength: [0.0; LANES],
            };
            for (lane, source) in sources.iter().enumerate() {
                let offset = middle - source.place;
                for axis in 0..3 {
                    group.offsets[axis][lane] = offset[axis] as f32;
                }
                group.strength[lane] = source.strength as f32;
            }
            groups.push(group);
        }
        let mut coefficients = [[[0.0; POWERS]; POWERS]; POWERS];
        let first_two = Groups(groups).first_two();
        // i + j + k up to the degree; of k only 0 and 1, the others follow.
        for i in 0..POWERS {
            for j in 0..POWERS - i {
                for k in 0..2.min(POWERS - i - j) {
                    coefficients[i][j][k] = first_two[k][i][j];
                }
            }
        }
        // The Laplacian of every power vanishes.
        for k in 2..POWERS {
            for i in 0..POWERS - k {
                for j in 0..POWERS - k - i {
                    // From Σ over axes of (n + 2)(n + 1) b = 0, solved for the power k of z.
                    let twice = |n: usize| ((n + 2) * (n + 1)) as f64;
                    let transverse = twice(i) * coefficients[i + 2][j][k - 2]
                        + twice(j) * coefficients[i][j + 2][k - 2];
                    coefficients[i][j][k] = -transverse / twice(k - 2);
                }
            }
        }
        Self {
            middle,
            coefficients,
        }
    }

    /// Potential, slope and flux of the charges at an edge with its middle in the ball.
    pub fn value_at(&self, edge: &EdgePlace) -> AtEdge {
        let offset = edge.middle - self.middle;
        let [axis, first, second] = edge.axes();
        let coefficients = self.coefficients.as_flattened().as_flattened();
        let (x, y) = (offset[first], offset[second]);
        // The powers of the coordinate along the edge, highest first, by Horner's rule for the others;
        // and from them the derivatives over n!.
        let mut derivatives = [0.0; 5];
        // Powers along the edge from the highest down; `derivatives` holds the
        // polynomial and its derivatives over n!, all by one Horner scheme.
        for n in (0..POWERS).rev() {
            let mut sum = 0.0;
            for a in (0..POWERS - n).rev() {
                let mut row = 0.0;
                for b in (0..POWERS - n - a).rev() {
                    let index = n * STRIDES[axis] + a * STRIDES[first] + b * STRIDES[second];
                    row = row * y + coefficients[index];
                }
                sum = sum * x + row;
            }
            // From the highest order down, as each needs the old value of the one below.
            for order in (1..derivatives.len()).rev() {
                derivatives[order] = derivatives[order] * offset[axis] + derivatives[order - 1];
            }
            derivatives[0] = derivatives[0] * offset[axis] + sum;
        }
        // Times n!, as the derivatives were divided by it.
        let [value, slope, second, third, fourth] = derivatives;
        edge.with_derivatives([value, slope, 2.0 * second, 6.0 * third, 24.0 * fourth])
    }
}

/// Sums of the coefficients of the first two powers of z, by those of z, x and y.
type FirstTwo = [[[f64; POWERS]; POWERS]; 2];

impl Groups {
    vectorised!(
        /// The coefficients of the first two powers of z, summed over all charges.
        fn first_two[first_two_avx512, first_two_avx2, first_two_any](self: &Self) -> FirstTwo
    );

    #[inline(always)]
    fn first_two_any(&self) -> FirstTwo {
        let mut sums = [[[[0.0_f32; LANES]; POWERS]; POWERS]; 2];
        let mut of_group = sums;
        for group in &self.0 {
            let [x, y, z] = &group.offsets;
            let mut inverse = [0.0; LANES];
            for lane in 0..LANES {
                let square = x[lane] * x[lane] + y[lane] * y[lane] + z[lane] * z[lane];
                inverse[lane] = 1.0 / square;
                of_group[0][0][0][lane] = group.strength[lane] * inverse[lane].sqrt();
                // b_0 = s/r starts the recursion.
                sums[0][0][0][lane] += of_group[0][0][0][lane];
            }
            for degree in 1..POWERS {
                // The factors of the recursion over |k| d²: 1/d² is applied per lane below.
                let one = -((2 * degree - 1) as f32) / degree as f32;
                let two = -((degree - 1) as f32) / degree as f32;
                for k in 0..2 {
                    for i in 0..=degree - k {
                        let j = degree - k - i;
                        let (mut first, mut second) = ([0.0; LANES], [0.0; LANES]);
                        let mut add = |offset: &[f32; LANES], lower: &[f32; LANES]| {
                            for lane in 0..LANES {
                                first[lane] += offset[lane] * lower[lane];
                            }
                        };
                        if i > 0 {
                            add(x, &of_group[k][i - 1][j]);
                        }
                        if j > 0 {
                            add(y, &of_group[k][i][j - 1]);
                        }
                        if k > 0 {
                            add(z, &of_group[k - 1][i][j]);
                        }
                        let mut add = |lower: &[f32; LANES]| {
                            for lane in 0..LANES {
                                second[lane] += lower[lane];
                            }
                        };
                        if i > 1 {
                            // b_{k - 2e_i}; for z it would need k = 2, which is not kept.
                            add(&of_group[k][i - 2][j]);
                        }
                        if j > 1 {
                            add(&of_group[k][i][j - 2]);
                        }
                        for lane in 0..LANES {
                            let coefficient =
                                (one * first[lane] + two * second[lane]) * inverse[lane];
                            of_group[k][i][j][lane] = coefficient;
                            sums[k][i][j][lane] += coefficient;
                        }
                    }
                }
            }
        }
        sums.map(|plane| {
            // Summed over lanes in double precision, at the very end.
            plane.map(|row| row.map(|lanes| lanes.iter().map(|sum| f64::from(*sum)).sum()))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edge_charges::EdgeCharges;
    use crate::edge_charges::tests::source;
    use protomer_kernel::random::CounterRng;

    fn edge(middle: Vec3, rng: &mut CounterRng, turn: usize) -> EdgePlace {
        EdgePlace {
            middle,
            axis: turn % 3,
            length: 0.5,
            offset: rng.uniform_in(-0.25, 0.25),
        }
    }

    #[test]
    fn one_charge_is_met_to_the_bound() {
        let mut rng = CounterRng::new(70, 0, 0);
        for turn in 0..300 {
            let (radius, distance) = (2.0, rng.uniform_in(FAR_IN_RADII, 12.0) * 2.0);
            let middle = rng.vector_in_ball(9.0);
            let charge = source(middle + rng.unit_vector() * distance, 1.7);
            let far = FarCharges::new(&[charge], middle);
            let edge = edge(middle + rng.vector_in_ball(radius), &mut rng, turn);
            let (found, exact) = (
                far.value_at(&edge),
                EdgeCharges::new(vec![charge], middle).value_at(&edge),
            );
            let part = radius / distance;
            let bound = part.powi(POWERS as i32) / (1.0 - part) * 1.7 / distance;
            let of_slope = bound * POWERS as f64 / radius;
            // And single precision.
            let rounding = 3e-6 * 1.7 / distance;
            assert!((found.value - exact.value).abs() < bound + rounding);
            assert!((found.slope - exact.slope).abs() < of_slope + rounding);
            assert!((found.flux - exact.flux).abs() < 0.25 * (of_slope + rounding));
        }
    }

    #[test]
    fn many_charges_are_met_far_better() {
        let mut rng = CounterRng::new(71, 0, 0);
        let (mut worst_value, mut worst_slope) = (0.0_f64, 0.0_f64);
        for _ in 0..40 {
            let radius = rng.uniform_in(2.0, 7.0);
            let middle = rng.unit_vector() * 30.0;
            // 20 Å³ for each charge.
            let charges =
                (0..5600).map(|_| source(rng.vector_in_ball(30.0), rng.uniform_in(-1.0, 1.0)));
            let mut charges: Vec<Source> = charges.collect();
            charges.retain(|charge| (charge.place - middle).norm() > FAR_IN_RADII * radius);
            let (far, direct) = (
                FarCharges::new(&charges, middle),
                EdgeCharges::new(charges.clone(), middle),
            );
            for turn in 0..60 {
                let edge = edge(middle + rng.vector_in_ball(radius), &mut rng, turn);
                let (found, exact) = (far.value_at(&edge), direct.value_at(&edge));
                let (mut of_value, mut of_slope) = (0.0, 0.0);
                for charge in &charges {
                    let inverse = 1.0 / (charge.place - edge.middle).norm();
                    of_value += charge.strength.abs() * inverse;
                    of_slope += charge.strength.abs() * inverse * inverse;
                }
                worst_value = worst_value.max((found.value - exact.value).abs() / of_value);
                for error in [found.slope - exact.slope, (found.flux - exact.flux) / 0.25] {
                    worst_slope = worst_slope.max(error.abs() / of_slope);
                }
            }
        }
        assert!(
            worst_value < 1e-5 && worst_slope < 3e-5,
            "{worst_value} {worst_slope}"
        );
    }
}
