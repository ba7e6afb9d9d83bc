//! Small tables as comma-separated values (RFC 4180), numbers printed so that they read back
//! exactly. Every cell is on one line and no formula ([`csv_cell`]).
//!
//! The crate `csv` writes. Reading is for files written by hand: blanks around a quoted cell are
//! allowed, and an unclosed quote is an error with its line. The crate `csv` splits a cell at its
//! commas if a blank precedes its quote, and reads to the end of the file after an open quote, so it
//! is a reference in the tests but not the reader.

use crate::written::csv_cell;
use crate::{IoError, Result};

/// A value in a table.
///
/// ```
/// use protomer_io::csv::Cell;
/// assert_eq!(Cell::from(None::<f64>), Cell::Empty);
/// assert_eq!(Cell::from(7_usize), Cell::Integer(7));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// No value.
    Empty,
    /// An integer.
    Integer(i64),
    /// A real number; printed with the fewest digits that read back exactly.
    Number(f64),
    /// Text; quoted if it has to be.
    Text(String),
}

impl Cell {
    fn text(&self) -> String {
        match self {
            Cell::Empty => String::new(),
            Cell::Integer(value) => value.to_string(),
            Cell::Number(value) => number(*value),
            Cell::Text(text) => text.clone(),
        }
    }
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
        match i64::try_from(value) {
            Ok(value) => Cell::Integer(value),
            Err(_) => Cell::Number(value as f64),
        }
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
/// assert_eq!(table.to_csv()?, "salt_M,r_g_mean_angstrom\n0.1,53.25\n");
/// # Ok::<(), protomer_io::IoError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    columns: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// A table with these columns and no rows.
    ///
    /// ```
    /// use protomer_io::csv::Table;
    /// assert_eq!(Table::new(["step", "energy_kt"]).to_csv()?, "step,energy_kt\n", "the head alone");
    /// # Ok::<(), protomer_io::IoError>(())
    /// ```
    pub fn new<S: Into<String>>(columns: impl IntoIterator<Item = S>) -> Self {
        Self {
            columns: columns.into_iter().map(Into::into).collect(),
            rows: Vec::new(),
        }
    }

    /// The column names.
    ///
    /// ```
    /// use protomer_io::csv::Table;
    /// assert_eq!(Table::new(["step", "energy_kt"]).columns(), ["step", "energy_kt"]);
    /// ```
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The rows.
    ///
    /// ```
    /// use protomer_io::csv::{Cell, Table};
    /// let mut table = Table::new(["chain", "charge_e"]);
    /// table.push(["A".into(), None::<f64>.into()])?;
    /// assert_eq!(table.rows(), [[Cell::Text("A".into()), Cell::Empty]]);
    /// # Ok::<(), protomer_io::IoError>(())
    /// ```
    pub fn rows(&self) -> &[Vec<Cell>] {
        &self.rows
    }

    /// Adds a row.
    ///
    /// ```
    /// use protomer_io::csv::Table;
    /// let mut table = Table::new(["replica", "energy_kt"]);
    /// table.push([1_usize.into(), (-2.5).into()])?;
    /// assert!(table.push([2_usize.into()]).is_err(), "the second cell is missing");
    /// assert_eq!(table.rows().len(), 1);
    /// # Ok::<(), protomer_io::IoError>(())
    /// ```
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
    ///
    /// ```
    /// use protomer_io::csv::{Cell, Table};
    /// let mut table = Table::new(["space group", "copies"]);
    /// table.push([Cell::from("P 1, 2"), Cell::Empty])?;
    /// assert_eq!(table.to_csv()?, "space group,copies\n\"P 1, 2\",\n");
    /// # Ok::<(), protomer_io::IoError>(())
    /// ```
    ///
    /// # Errors
    /// Never for text in memory.
    pub fn to_csv(&self) -> Result<String> {
        let mut text = line(&self.columns)?;
        for row in &self.rows {
            text += &line(row.iter().map(Cell::text))?;
        }
        Ok(text)
    }
}

/// Cells as a line with its end, for logs that grow.
///
/// ```
/// assert_eq!(protomer_io::csv::line(["P 1, P 2", "", "0.5"])?, "\"P 1, P 2\",,0.5\n");
/// # Ok::<(), protomer_io::IoError>(())
/// ```
///
/// # Errors
/// Never for text in memory.
pub fn line(cells: impl IntoIterator<Item = impl AsRef<str>>) -> Result<String> {
    let refused = |cause: String| IoError::unwritable(cause, "report it");
    let mut writer = csv::Writer::from_writer(Vec::new());
    let cells = cells.into_iter();
    let cells: Vec<String> = cells
        .map(|cell| csv_cell(cell.as_ref()).into_owned())
        .collect();
    let written = writer.write_record(&cells);
    written.map_err(|error| refused(error.to_string()))?;
    let bytes = writer.into_inner();
    let bytes = bytes.map_err(|error| refused(error.to_string()))?;
    String::from_utf8(bytes).map_err(|error| refused(error.to_string()))
}

