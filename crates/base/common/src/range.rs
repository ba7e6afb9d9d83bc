//! Ranges of numbers: what a setting may be, checked where it enters, be it a flag or a key of a file.
//!
//! A range is what physics and the methods can mean, wider than what anybody needs: it keeps out slips of the
//! keyboard, numbers that overflow, and counts that no memory holds. What further depends on other settings is
//! checked where these meet.

use anyhow::{Result, bail};
use std::fmt;

/// Temperatures of liquids, and of models of them.
pub const TEMPERATURE: Range = Range::new(1.0, 1e4, "K");
/// Relative permittivities, from the vacuum to beyond every liquid.
pub const PERMITTIVITY: Range = Range::new(1.0, 1e4, "");
/// Concentrations of salt; a litre of water is 55 mol.
pub const SALT: Range = Range::new(1e-9, 1000.0, "mol/L").or_zero();
/// Bjerrum lengths.
pub const BJERRUM_LENGTH: Range = Range::new(1e-3, 1e4, "Å");
/// Debye lengths; that of pure water is 10⁴ Å.
pub const DEBYE_LENGTH: Range = Range::new(0.01, 1e6, "Å");
/// Cut-offs of interactions.
pub const CUT_OFF: Range = Range::new(0.1, 1e4, "Å");
/// Distances of surfaces in contact.
pub const CONTACT_GAP: Range = Range::new(1e-3, 1000.0, "Å");
/// Displacement up to which a body belongs to a part of an assembly; a quarter and twice of it are tried too.
pub const PART_LIMIT: Range = Range::new(0.4, 25.0, "Å");
/// Spacings of the fine of two grids, so that the second can be coarser.
pub const FINE_SPACING: Range = Range::new(0.05, 0.9, "Å");
/// Distances of atoms of residues that touch.
pub const TOUCHING: Range = Range::new(1e-3, 20.0, "Å");
/// Gaps that are left between bodies.
pub const GAP: Range = Range::new(0.0, 1e4, "Å");
/// Edges of periodic boxes.
pub const BOX_EDGE: Range = Range::new(1.0, 1e6, "Å");
/// Radii of atoms, ions, probes and of the balls that fit into interiors; zero for none.
pub const RADIUS: Range = Range::new(1e-3, 1000.0, "Å").or_zero();
/// Mesh vertices.
pub const MESH_DENSITY: Range = Range::new(1e-3, 1000.0, "per Å²");
/// Angles of a turn.
pub const ANGLE: Range = Range::new(-360.0, 360.0, "degrees");
/// Wave numbers: from light to distances between atoms.
pub const WAVE_NUMBER: Range = Range::new(1e-6, 10.0, "Å⁻¹");
/// Parts of a whole.
pub const SHARE: Range = Range::new(0.0, 1.0, "");
/// Factors of energies, and energies over kT.
pub const STRENGTH: Range = Range::new(-1e6, 1e6, "");
/// Quantities in reduced units that are positive; beyond, products and powers of them are no numbers.
pub const POSITIVE: Range = Range::new(1e-9, 1e9, "");
/// Quantities in reduced units that may be zero.
pub const NOT_NEGATIVE: Range = Range::new(0.0, 1e6, "");
/// Tolerances and wanted errors.
pub const TOLERANCE: Range = Range::new(1e-12, 1e6, "");
/// Time limits, a thousand years at most.
pub const MINUTES: Range = Range::new(0.0, 5e8, "minutes");
/// Intervals between checkpoints.
pub const SECONDS: Range = Range::new(0.0, 3e10, "seconds");
/// Acidities.
pub const PH: Range = Range::new(0.0, 14.0, "");
/// Constants of the binding of an ion to a group.
pub const ANION_BINDING: Range = Range::new(1e-6, 1e6, "L/mol").or_zero();
/// Steps, sweeps and moves of a run, which can be interrupted.
pub const STEPS: Count = Count::new(0, 1_000_000_000_000);
/// Objects that are kept in memory.
pub const OBJECTS: Count = Count::new(0, 1_000_000);
/// Rows of a table, each of which costs a measurement.
pub const TABLE_ROWS: Count = Count::new(1, 1000);
/// Directions that an average runs over.
pub const DIRECTIONS: Count = Count::new(1, 1_000_000);
/// Trial moves of a measurement that has no checkpoints.
pub const MOVES: Count = Count::new(1, 1_000_000_000);
/// Trial moves of a measurement that has no checkpoints, or none.
pub const MOVES_OR_NONE: Count = Count::new(0, 1_000_000_000);
/// Channels of a block of a network.
pub const CHANNELS: Count = Count::new(1, 1024);
/// Groups of channels, or none.
pub const CHANNELS_OR_NONE: Count = Count::new(0, 1024);
/// Members of a ring.
pub const MEMBERS: Count = Count::new(1, 10_000);

