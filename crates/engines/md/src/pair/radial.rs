//! The energy of two points at a distance x, of bodies or of their centres.
//!
//! The repulsion (Weeks, Chandler and Andersen, J. Chem. Phys. 54, 5237 (1971)) is that of Lennard
//! and Jones, cut at its minimum x_m = 2^(1/6) σ and shifted; λ times the rest is the attraction:
//!
//! ```text
//! W(x) = 4ε [(σ/x)¹² - (σ/x)⁶] + ε = ε (2 (σ/x)⁶ - 1)²  for x < x_m, otherwise 0
//! U(x) = W(x) - λ ε                                       for x < x_m
//!      = λ S(x) 4ε [(σ/x)¹² - (σ/x)⁶]                     for x_m < x < c
//! ```
//!
//! S falls from 1 at 0.8 c to 0 at the cut-off c with two continuous derivatives. With λ = 1 and
//! without a cut-off U is the whole potential of Lennard and Jones; with λ = 0 it is the repulsion
//! alone.

use super::step::{step, step_slope};
use crate::bath::require;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// The number 2^(1/6).
const SIXTH_ROOT_OF_TWO: f64 = 1.122_462_048_309_373;
/// Distance at which the attraction begins to be switched off, over the cut-off.
const SWITCHED_FROM: f64 = 0.8;
/// The least cut-off over σ: the switch must not reach the minimum.
const LEAST_CUT_OFF: f64 = 1.5;

/// Strength and range of the attraction between points beyond the minimum.
///
/// ```
/// use protomer_md::pair::radial::Attraction;
/// assert!(Attraction { strength: 1.0, cut_off: 2.5 }.check().is_ok());
/// assert!(Attraction { strength: 1.0, cut_off: 1.2 }.check().is_err());
/// assert!(Attraction::NONE.check().is_ok());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Attraction {
    /// Strength λ: 0 for the repulsion alone, 1 for Lennard-Jones.
    pub strength: f64,
    /// The cut-off c over σ; infinite for none.
    pub cut_off: f64,
}

impl Attraction {
    /// The repulsion alone.
    pub const NONE: Self = Self {
        strength: 0.0,
        cut_off: 2.5,
    };

    /// Checks the numbers.
    ///
    /// ```
    /// use protomer_md::pair::radial::Attraction;
    /// assert!(Attraction { strength: 1.0, cut_off: f64::INFINITY }.check().is_ok());
    /// assert!(Attraction { strength: 1.0, cut_off: f64::NAN }.check().is_err());
    /// ```
    ///
    /// # Errors
    /// [`Error::OutOfRange`].
    pub fn check(&self) -> Result<()> {
        if self.strength != 0.0 {
            require("the attraction", self.strength)?;
        }
        if self.cut_off.is_nan() || self.cut_off < LEAST_CUT_OFF {
            return Err(Error::OutOfRange {
                what: "the cut-off of the attraction",
                value: self.cut_off,
                expected: "at least 1.5 of the length sigma",
            });
        }
        Ok(())
    }
}

/// Radial potential: the energy of two points, with ε = 1.
///
/// ```
/// use protomer_md::pair::radial::{Attraction, Radial};
/// let attraction = Attraction { strength: 1.0, cut_off: f64::INFINITY };
/// let lennard_jones = Radial { sigma: 2.0, attraction };
/// assert!((lennard_jones.energy(lennard_jones.minimum()) + 1.0).abs() < 1e-12);
/// assert!(lennard_jones.energy(2.0).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Radial {
    /// The length σ.
    pub sigma: f64,
    /// Attraction beyond the minimum.
    pub attraction: Attraction,
}

impl Radial {
    /// The repulsion alone.
    ///
    /// ```
    /// use protomer_md::pair::radial::Radial;
    /// let repulsion = Radial::repulsion(1.0);
    /// assert_eq!((repulsion.energy(1.0), repulsion.energy(1.2)), (1.0, 0.0));
    /// assert_eq!(repulsion.slope(1.0), -24.0);
    /// ```
    pub fn repulsion(sigma: f64) -> Self {
        Self {
            sigma,
            attraction: Attraction::NONE,
        }
    }

    /// Distance at which the repulsion ends: 2^(1/6) σ.
    ///
    /// ```
    /// use protomer_md::pair::radial::Radial;
    /// let repulsion = Radial::repulsion(1.0);
    /// assert!((repulsion.minimum().powi(6) - 2.0).abs() < 1e-12);
    /// ```
    pub fn minimum(&self) -> f64 {
        SIXTH_ROOT_OF_TWO * self.sigma
    }

    /// Distance beyond which the energy is zero.
    ///
    /// ```
    /// use protomer_md::pair::radial::{Attraction, Radial};
    /// let repulsion = Radial::repulsion(2.0);
    /// assert_eq!(repulsion.range(), repulsion.minimum());
    /// let attraction = Attraction { strength: 1.0, cut_off: 2.5 };
    /// assert_eq!(Radial { attraction, ..repulsion }.range(), 5.0);
    /// ```
    pub fn range(&self) -> f64 {
        match self.attraction.strength > 0.0 {
            true => self.attraction.cut_off * self.sigma,
            false => self.minimum(),
        }
    }

