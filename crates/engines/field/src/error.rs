//! The one error type of this crate.

use protomer_body::BodyError;
use protomer_kernel::{KernelError, Number};

/// Errors of a field calculation.
///
/// ```
/// use protomer_field::Grid;
/// use protomer_kernel::Vec3;
/// let message = Grid::around(&Vec3::zeros(), &Vec3::x(), -1.0, 1).map_err(|error| error.to_string());
/// assert_eq!(message, Err("spacing is -1; it must be positive, Å".to_owned()));
/// ```
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FieldError {
    /// A setting out of its range.
    #[error("{setting} is {}; it must be {requirement}", Number(*value))]
    BadSetting {
        /// Name of the setting.
        setting: &'static str,
        /// The value given.
        value: f64,
        /// Accepted values.
        requirement: &'static str,
    },
    /// A grid that would not fit in memory.
    #[error(
        "a grid of {points} points needs {needed_bytes} bytes, more than {allowed_bytes}: use a \
         larger spacing"
    )]
    TooLarge {
        /// Points of the grid.
        points: usize,
        /// Memory that a solve would take.
        needed_bytes: usize,
        /// Memory that it may take.
        allowed_bytes: usize,
    },
    /// A charge in the solvent.
    #[error(
        "charge {index} ({charge_e} e) lies {distance_angstrom:.2} Å outside the surface; charges \
         must be inside: give the atom a radius, or remove it"
    )]
    ChargeOutside {
        /// Index of the sphere.
        index: usize,
        /// Charge of the sphere, e.
        charge_e: f64,
        /// Distance of the charge from the surface, Å.
        distance_angstrom: f64,
    },
    /// An iteration that did not converge.
    #[error(
        "the potential did not converge: after {iterations} iterations the residual is \
         {relative_residual:e} of its start"
    )]
    NotConverged {
        /// Iterations made.
        iterations: usize,
        /// Residual over its start.
        relative_residual: f64,
    },
    /// Input that cannot be used.
    #[error("{0}")]
    BadInput(String),
    /// An error of the surface.
    #[error(transparent)]
    Body(#[from] BodyError),
    /// An error of the kernel crate.
    #[error(transparent)]
    Kernel(#[from] KernelError),
}

/// The result of a field calculation.
pub type Result<T> = std::result::Result<T, FieldError>;
