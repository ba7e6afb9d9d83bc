//! A table as a quadratic polynomial about each point of a coarser grid.
//!
//! ```text
//! V(g + u) = a + b · u + uᵀ C u
//! ```
//!
//! The polynomials are fitted by least squares to the table within a ball about the point g. What they leave of the
//! table in the ball says how far they can be trusted there: much at the surface of the body, where the table is
//! not smooth, and little in the solvent.

use super::lookup::{Lanes, Lookup};
use protomer_kernel::vectorised;
use rayon::prelude::*;

/// Coefficients of a polynomial: of 1; of x, y, z; of x², y², z²; of xy, xz, yz.
pub(super) const COEFFICIENTS: usize = 10;

/// Samples along the radius of a ball, about; more make no difference.
const SAMPLES_ALONG_RADIUS: f64 = 4.5;
/// The least radius, in samples: with its 19 samples a polynomial is still determined.
const LEAST_RADIUS: f64 = 1.5;
/// Share of the largest remainder in a ball that counts, if it is more than the root mean square: a corner of the
/// ball may reach into the surface of the body.
const SHARE_OF_LARGEST: f64 = 0.3;

/// Numbers of a polynomial: three for each coefficient, and two that only fill the line of the cache.
const NUMBERS: usize = 3 * COEFFICIENTS + 2;

/// Points along the edge of a brick.
const BRICK: usize = 4;

/// Polynomials about the points of a grid; the last one, zero, is for places beyond the grid.
// Neighbours in space are neighbours in memory: points lie in bricks, x running fastest in a brick and among bricks.
// Blocks of a body that touches the grid then find their polynomials on few pages.
#[derive(Debug)]
pub(super) struct Quadratics {
    origin_angstrom: [f32; 3],
    spacing_angstrom: f32,
    shape: [usize; 3],
    /// Bricks along x and y.
    bricks: [usize; 2],
    polynomials: Vec<Polynomial>,
    /// Remainders of the table around the polynomials, apart: they are judged before a polynomial is loaded.
    remainders: Vec<Remainders>,
}

/// The coefficients in kT per amount and powers of Å.
// The tables of two bodies are larger than the near caches, and most of the time goes to waiting for them. So a
// polynomial is two lines of the cache, with three numbers per coefficient.
#[derive(Debug, Clone, Copy)]
#[repr(align(128))]
pub(super) struct Polynomial([f32; NUMBERS]);

/// Remainders of a table around a polynomial, kT per amount, as the upper halves of single-precision numbers.
#[derive(Debug, Clone, Copy)]
#[repr(align(8))]
pub(super) struct Remainders([u16; 4]);

/// A place, by the polynomial next to it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Near {
    number: u32,
    /// From the point of the polynomial to the place, Å.
    pub offset_angstrom: [f32; 3],
}

impl Polynomial {
    const ZERO: Self = Self([0.0; NUMBERS]);

    fn new(coefficients: &[[f32; 3]; COEFFICIENTS]) -> Self {
        let mut numbers = [0.0; NUMBERS];
        numbers[..3 * COEFFICIENTS].copy_from_slice(coefficients.as_flattened());
        Self(numbers)
    }

    /// A coefficient for a kind of amount. The fourth lane has no meaning: it makes four numbers of three.
    #[inline(always)]
    pub fn coefficient(&self, number: usize, lane: usize) -> f32 {
        self.0[3 * number + lane]
    }
}

impl Remainders {
    const ZERO: Self = Self([0; 4]);

    fn new(kt_per_amount: [f32; 3]) -> Self {
        let [first, second, third] = kt_per_amount.map(|remainder| match remainder {
            0.0 => 0,
            // Truncated and one more: rounded up, so a remainder is never understated.
            remainder => ((remainder.to_bits() >> 16) + 1) as u16,
        });
        Self([first, second, third, 0])
    }

    /// The remainder for each kind of amount, kT per amount; the fourth is zero.
    #[inline(always)]
    pub fn kt_per_amount(&self) -> Lanes {
        self.0.map(|half| f32::from_bits(u32::from(half) << 16))
    }
}

