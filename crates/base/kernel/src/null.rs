//! Numbers that JSON does not have: serde writes NaN and infinities as `null`.
//!
//! A field that may hold one of them names the function that reads it back.

use serde::{Deserialize, Deserializer};

/// Reads a number, and `null` as NaN.
///
/// # Errors
/// If the value is neither.
///
/// ```
/// use protomer_kernel::null;
/// use serde::de::IntoDeserializer;
/// use serde::de::value::{Error, UnitDeserializer};
///
/// let nothing: UnitDeserializer<Error> = ().into_deserializer();
/// assert!(null::as_nan(nothing)?.is_nan());
/// # Ok::<(), Error>(())
/// ```
pub fn as_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

/// Reads a number, and `null` as infinity.
///
/// ```
/// use protomer_kernel::null;
/// use serde::de::IntoDeserializer;
/// use serde::de::value::{Error, UnitDeserializer};
///
/// let nothing: UnitDeserializer<Error> = ().into_deserializer();
/// assert_eq!(null::as_infinity(nothing)?, f64::INFINITY);
/// # Ok::<(), Error>(())
/// ```
///
/// # Errors
/// If the value is neither.
pub fn as_infinity<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
}

/// Value of a field that files of earlier versions do not have.
pub fn nan() -> f64 {
    f64::NAN
}