/// The fewest digits that read back exactly, in exponent notation if that is much shorter.
fn number(value: f64) -> String {
    // Beyond these bounds a float is written out with all its zeros.
    let is_short = value == 0.0 || (1e-5..1e16).contains(&value.abs());
    if is_short || !value.is_finite() {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// The cells of a line, without the blanks around them; a cell in double quotes may hold commas,
/// and quotes doubled.
///
/// ```
/// let cells = protomer_io::csv::cells("set.csv", 2, "1abc.pdb, \"P 1, \"\"x\"\"\" ,,c")?;
/// assert_eq!(cells, ["1abc.pdb", "P 1, \"x\"", "", "c"]);
/// # Ok::<(), protomer_io::IoError>(())
/// ```
///
/// # Errors
/// [`IoError::Parse`] names line and column of a quote that is not closed, and of text after a
/// closing quote.
pub fn cells(file: &str, line: usize, text: &str) -> Result<Vec<String>> {
    let mut cells = Vec::new();
    // Lines are cut at `\n`; of `\r\n` the first half is left.
    let mut remainder = text.trim_end_matches('\r');
    loop {
        let column = cells.len() + 1;
        let (cell, after) = match remainder.trim_start().strip_prefix('"') {
            Some(quoted) => quoted_cell(file, line, column, quoted)?,
            None => match remainder.find(',') {
                Some(end) => (remainder[..end].to_owned(), &remainder[end..]),
                None => (remainder.to_owned(), ""),
            },
        };
        cells.push(cell.trim().to_owned());
        match after.strip_prefix(',') {
            Some(next) => remainder = next,
            None => return Ok(cells),
        }
    }
}

/// The content of a quoted cell, without its opening quote, and what follows from the next comma
/// on.
fn quoted_cell<'a>(
    file: &str,
    line: usize,
    column: usize,
    mut remainder: &'a str,
) -> Result<(String, &'a str)> {
    let mut cell = String::new();
    loop {
        let Some((content, after)) = remainder.split_once('"') else {
            let cause = format!("column {column}: a quote is not closed");
            let remedy = "close it in the same line";
            return Err(IoError::parse(file, line, cause, remedy));
        };
        cell.push_str(content);
        // Two quotes within quotes stand for one.
        if let Some(after) = after.strip_prefix('"') {
            cell.push('"');
            remainder = after;
            continue;
        }
        let after = after.trim_start();
        return match after.chars().next() {
            None | Some(',') => Ok((cell, after)),
            Some(character) => {
                let cause = format!("column {column}: '{character}' after a closing quote");
                let remedy = "double quotes inside quotes";
                Err(IoError::parse(file, line, cause, remedy))
            }
        };
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

        /// The crate `csv` reads what is written here, and this reader does if no cell has blanks
        /// at its ends. An end of a line becomes a blank.
        #[test]
        fn written_text_reads_back(rows in prop::collection::vec(["[a ,\"x]{1,9}", "[b\"\n, ]{1,9}"], 1..6)) {
            let mut table = Table::new(["first", "second"]);
            for [first, second] in &rows {
                table.push([first.as_str().into(), second.as_str().into()]).unwrap();
            }
            let text = table.to_csv().unwrap();
            let mut witness = csv::Reader::from_reader(text.as_bytes());
            let read: Vec<[String; 2]> = witness.deserialize().map(|row| row.unwrap()).collect();
            let on_one_line = rows.iter().map(|row| row.each_ref().map(|cell| cell.replace('\n', " ")));
            prop_assert_eq!(&read, &on_one_line.collect::<Vec<_>>());
            for [first, _] in &rows {
                let line = line([first.as_str(), ""]).unwrap();
                let read = cells("x.csv", 1, line.trim_end_matches('\n')).unwrap();
                prop_assert_eq!(read, [first.trim(), ""]);
            }
        }

        #[test]
        fn any_line_is_read_or_refused(line in "[a\", ]{0,20}") {
            let _ = cells("x.csv", 1, &line);
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
            table.to_csv().unwrap(),
            "name,n,\"x, y\"\n\"say \"\"hi\"\"\",3,\n,-2,1e-300\n"
        );
        assert!(table.push([Cell::Empty]).is_err());
    }

    #[test]
    fn a_quote_in_the_middle_of_a_cell_is_text() {
        assert_eq!(
            cells("x.csv", 1, "5\" disc,b\r").unwrap(),
            ["5\" disc", "b"]
        );
        assert_eq!(cells("x.csv", 1, "").unwrap(), [""]);
        assert_eq!(cells("x.csv", 1, "a,").unwrap(), ["a", ""]);
    }

    #[test]
    fn damaged_quotes_are_refused_with_line_and_column() {
        for (line, cause) in [
            ("a.pdb,\"x,y", "set.csv:2: column 2: a quote is not closed"),
            (
                "a.pdb,\"x\"z,y",
                "set.csv:2: column 2: 'z' after a closing quote",
            ),
        ] {
            let message = cells("set.csv", 2, line).unwrap_err().to_string();
            assert!(message.starts_with(cause), "{message}");
        }
    }
}