/// Resolution of the approximation of a table.
#[derive(Debug, Clone, Copy)]
pub(super) struct Resolution {
    /// Distance between polynomials, Å; rounded to a multiple of the spacing of the table.
    pub spacing_angstrom: f64,
    /// Radius of the balls, Å.
    pub radius_angstrom: f64,
    /// The grid reaches so far beyond the table, Å.
    pub margin_angstrom: f64,
}

impl Quadratics {
    pub fn new(table: &Lookup, resolution: &Resolution) -> Self {
        let steps = (resolution.spacing_angstrom / table.spacing_angstrom)
            .round()
            .max(1.0);
        // A multiple of the table's spacing: polynomials stand
        // on points of the table, without interpolation.
        let spacing_angstrom = steps * table.spacing_angstrom;
        let margin = (resolution.margin_angstrom / spacing_angstrom).ceil();
        let points = |points: usize| ((points - 1) as f64 / steps).ceil() + 1.0 + 2.0 * margin;
        let shape = table.shape.map(|along| points(along) as usize);
        let ball = Ball::new(resolution.radius_angstrom, table.spacing_angstrom);
        let [bricks_x, bricks_y, bricks_z] = shape.map(|points| points.div_ceil(BRICK));
        let points = bricks_x * bricks_y * bricks_z * BRICK.pow(3);
        let (mut polynomials, mut remainders): (Vec<_>, Vec<_>) = (0..points)
            .into_par_iter()
            .map(|number| {
                let (brick, inside) = (number / BRICK.pow(3), number % BRICK.pow(3));
                let corner = [
                    brick % bricks_x,
                    brick / bricks_x % bricks_y,
                    brick / (bricks_x * bricks_y),
                ];
                let place = [
                    inside % BRICK,
                    inside / BRICK % BRICK,
                    inside / BRICK.pow(2),
                ];
                let point: [usize; 3] =
                    std::array::from_fn(|axis| corner[axis] * BRICK + place[axis]);
                // From steps of the coarse grid to points of the table, the margin being negative.
                let from_first = |place| (place as i64 - margin as i64) * steps as i64;
                ball.fit(table, point.map(from_first))
            })
            .unzip();
        // One past the end, so that a place beyond the grid needs no branch in the fast loop.
        polynomials.push(Polynomial::ZERO);
        remainders.push(Remainders::ZERO);
        let low = table.origin_angstrom.add_scalar(-margin * spacing_angstrom);
        Self {
            origin_angstrom: [0, 1, 2].map(|axis| low[axis] as f32),
            spacing_angstrom: spacing_angstrom as f32,
            shape,
            bricks: [bricks_x, bricks_y],
            polynomials,
            remainders,
        }
    }

    /// Number of the polynomial about a point.
    #[inline(always)]
    fn number(&self, point: [usize; 3]) -> usize {
        let [x, y, z] = point.map(|along| along / BRICK);
        let brick = (z * self.bricks[1] + y) * self.bricks[0] + x;
        let [x, y, z] = point.map(|along| along % BRICK);
        ((brick * BRICK + z) * BRICK + y) * BRICK + x
    }

    /// The polynomial next to a place (Å).
    #[inline(always)]
    pub fn near(&self, place: &[f32; 3]) -> Near {
        let per_angstrom = 1.0 / self.spacing_angstrom;
        let (mut point, mut offset_angstrom) = ([0; 3], [0.0; 3]);
        let mut is_inside = true;
        for axis in 0..3 {
            let steps = (place[axis] - self.origin_angstrom[axis]) * per_angstrom + 0.5;
            is_inside &= steps >= 0.0 && steps < self.shape[axis] as f32;
            // Nearest point: truncation after 1/2 was added.
            // Negative places truncate wrongly, but are outside.
            let whole = steps as i32;
            point[axis] = whole as usize;
            offset_angstrom[axis] = (steps - 0.5 - whole as f32) * self.spacing_angstrom;
        }
        let number = match is_inside {
            true => self.number(point),
            false => self.polynomials.len() - 1,
        };
        Near {
            number: number as u32,
            offset_angstrom,
        }
    }

    #[inline(always)]
    pub fn polynomial(&self, near: &Near) -> &Polynomial {
        &self.polynomials[near.number as usize]
    }

