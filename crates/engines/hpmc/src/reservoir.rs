//! What the reservoir of depletants holds.

use crate::{Result, error::require};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Volume of a ball in space, area of a disk in a plane, length of a rod on a line.
///
/// ```
/// use protomer_hpmc::reservoir::ball_volume;
/// assert_eq!(ball_volume(1, 1.5), 3.0);
/// assert!((ball_volume(3, 1.0) - 4.18879).abs() < 1e-5);
/// ```
pub fn ball_volume(dimension: usize, radius: f64) -> f64 {
    match dimension {
        1 => 2.0 * radius,
        2 => PI * radius * radius,
        _ => 4.0 / 3.0 * PI * radius * radius * radius,
    }
}

/// A kind of penetrable hard spheres; in a plane, disks.
///
/// ```
/// use protomer_hpmc::reservoir::Depletant;
/// assert!(Depletant { radius: 0.1, fugacity: 50.0 }.check().is_ok());
/// assert!(Depletant { radius: 0.1, fugacity: -1.0 }.check().is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Depletant {
    /// Radius, in the unit of the bodies.
    pub radius: f64,
    /// Number density in the reservoir. With zero, free volumes are measured and nothing else.
    pub fugacity: f64,
}

impl Depletant {
    /// Checks the numbers.
    ///
    /// ```
    /// use protomer_hpmc::reservoir::Depletant;
    /// assert!(Depletant { radius: 0.1, fugacity: 0.0 }.check().is_ok());
    /// assert!(Depletant { radius: 0.0, fugacity: 5.0 }.check().is_err());
    /// ```
    ///
    /// # Errors
    /// For a radius or fugacity that is negative or not finite.
    pub fn check(&self) -> Result<()> {
        require(
            "the radius of the depletants",
            self.radius,
            "from 1e-100 to 1e100",
            (1e-100..=1e100).contains(&self.radius),
        )?;
        require(
            "the fugacity of the depletants",
            self.fugacity,
            "from 0 to 1e100",
            (0.0..=1e100).contains(&self.fugacity),
        )
    }
}
