//! Shared by the readers of text formats: numbered lines, numbers, and the screening of binary
//! input.

use crate::{IoError, Result};
use std::borrow::Cow;

/// The bytes without the byte-order mark that some editors put before the first letter.
///
/// ```
/// assert_eq!(protomer_io::without_byte_order_mark(b"\xef\xbb\xbfATOM"), b"ATOM");
/// ```
pub fn without_byte_order_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// The text in these bytes, without a byte-order mark. Comments may be in any encoding; a NUL byte
/// means that the file is no text at all.
pub(crate) fn decode<'a>(file: &str, bytes: &'a [u8]) -> Result<Cow<'a, str>> {
    let bytes = without_byte_order_mark(bytes);
    if bytes.is_empty() {
        return Err(IoError::parse(
            file,
            0,
            "the file is empty",
            "give a file with content",
        ));
    }
    if bytes.contains(&0) {
        let remedy = "give a file of the format its extension names";
        return Err(IoError::parse(
            file,
            0,
            "the file is binary where text was expected",
            remedy,
        ));
    }
    Ok(String::from_utf8_lossy(bytes))
}

/// A token as an error message shows it: in quotes, and not in full where it is long.
pub(crate) fn shown(token: &str) -> String {
    const LONGEST: usize = 40;
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

    /// A finite number.
    pub fn number(&self, token: Option<&str>, what: &str) -> Result<f64> {
        let Some(token) = token else {
            return Err(self.error(format!("{what} is missing"), "complete the line"));
        };
        match token.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(self.error(
                format!("{what} is {}", shown(token)),
                "write a finite number",
            )),
        }
    }

    /// The next three tokens as a point.
    pub fn point<'t>(
        &self,
        tokens: &mut impl Iterator<Item = &'t str>,
        what: &str,
    ) -> Result<protomer_kernel::Vec3> {
        let mut coordinate = |axis: &str| self.number(tokens.next(), &format!("{axis} of {what}"));
        Ok(protomer_kernel::Vec3::new(
            coordinate("x")?,
            coordinate("y")?,
            coordinate("z")?,
        ))
    }

    /// A whole number.
    pub fn integer(&self, token: Option<&str>, what: &str) -> Result<i64> {
        let Some(token) = token else {
            return Err(self.error(format!("{what} is missing"), "complete the line"));
        };
        token.parse().map_err(|_| {
            self.error(
                format!("{what} is {}", shown(token)),
                "write a whole number",
            )
        })
    }
}