    /// Remainders of the polynomial next to a place.
    #[inline(always)]
    pub fn remainders(&self, near: &Near) -> &Remainders {
        &self.remainders[near.number as usize]
    }

    /// Whether a place is beyond the grid.
    #[inline(always)]
    pub fn is_beyond(&self, near: &Near) -> bool {
        near.number as usize + 1 == self.polynomials.len()
    }
}

/// The samples of a ball, and sums over them. Odd powers have sums of zero, so that the normal equations of b and of
/// the mixed terms of C are one number each.
struct Ball {
    /// Points of the table, from that at the centre.
    points: Vec<[i64; 3]>,
    monomials: Vec<[f64; COEFFICIENTS]>,
    /// Σ x²
    second: f64,
    /// Σ x⁴
    fourth: f64,
    /// Σ x² y²
    mixed: f64,
}

impl Ball {
    fn new(radius_angstrom: f64, spacing_angstrom: f64) -> Self {
        // Fewer samples of a large ball: at most about 4.5 along its radius.
        let stride = (radius_angstrom / (SAMPLES_ALONG_RADIUS * spacing_angstrom))
            .floor()
            .max(1.0);
        let radius = (radius_angstrom / (stride * spacing_angstrom)).max(LEAST_RADIUS);
        let reach = radius as i64;
        let mut points = Vec::new();
        for z in -reach..=reach {
            for y in -reach..=reach {
                for x in -reach..=reach {
                    if (x * x + y * y + z * z) as f64 <= radius * radius {
                        points.push([x, y, z].map(|along| along * stride as i64));
                    }
                }
            }
        }
        let place = |point: &[i64; 3]| point.map(|along| along as f64 * spacing_angstrom);
        let monomials: Vec<_> = points.iter().map(|point| monomials(place(point))).collect();
        // By symmetry of the ball one axis stands for all three.
        let sum = |number: &dyn Fn(&[f64; COEFFICIENTS]) -> f64| monomials.iter().map(number).sum();
        Self {
            second: sum(&|row| row[4]),
            fourth: sum(&|row| row[4] * row[4]),
            mixed: sum(&|row| row[4] * row[5]),
            points,
            monomials,
        }
    }

    /// The polynomial about a point of a table, and what it leaves of the table in the ball.
    fn fit(&self, table: &Lookup, centre: [i64; 3]) -> (Polynomial, Remainders) {
        let value =
            |point: &[i64; 3]| table.at_point([0, 1, 2].map(|axis| centre[axis] + point[axis]));
        let values: Vec<Lanes> = self.points.iter().map(value).collect();
        // Zeros, as beyond the table, have the polynomial zero and no remainder.
        if values.as_flattened().iter().all(|value| *value == 0.0) {
            return (Polynomial::ZERO, Remainders::ZERO);
        }
        let coefficients = self.coefficients(&values);
        let remainders = self.remainders(&values, &coefficients);
        let of_lanes = coefficients.map(|[x, y, z, _]| [x, y, z].map(|number| number as f32));
        let [x, y, z, _] = remainders.map(|remainder| remainder as f32);
        (Polynomial::new(&of_lanes), Remainders::new([x, y, z]))
    }

    /// Coefficients for each kind of amount.
    fn coefficients(&self, values: &[Lanes]) -> [[f64; 4]; COEFFICIENTS] {
        let sums = self.sums(values);
        let mut coefficients = [[0.0; 4]; COEFFICIENTS];
        for lane in 0..4 {
            let of_lane = self.solve(&sums.map(|sum| sum[lane]));
            for (row, coefficient) in coefficients.iter_mut().zip(of_lane) {
                row[lane] = coefficient;
            }
        }
        coefficients
    }

    vectorised!(
        /// Sums of value times monomial, by monomial and kind of amount.
        fn sums[sums_avx512, sums_avx2, sums_any](
            self: &Self, values: &[Lanes]
        ) -> [[f64; 4]; COEFFICIENTS]
    );

