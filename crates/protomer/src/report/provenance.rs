//! Where results come from: version, hashes, seed, how it ended.

use super::html::{definitions, folded_text, paragraph};
use super::page::Section;
use crate::run::RunRecord;
use anyhow::{Context, Result};
use std::path::Path;

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
    let mut rows = vec![("directory", name(directory))];
    if let Some(record) = record {
        rows.push(("program", format!("protomer {}", record.version)));
        rows.push(("command", format!("protomer {}", record.verb)));
        rows.push(("ended", record.exit_reason.clone()));
        if !record.input_sha256.is_empty() {
            rows.push(("SHA-256 of the input", record.input_sha256.clone()));
        }
        rows.push(("identity (SHA-256 of settings and input)", record.identity.clone()));
    }
    rows.extend(more);
    rows.push(("page made by", format!("protomer {}", env!("CARGO_PKG_VERSION"))));
    let path = directory.join(settings);
    let text = std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let note = "Equal settings on equal input give equal results.";
    Ok(Section::new("Provenance", definitions(&rows) + &folded_text(settings, &text) + &paragraph(note)))
}

/// The last part of the path, which says the same wherever the directory lies.
pub fn name(directory: &Path) -> String {
    let absolute = std::path::absolute(directory).unwrap_or_else(|_| directory.to_owned());
    absolute.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// What a record says of an end that was none.
pub fn unfinished(record: Option<&RunRecord>) -> Option<String> {
    let Some(record) = record else {
        return Some("There is no run.json: the run did not come far enough to write one.".into());
    };
    match record.exit_reason.as_str() {
        "done" => None,
        "stopped" => Some("It was stopped before its end; the same command goes on from there.".into()),
        "running" => Some(
            "By its record it is still running. If no process works in the directory, it was killed or failed; the same \
             command goes on, or says what is wrong."
                .into(),
        ),
        reason => Some(format!("It failed: {reason}")),
    }
}
