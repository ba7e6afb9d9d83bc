//! The space bodies live in.

use crate::{KernelError, Result, Vec3};
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
    /// Space without an end.
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
    /// # Errors
    /// [`KernelError::OutOfRange`] unless all three lengths are positive and finite.
    pub fn periodic(lengths_angstrom: Vec3) -> Result<Self> {
        match lengths_angstrom
            .iter()
            .find(|length| !(length.is_finite() && **length > 0.0))
        {
            None => Ok(Boundary::Periodic { lengths_angstrom }),
            Some(&value) => Err(KernelError::OutOfRange {
                quantity: "box length in Å",
                value,
                requirement: "positive and finite",
            }),
        }
    }

    /// The shortest displacement from one point to an image of the other, Å.
    pub fn displacement(&self, from: &Vec3, to: &Vec3) -> Vec3 {
        self.minimum_image(to - from)
    }

    /// The shortest image of a displacement, Å.
    pub fn minimum_image(&self, displacement: Vec3) -> Vec3 {
        match self {
            Boundary::Periodic { lengths_angstrom } => displacement
                .zip_map(lengths_angstrom, |d, length| {
                    d - length * (d / length).round()
                }),
            Boundary::Open | Boundary::SphereWall { .. } => displacement,
        }
    }

    /// The image of a position inside the box, Å; unchanged where there is no box.
    pub fn wrap(&self, position: &Vec3) -> Vec3 {
        self.minimum_image(*position)
    }

    /// Whether a body may have its origin here.
    pub fn contains(&self, position: &Vec3) -> bool {
        match self {
            Boundary::SphereWall { radius_angstrom } => {
                position.norm_squared() <= radius_angstrom * radius_angstrom
            }
            Boundary::Open | Boundary::Periodic { .. } => true,
        }
    }

    /// The smallest box length, Å; infinite where there is no box. Interactions that reach further
    /// than half of it would need more than the nearest image.
    pub fn smallest_length_angstrom(&self) -> f64 {
        match self {
            Boundary::Periodic { lengths_angstrom } => lengths_angstrom.min(),
            Boundary::Open | Boundary::SphereWall { .. } => f64::INFINITY,
        }
    }

    /// The volume of the space in Å³; infinite for open space.
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
