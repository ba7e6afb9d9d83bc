//! Exact sums and products of floating-point numbers, as sums of numbers that do not overlap
//! (Shewchuk, Discrete Comput. Geom. 18, 305 (1997)).

use std::cmp::Ordering;

/// A sum of numbers without common digits, the smallest first; empty for zero.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Expansion(Vec<f64>);

/// The rounded sum, and what rounding took from it.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    // Knuth's exact sum, which needs no order of magnitude of a and b.
    let second = sum - a;
    let first = sum - second;
    (sum, (a - first) + (b - second))
}

/// The rounded product, and what rounding took from it.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    // The fused product rounds once, so it returns exactly what the product lost.
    (product, a.mul_add(b, -product))
}

impl Expansion {
    /// The difference a - b.
    pub(super) fn of_difference(a: f64, b: f64) -> Self {
        let (sum, rounding) = two_sum(a, -b);
        let mut expansion = Self::default();
        expansion.add(rounding);
        expansion.add(sum);
        expansion
    }

    /// Adds a number (Grow-Expansion).
    pub(super) fn add(&mut self, number: f64) {
        let (mut carried, mut length) = (number, 0);
        for place in 0..self.0.len() {
            let (sum, rounding) = two_sum(carried, self.0[place]);
            carried = sum;
            // Zeros are dropped: expansions stay short, and the last part is never zero.
            if rounding != 0.0 {
                self.0[length] = rounding;
                length += 1;
            }
        }
        self.0.truncate(length);
        if carried != 0.0 {
            self.0.push(carried);
        }
    }

    pub(super) fn plus(mut self, other: &Self) -> Self {
        for part in &other.0 {
            self.add(*part);
        }
        self
    }

    pub(super) fn minus(mut self, other: &Self) -> Self {
        for part in &other.0 {
            self.add(-part);
        }
        self
    }

    pub(super) fn times(&self, other: &Self) -> Self {
        let mut product = Self::default();
        for a in &self.0 {
            for b in &other.0 {
                let (large, small) = two_product(*a, *b);
                product.add(small);
                product.add(large);
            }
        }
        product
    }

    /// The sign of the sum: the largest part outweighs all others together.
    pub(super) fn sign(&self) -> Ordering {
        let largest = self.0.last().copied().unwrap_or_default();
        largest.partial_cmp(&0.0).unwrap_or(Ordering::Equal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::CounterRng;

    /// Integers below 2^62 as sums of two numbers.
    fn of_integer(number: i64) -> Expansion {
        let high = (number >> 31 << 31) as f64;
        let low = (number & ((1 << 31) - 1)) as f64;
        let mut expansion = Expansion::default();
        expansion.add(low);
        expansion.add(high);
        expansion
    }

    #[test]
    fn sums_and_products_are_those_of_integers() {
        let mut rng = CounterRng::new(3, 0, 0);
        let limit = 2.0_f64.powi(41);
        for _ in 0..2000 {
            let [a, b, c] = [0; 3].map(|_| rng.uniform_in(-limit, limit) as i64);
            let [x, y, z] = [a, b, c].map(of_integer);
            let wide = [a, b, c].map(i128::from);
            let expected = wide[0] * wide[1] * wide[2];
            let product = x.times(&y).times(&z);
            assert_eq!(product.sign(), expected.cmp(&0));
            // A product of another grouping differs by nothing, and one more by one.
            let mut other = z.times(&x).times(&y).minus(&product);
            assert_eq!(other, Expansion::default());
            other.add(1.0);
            assert_eq!(other.sign(), Ordering::Greater);
            let expected = wide[0] * wide[1] - wide[2] * wide[0];
            let found = x.times(&y).minus(&z.times(&x));
            assert_eq!(found.sign(), expected.cmp(&0));
        }
    }

    #[test]
    fn what_rounding_loses_is_kept() {
        let mut sum = Expansion::of_difference(1e16, 1.0);
        sum.add(-1e16);
        assert_eq!(sum.sign(), Ordering::Less);
        sum.add(1.0);
        assert_eq!(sum, Expansion::default());
        assert_eq!(sum.sign(), Ordering::Equal);
    }
}
