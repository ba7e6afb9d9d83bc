//! The coherent motion, which has one degree of freedom, exactly.
//!
//! In the coherent motion θ = (-1)^(i+j) θ_c and the centres lie on a square grid of the distance d
//! = 2 l cos(θ_c - π/4) + r0, with all rods along x and y. The kinetic energy is that of one degree
//! of freedom, with φ = π/4 - θ_c
//!
//! K = ½ N I (1 - μ sin²φ) ω_c², μ = -4 m l² Σ (x² + y²) / (N I), Σ (x² + y²) = N (rows² +
//! columns² - 2) / 12
//!
//! over the grid of unit distance; for ns x ns squares of I = m l²/3 this is μ = 2 (1 - ns²). K is
//! constant (eq. 29b), so √(1 - μ sin²φ) dφ = -e0 dt, and with the incomplete elliptic integral
//! E(φ | μ) = ∫ √(1 - μ sin²) (eq. 29a)
//!
//! E(φ(t) | μ) = E(φ(0) | μ) - e0 t, e0 = √(1 - μ sin²φ(0)) ω_c(0).
//!
//! r0 appears nowhere but in where the squares meet. For r0 → 0 this is the model of Grima and
//! Evans (J. Mat. Sci. Lett. 19, 1563 (2000)), where the rods leave no other motion. For r0 > 0 the
//! rods do not *enforce* it, but the 2 x 2 lattice keeps it: reflections in the two midlines map
//! the coherent states on themselves, a state with both symmetries is one square's x, y, θ, and its
//! two kinds of rods, each perpendicular to a mirror, leave one degree of freedom. Larger lattices
//! with r0 > 0 leave the coherent orbit, unless a potential holds them there.
//!
//! The squares meet at θ_min and π/2 - θ_min, where (not as in eq. 29c)
//!
//! θ_min = -asin(r0 / (2√2 l)) for r0 ≤ 2√2 l, π/4 - arccos(-r0 / 4l) for r0 ≤ 4l,
//!
//! and beyond 4l they turn freely. An elastic contact turns ω_c around.

use super::elliptic::{elliptic_e, inverse_elliptic_e};
use crate::error::{Result, require, require_finite, require_not_negative, require_positive};
use crate::lattice::Square;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, SQRT_2};

/// The smallest θ_c before squares meet; the largest is π/2 less this. `None` where they turn
/// freely.
///
/// ```
/// use protomer_linkage::analysis::grima::smallest_angle;
/// assert_eq!(smallest_angle(0.0, 1.0), Some(0.0)); // Grima's squares close completely
/// assert!(smallest_angle(1.0, 1.0).unwrap() < 0.0); // rods let them turn beyond
/// assert_eq!(smallest_angle(4.1, 1.0), None);
/// ```
pub fn smallest_angle(rod_length: f64, half_diagonal: f64) -> Option<f64> {
    let ratio = rod_length / half_diagonal;
    if ratio <= 2.0 * SQRT_2 {
        Some(-(ratio / (2.0 * SQRT_2)).asin())
    } else if ratio <= 4.0 {
        Some(FRAC_PI_4 - (-ratio / 4.0).acos())
    } else {
        None
    }
}

/// An angle this near to that of a contact may be the contact.
const ANGLE_ROUNDING: f64 = 1e-12;

/// The coherent orbit through a given angle and angular velocity, with elastic contacts.
///
/// ```
/// use protomer_linkage::analysis::grima::CoherentOrbit;
/// use protomer_linkage::lattice::Square;
/// use std::f64::consts::FRAC_PI_4;
/// let orbit = CoherentOrbit::new(2, 2, Square::default(), 1.0, FRAC_PI_4, -1.0)?;
/// assert!((orbit.first_contact().unwrap() - 1.9177621277529928).abs() < 1e-12);
/// # Ok::<(), protomer_linkage::CrystalError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoherentOrbit {
    /// μ, zero or negative.
    parameter: f64,
    /// E(φ(0) | μ) and e0.
    start: f64,
    speed: f64,
    /// E(φ | μ) at the contact, if there is one.
    wall: Option<f64>,
    /// N I.
    inertia: f64,
}

