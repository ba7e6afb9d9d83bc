//! The repulsion between two points of bodies at a distance x (Weeks, Chandler and Andersen, J.
//! Chem. Phys. 54, 5237 (1971)):
//!
//! U(x) = 4ε [(σ/x)¹² - (σ/x)⁶] + ε = ε (2 (σ/x)⁶ - 1)² for x < 2^(1/6) σ, otherwise 0.

/// 2^(1/6).
const SIXTH_ROOT_OF_TWO: f64 = 1.122_462_048_309_373;

/// The repulsion of contact points, with ε = 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Repulsion {
    /// The length σ.
    pub sigma: f64,
}

impl Repulsion {
    /// Where it ends: 2^(1/6) σ.
    pub fn range(&self) -> f64 {
        SIXTH_ROOT_OF_TWO * self.sigma
    }

    /// The energy at a distance.
    pub fn energy(&self, distance: f64) -> f64 {
        if distance >= self.range() {
            return 0.0;
        }
        let sixth = (self.sigma / distance).powi(6);
        (2.0 * sixth - 1.0).powi(2)
    }

    /// The energy and its derivative at a distance nearer than the range.
    pub fn energy_and_slope(&self, distance: f64) -> [f64; 2] {
        let ratio = self.sigma / distance;
        let square = ratio * ratio;
        let sixth = square * square * square;
        let root = 2.0 * sixth - 1.0;
        [root * root, -24.0 * root * sixth / distance]
    }

    /// The derivative of the energy by the distance.
    pub fn slope(&self, distance: f64) -> f64 {
        if distance >= self.range() {
            return 0.0;
        }
        let sixth = (self.sigma / distance).powi(6);
        -24.0 * (2.0 * sixth - 1.0) * sixth / distance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_one_at_sigma_and_ends_smoothly() {
        let repulsion = Repulsion { sigma: 0.15 };
        assert!((repulsion.energy(0.15) - 1.0).abs() < 1e-14);
        let end = repulsion.range();
        assert!((end / 0.15 - 2.0_f64.powf(1.0 / 6.0)).abs() < 1e-15);
        assert_eq!(repulsion.energy(end), 0.0);
        assert!(repulsion.energy(end * (1.0 - 1e-6)) < 1e-9);
        assert!(repulsion.slope(end * (1.0 - 1e-6)).abs() < 1e-2);
        let step = 1e-6;
        let difference = repulsion.energy(0.14 + step) - repulsion.energy(0.14 - step);
        let slope = repulsion.slope(0.14);
        let both = repulsion.energy_and_slope(0.14);
        assert!((both[0] / repulsion.energy(0.14) - 1.0).abs() < 1e-14);
        assert!((both[1] / slope - 1.0).abs() < 1e-14);
        assert!((difference / (2.0 * step) / slope - 1.0).abs() < 1e-8);
    }
}
