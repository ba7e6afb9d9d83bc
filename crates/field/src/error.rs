//! The one error type of this crate.

use protomer_body::BodyError;

/// What can go wrong with a field.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FieldError {
    /// A setting out of its range.
    #[error("{setting} is {value}; it must be {requirement}")]
    BadSetting {
        /// The setting's name.
        setting: &'static str,
        /// What it was.
        value: f64,
        /// What it must be.
        requirement: &'static str,
    },
    /// A grid that would not fit in memory.
    #[error(
        "a grid of {points} points needs {needed_bytes} bytes, more than {allowed_bytes}: use a larger spacing"
    )]
    TooLarge {
        /// Grid points.
        points: usize,
        /// What it would take.
        needed_bytes: usize,
        /// What is allowed.
        allowed_bytes: usize,
    },
    /// A charge in the solvent.
    #[error(
        "charge {index} ({charge_e} e) lies {distance_angstrom:.2} Å outside the surface; charges must be inside: give the \
         atom a radius, or remove it"
    )]
    ChargeOutside {
        /// Index of the sphere.
        index: usize,
        /// Its charge.
        charge_e: f64,
        /// How far out.
        distance_angstrom: f64,
    },
    /// An iteration that did not come to an end.
    #[error(
        "the potential did not converge: after {iterations} iterations the residual is {relative_residual:e} of its start"
    )]
    NotConverged {
        /// Iterations made.
        iterations: usize,
        /// What is left.
        relative_residual: f64,
    },
    /// Input that makes no sense.
    #[error("{0}")]
    BadInput(String),
    /// From the surface.
    #[error(transparent)]
    Body(#[from] BodyError),
}

/// The result of anything here that can fail.
pub type Result<T> = std::result::Result<T, FieldError>;
