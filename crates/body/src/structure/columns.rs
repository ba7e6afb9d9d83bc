//! Fixed-column fields of PDB lines.

use super::messages::{parse_error, quoted};
use crate::{BodyError, Result};

/// One line of a fixed-column file.
#[derive(Clone, Copy)]
pub(crate) struct Line<'a> {
    pub(crate) source: &'a str,
    pub(crate) number: usize,
    pub(crate) text: &'a str,
}

impl<'a> Line<'a> {
    /// Columns `first` to `last`, counted from one, both included; shorter or empty where the line
    /// ends early.
    pub(crate) fn columns(&self, first: usize, last: usize) -> &'a str {
        let length = self.text.len();
        let (from, to) = if self.text.is_ascii() {
            (first - 1, last.min(length))
        } else {
            let mut starts = self.text.char_indices().map(|(at, _)| at).skip(first - 1);
            let from = starts.next().unwrap_or(length);
            (from, starts.nth(last - first).unwrap_or(length))
        };
        self.text.get(from..to).unwrap_or("")
    }

    /// The columns without surrounding blanks.
    pub(crate) fn field(&self, first: usize, last: usize) -> &'a str {
        self.columns(first, last).trim()
    }

    /// The field as a character that is not blank.
    pub(crate) fn character(&self, column: usize) -> Option<char> {
        self.field(column, column).chars().next()
    }

    pub(crate) fn error(&self, cause: String, remedy: &str) -> BodyError {
        parse_error(self.source, self.number, cause, remedy)
    }

    /// A coordinate: a finite number within the size of a molecule.
    pub(crate) fn coordinate(&self, name: &str, first: usize, last: usize) -> Result<f64> {
        /// No structure is larger, although eight columns can hold larger numbers.
        const LARGEST_ANGSTROM: f64 = 1e6;
        let field = self.field(first, last);
        match field.parse::<f64>() {
            Ok(value) if value.is_finite() && value.abs() <= LARGEST_ANGSTROM => Ok(value),
            _ => {
                let cause = format!(
                    "{name} in columns {first}-{last} is {}, not a coordinate in Å",
                    quoted(field)
                );
                Err(self.error(cause, "correct or delete the line; columns may be shifted"))
            }
        }
    }
}

/// A number of `width` columns in decimal or hybrid-36 notation (Grosse-Kunstleve, cctbx: after
/// 99999 follow A0000 to ZZZZZ, then a0000 to zzzzz, base 36).
///
/// Value of an upper-case field: base36(field) - 10·36^(w-1) + 10^w; lower case continues where
/// upper case ends.
pub(crate) fn hybrid36(field: &str, width: u32) -> Option<i64> {
    if let Ok(value) = field.parse::<i64>() {
        return Some(value);
    }
    let (is_of_case, offset): (fn(&u8) -> bool, i64) = match field.bytes().next()? {
        b'A'..=b'Z' => (u8::is_ascii_uppercase, -10),
        b'a'..=b'z' => (u8::is_ascii_lowercase, 16),
        _ => return None,
    };
    let is_one_case = field
        .bytes()
        .all(|byte| byte.is_ascii_digit() || is_of_case(&byte));
    if field.len() != width as usize || !is_one_case {
        return None;
    }
    let value = i64::from_str_radix(field, 36).ok()?;
    Some(value + 10_i64.pow(width) + offset * 36_i64.pow(width - 1))
}

/// A residue number in decimal or hybrid-36 notation.
pub(crate) fn whole_number(field: &str) -> Option<i32> {
    let number = hybrid36(field, 4)?;
    i32::try_from(number).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hybrid_36_continues_the_decimals() {
        let cases = [
            ("99999", 99_999),
            ("A0000", 100_000),
            ("A0001", 100_001),
            ("ZZZZZ", 43_770_015),
        ];
        for (field, value) in cases {
            assert_eq!(hybrid36(field, 5), Some(value), "{field}");
        }
        assert_eq!(hybrid36("a0000", 5), Some(43_770_016));
        assert_eq!(hybrid36("A000", 4), Some(10_000));
        assert_eq!(hybrid36("-12", 4), Some(-12));
        for nonsense in ["*****", "Aa000", "A00", "", "é000"] {
            assert_eq!(hybrid36(nonsense, 5), None);
        }
    }

    #[test]
    fn columns_survive_short_lines_and_wide_characters() {
        let line = Line {
            source: "x",
            number: 1,
            text: "ABé Z",
        };
        assert_eq!(
            (
                line.columns(1, 2),
                line.columns(3, 3),
                line.field(4, 90),
                line.columns(9, 10)
            ),
            ("AB", "é", "Z", "")
        );
    }
}
