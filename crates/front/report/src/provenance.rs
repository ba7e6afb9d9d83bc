//! The origin of results: version, hashes, seed, how the run ended.

use super::html::{definitions, folded_text, paragraph};
use super::page::Section;
use anyhow::{Context, Result};
use protomer_common::page::SettingsText;
use protomer_results::{Exit, Record};
use std::path::Path;

const NOTE: &str = "Equal settings on equal input give equal results.";

/// The section of a directory with these settings and the additional rows `more`.
///
/// # Errors
/// If the settings cannot be read.
pub fn section(
    directory: &Path,
    settings: &SettingsText,
    record: Option<&Record>,
    more: Vec<(&str, String)>,
) -> Result<Section> {
    let folded = match settings {
        SettingsText::File(name) => {
            let path = directory.join(name);
            let text = protomer_io::input::read_to_string(&path)
                .with_context(|| format!("cannot read {}", path.display()))?;
            folded_text(name, &text)
        }
        SettingsText::Text(text) => folded_text("settings", text),
        SettingsText::None => String::new(),
    };
    Ok(Section::new(
        "Provenance",
        rows(directory, record, more) + &folded + &paragraph(NOTE),
    ))
}

fn rows(directory: &Path, record: Option<&Record>, more: Vec<(&str, String)>) -> String {
    let mut rows = vec![("directory", name(directory))];
    if let Some(record) = record {
        rows.push(("program", format!("protomer {}", record.version)));
        rows.push(("command", format!("protomer {}", record.verb)));
        rows.push(("ended", ended_in_words(&record.exit)));
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

/// The last part of the path, which does not depend on where the directory is.
pub fn name(directory: &Path) -> String {
    let absolute = std::path::absolute(directory).unwrap_or_else(|_| directory.to_owned());
    absolute
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// Description of the end of a run, with the error that ended it.
fn ended_in_words(exit: &Exit) -> String {
    match exit {
        Exit::Failed { error } => format!("failed: {error}"),
        exit => exit.word().to_owned(),
    }
}

/// Reason why a run is not finished, as a sentence; `None` if it is.
pub fn unfinished(record: Option<&Record>) -> Option<String> {
    let Some(record) = record else {
        return Some("There is no run.json: the run ended before it could write one.".into());
    };
    match &record.exit {
        Exit::Done => None,
        Exit::Failed { error } => Some(format!("It failed: {error}")),
        Exit::Stopped { by: cause } => {
            let reason = cause
                .as_ref()
                .map_or_else(String::new, |cause| format!(" by {cause}"));
            Some(format!(
                "It was stopped{reason}; the same command continues it."
            ))
        }
        Exit::Running => Some(
            "According to its record it is still running. If no process works in the \
             directory, it was killed; the same command continues it."
                .into(),
        ),
    }
}
