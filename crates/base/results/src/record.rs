//! `run.json`: the work, its input, the version, the progress, and how it ended.

use crate::keys;
use crate::{Error, Interrupt, Result, ResultKind};
use protomer_io::atomic::write_atomically;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::fmt;
use std::path::Path;

/// The name of the record in its directory.
pub const FILE: &str = "run.json";
/// The key in the details for the reason of a stop.
const STOPPED_BY: &str = "stopped_by";

/// The identity of the work. Work with the same identity gives the same result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Work {
    /// The kind of its results.
    pub kind: ResultKind,
    /// The verb that runs it.
    pub verb: &'static str,
    /// SHA-256 of the settings and the input.
    pub identity: String,
    /// SHA-256 of the input; empty if there is none besides the settings.
    pub input_sha256: String,
}

impl Work {
    /// The work of a verb, by what its settings and its input hash to.
    pub fn new(kind: ResultKind, verb: &'static str, identity: &str, input_sha256: &str) -> Self {
        Self {
            kind,
            verb,
            identity: identity.to_owned(),
            input_sha256: input_sha256.to_owned(),
        }
    }
}

/// Status of a run: running, or how it ended.
///
/// ```
/// use protomer_results::Exit;
/// assert_eq!(Exit::failed(&"the energy is NaN").word(), "failed");
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Exit {
    /// Run that has not ended: a process is working on it, or was killed.
    Running,
    /// Run that is complete.
    Done,
    /// Run that was stopped on request.
    Stopped {
        /// The reason, as in "stopped by *the time limit*"; unknown in some older records.
        by: Option<String>,
    },
    /// Run that an error ended.
    Failed {
        /// The error, in words.
        error: String,
    },
}

/// The record of a run, a sweep, or any other work with a directory.
///
/// ```
/// use protomer_results::{Exit, Record, ResultKind, Work};
/// # let folder = tempfile::tempdir().unwrap();
/// let work = Work::new(ResultKind::LatticeRun, "lattice run", "5f2c", "");
/// let record = Record { done: Some(200), ..Record::new(&work, Exit::Done) };
/// record.write(folder.path()).unwrap();
/// assert_eq!(Record::read(folder.path()).unwrap(), Some(record));
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(from = "Form", into = "Form")]
pub struct Record {
    /// Version of the program.
    pub version: String,
    /// The kind of results; `None` in records of earlier versions.
    pub kind: Option<ResultKind>,
    /// The verb.
    pub verb: String,
    /// SHA-256 of the settings and the input.
    pub identity: String,
    /// SHA-256 of the input; empty if there is none besides the settings.
    pub input_sha256: String,
    /// Status of the run.
    pub exit: Exit,
    /// Progress, in the units of its length; `None` for work without a length.
    pub done: Option<u64>,
    /// Further details.
    pub details: Value,
}

