//! A pair potential in two parts: a near one for pairs of charges, and a smooth one for tables.
//!
//! With t = r² and g the Taylor polynomial of v(t) about R²,
//!
//! ```text
//! v = (v - g) θ(R - r)  +  [ g θ(R - r) + v θ(r - R) ]
//!     near: few pairs      smooth: C⁴ at R, bounded at 0, v itself beyond R
//! ```

use crate::energy::SitePotential;
use protomer_kernel::fused::add;
use protomer_kernel::potential::Yukawa;

/// Number of coefficients of g.
const TERMS: usize = 6;

/// The parts of a pair potential.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Split {
    pub potential: Yukawa,
    /// R, Å.
    pub radius_angstrom: f64,
    /// g in powers of t - R².
    polynomial: [f64; TERMS],
    single: [f32; TERMS],
}

impl Split {
    pub fn new(potential: Yukawa, radius_angstrom: f64) -> Self {
        let polynomial = potential.taylor::<TERMS>(radius_angstrom * radius_angstrom);
        Self {
            potential,
            radius_angstrom,
            polynomial,
            single: polynomial.map(|coefficient| coefficient as f32),
        }
    }

    /// The near part at a squared distance.
    #[inline(always)]
    pub fn near(&self, square: f64) -> f64 {
        let radius_square = self.radius_angstrom * self.radius_angstrom;
        let near =
            self.potential.at_square(square) - horner(&self.polynomial, square - radius_square);
        // Computed on both sides and selected, so that loops over lanes have no branch.
        if square < radius_square { near } else { 0.0 }
    }

    /// The smooth part at a squared distance, for comparison.
    #[cfg(test)]
    pub fn smooth(&self, square: f64) -> f64 {
        let radius_square = self.radius_angstrom * self.radius_angstrom;
        let outside = self.potential.at_square(square);
        let inside = horner(&self.polynomial, square - radius_square);
        if square < radius_square {
            inside
        } else {
            outside
        }
    }

    /// The smooth part in single precision.
    #[inline(always)]
    pub fn smooth_f32<const FUSED: bool>(&self, square: f32) -> f32 {
        let radius_square = (self.radius_angstrom * self.radius_angstrom) as f32;
        let outside = self.potential.at_square_f32::<FUSED>(square);
        let inside = self.polynomial_f32::<FUSED>(square - radius_square);
        if square < radius_square {
            inside
        } else {
            outside
        }
    }

    /// The near part in single precision.
    #[inline(always)]
    pub fn near_f32<const FUSED: bool>(&self, square: f32) -> f32 {
        let radius_square = (self.radius_angstrom * self.radius_angstrom) as f32;
        let near = self.potential.at_square_f32::<FUSED>(square)
            - self.polynomial_f32::<FUSED>(square - radius_square);
        if square < radius_square { near } else { 0.0 }
    }

    #[inline(always)]
    fn polynomial_f32<const FUSED: bool>(&self, s: f32) -> f32 {
        let mut sum = self.single[TERMS - 1];
        for coefficient in self.single[..TERMS - 1].iter().rev() {
            sum = add::<FUSED>(sum, s, *coefficient);
        }
        sum
    }
}

#[inline(always)]
fn horner(coefficients: &[f64; TERMS], s: f64) -> f64 {
    let mut sum = coefficients[TERMS - 1];
    for coefficient in coefficients[..TERMS - 1].iter().rev() {
        sum = sum * s + coefficient;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::potential::Yukawa;

    #[test]
    fn the_parts_add_up_and_the_smooth_one_is_smooth() {
        let yukawa = Yukawa::uncut(7.0, 1.0 / 9.6).unwrap();
        let split = Split::new(yukawa, 3.0);
        for step in 1..600 {
            let t = 0.05 * f64::from(step);
            let (near, whole) = (split.near(t), yukawa.at_square(t));
            let smooth = f64::from(split.smooth_f32::<false>(t as f32));
            assert!((near + split.smooth(t) - whole).abs() < 1e-13 * whole.max(1.0));
            assert!((near + smooth - whole).abs() < 1e-5 * whole.max(1.0));
            assert!(
                (f64::from(split.near_f32::<true>(t as f32)) - near).abs() < 1e-4 * whole.max(0.1)
            );
        }
        // The jump of the smooth part's departure from its Taylor polynomial is of sixth order.
        let jump = |s: f64| (yukawa.at_square(9.0 + s) - horner(&split.polynomial, s)).abs();
        assert!(jump(0.2) < jump(0.4) / 50.0);
    }
}