    #[inline(always)]
    fn sums_any(&self, values: &[Lanes]) -> [[f64; 4]; COEFFICIENTS] {
        // All kinds of amounts at once, as lanes of one vector: the samples of a lane are added in the
        // order of the ball, so the sums are those of each lane alone.
        let mut sums = [[0.0; 4]; COEFFICIENTS];
        for (value, monomials) in values.iter().zip(&self.monomials) {
            let value = value.map(f64::from);
            for (sum, monomial) in sums.iter_mut().zip(monomials) {
                for (sum, value) in sum.iter_mut().zip(value) {
                    *sum += monomial * value;
                }
            }
        }
        sums
    }

    vectorised!(
        /// Remainders of the values around polynomials, by kind of amount: the root mean square, or a
        /// share of the largest if that is more.
        fn remainders[remainders_avx512, remainders_avx2, remainders_any](
            self: &Self, values: &[Lanes], coefficients: &[[f64; 4]; COEFFICIENTS]
        ) -> [f64; 4]
    );

    #[inline(always)]
    fn remainders_any(
        &self,
        values: &[Lanes],
        coefficients: &[[f64; 4]; COEFFICIENTS],
    ) -> [f64; 4] {
        let (mut squares, mut largest) = ([0.0; 4], [0.0_f64; 4]);
        for (value, monomials) in values.iter().zip(&self.monomials) {
            let mut found = [0.0; 4];
            for (coefficient, monomial) in coefficients.iter().zip(monomials) {
                for (found, coefficient) in found.iter_mut().zip(coefficient) {
                    *found += coefficient * monomial;
                }
            }
            for lane in 0..4 {
                let remainder = found[lane] - f64::from(value[lane]);
                squares[lane] += remainder * remainder;
                largest[lane] = largest[lane].max(remainder.abs());
            }
        }
        // The largest counts only in part: it is often a
        // corner of the ball that touches the surface.
        std::array::from_fn(|lane| {
            let typical = (squares[lane] / values.len() as f64).sqrt();
            typical.max(SHARE_OF_LARGEST * largest[lane])
        })
    }

    /// The coefficients from the sums of value times monomial: the trace of C decouples from its other part.
    fn solve(&self, sums: &[f64; COEFFICIENTS]) -> [f64; COEFFICIENTS] {
        let (count, second) = (self.points.len() as f64, self.second);
        let (fourth, mixed) = (self.fourth, self.mixed);
        let of_squares = sums[4] + sums[5] + sums[6];
        // The trace couples to the constant; the traceless part of C does not.
        let trace = (of_squares - 3.0 * second * sums[0] / count)
            / (fourth + 2.0 * mixed - 3.0 * second * second / count);
        let constant = (sums[0] - second * trace) / count;
        let square = |sum: f64| (sum - second * constant - mixed * trace) / (fourth - mixed);
        [
            constant,
            sums[1] / second,
            sums[2] / second,
            sums[3] / second,
            square(sums[4]),
            square(sums[5]),
            square(sums[6]),
            sums[7] / mixed,
            sums[8] / mixed,
            sums[9] / mixed,
        ]
    }
}

/// Monomials that the coefficients multiply.
pub(super) fn monomials([x, y, z]: [f64; 3]) -> [f64; COEFFICIENTS] {
    [1.0, x, y, z, x * x, y * y, z * z, x * y, x * z, y * z]
}

#[cfg(test)]
mod tests {
    use super::super::ResponseGrid;
    use super::*;
    use protomer_kernel::Vec3;

    fn table(value: impl Fn(&Vec3) -> f64) -> Lookup {
        let origin_angstrom = Vec3::new(-14.0, -15.0, -16.0);
        let values = (0..29 * 31 * 33).map(|number| {
            let point = [number % 29, number / 29 % 31, number / (29 * 31)];
            let place = origin_angstrom + Vec3::from(point.map(|along| along as f64));
            [value(&place) as f32, 0.0, 1.0, 0.0]
        });
        Lookup::new(ResponseGrid {
            origin_angstrom,
            spacing_angstrom: 1.0,
            shape: [29, 31, 33],
            values: values.collect(),
        })
    }

    const RESOLUTION: Resolution = Resolution {
        spacing_angstrom: 3.0,
        radius_angstrom: 4.0,
        margin_angstrom: 3.0,
    };

