//! Shared code of the readers of text formats: numbered lines, numbers, and the refusal of
//! binary input.

use crate::written::refused_name;
use crate::{IoError, Result};
use protomer_kernel::mesh::LARGEST_COORDINATE_ANGSTROM;
use protomer_kernel::point_record::LARGEST_CHARGE_E;
use protomer_kernel::{Number, Vec3, plain_text};
use std::borrow::Cow;

/// Removes the byte-order mark that some editors write at the beginning.
///
/// ```
/// assert_eq!(protomer_io::without_byte_order_mark(b"\xef\xbb\xbfATOM"), b"ATOM");
/// ```
pub fn without_byte_order_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// The text in these bytes, in any encoding and with any line ends.
pub(crate) fn decode<'a>(file: &str, bytes: &'a [u8]) -> Result<Cow<'a, str>> {
    plain_text::decode(bytes)
        .map_err(|error| IoError::parse(file, error.line(), error.cause(), error.remedy()))
}

/// A token as an error message shows it: in quotes, and shortened if it is long.
pub(crate) fn shown(token: &str) -> String {
    const LONGEST: usize = 40;
    // By characters: a cut through one would panic.
    match token.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{:?}...", &token[..end]),
        None => format!("{token:?}"),
    }
}

/// A line of a named file, for error messages.
#[derive(Clone, Copy)]
pub(crate) struct Line<'a> {
    pub file: &'a str,
    pub number: usize,
    pub text: &'a str,
}

impl<'a> Line<'a> {
    /// The lines that are neither blank nor comments; a comment runs from `#` to the end of the
    /// line.
    pub fn significant(file: &'a str, text: &'a str) -> impl Iterator<Item = Line<'a>> {
        text.lines().enumerate().filter_map(move |(index, line)| {
            // Numbered before comments are left out, so that messages name the line of the file.
            let text = line.split('#').next().unwrap_or_default().trim();
            (!text.is_empty()).then_some(Line {
                file,
                number: index + 1,
                text,
            })
        })
    }

    pub fn error(&self, cause: impl Into<String>, remedy: impl Into<String>) -> IoError {
        IoError::parse(self.file, self.number, cause, remedy)
    }

    /// A required token.
    fn required<'t>(&self, token: Option<&'t str>, subject: &str) -> Result<&'t str> {
        match token {
            Some(token) => Ok(token),
            None => Err(self.error(format!("{subject} is missing"), "complete the line")),
        }
    }

    /// A name, without what a name may not hold.
    pub fn name(&self, token: &str, subject: &str) -> Result<String> {
        match refused_name(subject, token) {
            None => Ok(token.to_owned()),
            Some(cause) => Err(self.error(cause, "write a name of visible characters")),
        }
    }

    /// A finite number.
    pub fn number(&self, token: Option<&str>, subject: &str) -> Result<f64> {
        let token = self.required(token, subject)?;
        match token.parse::<f64>() {
            // `inf` and `NaN` parse, but no file means them.
            Ok(value) if value.is_finite() => Ok(value),
            _ => {
                let cause = format!("{subject} is {}", shown(token));
                Err(self.error(cause, "write a finite number"))
            }
        }
    }

    /// A radius, Å: a number that is not negative, and not beyond every coordinate.
    pub fn radius(&self, token: Option<&str>) -> Result<f64> {
        let radius = self.number(token, "the radius")?;
        if radius < 0.0 {
            let cause = format!("the radius is {radius}");
            return Err(self.error(cause, "a radius is not negative"));
        }
        self.require_at_most(LARGEST_COORDINATE_ANGSTROM, radius, "the radius", "Å")
    }

    /// A charge, e.
    pub fn charge(&self, token: Option<&str>) -> Result<f64> {
        let charge = self.number(token, "the charge")?;
        self.require_at_most(LARGEST_CHARGE_E, charge, "the charge", "e")
    }

    /// The next three tokens as the position of an atom or a charge, Å.
    pub fn position<'t>(
        &self,
        tokens: &mut impl Iterator<Item = &'t str>,
        subject: &str,
    ) -> Result<Vec3> {
        let position = self.point(tokens, subject)?;
        for coordinate in &position {
            let label = format!("a coordinate of {subject}");
            self.require_at_most(LARGEST_COORDINATE_ANGSTROM, *coordinate, &label, "Å")?;
        }
        Ok(position)
    }

    fn require_at_most(&self, most: f64, value: f64, subject: &str, unit: &str) -> Result<f64> {
        if value.abs() <= most {
            return Ok(value);
        }
        let cause = format!("{subject} is {} {unit}", Number(value));
        Err(self.error(cause, format!("give at most {most} {unit} in size")))
    }

    /// The next three tokens as a point.
    pub fn point<'t>(
        &self,
        tokens: &mut impl Iterator<Item = &'t str>,
        subject: &str,
    ) -> Result<Vec3> {
        let mut position = Vec3::zeros();
        for (axis, coordinate) in ["x", "y", "z"].into_iter().zip(position.iter_mut()) {
            *coordinate = self.number(tokens.next(), &format!("{axis} of {subject}"))?;
        }
        Ok(position)
    }

    /// An integer.
    pub fn integer(&self, token: Option<&str>, subject: &str) -> Result<i64> {
        let token = self.required(token, subject)?;
        token.parse().map_err(|_| {
            let cause = format!("{subject} is {}", shown(token));
            self.error(cause, "write a whole number")
        })
    }
}