/// Numbers between two ends, both included, and perhaps zero.
///
/// ```
/// use protomer_common::range::{SALT, TEMPERATURE};
/// assert!(TEMPERATURE.require("temperature_K", 298.15).is_ok());
/// let error = TEMPERATURE.require("temperature_K", 1e308).unwrap_err();
/// assert_eq!(error.to_string(), "temperature_K is 1e308; give 1 to 10000 K");
/// assert!(SALT.holds(0.0) && !SALT.holds(1e-308) && !SALT.holds(f64::NAN));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    least: f64,
    most: f64,
    unit: &'static str,
    has_zero: bool,
}

impl Range {
    /// The range from the least number to the largest, with their unit.
    ///
    /// ```
    /// use protomer_common::range::Range;
    /// let density = Range::new(0.5, 20.0, "g/mL");
    /// assert!(density.holds(0.5) && density.holds(20.0) && !density.holds(0.0));
    /// assert_eq!(density.to_string(), "0.5 to 20 g/mL");
    /// ```
    pub const fn new(least: f64, most: f64, unit: &'static str) -> Self {
        Self {
            least,
            most,
            unit,
            has_zero: false,
        }
    }

    /// The same range with zero added.
    ///
    /// ```
    /// use protomer_common::range::Range;
    /// let salt = Range::new(1e-3, 5.0, "mol/L").or_zero();
    /// assert!(salt.holds(0.0) && !salt.holds(1e-4));
    /// assert_eq!(salt.to_string(), "0, or 0.001 to 5 mol/L");
    /// ```
    pub const fn or_zero(self) -> Self {
        Self {
            has_zero: true,
            ..self
        }
    }

    /// Whether a number is in the range.
    ///
    /// ```
    /// use protomer_common::range::{PH, Range};
    /// assert!(PH.holds(7.4) && !PH.holds(15.0));
    /// let salt = Range::new(1e-3, 5.0, "mol/L").or_zero();
    /// assert!(salt.holds(0.0) && !salt.holds(f64::NAN), "no range holds what is not a number");
    /// ```
    pub fn holds(&self, value: f64) -> bool {
        // NaN is in no range.
        (self.least..=self.most).contains(&value) || self.has_zero && value == 0.0
    }

    /// Refuses the value of a key that is outside the range.
    ///
    /// ```
    /// use protomer_common::range::PH;
    /// assert!(PH.require("ph", 7.4).is_ok());
    /// let message = PH.require("ph", 15.0).map_err(|error| error.to_string());
    /// assert_eq!(message, Err("ph is 15; give 0 to 14".to_owned()));
    /// ```
    ///
    /// # Errors
    /// Names the key, the value and the range.
    pub fn require(&self, key: &str, value: f64) -> Result<()> {
        if !self.holds(value) {
            bail!("{key} is {}; give {self}", Plain(value));
        }
        Ok(())
    }

    /// The reader of a flag: a plain number in the range.
    ///
    /// ```
    /// let read = protomer_common::range::SHARE.number();
    /// assert_eq!(read("0.2").unwrap(), 0.2);
    /// assert_eq!(read("nan").unwrap_err().to_string(), "give 0 to 1");
    /// ```
    pub fn number(self) -> impl Fn(&str) -> Result<f64> + Clone + Send + Sync + 'static {
        // Blanks around a number come with quoted flags.
        self.read(|text| match text.trim().parse() {
            Ok(value) => Ok(value),
            Err(_) => bail!("write a number"),
        })
    }

    /// The reader of a flag whose text another function understands, such as a length with a unit.
    ///
    /// ```
    /// use protomer_common::{quantity::length_angstrom, range::CUT_OFF};
    /// let read = CUT_OFF.read(length_angstrom);
    /// assert_eq!(read("3nm").unwrap(), 30.0);
    /// assert_eq!(read("1e9nm").unwrap_err().to_string(), "give 0.1 to 10000 Å");
    /// ```
    pub fn read(
        self,
        parse: fn(&str) -> Result<f64>,
    ) -> impl Fn(&str) -> Result<f64> + Clone + Send + Sync + 'static {
        move |text| {
            let value = parse(text)?;
            if !self.holds(value) {
                bail!("give {self}");
            }
            Ok(value)
        }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let zero = if self.has_zero { "0, or " } else { "" };
        write!(
            formatter,
            "{zero}{} to {}",
            Plain(self.least),
            Plain(self.most)
        )?;
        match self.unit {
            "" => Ok(()),
            unit => write!(formatter, " {unit}"),
        }
    }
}

