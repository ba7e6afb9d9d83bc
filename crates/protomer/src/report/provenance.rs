//! Where results come from: version, hashes, seed, how it ended.

use super::html::{definitions, folded_text, paragraph};
use super::page::Section;
use crate::run::RunRecord;
use anyhow::{Context, Result};
use std::path::Path;

const NOTE: &str = "Equal settings on equal input give equal results.";

/// The section of a directory with this file of settings; `more` is told besides.
///
/// # Errors
/// If the settings cannot be read.
pub fn section(
    directory: &Path,
    settings: &str,
    record: Option<&RunRecord>,
    more: Vec<(&str, String)>,
) -> Result<Section> {
    let path = directory.join(settings);
    let text = std::fs::read_to_string(&path)
        .with_context(|| format!("cannot read {}", path.display()))?;
    let folded = folded_text(settings, &text);
    Ok(Section::new(
        "Provenance",
        rows(directory, record, more) + &folded + &paragraph(NOTE),
    ))
}

/// The section of a directory that has no file of settings, but perhaps says them elsewhere: a
/// heading and the text.
pub fn without_file(
    directory: &Path,
    settings: Option<(&str, &str)>,
    more: Vec<(&str, String)>,
) -> Section {
    let folded = settings.map_or_else(String::new, |(title, text)| folded_text(title, text));
    Section::new(
        "Provenance",
        rows(directory, None, more) + &folded + &paragraph(NOTE),
    )
}

fn rows(directory: &Path, record: Option<&RunRecord>, more: Vec<(&str, String)>) -> String {
    let mut rows = vec![("directory", name(directory))];
    if let Some(record) = record {
        rows.push(("program", format!("protomer {}", record.version)));
        rows.push(("command", format!("protomer {}", record.verb)));
        rows.push(("ended", record.exit_reason.clone()));
        if !record.input_sha256.is_empty() {
            rows.push(("SHA-256 of the input", record.input_sha256.clone()));
        }
        rows.push((
            "identity (SHA-256 of settings and input)",
            record.identity.clone(),
        ));
    }
    rows.extend(more);
    rows.push((
        "page made by",
        format!("protomer {}", env!("CARGO_PKG_VERSION")),
    ));
    definitions(&rows)
}

/// The last part of the path, which says the same wherever the directory lies.
pub fn name(directory: &Path) -> String {
    let absolute = std::path::absolute(directory).unwrap_or_else(|_| directory.to_owned());
    absolute
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// What a record says of an end that was none.
pub fn unfinished(record: Option<&RunRecord>) -> Option<String> {
    let Some(record) = record else {
        return Some("There is no run.json: the run did not come far enough to write one.".into());
    };
    if let Some(error) = record.error() {
        return Some(format!("It failed: {error}"));
    }
    match record.exit_reason.as_str() {
        "done" => None,
        "stopped" => {
            let by = record.stopper().map_or_else(String::new, |stopper| format!(" by {stopper}"));
            Some(format!("It was stopped{by} before its end; the same command goes on from there."))
        }
        _ => Some(
            "By its record it is still running. If no process works in the directory, it was killed; the same command goes on."
                .into(),
        ),
    }
}

/// How a part ended, in a word for a table.
pub fn ended(record: Option<&RunRecord>) -> &str {
    match record {
        None => "–",
        Some(record) if record.error().is_some() => "failed",
        Some(record) => &record.exit_reason,
    }
}

/// What kept a part from its end, as in "50 mM, replica 1: *stopped by a signal after 3 of 9
/// sweeps*"; nothing if it came to it. `progress` says how far it is by its record.
pub fn problem_of_part(record: Option<&RunRecord>, progress: &str) -> Option<String> {
    let Some(record) = record else {
        return Some("no record; it was not begun, or was killed before its end".into());
    };
    if let Some(error) = record.error() {
        return Some(format!("failed{progress}: {error}"));
    }
    match (record.exit_reason.as_str(), record.stopper()) {
        ("done", _) => None,
        ("stopped", Some(stopper)) => Some(format!("stopped by {stopper}{progress}")),
        ("stopped", None) => Some(format!("stopped{progress}")),
        _ => Some("at work, or killed".into()),
    }
}