    #[test]
    fn a_quadratic_table_is_found_again() {
        let value =
            |x: &Vec3| 2.0 + 0.5 * x.x - x.y + 0.1 * x.x * x.x - 0.3 * x.y * x.z + 0.2 * x.z * x.z;
        let quadratics = Quadratics::new(&table(value), &RESOLUTION);
        let place = Vec3::new(3.2, -2.1, 4.4);
        let near = quadratics.near(&[3.2, -2.1, 4.4]);
        let polynomial = quadratics.polynomial(&near);
        let terms = monomials(near.offset_angstrom.map(f64::from));
        let mut found = [0.0; 3];
        for (number, monomial) in terms.into_iter().enumerate() {
            for (lane, found) in found.iter_mut().enumerate() {
                *found += f64::from(polynomial.coefficient(number, lane)) * monomial;
            }
        }
        assert!((found[0] - value(&place)).abs() < 1e-5, "{found:?}");
        assert!((found[2] - 1.0).abs() < 1e-6, "{found:?}");
        let remainders = quadratics.remainders(&near).kt_per_amount();
        assert!(remainders.iter().all(|lane| *lane < 1e-5), "{remainders:?}");
    }

    /// The slow twin: each kind of amount by itself, without vectors.
    #[test]
    fn fits_of_all_lanes_are_those_of_each_lane() {
        let wave = table(|x| (0.3 * x.x).sin() * x.y + f64::from(u8::from(x.z > 1.0)));
        let ball = Ball::new(RESOLUTION.radius_angstrom, wave.spacing_angstrom);
        for centre in [[3, 4, 5], [14, 15, 16], [-2, 30, 20]] {
            let (polynomial, remainders) = ball.fit(&wave, centre);
            let value = |point: &[i64; 3], lane: usize| {
                let point = [0, 1, 2].map(|axis| centre[axis] + point[axis]);
                f64::from(wave.at_point(point)[lane])
            };
            for lane in 0..3 {
                let mut sums = [0.0; COEFFICIENTS];
                for (point, monomials) in ball.points.iter().zip(&ball.monomials) {
                    for (sum, monomial) in sums.iter_mut().zip(monomials) {
                        *sum += monomial * value(point, lane);
                    }
                }
                let coefficients = ball.solve(&sums);
                let (mut squares, mut largest) = (0.0, 0.0_f64);
                for (point, monomials) in ball.points.iter().zip(&ball.monomials) {
                    let terms = coefficients.iter().zip(monomials);
                    let found: f64 = terms.map(|(c, monomial)| c * monomial).sum();
                    let remainder = found - value(point, lane);
                    squares += remainder * remainder;
                    largest = largest.max(remainder.abs());
                }
                let typical = f64::sqrt(squares / ball.points.len() as f64);
                let expected = typical.max(SHARE_OF_LARGEST * largest) as f32;
                let kept = Remainders::new([expected; 3]).kt_per_amount()[0];
                assert_eq!(remainders.kt_per_amount()[lane], kept);
                for (number, expected) in coefficients.into_iter().enumerate() {
                    assert_eq!(polynomial.coefficient(number, lane), expected as f32);
                }
            }
        }
    }

    #[test]
    fn remainders_are_kept_or_rounded_up() {
        let given = [0.0, 1.234e-3, 7.9];
        let kept = Remainders::new(given).kt_per_amount();
        for (kept, given) in kept.iter().zip(given) {
            assert!((given..=1.01 * given).contains(kept), "{kept} {given}");
        }
    }

    #[test]
    fn a_step_is_no_polynomial_and_neither_is_the_end_of_a_table() {
        let quadratics = Quadratics::new(&table(|x| f64::from(u8::from(x.x > 2.0))), &RESOLUTION);
        let remainder = |place: [f32; 3]| {
            quadratics
                .remainders(&quadratics.near(&place))
                .kt_per_amount()
        };
        assert!(remainder([2.0, 0.0, 0.0])[0] > 0.1);
        assert!(remainder([-8.0, 0.0, 0.0])[0] < 1e-6);
        assert!(remainder([13.0, 0.0, 0.0])[2] > 0.1);
        assert!(quadratics.is_beyond(&quadratics.near(&[40.0, 0.0, 0.0])));
    }
}