/// Whole numbers between two ends, both included.
///
/// ```
/// use protomer_common::range::MEMBERS;
/// assert!(MEMBERS.require("members", 0).is_err());
/// let read = MEMBERS.number::<usize>();
/// assert_eq!(read("12").unwrap(), 12);
/// assert_eq!(read("1000000").unwrap_err().to_string(), "give a whole number from 1 to 10000");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Count {
    least: u64,
    most: u64,
}

impl Count {
    /// The range from the least number to the largest.
    ///
    /// ```
    /// use protomer_common::range::Count;
    /// let replicas = Count::new(2, 8);
    /// assert!(replicas.require("replicas", 2).is_ok() && replicas.require("replicas", 8).is_ok());
    /// ```
    pub const fn new(least: u64, most: u64) -> Self {
        Self { least, most }
    }

    /// The same range with another least number.
    ///
    /// ```
    /// use protomer_common::range::STEPS;
    /// assert!(STEPS.require("steps", 0).is_ok());
    /// assert!(STEPS.at_least(1).require("steps", 0).is_err());
    /// ```
    #[must_use]
    pub const fn at_least(self, least: u64) -> Self {
        Self { least, ..self }
    }

    /// Refuses the value of a key that is outside the range.
    ///
    /// ```
    /// use protomer_common::range::Count;
    /// let message = Count::new(2, 8).require("replicas", 9).map_err(|error| error.to_string());
    /// assert_eq!(message, Err("replicas is 9; give a whole number from 2 to 8".to_owned()));
    /// ```
    ///
    /// # Errors
    /// Names the key, the value and the range.
    pub fn require(&self, key: &str, value: u64) -> Result<()> {
        if !(self.least..=self.most).contains(&value) {
            bail!("{key} is {value}; give {self}");
        }
        Ok(())
    }

    /// The reader of a flag.
    ///
    /// ```
    /// use protomer_common::range::Count;
    /// let read = Count::new(0, 1000).number::<u8>();
    /// assert_eq!(read("255")?, 255);
    /// assert!(read("256").is_err(), "no byte");
    /// assert!(read("1.5").is_err());
    /// # Ok::<(), anyhow::Error>(())
    /// ```
    pub fn number<T: TryFrom<u64> + 'static>(
        self,
    ) -> impl Fn(&str) -> Result<T> + Clone + Send + Sync + 'static {
        move |text| {
            // As 64 bits first: the range decides, not the type that is asked for.
            let value = text.trim().parse().ok();
            let value = value.filter(|value| (self.least..=self.most).contains(value));
            match value.map(T::try_from) {
                Some(Ok(value)) => Ok(value),
                _ => bail!("give {self}"),
            }
        }
    }
}

impl fmt::Display for Count {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "a whole number from {} to {}",
            self.least, self.most
        )
    }
}

/// A number as a person writes it: without `.0`, with an exponent where there would be many zeros.
struct Plain(f64);

impl fmt::Display for Plain {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = format!("{:?}", self.0);
        // `{:?}` gives the shortest form that reads back,
        // exponent included, and `.0` for whole numbers.
        formatter.write_str(text.strip_suffix(".0").unwrap_or(&text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_is_not_finite_is_in_a_range() {
        for range in [TEMPERATURE, SALT, RADIUS, STRENGTH, ANGLE, BOX_EDGE] {
            for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -1e308] {
                assert!(!range.holds(value), "{range} {value}");
                assert!(range.number()(&value.to_string()).is_err());
            }
        }
    }

    #[test]
    fn whole_numbers_must_fit_their_type() {
        let read = Count::new(0, 1000).number::<u8>();
        assert_eq!(read("255").unwrap(), 255);
        for text in ["256", "1e2", "-1", "", "18446744073709551616"] {
            assert!(read(text).is_err(), "{text}");
        }
    }
}
