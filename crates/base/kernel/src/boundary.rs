//! The space that bodies live in.

use crate::error::require;
use crate::{Result, Vec3};
use serde::{Deserialize, Serialize};

/// The boundary of the space.
///
/// ```
/// use protomer_kernel::{Boundary, Vec3};
/// let space = Boundary::periodic(Vec3::new(10.0, 10.0, 10.0))?;
/// let shortest = space.displacement(&Vec3::new(-4.0, 0.0, 0.0), &Vec3::new(4.0, 0.0, 0.0));
/// assert_eq!(shortest, Vec3::new(-2.0, 0.0, 0.0));
/// # Ok::<(), protomer_kernel::KernelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Boundary {
    /// Unbounded space.
    Open,
    /// An orthorhombic periodic box centred on the origin.
    Periodic {
        /// Edge lengths, Å.
        lengths_angstrom: Vec3,
    },
    /// A hard wall that the *origins* of the bodies may not cross, a sphere about the origin.
    SphereWall {
        /// Radius, Å.
        radius_angstrom: f64,
    },
}

impl Boundary {
    /// A periodic box with these edge lengths, Å.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Vec3};
    /// assert!(Boundary::periodic(Vec3::new(10.0, 20.0, 30.0)).is_ok());
    /// assert!(Boundary::periodic(Vec3::new(10.0, 0.0, 30.0)).is_err());
    /// ```
    ///
    /// # Errors
    /// [`KernelError::OutOfRange`](crate::KernelError::OutOfRange) unless all three lengths are
    /// positive and finite.
    pub fn periodic(lengths_angstrom: Vec3) -> Result<Self> {
        for &length in lengths_angstrom.iter() {
            require(
                "box length in Å",
                length,
                "positive and finite",
                length > 0.0,
            )?;
        }
        Ok(Boundary::Periodic { lengths_angstrom })
    }

    /// The shortest displacement from one point to an image of the other, Å.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Vec3};
    /// let (from, to) = (Vec3::new(-4.0, 0.0, 0.0), Vec3::new(4.0, 0.0, 0.0));
    /// assert_eq!(Boundary::Open.displacement(&from, &to).x, 8.0);
    /// assert_eq!(Boundary::periodic(Vec3::repeat(10.0))?.displacement(&from, &to).x, -2.0);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    #[inline]
    pub fn displacement(&self, from: &Vec3, to: &Vec3) -> Vec3 {
        self.minimum_image(to - from)
    }

    /// The shortest image of a displacement, Å.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Vec3};
    /// let space = Boundary::periodic(Vec3::new(10.0, 20.0, 30.0))?;
    /// let nearest = space.minimum_image(Vec3::repeat(8.0));
    /// assert_eq!(nearest, Vec3::new(-2.0, 8.0, 8.0));
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    #[inline]
    pub fn minimum_image(&self, displacement: Vec3) -> Vec3 {
        match self {
            Boundary::Periodic { lengths_angstrom } => {
                displacement.zip_map(lengths_angstrom, nearest_image)
            }
            Boundary::Open | Boundary::SphereWall { .. } => displacement,
        }
    }

    /// The image of a position inside the box, Å; unchanged where there is no box.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Vec3};
    /// let space = Boundary::periodic(Vec3::repeat(10.0))?;
    /// assert_eq!(space.wrap(&Vec3::new(6.0, 0.0, -12.0)), Vec3::new(-4.0, 0.0, -2.0));
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn wrap(&self, position: &Vec3) -> Vec3 {
        self.minimum_image(*position)
    }

    /// Whether a body may have its origin here.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Vec3};
    /// let ball = Boundary::SphereWall { radius_angstrom: 100.0 };
    /// assert!(ball.contains(&Vec3::new(0.0, 99.0, 0.0)));
    /// assert!(!ball.contains(&Vec3::new(0.0, 99.0, 99.0)));
    /// ```
    pub fn contains(&self, position: &Vec3) -> bool {
        match self {
            Boundary::SphereWall { radius_angstrom } => {
                position.norm_squared() <= radius_angstrom * radius_angstrom
            }
            Boundary::Open | Boundary::Periodic { .. } => true,
        }
    }

    /// The smallest box length, Å; infinite where there is no box. Interactions that reach farther
    /// than half of it would need more than the nearest image.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Vec3};
    /// let space = Boundary::periodic(Vec3::new(10.0, 20.0, 30.0))?;
    /// assert_eq!(space.smallest_length_angstrom(), 10.0);
    /// assert_eq!(Boundary::Open.smallest_length_angstrom(), f64::INFINITY);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn smallest_length_angstrom(&self) -> f64 {
        match self {
            Boundary::Periodic { lengths_angstrom } => lengths_angstrom.min(),
            Boundary::Open | Boundary::SphereWall { .. } => f64::INFINITY,
        }
    }

    /// The volume of the space in Å³; infinite for open space.
    ///
    /// ```
    /// use protomer_kernel::{Boundary, Vec3};
    /// let space = Boundary::periodic(Vec3::new(10.0, 20.0, 30.0))?;
    /// assert_eq!(space.volume_angstrom3(), 6000.0);
    /// let ball = Boundary::SphereWall { radius_angstrom: 3.0 };
    /// assert!((ball.volume_angstrom3() - 36.0 * std::f64::consts::PI).abs() < 1e-12);
    /// # Ok::<(), protomer_kernel::KernelError>(())
    /// ```
    pub fn volume_angstrom3(&self) -> f64 {
        match self {
            Boundary::Open => f64::INFINITY,
            Boundary::Periodic { lengths_angstrom } => lengths_angstrom.product(),
            Boundary::SphereWall { radius_angstrom } => {
                4.0 / 3.0 * std::f64::consts::PI * radius_angstrom.powi(3)
            }
        }
    }
}

/// The nearest image of one coordinate of a displacement. Points in the box are less than one and a
/// half boxes apart, and then no branch depends on how far; rounding is a call on many processors.
#[inline]
fn nearest_image(displacement: f64, length: f64) -> f64 {
    let half = 0.5 * length;
    match displacement.abs() < length + half {
        true => {
            let ahead = f64::from(u8::from(displacement >= half));
            let behind = f64::from(u8::from(displacement <= -half));
            displacement - length * (ahead - behind)
        }
        false => displacement - length * (displacement / length).round(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_without_a_volume_are_refused() {
        for length in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(
                Boundary::periodic(Vec3::new(1.0, length, 1.0)).is_err(),
                "{length}"
            );
        }
    }

    #[test]
    fn volumes_are_those_of_the_shapes() {
        let periodic = Boundary::periodic(Vec3::new(1.0, 2.0, 3.0)).unwrap();
        assert_eq!(periodic.volume_angstrom3(), 6.0);
        let ball = Boundary::SphereWall {
            radius_angstrom: 1.0,
        };
        assert!((ball.volume_angstrom3() - 4.18879).abs() < 1e-5);
        assert_eq!(Boundary::Open.volume_angstrom3(), f64::INFINITY);
    }
}
