//! The page of a directory of scores.

use super::figure;
use super::table::ShownScores;
use anyhow::Result;
use protomer_common::answer::counted;
use protomer_common::page::{Contents, Part, Section, significant};
use protomer_results::Record;
use std::path::Path;

/// Most rows of the table of the page; the file has all.
const MOST_ROWS: usize = 2000;
/// Digits of the numbers in the table of the page.
const DIGITS: usize = 4;

/// Contents of the page of a directory.
///
/// # Errors
/// If the table is damaged.
pub fn contents(directory: &Path, _record: Option<&Record>) -> Result<Contents> {
    let mut contents = Contents::new("Scores");
    let Some(scores) = ShownScores::read_if_present(&directory.join("score.csv"))? else {
        return Ok(contents);
    };
    let failed = scores.with_text("error").count();
    contents.subtitle = format!(
        "{}, {failed} failed",
        counted(scores.rows.len(), "complex", "complexes")
    );
    if failed > 0 {
        let complexes = counted(failed, "complex", "complexes");
        contents
            .problems
            .push(format!("{complexes} could not be scored; see Failures."));
    }
    let mut parts = Vec::new();
    if let Some(figure) = figure::figure(&scores) {
        parts.push(Part::figure(figure, "score.csv"));
    }
    if scores.rows.len() > MOST_ROWS {
        parts.push(Part::Paragraph(format!(
            "The first {MOST_ROWS} complexes; score.csv has all."
        )));
    }
    parts.push(table(&scores));
    contents.add(Section::new("Complexes", parts));
    for (title, column) in [("Failures", "error"), ("Warnings", "warnings")] {
        let rows: Vec<Vec<String>> = scores
            .with_text(column)
            .take(MOST_ROWS)
            .map(|(name, text)| vec![name.to_owned(), text.to_owned()])
            .collect();
        if !rows.is_empty() {
            let columns = vec!["complex", "message"];
            contents.add(Section::new(title, vec![Part::Table { columns, rows }]));
        }
    }
    Ok(contents)
}

/// The numbers of all complexes, which a reader can sort.
fn table(scores: &ShownScores) -> Part {
    let is_shown = |heading: &str| {
        !matches!(
            heading,
            "status" | "receptor" | "ligand" | "warnings" | "error"
        )
    };
    let shown: Vec<usize> = (0..scores.columns.len())
        .filter(|index| is_shown(&scores.columns[*index]))
        .collect();
    let cell = |text: &str| match text.parse::<f64>() {
        Ok(number) => significant(number, DIGITS),
        Err(_) => text.to_owned(),
    };
    let row = |row: &Vec<String>| shown.iter().map(|index| cell(&row[*index])).collect();
    Part::Sortable {
        columns: shown
            .iter()
            .map(|index| figure::words(&scores.columns[*index]))
            .collect(),
        rows: scores.rows.iter().take(MOST_ROWS).map(row).collect(),
    }
}
