//! The table of all complexes: a row each, in the order of their source.

use super::record::ScoreRecord;
use super::{Complexes, Measure, ScoreSettings};
use anyhow::{Context, Result};
use protomer_io::csv::{Cell, Table, cells};
use serde_json::Value;
use std::path::Path;

/// Columns before those that are measured.
const BEFORE: [&str; 4] = ["name", "status", "receptor", "ligand"];
/// Warnings of a complex in the table.
const WARNINGS_SHOWN: usize = 6;
/// Columns after those that are measured.
const AFTER: [&str; 2] = ["warnings", "error"];

/// The table of scores.
pub(super) struct ScoreTable(Table);

impl ScoreTable {
    /// The rows of complexes and their records.
    pub fn new(complexes: &Complexes, settings: &ScoreSettings, records: &[ScoreRecord]) -> Self {
        let measured = headings(settings, records);
        let further = further_headings(complexes);
        let before = BEFORE.iter().map(|name| (*name).to_owned());
        let after = AFTER.iter().map(|name| (*name).to_owned());
        let columns = before
            .chain(further.iter().cloned())
            .chain(measured.iter().cloned());
        let mut table = Table::new(columns.chain(after));
        for (complex, record) in complexes.0.iter().zip(records) {
            let path = |path: &Path| Cell::Text(path.display().to_string());
            let mut row = vec![
                Cell::from(complex.name.as_str()),
                Cell::from(status(record)),
                path(&complex.receptor),
                complex.ligand.as_deref().map_or(Cell::Empty, path),
            ];
            for heading in &further {
                let stated = complex.further.iter().find(|(name, _)| name == heading);
                row.push(stated.map_or(Cell::Empty, |(_, text)| as_read(text)));
            }
            row.extend(measured.iter().map(|heading| cell(record.value(heading))));
            row.push(Cell::from(warnings_in_words(record).as_str()));
            row.push(record.error.as_deref().map_or(Cell::Empty, Cell::from));
            // A row has a cell for each column by construction.
            drop(table.push(row));
        }
        Self(table)
    }

    /// Writes the table.
    ///
    /// # Errors
    /// Names the file that cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let text = self.0.to_csv()?;
        Ok(protomer_io::atomic::write_atomically(path, |file| {
            file.write_all(text.as_bytes())
        })?)
    }

    /// Names of the columns.
    pub fn columns(&self) -> &[String] {
        self.0.columns()
    }
}

/// The table as its file has it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ShownScores {
    /// Headings.
    pub columns: Vec<String>,
    /// Cells of each complex, one for each heading.
    pub rows: Vec<Vec<String>>,
}

impl ScoreTable {
    /// The table as its file has it.
    pub fn shown(&self) -> ShownScores {
        let text = self.0.to_csv().unwrap_or_default();
        ShownScores::of_text("score.csv", &text).unwrap_or_default()
    }
}

impl ShownScores {
    /// Reads a table; `None` if there is no such file.
    ///
    /// # Errors
    /// If the file cannot be read or is damaged.
    pub fn read_if_present(path: &Path) -> Result<Option<Self>> {
        if !path.is_file() {
            return Ok(None);
        }
        let shown = path.display().to_string();
        let text = protomer_io::input::read_to_string(path)
            .with_context(|| format!("cannot read {shown}"))?;
        Self::of_text(&shown, &text).map(Some)
    }

    fn of_text(file: &str, text: &str) -> Result<Self> {
        let mut rows = Vec::new();
        for (number, line) in text.lines().enumerate() {
            rows.push(cells(file, number + 1, line)?);
        }
        let mut rows = rows.into_iter();
        let columns = rows.next().unwrap_or_default();
        let width = columns.len();
        Ok(Self {
            columns,
            rows: rows.filter(|row| row.len() == width).collect(),
        })
    }

    /// Names of the complexes that have a text in a column, and the text.
    pub fn with_text<'a>(&'a self, column: &str) -> impl Iterator<Item = (&'a str, &'a str)> {
        let place = self.columns.iter().position(|heading| heading == column);
        let rows = self.rows.iter();
        rows.filter_map(move |row| {
            let text = row[place?].as_str();
            (!text.is_empty()).then_some((row[0].as_str(), text))
        })
    }
}

/// The first warnings of a complex, and how many more its record has.
fn warnings_in_words(record: &ScoreRecord) -> String {
    let shown = record.warnings.iter().take(WARNINGS_SHOWN);
    let mut text = shown.cloned().collect::<Vec<_>>().join("; ");
    if record.warnings.len() > WARNINGS_SHOWN {
        let more = record.warnings.len() - WARNINGS_SHOWN;
        text += &format!("; and {more} more in row.json");
    }
    text
}

/// Whether a complex was scored.
pub(super) fn status(record: &ScoreRecord) -> &'static str {
    match record.error {
        None => "ok",
        Some(_) => "failed",
    }
}

/// Headings of the requested groups, those of each group as the first record has them.
pub(super) fn headings(settings: &ScoreSettings, records: &[ScoreRecord]) -> Vec<String> {
    let of_measure = |measure: &Measure| {
        let mut groups = records.iter().flat_map(|record| &record.measured);
        let group = groups.find(|group| group.measure == *measure);
        let values = group.into_iter().flat_map(|group| &group.values);
        values
            .map(|(heading, _)| heading.clone())
            .collect::<Vec<_>>()
    };
    settings.columns.iter().flat_map(of_measure).collect()
}

/// Further columns of the source, without those that this table has itself.
fn further_headings(complexes: &Complexes) -> Vec<String> {
    let first = complexes.0.first();
    let further = first.into_iter().flat_map(|complex| &complex.further);
    let names = further.map(|(name, _)| name);
    let is_other =
        |name: &&String| !BEFORE.contains(&name.as_str()) && !AFTER.contains(&name.as_str());
    names.filter(is_other).cloned().collect()
}

fn as_read(text: &str) -> Cell {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Cell::Number(number),
        _ => Cell::from(text),
    }
}

fn cell(value: Option<&Value>) -> Cell {
    match value {
        None | Some(Value::Null) => Cell::Empty,
        Some(Value::Bool(true)) => Cell::from("yes"),
        Some(Value::Bool(false)) => Cell::from("no"),
        Some(Value::String(text)) => Cell::from(text.as_str()),
        Some(number) => match (number.as_i64(), number.as_f64()) {
            (Some(integer), _) => Cell::Integer(integer),
            (None, Some(real)) => Cell::Number(real),
            (None, None) => Cell::Empty,
        },
    }
}
