//! Small tables as comma-separated values (RFC 4180), numbers printed so that they read back
//! exactly.

use crate::{IoError, Result};
use std::fmt::Write;

/// A value in a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Nothing known.
    Empty,
    /// A whole number.
    Integer(i64),
    /// A real number; printed with the fewest digits that read back exactly.
    Number(f64),
    /// Text; quoted if it has to be.
    Text(String),
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Cell::Number(value)
    }
}

impl From<i64> for Cell {
    fn from(value: i64) -> Self {
        Cell::Integer(value)
    }
}

impl From<usize> for Cell {
    fn from(value: usize) -> Self {
        i64::try_from(value).map_or(Cell::Number(value as f64), Cell::Integer)
    }
}

impl From<&str> for Cell {
    fn from(value: &str) -> Self {
        Cell::Text(value.to_owned())
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Cell::Empty, Into::into)
    }
}

/// A table with named columns.
///
/// ```
/// use protomer_io::csv::Table;
/// let mut table = Table::new(["salt_M", "r_g_mean_angstrom"]);
/// table.push([0.1.into(), 53.25.into()])?;
/// assert_eq!(table.to_csv(), "salt_M,r_g_mean_angstrom\n0.1,53.25\n");
/// # Ok::<(), protomer_io::IoError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    columns: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// A table with these columns and no rows.
    pub fn new<S: Into<String>>(columns: impl IntoIterator<Item = S>) -> Self {
        Self {
            columns: columns.into_iter().map(Into::into).collect(),
            rows: Vec::new(),
        }
    }

    /// The column names.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The rows.
    pub fn rows(&self) -> &[Vec<Cell>] {
        &self.rows
    }

    /// Adds a row.
    ///
    /// # Errors
    /// [`IoError::Unwritable`] unless it has a cell for each column.
    pub fn push(&mut self, row: impl IntoIterator<Item = Cell>) -> Result<()> {
        let row: Vec<Cell> = row.into_iter().collect();
        if row.len() != self.columns.len() {
            let cause = format!(
                "a row has {} cells for {} columns",
                row.len(),
                self.columns.len()
            );
            return Err(IoError::unwritable(cause, "give a cell for each column"));
        }
        self.rows.push(row);
        Ok(())
    }

    /// The header line and a line per row.
    pub fn to_csv(&self) -> String {
        let mut text = csv_line(self.columns.iter().map(|column| quote(column)));
        for row in &self.rows {
            text.push_str(&row_to_csv(row));
        }
        text
    }
}

/// One row as a line with its end, for logs that grow.
pub fn row_to_csv(row: &[Cell]) -> String {
    csv_line(row.iter().map(|cell| match cell {
        Cell::Empty => String::new(),
        Cell::Integer(value) => value.to_string(),
        Cell::Number(value) => number(*value),
        Cell::Text(text) => quote(text),
    }))
}

fn csv_line(cells: impl Iterator<Item = String>) -> String {
    let mut line = cells.collect::<Vec<_>>().join(",");
    line.push('\n');
    line
}

/// The fewest digits that read back exactly, in exponent notation where that is much shorter.
fn number(value: f64) -> String {
    let magnitude = value.abs();
    let mut text = String::new();
    let _ = if value == 0.0 || (1e-5..1e16).contains(&magnitude) || !value.is_finite() {
        write!(text, "{value}")
    } else {
        write!(text, "{value:e}")
    };
    text
}

fn quote(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn numbers_read_back_exactly(bits in any::<u64>()) {
            let value = f64::from_bits(bits);
            let back: f64 = number(value).parse().unwrap();
            prop_assert!(back.to_bits() == bits || (back.is_nan() && value.is_nan()));
        }
    }

    #[test]
    fn awkward_text_is_quoted() {
        let mut table = Table::new(["name", "n", "x, y"]);
        table
            .push(["say \"hi\"".into(), 3usize.into(), Cell::Empty])
            .unwrap();
        table
            .push([Cell::from(None::<f64>), (-2i64).into(), 1e-300.into()])
            .unwrap();
        assert_eq!(
            table.to_csv(),
            "name,n,\"x, y\"\n\"say \"\"hi\"\"\",3,\n,-2,1e-300\n"
        );
        assert!(table.push([Cell::Empty]).is_err());
    }
}
