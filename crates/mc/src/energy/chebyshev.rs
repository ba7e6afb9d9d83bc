//! Interpolation through Chebyshev points.

use std::f64::consts::PI;

/// The N Chebyshev points between -1 and 1, and the transform from values there to coefficients.
#[derive(Debug)]
pub(super) struct Chebyshev<const N: usize> {
    /// The points, from 1 to -1.
    pub points: [f64; N],
    transform: [[f64; N]; N],
}

impl<const N: usize> Chebyshev<N> {
    pub fn new() -> Self {
        let weight = |order: usize| if order == 0 { 1.0 } else { 2.0 } / N as f64;
        Self {
            points: std::array::from_fn(|i| Self::angle(i).cos()),
            transform: std::array::from_fn(|order| {
                std::array::from_fn(|i| weight(order) * (order as f64 * Self::angle(i)).cos())
            }),
        }
    }

    fn angle(i: usize) -> f64 {
        PI * (i as f64 + 0.5) / N as f64
    }

    /// Largest factor by which interpolation enlarges errors at the points: the largest Σ |l_i(t)|
    /// of the Lagrange polynomials, which for these points stands at the ends.
    pub fn lebesgue_constant() -> f64 {
        let cotangents = (0..N).map(|i| 1.0 / (0.5 * Self::angle(i)).tan());
        cotangents.sum::<f64>() / N as f64
    }

    /// Coefficients of T_i(x) T_j(y) T_k(z) from values at N³ points, one axis after the other; x runs
    /// fastest in both.
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

#[cfg(test)]
mod tests {
    use super::*;

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
            let chebyshev = Chebyshev::<N>::new();
            let at = |step: i32| lebesgue(&chebyshev.points, f64::from(step) / 1000.0);
            let largest = (-1000..=1000).map(at).fold(0.0, f64::max);
            let constant = Chebyshev::<N>::lebesgue_constant();
            assert!((constant - largest).abs() < 1e-12, "{N} {largest}");
        }
        check::<6>();
        check::<8>();
    }
}