impl CoherentOrbit {
    /// The orbit of this many rows and columns from θ_c = `angle` at ω_c = `rate`.
    ///
    /// ```
    /// use protomer_linkage::analysis::grima::CoherentOrbit;
    /// use protomer_linkage::lattice::Square;
    /// let square = Square::default();
    /// let orbit = CoherentOrbit::new(1, 1, square, 1.0, 0.5, 2.0)?;
    /// assert!((orbit.energy() - 0.5 * square.inertia * 4.0).abs() < 1e-12, "a square alone only turns");
    /// assert!(CoherentOrbit::new(2, 2, square, 1.0, -1.5, 2.0).is_err(), "the squares overlap");
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    ///
    /// # Errors
    /// [`CrystalError::BadSetting`](crate::CrystalError::BadSetting) for numbers that make no lattice, or an angle at which squares
    /// overlap.
    pub fn new(
        rows: usize,
        columns: usize,
        square: Square,
        rod_length: f64,
        angle: f64,
        rate: f64,
    ) -> Result<Self> {
        let count = (rows * columns) as f64;
        require("number of squares", count, count > 0.0, "positive")?;
        require_positive("half_diagonal", square.half_diagonal)?;
        require_positive("mass", square.mass)?;
        require_positive("inertia", square.inertia)?;
        require_not_negative("rod_length", rod_length)?;
        require_finite("rate", rate)?;
        let least = smallest_angle(rod_length, square.half_diagonal);
        let is_apart = least.is_none_or(|least| {
            angle >= least - ANGLE_ROUNDING && angle <= FRAC_PI_2 - least + ANGLE_ROUNDING
        });
        let requirement = "between those at which squares meet";
        require("angle", angle, is_apart, requirement)?;
        let around = (rows * rows + columns * columns - 2) as f64 / 12.0;
        let parameter = -4.0 * square.mass * square.half_diagonal.powi(2) * around / square.inertia;
        let from_open = FRAC_PI_4 - angle;
        Ok(Self {
            parameter,
            start: elliptic_e(from_open, parameter),
            speed: (1.0 - parameter * from_open.sin().powi(2)).sqrt() * rate,
            wall: least.map(|least| elliptic_e(FRAC_PI_4 - least, parameter)),
            inertia: count * square.inertia,
        })
    }

    /// μ of the elliptic integrals.
    pub fn parameter(&self) -> f64 {
        self.parameter
    }

    /// The kinetic energy, a constant: ½ N I e0².
    pub fn energy(&self) -> f64 {
        0.5 * self.inertia * self.speed * self.speed
    }

    /// Absolute value of the angular velocity ω_c at an angle, eq. 29b.
    ///
    /// ```
    /// use protomer_linkage::analysis::grima::CoherentOrbit;
    /// use protomer_linkage::lattice::Square;
    /// use std::f64::consts::FRAC_PI_4;
    /// let orbit = CoherentOrbit::new(4, 4, Square::default(), 1.0, FRAC_PI_4, -2.0)?;
    /// assert!((orbit.rate_at(FRAC_PI_4) - 2.0).abs() < 1e-12);
    /// assert!(orbit.rate_at(0.2) < 2.0, "it is fastest where the lattice is open");
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    pub fn rate_at(&self, angle: f64) -> f64 {
        self.speed.abs() / (1.0 - self.parameter * (FRAC_PI_4 - angle).sin().powi(2)).sqrt()
    }

    /// Time at which squares first meet; `None` if they never do.
    pub fn first_contact(&self) -> Option<f64> {
        let wall = self.wall?;
        // A positive rate lowers E.
        let way = if self.speed > 0.0 {
            self.start + wall
        } else {
            wall - self.start
        };
        (self.speed != 0.0).then(|| way.max(0.0) / self.speed.abs())
    }

