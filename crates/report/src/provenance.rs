//! The origin of results: version, hashes, seed, how the run ended.

use super::html::{definitions, folded_text, paragraph};
use super::page::Section;
use anyhow::{Context, Result};
use protomer_results::{Exit, Record};
use std::path::Path;

const NOTE: &str = "Equal settings on equal input give equal results.";

/// The section of a directory with this settings file and the additional rows `more`.
///
/// # Errors
/// If the settings cannot be read.
pub fn section(
    directory: &Path,
    settings: &str,
    record: Option<&Record>,
    more: Vec<(&str, String)>,
) -> Result<Section> {
    let path = directory.join(settings);
    let text = protomer_io::input::read_to_string(&path)
        .with_context(|| format!("cannot read {}", path.display()))?;
    let folded = folded_text(settings, &text);
    Ok(Section::new(
        "Provenance",
        rows(directory, record, more) + &folded + &paragraph(NOTE),
    ))
}

/// The section of a directory without a settings file; the settings may be given as a heading
/// and text.
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

/// State of a part, in a word for a table.
pub fn ended(record: Option<&Record>) -> &str {
    record.map_or("–", |record| record.exit.word())
}

/// Cause that stopped a part, as in "50 mM, replica 1: *stopped by a signal after 3 of 9 sweeps*";
/// `None` if it is finished. `progress` is its progress according to its record.
pub fn problem_of_part(record: Option<&Record>, progress: &str) -> Option<String> {
    let Some(record) = record else {
        return Some("no record; it was not started, or was killed early".into());
    };
    match &record.exit {
        Exit::Done => None,
        Exit::Failed { error } => Some(format!("failed{progress}: {error}")),
        Exit::Stopped { by: Some(cause) } => Some(format!("stopped by {cause}{progress}")),
        Exit::Stopped { by: None } => Some(format!("stopped{progress}")),
        Exit::Running => Some("at work, or killed".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_results::{ResultKind, Work};

    fn record(exit: Exit) -> Record {
        let work = Work {
            kind: ResultKind::Simulation,
            verb: "simulate",
            identity: String::new(),
            input_sha256: String::new(),
        };
        Record::new(&work, exit)
    }

    #[test]
    fn what_kept_a_part_from_its_end_is_said_with_how_far_it_came() {
        let stopped = |by: Option<&str>| Exit::Stopped {
            by: by.map(str::to_owned),
        };
        let cases = [
            (Exit::Done, None),
            (
                stopped(Some("a signal")),
                Some("stopped by a signal after 3 of 9 sweeps"),
            ),
            (stopped(None), Some("stopped after 3 of 9 sweeps")),
            (
                Exit::failed(&"the disk is full"),
                Some("failed after 3 of 9 sweeps: the disk is full"),
            ),
            (Exit::Running, Some("at work, or killed")),
        ];
        for (exit, expected) in cases {
            let problem = problem_of_part(Some(&record(exit)), " after 3 of 9 sweeps");
            assert_eq!(problem.as_deref(), expected);
        }
        assert!(problem_of_part(None, "").is_some_and(|problem| problem.contains("not started")));
    }
}
