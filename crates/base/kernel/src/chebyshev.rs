//! Polynomials through Chebyshev points (Berrut and Trefethen, SIAM Rev. 46, 501 (2004)).
//!
//! The N points of the interval from -1 to 1 are the zeros cos θᵢ of the Chebyshev polynomial of degree
//! N, with θᵢ = π (i + 1/2)/N. Between the points of an interval of half-length a, a function that is
//! analytic up to a distance d from it is met to about ρ⁻ᴺ, with ρ = d/a + √(1 + (d/a)²).

use std::f64::consts::PI;

/// Shortest half-length of an interval: keeps points apart.
const SHORTEST: f64 = 1e-2;

/// The angle θ of the point of this number.
fn angle<const N: usize>(number: usize) -> f64 {
    PI * (number as f64 + 0.5) / N as f64
}

/// The N points between -1 and 1, and the transform from values there to coefficients of a series.
///
/// ```
/// use protomer_kernel::chebyshev::Chebyshev;
/// let chebyshev = Chebyshev::<4>::default();
/// let x = |place: usize| chebyshev.points[place % 4];
/// // T₂(x) = 2x² - 1, the same for all y and z.
/// let values: Vec<f64> = (0..64).map(|place| 2.0 * x(place).powi(2) - 1.0).collect();
/// let series = chebyshev.series(&values);
/// assert!((series[2] - 1.0).abs() < 1e-14 && series[0].abs() < 1e-14);
/// ```
#[derive(Debug)]
pub struct Chebyshev<const N: usize> {
    /// The points, from 1 to -1.
    pub points: [f64; N],
    transform: [[f64; N]; N],
}

impl<const N: usize> Default for Chebyshev<N> {
    fn default() -> Self {
        let weight = |order: usize| if order == 0 { 1.0 } else { 2.0 } / N as f64;
        Self {
            points: std::array::from_fn(|i| angle::<N>(i).cos()),
            transform: std::array::from_fn(|order| {
                std::array::from_fn(|i| weight(order) * (order as f64 * angle::<N>(i)).cos())
            }),
        }
    }
}

impl<const N: usize> Chebyshev<N> {
    /// Largest factor by which interpolation enlarges errors at the points: the largest Σ |l_i(t)|
    /// of the Lagrange polynomials, which for these points stands at the ends.
    ///
    /// ```
    /// use protomer_kernel::chebyshev::Chebyshev;
    /// // The line through values at -1/√2 and 1/√2 reaches √2 at the ends if they are -1 and 1.
    /// assert!((Chebyshev::<2>::lebesgue_constant() - 2.0_f64.sqrt()).abs() < 1e-14);
    /// ```
    pub fn lebesgue_constant() -> f64 {
        let cotangents = (0..N).map(|i| 1.0 / (0.5 * angle::<N>(i)).tan());
        cotangents.sum::<f64>() / N as f64
    }

    /// Coefficients of T_i(x) T_j(y) T_k(z) from values at N³ points, one axis after the other; x runs
    /// fastest in both.
    ///
    /// ```
    /// use protomer_kernel::chebyshev::Chebyshev;
    /// let series = Chebyshev::<3>::default().series(&[5.0; 27]);
    /// assert!((series[0] - 5.0).abs() < 1e-14, "a constant has the first coefficient alone");
    /// assert!(series[1..].iter().all(|coefficient| coefficient.abs() < 1e-14));
    /// ```
    pub fn series(&self, values: &[f64]) -> Vec<f64> {
        let mut from = values.to_vec();
        for stride in [1, N, N * N] {
            let mut to = vec![0.0; from.len()];
            for (place, to) in to.iter_mut().enumerate() {
                let order = place / stride % N;
                let start = place - order * stride;
                let term = |i: usize| self.transform[order][i] * from[start + i * stride];
                *to = (0..N).map(term).sum();
            }
            from = to;
        }
        from
    }
}

/// The polynomial through N points of an interval, from the values there.
///
/// ```
/// use protomer_kernel::chebyshev::Interpolation;
/// let cubic = Interpolation::<4>::new(1.0, 3.0);
/// let terms = cubic.points.iter().zip(cubic.weights_at(2.5));
/// let value: f64 = terms.map(|(point, weight)| weight * point.powi(3)).sum();
/// assert!((value - 2.5_f64.powi(3)).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Interpolation<const N: usize> {
    /// The points, ascending.
    pub points: [f64; N],
    weights: [f64; N],
}

