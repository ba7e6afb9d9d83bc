//! Interpolation by polynomials through Chebyshev points (Berrut and Trefethen, SIAM Rev. 46, 501
//! (2004)).
//!
//! Between N points of an interval of half-length a, a function that is analytic up to a distance d
//! beside it is met to about ρ⁻ᴺ, with ρ = d/a + √(1 + (d/a)²).

use std::f64::consts::PI;

/// Shortest half-length of an interval: keeps points apart.
const SHORTEST: f64 = 1e-2;

/// N points of an interval.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chebyshev<const N: usize> {
    pub points: [f64; N],
    weights: [f64; N],
}

impl<const N: usize> Chebyshev<N> {
    /// The zeros of the polynomial of degree N on the interval between two numbers.
    pub fn new(low: f64, high: f64) -> Self {
        let (middle, half) = (0.5 * (low + high), (0.5 * (high - low)).max(SHORTEST));
        let (mut points, mut weights) = ([0.0; N], [0.0; N]);
        for n in 0..N {
            let angle = (2 * n + 1) as f64 * PI / (2 * N) as f64;
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
    use protomer_kernel::random::CounterRng;

    #[test]
    fn polynomials_of_the_degree_are_met_and_others_to_the_power_of_rho() {
        let mut rng = CounterRng::new(18, 0, 0);
        for _ in 0..50 {
            let (low, length) = (rng.uniform_in(-5.0, 5.0), rng.uniform_in(0.1, 4.0));
            let points = Chebyshev::<6>::new(low, low + length);
            let interpolated = |x: f64, f: &dyn Fn(f64) -> f64| -> f64 {
                let terms = points.points.iter().zip(points.weights_at(x));
                terms.map(|(point, weight)| weight * f(*point)).sum()
            };
            let x = rng.uniform_in(low, low + length);
            let quintic = |x: f64| ((x - 0.3) * x * x + 2.0) * x * x - 1.0;
            let scale = quintic(low.abs() + length).abs() + 10.0;
            assert!((interpolated(x, &quintic) - quintic(x)).abs() < 1e-12 * scale);
            // A charge beside the interval, three half-lengths away.
            let (middle, half) = (low + 0.5 * length, 0.5 * length);
            let charge = |x: f64| (9.0 + ((x - middle) / half).powi(2)).sqrt().recip();
            let rho = 3.0 + 10_f64.sqrt();
            assert!((interpolated(x, &charge) - charge(x)).abs() < rho.powi(-6));
        }
        let collapsed = Chebyshev::<4>::new(1.0, 1.0).weights_at(1.0);
        assert!((collapsed.iter().sum::<f64>() - 1.0).abs() < 1e-14);
    }
}
