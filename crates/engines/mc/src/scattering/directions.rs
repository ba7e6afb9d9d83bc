//! Averages over all orientations, as sums over directions.

use protomer_kernel::quadrature::gauss_legendre;
use protomer_kernel::{Rotation, Vec3};
use std::f64::consts::TAU;

/// Directions with weights whose sum is 1. They stand for all directions in averages of functions
/// that are equal at q and -q, as intensities are.
#[derive(Debug, Clone, PartialEq)]
pub struct Directions(Vec<(Vec3, f64)>);

impl Directions {
    /// Directions whose average is exact for polynomials up to this degree: Gauss points in z, equal
    /// steps around the axis.
    ///
    /// |Σ exp(i q·r)|² of points within a sphere of radius R is such a polynomial of degree 2qR, up to
    /// terms that fall off faster than exponentially.
    ///
    /// ```
    /// use protomer_mc::scattering::directions::Directions;
    /// let directions = Directions::exact_to_degree(4);
    /// let fourth: f64 = directions.iter().map(|(n, weight)| weight * n.y.powi(4)).sum();
    /// assert!((fourth - 0.2).abs() < 1e-14);
    /// ```
    pub fn exact_to_degree(degree: usize) -> Self {
        // An even number, so that each point above the equator has its opposite below.
        let heights = (degree / 2 + 1).next_multiple_of(2);
        let around = degree + 1;
        let mut directions = Vec::with_capacity(heights / 2 * around);
        // From the pole to the equator: the lower half of the rule, turned over.
        for node in gauss_legendre(heights).iter().take(heights / 2) {
            let z = -node.place;
            let radius = (1.0 - z * z).sqrt();
            for step in 0..around {
                let (sine, cosine) = (TAU * step as f64 / around as f64).sin_cos();
                let direction = Vec3::new(radius * cosine, radius * sine, z);
                directions.push((direction, node.weight / around as f64));
            }
        }
        Self(directions)
    }

    /// Number of the directions of [`exact_to_degree`](Self::exact_to_degree).
    pub fn count(degree: usize) -> usize {
        (degree / 2 + 1).div_ceil(2) * (degree + 1)
    }

    /// The directions with the highest degree that are not more than `most`, and one at least.
    ///
    /// ```
    /// use protomer_mc::scattering::directions::Directions;
    /// let directions = Directions::at_most(24);
    /// assert!(directions.len() <= 24);
    /// let weights: f64 = directions.iter().map(|(_, weight)| weight).sum();
    /// assert!((weights - 1.0).abs() < 1e-12);
    /// ```
    pub fn at_most(most: usize) -> Self {
        let mut directions = Self::exact_to_degree(0);
        for degree in 1.. {
            if Self::count(degree) > most {
                break;
            }
            directions = Self::exact_to_degree(degree);
        }
        directions
    }

    /// The same directions, all turned. With a random rotation each of them is a random direction, so
    /// that averages have no systematic error, of whatever degree.
    ///
    /// ```
    /// use protomer_kernel::{Rotation, Vec3};
    /// use protomer_mc::scattering::directions::Directions;
    /// let half_turn = Rotation::new(std::f64::consts::PI * Vec3::x());
    /// let directions = Directions::exact_to_degree(4);
    /// let pairs = directions.turned(&half_turn);
    /// let z: Vec<f64> = directions.iter().zip(pairs.iter()).map(|(a, b)| a.0.z + b.0.z).collect();
    /// assert!(z.iter().all(|sum| sum.abs() < 1e-12));
    /// ```
    pub fn turned(&self, rotation: &Rotation) -> Self {
        let directions = self
            .0
            .iter()
            .map(|(direction, weight)| (rotation * direction, *weight));
        Self(directions.collect())
    }

    /// Each direction with its weight.
    pub fn iter(&self) -> impl Iterator<Item = &(Vec3, f64)> {
        self.0.iter()
    }

    /// Number of directions.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Always false.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn averages_are_exact_up_to_their_degree() {
        for degree in [2, 7, 20, 41] {
            let directions = Directions::exact_to_degree(degree);
            let weights: f64 = directions.iter().map(|(_, weight)| weight).sum();
            assert!((weights - 1.0).abs() < 1e-13, "{degree}: {weights}");
            assert_eq!(directions.len(), Directions::count(degree));
            let even = degree - degree % 2;
            for axis in 0..3 {
                let power: f64 = directions
                    .iter()
                    .map(|(n, weight)| weight * n[axis].powi(even as i32))
                    .sum();
                assert!(
                    (power * (even as f64 + 1.0) - 1.0).abs() < 1e-12,
                    "{degree} {axis}"
                );
            }
            // A degree too many shows.
            let beyond = 2 * (degree + 1);
            let power: f64 = directions
                .iter()
                .map(|(n, w)| w * n.x.powi(beyond as i32))
                .sum();
            assert!((power * (beyond as f64 + 1.0) - 1.0).abs() > 1e-12);
        }
    }
}