impl<const N: usize> Interpolation<N> {
    /// The points of the interval between two numbers, which may be one.
    ///
    /// ```
    /// use protomer_kernel::chebyshev::Interpolation;
    /// let points = Interpolation::<5>::new(2.0, 4.0).points;
    /// assert!((points[2] - 3.0).abs() < 1e-14, "the middle");
    /// assert!(points.is_sorted() && points[0] > 2.0 && points[4] < 4.0);
    /// ```
    pub fn new(low: f64, high: f64) -> Self {
        let (middle, half) = (0.5 * (low + high), (0.5 * (high - low)).max(SHORTEST));
        let (mut points, mut weights) = ([0.0; N], [0.0; N]);
        for n in 0..N {
            let angle = angle::<N>(n);
            points[n] = middle - half * angle.cos();
            weights[n] = if n % 2 == 0 {
                angle.sin()
            } else {
                -angle.sin()
            };
        }
        Self { points, weights }
    }

    /// The weights at x of the values at the points; they sum to one.
    ///
    /// ```
    /// use protomer_kernel::chebyshev::Interpolation;
    /// let line = Interpolation::<2>::new(0.0, 2.0);
    /// let [first, second] = line.weights_at(1.0);
    /// assert!((first - 0.5).abs() < 1e-14 && (second - 0.5).abs() < 1e-14);
    /// assert_eq!(line.weights_at(line.points[1]), [0.0, 1.0]);
    /// ```
    pub fn weights_at(&self, x: f64) -> [f64; N] {
        let mut weights = [0.0; N];
        let mut sum = 0.0;
        for n in 0..N {
            let offset = x - self.points[n];
            if offset == 0.0 {
                weights = [0.0; N];
                weights[n] = 1.0;
                return weights;
            }
            weights[n] = self.weights[n] / offset;
            sum += weights[n];
        }
        weights.map(|weight| weight / sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::CounterRng;

    /// Σ |l_i(t)| over the Lagrange polynomials of the points.
    fn lebesgue<const N: usize>(points: &[f64; N], t: f64) -> f64 {
        let lagrange = |i: usize| {
            let others = (0..N).filter(|j| *j != i);
            let factor = |j: usize| (t - points[j]) / (points[i] - points[j]);
            others.map(factor).product::<f64>().abs()
        };
        (0..N).map(lagrange).sum()
    }

    #[test]
    fn no_interpolation_enlarges_errors_more_than_the_lebesgue_constant() {
        fn check<const N: usize>() {
            let chebyshev = Chebyshev::<N>::default();
            let bound = |step: i32| lebesgue(&chebyshev.points, f64::from(step) / 1000.0);
            let largest = (-1000..=1000).map(bound).fold(0.0, f64::max);
            let constant = Chebyshev::<N>::lebesgue_constant();
            assert!((constant - largest).abs() < 1e-12, "{N} {largest}");
        }
        check::<6>();
        check::<8>();
    }

    #[test]
    fn polynomials_of_the_degree_are_met_and_others_to_the_power_of_rho() {
        let mut rng = CounterRng::new(18, 0, 0);
        for _ in 0..50 {
            let (low, length) = (rng.uniform_in(-5.0, 5.0), rng.uniform_in(0.1, 4.0));
            let points = Interpolation::<6>::new(low, low + length);
            let interpolated = |x: f64, f: &dyn Fn(f64) -> f64| -> f64 {
                let terms = points.points.iter().zip(points.weights_at(x));
                terms.map(|(point, weight)| weight * f(*point)).sum()
            };
            let x = rng.uniform_in(low, low + length);
            let quintic = |x: f64| ((x - 0.3) * x * x + 2.0) * x * x - 1.0;
            let scale = quintic(low.abs() + length).abs() + 10.0;
            assert!((interpolated(x, &quintic) - quintic(x)).abs() < 1e-12 * scale);
            // A charge next to the interval, three half-lengths away.
            let (middle, half) = (low + 0.5 * length, 0.5 * length);
            let charge = |x: f64| (9.0 + ((x - middle) / half).powi(2)).sqrt().recip();
            let rho = 3.0 + 10_f64.sqrt();
            assert!((interpolated(x, &charge) - charge(x)).abs() < rho.powi(-6));
        }
        let collapsed = Interpolation::<4>::new(1.0, 1.0).weights_at(1.0);
        assert!((collapsed.iter().sum::<f64>() - 1.0).abs() < 1e-14);
    }
}
