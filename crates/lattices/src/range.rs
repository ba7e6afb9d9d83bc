//! Ranges of numbers: every one is checked where it enters, under the name that the user gave it.

use anyhow::{Result, bail};
use protomer_kernel::Number;

/// Values that a setting may have.
///
/// ```
/// use protomer_lattices::range::Range;
/// let friction = Range::from(1e-6, 1e6).or_zero();
/// assert!(friction.check("friction", 0.0).is_ok());
/// let error = friction.check("friction", f64::NAN).unwrap_err();
/// assert_eq!(error.to_string(), "friction is NaN; it must be 0, or from 1e-6 to 1000000");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    least: f64,
    most: f64,
    has_zero: bool,
    unit: &'static str,
}

impl Range {
    /// From `least` to `most`, both included.
    pub const fn from(least: f64, most: f64) -> Self {
        Self {
            least,
            most,
            has_zero: false,
            unit: "",
        }
    }

    /// The same range, and zero.
    #[must_use]
    pub const fn or_zero(self) -> Self {
        Self {
            has_zero: true,
            ..self
        }
    }

    /// The same range in a unit, for messages.
    #[must_use]
    pub const fn in_unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// Whether the range holds this value; NaN and infinities are in no range.
    pub fn holds(&self, value: f64) -> bool {
        (self.least..=self.most).contains(&value) || (self.has_zero && value == 0.0)
    }

    /// Refuses a value outside the range.
    ///
    /// # Errors
    /// Names the setting, its value and the range.
    pub fn check(&self, name: &str, value: f64) -> Result<()> {
        if self.holds(value) {
            return Ok(());
        }
        let Self {
            least, most, unit, ..
        } = *self;
        let zero = if self.has_zero { "0, or " } else { "" };
        let space = if unit.is_empty() { "" } else { " " };
        bail!(
            "{name} is {}; it must be {zero}from {} to {}{space}{unit}",
            Number(value),
            Number(least),
            Number(most)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_inside_and_what_is_no_number_is_not() {
        let range = Range::from(1e-4, 1e3);
        for value in [1e-4, 0.5, 1e3] {
            assert!(range.holds(value), "{value}");
        }
        for value in [
            0.0,
            -1.0,
            9e-5,
            1001.0,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            1e308,
            1e-308,
        ] {
            assert!(!range.holds(value), "{value}");
        }
        assert!(range.or_zero().holds(0.0) && range.or_zero().holds(-0.0));
    }
}
