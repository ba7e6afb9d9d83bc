//! Writing to the user: data on stdout, notes on stderr.

use anyhow::Result;
use serde::Serialize;
use std::cell::RefCell;
use std::io::Write;

thread_local! {
    /// What this thread would have written to stdout, while a program asked for it.
    static CAPTURED: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Does some work and returns with it what this thread meant for stdout meanwhile.
pub fn captured<T>(work: impl FnOnce() -> T) -> (T, String) {
    let outer = CAPTURED.replace(Some(String::new()));
    let result = work();
    (result, CAPTURED.replace(outer).unwrap_or_default())
}

/// Whether a program listens, which reads answers and not notes.
pub fn is_captured() -> bool {
    CAPTURED.with_borrow(Option::is_some)
}

/// Whether a program listens: then the text is its, and true is returned.
fn capture(text: &str) -> bool {
    CAPTURED.with_borrow_mut(|captured| {
        let Some(captured) = captured else {
            return false;
        };
        captured.push_str(text);
        captured.push('\n');
        true
    })
}

/// One JSON object on stdout, followed by a newline.
pub fn json(value: &impl Serialize) -> Result<()> {
    text(&serde_json::to_string_pretty(value)?)
}

/// Text on stdout, followed by a newline.
pub fn text(text: &str) -> Result<()> {
    if capture(text) {
        return Ok(());
    }
    let mut stdout = std::io::stdout().lock();
    writeln!(stdout, "{text}")?;
    stdout.flush()?;
    Ok(())
}

/// A line on stderr. That stderr is gone is no reason to stop.
pub fn note(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// Whether the reader of our output went away, as in `protomer ... | head`.
pub fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .chain()
        .filter_map(|cause| cause.downcast_ref::<std::io::Error>())
        .any(|cause| cause.kind() == std::io::ErrorKind::BrokenPipe)
}

/// Columns padded to the same width, the first row being the heading.
pub fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        rows.iter()
            .filter_map(|row| row.get(column))
            .map(|c| c.chars().count())
            .max()
    };
    let widths: Vec<usize> = (0..columns)
        .map(|column| width(column).unwrap_or(0))
        .collect();
    let line = |row: &Vec<String>| {
        let cells = row
            .iter()
            .zip(&widths)
            .map(|(cell, width)| format!("{cell:<width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}
