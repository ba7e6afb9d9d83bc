//! Fixed-column fields of PDB lines.

use super::messages::{parse_error, quoted};
use crate::{BodyError, Result};
use protomer_kernel::Vec3;

/// Columns of the serial number.
const SERIAL: (usize, usize) = (7, 11);
/// Columns of the residue number.
const RESIDUE_NUMBER: (usize, usize) = (23, 26);
/// Name and columns of each coordinate.
const COORDINATES: [(&str, usize, usize); 3] = [("x", 31, 38), ("y", 39, 46), ("z", 47, 54)];

/// One line of a fixed-column file.
#[derive(Clone, Copy)]
pub(crate) struct Line<'a> {
    pub(crate) source: &'a str,
    pub(crate) number: usize,
    pub(crate) text: &'a str,
    shift: Shift,
}

/// Columns beyond `after` that an overlong number before them has moved to the right.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
struct Shift {
    after: usize,
    offset: usize,
}

impl<'a> Line<'a> {
    /// A line in its standard columns.
    pub(crate) fn new(source: &'a str, number: usize, text: &'a str) -> Self {
        Self {
            source,
            number,
            text: text.trim_end(),
            shift: Shift::default(),
        }
    }

    /// A coordinate record. A serial number of more than five digits, or a residue number of more
    /// than four, may have moved the columns after it.
    pub(crate) fn of_atom(source: &'a str, number: usize, text: &'a str) -> Self {
        let line = Self::new(source, number, text);
        if line.coordinates_fit() {
            return line;
        }
        let shifts = [
            (line.end_of_digits(SERIAL), SERIAL.1),
            (line.end_of_digits(RESIDUE_NUMBER), RESIDUE_NUMBER.1),
        ];
        for (end, after) in shifts {
            let shift = Shift {
                after,
                offset: end.saturating_sub(after),
            };
            let shifted = Self { shift, ..line };
            if shift.offset > 0 && shifted.coordinates_fit() {
                return shifted;
            }
        }
        line
    }

    /// The last column of the run of digits that continues from the given columns to the right.
    fn end_of_digits(&self, (_, last): (usize, usize)) -> usize {
        let bytes = self.text.as_bytes();
        let is_digit = |column: usize| {
            let byte = bytes.get(column + self.shift_at(column) - 1);
            byte.is_some_and(u8::is_ascii_digit)
        };
        let mut end = last;
        while is_digit(end) && is_digit(end + 1) {
            end += 1;
        }
        end
    }

    /// Whether an overlong number has moved columns.
    pub(crate) fn is_shifted(&self) -> bool {
        self.shift != Shift::default()
    }

    /// Whether columns 31-54 hold three numbers with decimal points.
    pub(crate) fn coordinates_fit(&self) -> bool {
        COORDINATES.iter().all(|(_, first, last)| {
            let field = self.field(*first, *last);
            field.contains('.') && field.parse::<f64>().is_ok_and(f64::is_finite)
        })
    }

    /// The serial number: columns 7-11 by the standard. Numbers of more than five digits begin in
    /// column 6, or end in column 12 or beyond.
    pub(crate) fn serial_field(&self) -> &'a str {
        let first = if self.text.starts_with("ATOM") { 5 } else { 7 };
        let standard = self.unshifted();
        standard.field(first, standard.end_of_digits(SERIAL))
    }

    /// The residue number: columns 23-26 by the standard, and further digits after them.
    pub(crate) fn residue_number_field(&self) -> &'a str {
        let (first, last) = RESIDUE_NUMBER;
        let line = match self.shift.after == last {
            true => self.unshifted(),
            false => *self,
        };
        line.field(first, line.end_of_digits(RESIDUE_NUMBER))
    }

    fn unshifted(&self) -> Self {
        Self {
            shift: Shift::default(),
            ..*self
        }
    }

    /// Number of columns by which a column has been moved to the right.
    fn shift_at(&self, column: usize) -> usize {
        match column > self.shift.after {
            true => self.shift.offset,
            false => 0,
        }
    }

    /// Columns `first` to `last`, counted from one, both included; shorter or empty where the line
    /// ends early.
    pub(crate) fn columns(&self, first: usize, last: usize) -> &'a str {
        let offset = self.shift_at(first);
        let (first, last) = (first + offset, last + offset);
        let length = self.text.len();
        let (from, to) = if self.text.is_ascii() {
            (first - 1, last.min(length))
        } else {
            let mut starts = self
                .text
                .char_indices()
                .map(|(byte, _)| byte)
                .skip(first - 1);
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

    /// The position in columns 31-54.
    pub(crate) fn position(&self) -> Result<Vec3> {
        let mut position = Vec3::zeros();
        for ((name, first, last), component) in COORDINATES.into_iter().zip(position.iter_mut()) {
            *component = self.coordinate(name, first, last)?;
        }
        Ok(position)
    }

    /// A coordinate: a finite number within the size of a molecule.
    fn coordinate(&self, name: &str, first: usize, last: usize) -> Result<f64> {
        /// Largest coordinate, Å: no structure is larger, although eight columns can hold larger
        /// numbers.
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

/// A serial number in decimal or hybrid-36 notation, or in hexadecimal as VMD and NAMD write those
/// beyond 99999: `186a0` is 100000.
pub(crate) fn serial_number(field: &str) -> Option<i64> {
    let is_hexadecimal = field.len() == 5 && field.starts_with(|c: char| c.is_ascii_digit());
    match hybrid36(field, 5) {
        None if is_hexadecimal => i64::from_str_radix(field, 16).ok(),
        number => number,
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
        let line = Line::new("x", 1, "ABé Z");
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
    #[test]
    fn a_long_number_may_move_the_columns_after_it() {
        for (text, serial, residue) in [
            (
                "ATOM  99999  CA  GLY A   7      11.104   6.134  -6.504",
                99_999,
                "7",
            ),
            (
                "ATOM 100000  CA  GLY A   7      11.104   6.134  -6.504",
                100_000,
                "7",
            ),
            (
                "ATOM  100000 CA  GLY A   7      11.104   6.134  -6.504",
                100_000,
                "7",
            ),
            (
                "ATOM  100000  CA  GLY A   7      11.104   6.134  -6.504",
                100_000,
                "7",
            ),
            (
                "HETATM100000  CA  GLY A   7      11.104   6.134  -6.504",
                100_000,
                "7",
            ),
            (
                "HETATM1000000  CA  GLY A   7      11.104   6.134  -6.504",
                1_000_000,
                "7",
            ),
            (
                "ATOM  186a0  CA  GLY A   7      11.104   6.134  -6.504",
                100_000,
                "7",
            ),
            (
                "ATOM  A0000  CA  GLY A   7      11.104   6.134  -6.504",
                100_000,
                "7",
            ),
        ] {
            let line = Line::of_atom("x", 1, text);
            assert_eq!(serial_number(line.serial_field()), Some(serial), "{text}");
            assert_eq!(
                (line.field(13, 16), line.field(23, 26)),
                ("CA", residue),
                "{text}"
            );
            assert_eq!(
                line.position().unwrap(),
                Vec3::new(11.104, 6.134, -6.504),
                "{text}"
            );
        }
        let text = "ATOM      1  CA  GLY A1234567      11.104   6.134  -6.504";
        let line = Line::of_atom("x", 1, text);
        assert!(line.is_shifted() && line.position().unwrap().x == 11.104);
        // What no number explains stays an error.
        let text = "ATOM      1  CA  GLY A   7  x     11.104   6.134  -6.504";
        assert!(Line::of_atom("x", 1, text).position().is_err());
    }
}