impl Record {
    /// A record without details.
    pub fn new(work: &Work, exit: Exit) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            kind: Some(work.kind.clone()),
            verb: work.verb.into(),
            identity: work.identity.clone(),
            input_sha256: work.input_sha256.clone(),
            exit,
            done: None,
            details: Value::Null,
        }
    }

    /// Whether the work is complete.
    pub fn is_done(&self) -> bool {
        self.exit == Exit::Done
    }

    /// Whether the work is complete at this length; a run that has been extended is not.
    pub fn is_done_at(&self, length: u64) -> bool {
        // The length may have grown since; then the run goes on.
        self.is_done() && self.done == Some(length)
    }

    /// The answer among the details; `None` before there is one, or if it is of another version.
    pub fn answer<T: DeserializeOwned>(&self) -> Option<T> {
        serde_json::from_value(self.details.clone()).ok()
    }

    /// The details as a value.
    ///
    /// # Errors
    /// [`Error::Parse`] if they do not have the expected form.
    pub fn read_details<T: DeserializeOwned>(&self, directory: &Path) -> Result<T> {
        serde_json::from_value(self.details.clone()).map_err(|error| Error::Parse {
            path: directory.join(FILE),
            line: 1,
            problem: format!("the details are damaged ({error}); start again with --force"),
        })
    }

    /// Cause that stopped a part, as in "50 mM, replica 1: *stopped by a signal after 3 of 9 sweeps*";
    /// `None` if it is finished. `progress` is its progress according to its record.
    ///
    /// ```
    /// use protomer_results::Record;
    /// let problem = Record::problem_of_part(None, " after 3 of 9 sweeps");
    /// assert!(problem.is_some_and(|problem| problem.starts_with("no record")));
    /// ```
    pub fn problem_of_part(record: Option<&Self>, progress: &str) -> Option<String> {
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

    /// Refuses a directory that holds other work of this kind.
    ///
    /// # Errors
    /// [`Error::OtherInput`].
    pub fn require(&self, identity: &str, kind: &ResultKind, directory: &Path) -> Result<()> {
        if self.identity == identity {
            return Ok(());
        }
        Err(Error::OtherInput {
            path: directory.to_owned(),
            kind: kind.clone(),
        })
    }

    /// Reads the record of a directory, if it exists.
    ///
    /// # Errors
    /// If it exists but cannot be read.
    pub fn read(directory: &Path) -> Result<Option<Self>> {
        keys::read_json_if_present(&directory.join(FILE))
    }

    /// Writes the record into a directory.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, directory: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(self).map_err(|error| Error::Unwritable {
            content: FILE,
            cause: error.to_string(),
        })?;
        write_atomically(&directory.join(FILE), |file| writeln!(file, "{text}"))?;
        Ok(())
    }
}

impl Exit {
    /// Status of a run that this interrupt stopped.
    ///
    /// ```
    /// use protomer_results::{Exit, Interrupt};
    /// let interrupt = Interrupt::default();
    /// interrupt.request();
    /// let exit = Exit::stopped_by(&interrupt);
    /// assert_eq!(exit, Exit::Stopped { by: Some("a signal".to_owned()) });
    /// ```
    pub fn stopped_by(interrupt: &Interrupt) -> Self {
        Exit::Stopped {
            by: Some(interrupt.reason().into()),
        }
    }

    /// Status of a run that this error ended, with its causes.
    pub fn failed(error: &dyn fmt::Display) -> Self {
        Exit::Failed {
            error: format!("{error:#}"),
        }
    }

    /// The word in JSON: `running`, `done`, `stopped` or `failed`.
    ///
    /// ```
    /// use protomer_results::Exit;
    /// let failed = Exit::failed(&"no space left");
    /// assert_eq!((failed.word(), Exit::Done.word()), ("failed", "done"));
    /// ```
    pub fn word(&self) -> &'static str {
        match self {
            Exit::Running => "running",
            Exit::Done => "done",
            Exit::Stopped { .. } => "stopped",
            Exit::Failed { .. } => "failed",
        }
    }
}

/// The JSON form of a record.
#[derive(Serialize, Deserialize)]
struct Form {
    version: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    kind: Option<ResultKind>,
    verb: String,
    identity: String,
    input_sha256: String,
    exit_reason: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    done: Option<u64>,
    details: Value,
}

impl From<Record> for Form {
    fn from(record: Record) -> Self {
        let mut details = record.details;
        let exit_reason = record.exit.word().to_owned();
        let mut failure = None;
        match record.exit {
            Exit::Stopped { by: Some(reason) } => {
                // Details of another form could not take the key.
                if !details.is_object() {
                    details = json!({});
                }
                details[STOPPED_BY] = reason.into();
            }
            Exit::Failed { error } => failure = Some(error),
            Exit::Running | Exit::Done | Exit::Stopped { by: None } => {}
        }
        Self {
            version: record.version,
            kind: record.kind,
            verb: record.verb,
            identity: record.identity,
            input_sha256: record.input_sha256,
            exit_reason,
            error: failure,
            done: record.done,
            details,
        }
    }
}

