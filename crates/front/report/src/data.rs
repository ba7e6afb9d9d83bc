//! The numbers of a figure: a folded table, and a link that saves them as CSV.

use super::html::{escape, significant, table};
use anyhow::{Context, Result};
use protomer_io::csv::cells;
use std::fmt::Write;
use std::path::Path;

/// Number of rows shown on the page; the link saves all of them.
const MOST_ROWS: usize = 200;
/// Size up to which tables are embedded; longer ones are only mentioned.
const MOST_BYTES: usize = 4 << 20;
/// Number of digits shown on the page; the link saves all of them.
const DIGITS: usize = 6;

/// Shows a CSV table of this name.
///
/// # Errors
/// If the text is not CSV.
pub fn data(name: &str, csv: &str) -> Result<String> {
    let mut lines = csv.lines().enumerate();
    let columns = lines
        .next()
        .map(|(_, line)| cells(name, 1, line))
        .transpose()?
        .unwrap_or_default();
    let count = csv.lines().count().saturating_sub(1);
    let shown = lines
        .take(MOST_ROWS)
        .map(|(number, line)| cells(name, number + 1, line));
    let rows = shown
        .map(|row| Ok(row?.iter().map(|cell| short(cell)).collect()))
        .collect::<Result<Vec<Vec<String>>>>()?;
    let note = if count > MOST_ROWS {
        format!("the first {MOST_ROWS} of {count} rows")
    } else {
        rows_of(count)
    };
    Ok(format!(
        "<details><summary>{}: {note}</summary>\n<p>{}</p>\n{}</details>\n",
        escape(name),
        link(name, csv),
        table(&columns, &rows)
    ))
}

/// Shows the CSV table in a file of a directory, under the name of the file; empty if it does not
/// exist.
///
/// # Errors
/// If it cannot be read.
pub fn of_file(directory: &Path, name: &str) -> Result<String> {
    let path = directory.join(name);
    if !path.is_file() {
        return Ok(String::new());
    }
    let csv = protomer_io::input::read_to_string(&path)
        .with_context(|| format!("cannot read {}", path.display()))?;
    data(
        &path.file_name().unwrap_or_default().to_string_lossy(),
        &csv,
    )
}

fn rows_of(count: usize) -> String {
    format!("{count} {}", if count == 1 { "row" } else { "rows" })
}

fn link(name: &str, csv: &str) -> String {
    if csv.len() > MOST_BYTES {
        return format!(
            "The whole table is too long for this page; it is the file {} of the directory.",
            escape(name)
        );
    }
    format!(
        "<a download=\"{}\" href=\"data:text/csv;charset=utf-8,{}\">Save as CSV</a>",
        escape(name),
        encode(csv)
    )
}

/// Percent-encodes text for a URI.
fn encode(text: &str) -> String {
    let mut encoded = String::with_capacity(text.len() + text.len() / 4);
    for byte in text.bytes() {
        match byte {
            b'A'..=b'Z'
            | b'a'..=b'z'
            | b'0'..=b'9'
            | b'-'
            | b'.'
            | b'_'
            | b'~'
            | b','
            | b':'
            | b'/' => {
                encoded.push(char::from(byte));
            }
            // Writing to a string cannot fail.
            _ => drop(write!(encoded, "%{byte:02X}")),
        }
    }
    encoded
}

/// Rounds numbers for display; leaves text unchanged.
fn short(cell: &str) -> String {
    match cell.parse::<f64>() {
        Ok(_) if cell.bytes().all(|byte| byte.is_ascii_digit()) => cell.to_owned(),
        Ok(value) => significant(value, DIGITS),
        Err(_) => cell.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_kept_in_the_link() {
        let html = data("a.csv", "x,\"a, b\"\n0.12345678901234,1%\n").unwrap();
        assert!(
            html.contains("x,%22a,%20b%22%0A0.12345678901234,1%25%0A"),
            "{html}"
        );
        assert!(
            html.contains("<td>0.123457</td>")
                && html.contains("<th>a, b</th>")
                && html.contains("1 row<")
        );
    }

    #[test]
    fn long_tables_say_so() {
        let csv = format!("x\n{}", "1\n".repeat(300));
        assert!(
            data("a.csv", &csv)
                .unwrap()
                .contains("the first 200 of 300 rows")
        );
    }
}
