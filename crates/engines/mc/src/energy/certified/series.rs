//! Polynomials through 8³ Chebyshev points of a cube.
//!
//! With half edge h and n points along each axis, interpolation along one axis misses a function f by at
//! most h^n / (2^(n-1) n!) sup |∂^n f|, and enlarges what another axis missed by at most the Lebesgue
//! constant Λ. Along three axes, therefore,
//!
//! |f - L f| ≤ (1 + Λ + Λ²) / 2^(n-1) · h^n sup |∂^n f| / n!.
//!
//! What is stored is less: T_i(x) T_j(y) T_k(z) with j + k < n, in single precision. No Chebyshev polynomial is
//! larger than 1, so that the error of this is at most the sum of the coefficients' changes.

use protomer_kernel::chebyshev::Chebyshev;
use protomer_kernel::fused::add_f64;

/// Points along each axis, n.
pub(super) const POINTS: usize = 8;

/// Pairs of orders in y and z that are stored.
const ROWS: usize = POINTS * (POINTS + 1) / 2;

/// Stored coefficients: the lanes of a row are the orders in x; of the rows, j runs fastest, then k.
#[derive(Debug)]
pub(super) struct Series([[f32; POINTS]; ROWS]);

impl Series {
    /// The series from all coefficients, x fastest, then y, then z; with the largest error that
    /// storing them brings.
    fn new(coefficients: &[f64]) -> (Self, f64) {
        let (mut rows, mut row, mut change) = ([[0.0; POINTS]; ROWS], 0, 0.0);
        for (number, of_x) in coefficients.chunks_exact(POINTS).enumerate() {
            let (j, k) = (number % POINTS, number / POINTS);
            let is_stored = j + k < POINTS;
            for (lane, coefficient) in of_x.iter().enumerate() {
                let stored = if is_stored { *coefficient as f32 } else { 0.0 };
                // |T_i T_j T_k| ≤ 1, so the sum of changes bounds the error everywhere in the cell.
                change += (coefficient - f64::from(stored)).abs();
                if is_stored {
                    rows[row][lane] = stored;
                }
            }
            row += usize::from(is_stored);
        }
        (Self(rows), change)
    }
}

/// Interpolation with a bound of its error.
#[derive(Debug)]
pub(super) struct Interpolation {
    chebyshev: Chebyshev<POINTS>,
    /// (1 + Λ + Λ²) / 2^(n-1).
    pub error_factor: f64,
    /// Λ³: how much larger than errors of the values those of the polynomial can be.
    pub amplification: f64,
}

impl Interpolation {
    pub fn new() -> Self {
        let lebesgue = Chebyshev::<POINTS>::lebesgue_constant();
        let axes = 1.0 + lebesgue + lebesgue * lebesgue;
        Self {
            chebyshev: Chebyshev::default(),
            error_factor: axes / f64::from(1_u32 << (POINTS - 1)),
            amplification: lebesgue.powi(3),
        }
    }

    /// The points of a cube with coordinates from -1 to 1; x runs fastest, then y, then z.
    pub fn points(&self) -> impl Iterator<Item = [f64; 3]> {
        let point = |i: usize| self.chebyshev.points[i % POINTS];
        let numbers = (0..POINTS.pow(3)).map(|n| [n, n / POINTS, n / (POINTS * POINTS)]);
        numbers.map(move |indices| indices.map(point))
    }

    /// The series through values at the points, with the largest error of what is stored.
    pub fn series(&self, values: &[f64]) -> (Series, f64) {
        Series::new(&self.chebyshev.series(values))
    }
}

/// The value of a series at a place in the cube, coordinates from -1 to 1.
#[inline(always)]
pub(super) fn value<const FUSED: bool>(Series(rows): &Series, coordinates: [f64; 3]) -> f64 {
    let [of_x, of_y, of_z] = coordinates.map(polynomials);
    // The lanes are the orders in x, so sums over y and z never cross lanes.
    let (mut lanes, mut first) = ([0.0; POINTS], 0);
    for k in 0..POINTS {
        let mut in_plane = [0.0; POINTS];
        // j + k < n: the triangle that is stored; row number `first` + j.
        for j in 0..POINTS - k {
            for lane in 0..POINTS {
                let coefficient = f64::from(rows[first + j][lane]);
                in_plane[lane] = add_f64::<FUSED>(coefficient, of_y[j], in_plane[lane]);
            }
        }
        first += POINTS - k;
        // T_k(z) once per plane, outside of the loop over j.
        for lane in 0..POINTS {
            lanes[lane] = add_f64::<FUSED>(in_plane[lane], of_z[k], lanes[lane]);
        }
    }
    // Orders in x last, in a fixed order for the same bits.
    let mut sum = 0.0;
    for lane in 0..POINTS {
        sum = add_f64::<FUSED>(lanes[lane], of_x[lane], sum);
    }
    sum
}

/// T_0 to T_7 at t.
#[inline(always)]
fn polynomials(t: f64) -> [f64; POINTS] {
    let mut values = [1.0; POINTS];
    values[1] = t;
    for order in 2..POINTS {
        values[order] = 2.0 * t * values[order - 1] - values[order - 2];
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;

    #[test]
    fn polynomials_of_seventh_order_are_found_exactly_and_others_within_the_bound() {
        let interpolation = Interpolation::new();
        let mut rng = CounterRng::new(3, 0, 0);
        let exact =
            |[x, y, z]: [f64; 3]| (1.0 + x - 0.3 * x.powi(7)) * (y.powi(3) - 2.0) * z.powi(4);
        // Of 1/(a - x - y - z) the n-th derivative along an axis is n!/(a - x - y - z)^(n+1).
        let a = 5.0;
        let smooth = |[x, y, z]: [f64; 3]| 1.0 / (a - x - y - z);
        let bound = interpolation.error_factor / f64::powi(a - 3.0, POINTS as i32 + 1);
        let mut largest: f64 = 0.0;
        for (function, bound) in [
            (&exact as &dyn Fn([f64; 3]) -> f64, 1e-13),
            (&smooth, bound),
        ] {
            let values: Vec<f64> = interpolation.points().map(function).collect();
            let (series, change) = interpolation.series(&values);
            let bound = bound + change;
            for _ in 0..2000 {
                let point = [0; 3].map(|_| rng.uniform_in(-1.0, 1.0));
                for found in [
                    value::<true>(&series, point),
                    value::<false>(&series, point),
                ] {
                    let error = (found - function(point)).abs();
                    assert!(error < bound, "{point:?} {error} {bound}");
                    largest = largest.max(error);
                }
            }
        }
        // The bound is not a thousand times too large.
        assert!(largest > 1e-3 * bound, "{largest} {bound}");
    }
}