    /// The energy at a distance.
    ///
    /// ```
    /// use protomer_md::pair::radial::{Attraction, Radial};
    /// let attraction = Attraction { strength: 0.5, cut_off: f64::INFINITY };
    /// let half = Radial { attraction, ..Radial::repulsion(1.0) };
    /// assert!((half.energy(half.minimum()) + 0.5).abs() < 1e-12, "the depth is λ");
    /// ```
    pub fn energy(&self, distance: f64) -> f64 {
        match distance >= self.range() {
            true => 0.0,
            false => self.energy_and_slope(distance)[0],
        }
    }

    /// The derivative of the energy by the distance.
    ///
    /// ```
    /// use protomer_md::pair::radial::Radial;
    /// let (repulsion, h) = (Radial::repulsion(1.0), 1e-6);
    /// let difference = repulsion.energy(0.9 + h) - repulsion.energy(0.9 - h);
    /// assert!((repulsion.slope(0.9) / (difference / (2.0 * h)) - 1.0).abs() < 1e-6);
    /// ```
    pub fn slope(&self, distance: f64) -> f64 {
        match distance >= self.range() {
            true => 0.0,
            false => self.energy_and_slope(distance)[1],
        }
    }

    /// The energy and its derivative at a distance nearer than the range.
    #[inline]
    pub fn energy_and_slope(&self, distance: f64) -> [f64; 2] {
        let ratio = self.sigma / distance;
        let square = ratio * ratio;
        let sixth = square * square * square;
        let root = 2.0 * sixth - 1.0;
        if self.attraction.strength == 0.0 {
            return [root * root, -24.0 * root * sixth / distance];
        }
        self.with_attraction(distance, sixth)
    }

    fn with_attraction(&self, distance: f64, sixth: f64) -> [f64; 2] {
        let strength = self.attraction.strength;
        let root = 2.0 * sixth - 1.0;
        let slope = -24.0 * root * sixth / distance;
        if distance < self.minimum() {
            return [root * root - strength, slope];
        }
        let energy = root * root - 1.0;
        let end = self.range();
        let place = match end.is_finite() {
            true => (distance / end - SWITCHED_FROM) / (1.0 - SWITCHED_FROM),
            false => 0.0,
        };
        if place <= 0.0 {
            return [strength * energy, strength * slope];
        }
        let switch = 1.0 - step(place);
        let by_distance = step_slope(place) / (end * (1.0 - SWITCHED_FROM));
        [
            strength * switch * energy,
            strength * (switch * slope - by_distance * energy),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_repulsion_is_one_at_sigma_and_ends_smoothly() {
        let repulsion = Radial::repulsion(0.15);
        assert!((repulsion.energy(0.15) - 1.0).abs() < 1e-14);
        let end = repulsion.range();
        assert!((end / 0.15 - 2.0_f64.powf(1.0 / 6.0)).abs() < 1e-15);
        assert_eq!(repulsion.energy(end), 0.0);
        assert!(repulsion.energy(end * (1.0 - 1e-6)) < 1e-9);
        assert!(repulsion.slope(end * (1.0 - 1e-6)).abs() < 1e-2);
    }

    #[test]
    fn the_whole_is_that_of_lennard_and_jones_up_to_the_switch() {
        let attraction = Attraction {
            strength: 1.0,
            cut_off: 2.5,
        };
        let cut = Radial {
            sigma: 0.3,
            attraction,
        };
        let whole = Radial {
            attraction: Attraction {
                cut_off: f64::INFINITY,
                ..attraction
            },
            ..cut
        };
        for distance in [0.25, 0.3, 0.34, 0.5, 0.599] {
            let sixth = (0.3_f64 / distance).powi(6);
            let expected = 4.0 * (sixth * sixth - sixth);
            for radial in [cut, whole] {
                assert!(
                    (radial.energy(distance) - expected).abs() < 1e-12 * (1.0 + expected.abs())
                );
            }
        }
        assert_eq!(cut.energy(0.75), 0.0);
        assert!(whole.energy(9.0) < 0.0);
    }

    #[test]
    fn slopes_are_derivatives_and_nothing_jumps() {
        const STEP: f64 = 1e-6;
        for strength in [0.0, 0.4, 1.0] {
            let radial = Radial {
                sigma: 0.15,
                attraction: Attraction {
                    strength,
                    cut_off: 2.5,
                },
            };
            for step in 0..260 {
                let distance = 0.13 + 0.001 * f64::from(step);
                let [up, down] = [STEP, -STEP].map(|way| radial.energy(distance + way));
                let slope = radial.slope(distance);
                let error = ((up - down) / (2.0 * STEP) - slope).abs();
                assert!(error < 1e-4 * (1.0 + slope.abs()), "{strength} {distance}");
                let jump = radial.slope(distance + STEP) - radial.slope(distance - STEP);
                assert!(
                    jump.abs() < 1e-3 * (1.0 + slope.abs()) + 0.1,
                    "{distance} {jump}"
                );
            }
        }
    }

    #[test]
    fn what_is_no_attraction_is_refused() {
        for (strength, cut_off) in [(-1.0, 2.5), (f64::NAN, 2.5), (1.0, 1.0), (1.0, f64::NAN)] {
            assert!(Attraction { strength, cut_off }.check().is_err());
        }
        assert!(Attraction::NONE.check().is_ok());
    }
}