impl From<Form> for Record {
    fn from(form: Form) -> Self {
        let mut details = form.details;
        let exit = match form.exit_reason.as_str() {
            "running" => Exit::Running,
            "done" => Exit::Done,
            "stopped" => Exit::Stopped {
                by: take_stopper(&mut details),
            },
            "failed" => Exit::Failed {
                error: form.error.unwrap_or_default(),
            },
            // Earlier versions wrote the error in place of the word.
            error => Exit::Failed {
                error: error.to_owned(),
            },
        };
        let done = form.done.or_else(|| earlier_count(&details));
        Self {
            version: form.version,
            kind: form.kind,
            verb: form.verb,
            identity: form.identity,
            input_sha256: form.input_sha256,
            exit,
            done,
            details,
        }
    }
}

fn take_stopper(details: &mut Value) -> Option<String> {
    let reason = details.as_object_mut()?.remove(STOPPED_BY)?;
    // What `From<Record>` made an object only for this key becomes null again.
    if details.as_object().is_some_and(serde_json::Map::is_empty) {
        *details = Value::Null;
    }
    reason.as_str().map(str::to_owned)
}

/// The progress in records of earlier versions.
fn earlier_count(details: &Value) -> Option<u64> {
    ["sweeps_done", "steps"]
        .into_iter()
        .find_map(|key| details.get(key)?.as_u64())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(exit: Exit, details: Value) -> Record {
        let work = Work::new(ResultKind::Sweep, "sweep", "a", "b");
        Record {
            done: Some(7),
            details,
            ..Record::new(&work, exit)
        }
    }

    #[test]
    fn what_kept_a_part_from_its_end_is_said_with_how_far_it_came() {
        let stopped = |cause: Option<&str>| Exit::Stopped {
            by: cause.map(str::to_owned),
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
            let problem =
                Record::problem_of_part(Some(&record(exit, Value::Null)), " after 3 of 9 sweeps");
            assert_eq!(problem.as_deref(), expected);
        }
        assert!(
            Record::problem_of_part(None, "")
                .is_some_and(|problem| problem.contains("not started"))
        );
    }

    #[test]
    fn every_exit_survives_a_round_trip() {
        let exits = [
            Exit::Running,
            Exit::Done,
            Exit::Stopped { by: None },
            Exit::stopped_by(&Interrupt::default()),
            Exit::failed(&"the disk is full"),
        ];
        for exit in exits {
            for details in [Value::Null, json!({"replica": 2})] {
                let written = record(exit.clone(), details);
                let text = serde_json::to_string(&written).unwrap();
                assert_eq!(
                    serde_json::from_str::<Record>(&text).unwrap(),
                    written,
                    "{text}"
                );
            }
        }
    }

    #[test]
    fn the_json_has_a_word_for_the_end_and_a_key_for_the_error() {
        let json = |exit| serde_json::to_value(record(exit, json!({}))).unwrap();
        let failed = json(Exit::failed(&"no space"));
        assert_eq!(
            (&failed["exit_reason"], &failed["error"]),
            (&json!("failed"), &json!("no space"))
        );
        let stopped = json(Exit::Stopped {
            by: Some("a signal".into()),
        });
        assert_eq!(
            (&stopped["exit_reason"], &stopped["details"]["stopped_by"]),
            (&json!("stopped"), &json!("a signal"))
        );
        assert_eq!(stopped.get("error"), None);
    }

    #[test]
    fn records_of_earlier_versions_are_understood() {
        let earlier = |exit_reason: &str| -> Record {
            serde_json::from_value(json!({
                "version": "0.1.0", "verb": "simulate", "identity": "a", "input_sha256": "b",
                "exit_reason": exit_reason, "details": {"sweeps_done": 12},
            }))
            .unwrap()
        };
        assert_eq!(
            (earlier("done").exit, earlier("done").done),
            (Exit::Done, Some(12))
        );
        assert_eq!(earlier("done").kind, None);
        assert_eq!(
            earlier("the energy is NaN").exit,
            Exit::Failed {
                error: "the energy is NaN".into()
            }
        );
    }
}
