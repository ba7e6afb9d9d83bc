//! The one error type of this crate.

use std::fmt;

/// A number in a message: with an exponent where it would have many digits.
///
/// ```
/// use protomer_kernel::Number;
/// assert_eq!(format!("{} {} {}", Number(-0.5), Number(1e300), Number(2e-9)), "-0.5 1e300 2e-9");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number(pub f64);

impl fmt::Display for Number {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size != 0.0 && size.is_finite() && !(1e-5..1e9).contains(&size) {
            write!(formatter, "{:e}", self.0)
        } else {
            write!(formatter, "{}", self.0)
        }
    }
}

/// A positive number in advice such as "give at most": four digits that are never more than the number itself.
///
/// ```
/// use protomer_kernel::AtMost;
/// assert_eq!(format!("{} {}", AtMost(0.74048), AtMost(0.000123456)), "0.7404 0.0001234");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AtMost(pub f64);

impl fmt::Display for AtMost {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let decimals = (3.0 - self.0.log10().floor()).clamp(0.0, 12.0) as usize;
        let unit = 10.0_f64.powi(decimals as i32);
        write!(formatter, "{:.decimals$}", (self.0 * unit).floor() / unit)
    }
}

/// Errors of the kernels.
///
/// ```
/// use protomer_kernel::Electrolyte;
/// let message = Electrolyte::in_water(298.15, -1.0).map_err(|error| error.to_string());
/// assert_eq!(
///     message,
///     Err("salt concentration in mol/L is -1; it must be zero or positive".to_owned())
/// );
/// ```
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum KernelError {
    /// A physical quantity outside the range in which its equation holds.
    #[error("{quantity} is {}; it must be {requirement}", Number(*value))]
    OutOfRange {
        /// The quantity with its unit, as a user would name it.
        quantity: &'static str,
        /// The value given.
        value: f64,
        /// The requirement that the value must meet.
        requirement: &'static str,
    },
    /// A mesh that does not bound a solid.
    #[error("the mesh is not a closed, outward-oriented surface: {0}")]
    BadMesh(String),
    /// Points or a name that make no shape.
    #[error("this is not a shape: {0}")]
    BadShape(String),
    /// A polygon or a mesh that is not its convex hull.
    #[error(
        "this is not a convex shape: {0}; divide it into convex pieces, a file for each, and join them with +, \
         such as A.off+B.off, or give the corners of the hull alone"
    )]
    NotConvex(String),
    /// Points through which no curve can be drawn.
    #[error("{0}")]
    BadTable(String),
    /// An energy without a force that bodies in motion could follow.
    #[error("{reason}, and bodies in motion need a force; {remedy}")]
    NoForce {
        /// The term, and where its energy is not smooth.
        reason: &'static str,
        /// Remedy.
        remedy: &'static str,
    },
    /// A periodic box in which a body would meet two images of another.
    #[error(
        "interactions reach {range_angstrom:.2} Å, so every box length must be at least {:.2} Å; \
         the smallest is {smallest_length_angstrom:.2} Å",
        2.0 * range_angstrom
    )]
    BoxTooSmall {
        /// Largest distance between the origins of two bodies at which they interact, Å.
        range_angstrom: f64,
        /// The smallest box length, Å.
        smallest_length_angstrom: f64,
    },
}

/// The result of a kernel operation.
pub type Result<T> = std::result::Result<T, KernelError>;

/// `Ok` if `value` is finite and `holds`, otherwise the error that names the quantity.
pub(crate) fn require(
    quantity: &'static str,
    value: f64,
    requirement: &'static str,
    holds: bool,
) -> Result<()> {
    if value.is_finite() && holds {
        return Ok(());
    }
    Err(KernelError::OutOfRange {
        quantity,
        value,
        requirement,
    })
}
