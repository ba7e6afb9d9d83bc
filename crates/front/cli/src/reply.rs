//! The reply of a verb, and the only place that prints: data on stdout, notes on stderr.

use crate::global::Global;
use crate::stderr::{for_terminal, note};
use anyhow::{Error, Result};
use protomer_common::answer::{Answer, AnyAnswer, CompletedPart};
use protomer_results::{End, Shard};
use serde_json::Value;
use std::io::Write;

/// Outcome of a verb.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Everything is done.
    Done,
    /// Some of the inputs failed; the rest is done.
    Partial,
    /// Stopped early on request; the same command continues it.
    Stopped,
}

/// The reply of a verb.
///
/// ```
/// let words = ["framework", "honeycomb", "--theta", "60", "--kh", "50", "--ks", "10000"];
/// let reply = protomer_cli::call(&words, protomer_cli::Host::default()).unwrap();
/// assert_eq!(reply.outcome(), protomer_cli::Outcome::Done);
/// assert_eq!(reply.value().unwrap().unwrap()["dimension"], 2);
/// ```
pub struct Reply {
    answer: Option<Box<dyn AnyAnswer + Send>>,
    /// Text that is printed instead of that of the answer.
    text: Option<String>,
    /// Whether the text is the requested data rather than a summary: `--quiet` prints data too.
    is_data: bool,
    notes: Vec<Note>,
    outcome: Outcome,
    failure: Option<Error>,
}

/// A line in addition to the answer.
enum Note {
    /// A line that is printed unless quiet.
    Remark(String),
    /// A line that is printed unless quiet; the answer contains it as well, so that Python need not
    /// warn of it.
    Repeated(String),
    /// A line that is printed unless quiet or JSON, where the answer contains it.
    Summary(String),
    /// A line that is always printed.
    Error(String),
}

impl Reply {
    fn new(answer: Option<Box<dyn AnyAnswer + Send>>, outcome: Outcome) -> Self {
        Self {
            answer,
            text: None,
            is_data: false,
            notes: Vec::new(),
            outcome,
            failure: None,
        }
    }

    /// An answer whose text is a summary.
    pub fn from_answer(answer: impl Answer + Send + 'static) -> Self {
        Self::new(Some(Box::new(answer)), Outcome::Done)
    }

    /// An answer whose text is the requested data.
    pub fn data(answer: impl Answer + Send + 'static) -> Self {
        Self {
            is_data: true,
            ..Self::from_answer(answer)
        }
    }

    /// Text that has no JSON form.
    pub fn text(text: String) -> Self {
        Self {
            text: Some(text),
            is_data: true,
            ..Self::new(None, Outcome::Done)
        }
    }

    /// An empty reply.
    pub fn nothing() -> Self {
        Self::new(None, Outcome::Done)
    }

    /// Work that was stopped; `line` says how to continue.
    pub fn stopped(line: String) -> Self {
        Self::new(None, Outcome::Stopped).with_note(line)
    }

    /// The answer of finished work, or the note that it was stopped.
    pub fn of_end(
        end: End<impl Answer + Send + 'static>,
        if_stopped: impl FnOnce() -> String,
    ) -> Self {
        match end {
            End::Finished(answer) => Self::from_answer(answer),
            End::Stopped => Self::stopped(if_stopped()),
        }
    }

    /// The answer of a part of work that many processes share, or the note that the part was stopped.
    pub fn of_end_in_part(end: End<impl Answer + Send + 'static>, shard: Shard) -> Self {
        let Shard { index, of } = shard;
        Self::of_end(end, || {
            format!("stopped; the same command continues part {index} of {of}")
        })
    }