    /// θ_c and ω_c at this time.
    ///
    /// ```
    /// use protomer_linkage::analysis::grima::CoherentOrbit;
    /// use protomer_linkage::lattice::Square;
    /// let orbit = CoherentOrbit::new(2, 2, Square::default(), 1.0, 0.7, -1.0)?;
    /// let [angle, rate] = orbit.state(0.0);
    /// assert!((angle - 0.7).abs() < 1e-12 && (rate + 1.0).abs() < 1e-12);
    /// # Ok::<(), protomer_linkage::CrystalError>(())
    /// ```
    pub fn state(&self, time: f64) -> [f64; 2] {
        let mut travelled = self.start - self.speed * time;
        let mut direction = self.speed;
        if let Some(wall) = self.wall {
            // A triangle wave between the walls.
            let turns = ((travelled + wall) / (2.0 * wall)).floor();
            if wall > 0.0 && turns.is_finite() {
                travelled -= 2.0 * wall * turns;
                if turns.rem_euclid(2.0) == 1.0 {
                    travelled = -travelled;
                    direction = -direction;
                }
            }
        }
        let angle = FRAC_PI_4 - inverse_elliptic_e(travelled, self.parameter);
        [angle, self.rate_at(angle).copysign(direction)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::bisection::halved;
    use std::f64::consts::PI;

    #[test]
    fn the_parameter_is_that_of_the_paper() {
        for size in [1, 2, 3, 10] {
            let orbit = CoherentOrbit::new(size, size, Square::default(), 0.1, 0.5, 1.0).unwrap();
            assert!((orbit.parameter() - 2.0 * (1.0 - (size * size) as f64)).abs() < 1e-12);
            // e0 of fig. 4, but for the factor that makes it 1 for one square.
            let squares = (size * size) as f64;
            let e0 = (squares + (1.0 - squares) * 1.0f64.sin()).sqrt();
            assert!((orbit.speed - e0).abs() < 1e-12);
        }
    }

    #[test]
    fn closing_angles_join_and_end() {
        let kink = 2.0 * SQRT_2;
        assert!((smallest_angle(kink, 1.0).unwrap() + FRAC_PI_2).abs() < 1e-7);
        assert!((smallest_angle(kink + 1e-9, 1.0).unwrap() + FRAC_PI_2).abs() < 1e-4);
        assert_eq!(smallest_angle(0.0, 1.0), Some(0.0));
        assert!((smallest_angle(4.0, 1.0).unwrap() - (FRAC_PI_4 - PI)).abs() < 1e-7);
        assert_eq!(smallest_angle(4.1, 1.0), None);
        assert_eq!(smallest_angle(0.3, 1.0), smallest_angle(0.6, 2.0));
    }

    /// θ̈ from Lagrange's equation of the one degree of freedom, integrated by Runge and Kutta's
    /// fourth-order rule, with contacts found by bisection.
    #[test]
    fn the_orbit_solves_its_equation_of_motion_and_bounces() {
        let (rod_length, size) = (0.3, 4.0f64);
        let orbit = CoherentOrbit::new(4, 4, Square::default(), rod_length, 0.9, 0.8).unwrap();
        let least = smallest_angle(rod_length, 1.0).unwrap();
        let mu = 2.0 * (1.0 - size * size);
        // d/dt (f ω) = ½ f' ω², f = 1 - μ sin²(π/4 - θ).
        let rhs = |y: [f64; 2]| {
            let phi = FRAC_PI_4 - y[0];
            let (f, slope) = (1.0 - mu * phi.sin().powi(2), mu * (2.0 * phi).sin());
            [y[1], -0.5 * slope / f * y[1] * y[1]]
        };
        let advance = |y: [f64; 2], h: f64| {
            let add = |k: [f64; 2], s: f64| [y[0] + s * k[0], y[1] + s * k[1]];
            let k1 = rhs(y);
            let k2 = rhs(add(k1, 0.5 * h));
            let k3 = rhs(add(k2, 0.5 * h));
            let k4 = rhs(add(k3, h));
            [0, 1].map(|c| y[c] + h / 6.0 * (k1[c] + 2.0 * k2[c] + 2.0 * k3[c] + k4[c]))
        };
        let inside = |y: [f64; 2]| y[0] >= least && y[0] <= FRAC_PI_2 - least;
        let (mut y, mut bounces, h) = ([0.9, 0.8], 0, 1e-3);
        for step in 1..=40_000 {
            let mut next = advance(y, h);
            if !inside(next) {
                let low = halved([0.0, h], 60, |time| inside(advance(y, time)))[0];
                let mut bounced = advance(y, low);
                bounced[1] = -bounced[1];
                bounces += 1;
                next = advance(bounced, h - low);
            }
            y = next;
            let [angle, rate] = orbit.state(f64::from(step) * h);
            assert!(
                (angle - y[0]).abs() < 1e-8 && (rate - y[1]).abs() < 1e-8,
                "{step}: {angle} {rate} {y:?}"
            );
        }
        assert!(bounces >= 3, "{bounces}");
        // And backwards in time.
        let [angle, rate] = orbit.state(-3.0);
        let back = CoherentOrbit::new(4, 4, Square::default(), rod_length, angle, rate)
            .unwrap()
            .state(3.0);
        assert!((back[0] - 0.9).abs() < 1e-12 && (back[1] - 0.8).abs() < 1e-12);
    }

    #[test]
    fn nonsense_is_refused() {
        let make = |size, rod_length, angle, rate| {
            CoherentOrbit::new(size, size, Square::default(), rod_length, angle, rate)
        };
        assert!(make(0, 1.0, 0.5, 1.0).is_err());
        assert!(make(2, -1.0, 0.5, 1.0).is_err());
        assert!(make(2, 0.1, -0.5, 1.0).is_err());
        assert!(make(2, 0.1, 0.5, f64::NAN).is_err());
    }
}