    /// The number of tasks that a part has done; `tasks` names one and several of them.
    pub fn of_part(count: End<usize>, shard: Shard, tasks: [&'static str; 2]) -> Self {
        let Shard { index, of } = shard;
        let part = |count| CompletedPart {
            shard: index,
            of,
            count,
            tasks,
        };
        Self::of_end_in_part(count.map(part), shard)
    }

    /// Replaces the text of the answer by data.
    pub fn showing(self, text: String) -> Self {
        Self {
            text: Some(text),
            is_data: true,
            ..self
        }
    }

    /// Adds a summary.
    pub fn with_summary(mut self, line: String) -> Self {
        self.notes.push(Note::Summary(line));
        self
    }

    /// Adds a note.
    pub fn with_note(mut self, line: String) -> Self {
        self.notes.push(Note::Remark(line));
        self
    }

    /// Adds notes.
    pub fn with_notes(mut self, lines: impl IntoIterator<Item = String>) -> Self {
        self.notes.extend(lines.into_iter().map(Note::Remark));
        self
    }

    /// Adds notes that the answer also contains.
    pub fn with_repeated(mut self, lines: impl IntoIterator<Item = String>) -> Self {
        self.notes.extend(lines.into_iter().map(Note::Repeated));
        self
    }

    /// Adds errors, which the answer also contains.
    pub fn with_errors(mut self, lines: impl IntoIterator<Item = String>) -> Self {
        self.notes.extend(lines.into_iter().map(Note::Error));
        self
    }

    /// Sets the outcome.
    pub fn ending(self, outcome: Outcome) -> Self {
        Self { outcome, ..self }
    }

    /// Sets the outcome to partial if some of the inputs failed.
    pub fn partial_if(self, some_failed: bool) -> Self {
        match some_failed {
            true => self.ending(Outcome::Partial),
            false => self,
        }
    }

    /// Makes the reply fail if there is an error, in spite of an answer.
    pub fn failing(self, failure: Option<Error>) -> Self {
        Self { failure, ..self }
    }

    /// Outcome of the verb.
    pub fn outcome(&self) -> Outcome {
        self.outcome
    }

    /// The answer as a JSON value; `None` if there is none.
    ///
    /// # Errors
    /// If the value cannot be represented in JSON.
    pub fn value(&self) -> Result<Option<Value>> {
        let value = self.answer.as_ref().map(|answer| answer.value());
        Ok(value.transpose()?)
    }

    /// The figure of the answer as a JSON value; `None` if there is nothing to draw.
    ///
    /// # Errors
    /// If the value cannot be represented in JSON.
    pub fn figure(&self) -> Result<Option<Value>> {
        let figure = self.answer.as_ref().and_then(|answer| answer.figure());
        Ok(figure.map(serde_json::to_value).transpose()?)
    }

    /// The lines that warn of something that the answer does not contain, each once.
    pub fn warnings(&self) -> Vec<&str> {
        let mut warnings = Vec::new();
        for note in &self.notes {
            match note {
                Note::Remark(line)
                    // Others are remarks; each warning once,
                    // as Python would show it again and again.
                    if line.starts_with("warning: ") && !warnings.contains(&&**line) =>
                {
                    warnings.push(line.as_str());
                }
                _ => {}
            }
        }
        warnings
    }

    /// The reply, or its error.
    pub(crate) fn unless_failed(mut self) -> Result<Self> {
        match self.failure.take() {
            Some(error) => Err(error),
            None => Ok(self),
        }
    }

    /// Prints the reply and returns the exit code.
    pub(crate) fn print(self, flags: &Global) -> Result<u8> {
        // Data before notes: whoever reads both in one terminal sees the answer first.
        if let Some(text) = self.printed(flags)? {
            let mut stdout = std::io::stdout().lock();
            writeln!(stdout, "{text}")?;
            // Flushed here: an error of writing must become the exit code, not be lost at the end.
            stdout.flush()?;
        }
        for line in &self.notes {
            match line {
                Note::Error(line) => note(line),
                Note::Remark(line) | Note::Repeated(line) if !flags.quiet => note(line),
                Note::Summary(line) if !flags.quiet && !flags.json => note(line),
                Note::Remark(_) | Note::Repeated(_) | Note::Summary(_) => {}
            }
        }
        // After printing: an answer may be good although something failed besides.
        match self.failure {
            Some(error) => Err(error),
            None => Ok(match self.outcome {
                Outcome::Done => 0,
                Outcome::Partial => 1,
                Outcome::Stopped => 3,
            }),
        }
    }

    fn printed(&self, flags: &Global) -> Result<Option<String>> {
        if let (Some(answer), true) = (&self.answer, flags.json) {
            return Ok(Some(answer.json()?));
        }
        // Quiet leaves out summaries, never data.
        if flags.quiet && !self.is_data {
            return Ok(None);
        }
        let own_text = || {
            self.answer
                .as_ref()
                .map(|answer| for_terminal(&answer.text()))
        };
        Ok(self.text.clone().or_else(own_text))
    }
}

/// Whether the reader of our output has closed it, as in `protomer ... | head`.
pub fn is_broken_pipe(error: &Error) -> bool {
    error
        .chain()
        .filter_map(|cause| cause.downcast_ref::<std::io::Error>())
        .any(|cause| cause.kind() == std::io::ErrorKind::BrokenPipe)
}
