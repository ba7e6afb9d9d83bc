//! Who a verb works for: a person at a terminal, or a program that called it.

use super::{Cli, Outcome, output};
use crate::interrupt::Interrupt;
use anyhow::{Result, anyhow};
use clap::Parser;
use indicatif::ProgressBar;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Hears what a long piece of work has done: units done, units in all (0: unknown), what a unit is.
pub type ProgressListener = Arc<dyn Fn(u64, u64, &str) + Send + Sync>;

/// A program that calls a verb; the default is a terminal.
#[derive(Clone, Default)]
pub struct Host {
    /// Hears of progress instead of a bar.
    pub progress: Option<ProgressListener>,
    /// Asked by long work instead of signals.
    pub interrupt: Option<Interrupt>,
}

impl fmt::Debug for Host {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Host")
            .field("interrupt", &self.interrupt)
            .finish_non_exhaustive()
    }
}

/// What a verb answered.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Answer {
    /// How it ended.
    pub outcome: Outcome,
    /// What it wrote to its standard output: one JSON object, or nothing where it has none.
    pub json: String,
}

/// Words that are no command, as the command line says it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UsageError(pub String);

impl fmt::Display for UsageError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl std::error::Error for UsageError {}

/// Runs a verb for a program, as `protomer WORDS --json` would, on threads of its own.
///
/// ```
/// use protomer::cli::{Host, call};
/// let words = ["framework", "honeycomb", "--theta", "60", "--kh", "50", "--ks", "10000"];
/// let answer = call(&words, Host::default()).unwrap();
/// assert!(answer.json.trim_start().starts_with('{'));
/// ```
///
/// # Errors
/// [`UsageError`] for words that are no command, else what the verb met.
pub fn call<S: AsRef<str>>(words: &[S], host: Host) -> Result<Answer> {
    let words = ["protomer", "--json", "--quiet"]
        .into_iter()
        .chain(words.iter().map(AsRef::as_ref));
    let mut cli = Cli::try_parse_from(words)
        .map_err(|error| UsageError(error.to_string().trim().to_owned()))?;
    cli.global.host = host;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(cli.global.checked_threads()?)
        .build()
        .map_err(|error| anyhow!("cannot start the threads: {error}; try fewer"))?;
    let (outcome, json) = pool.install(|| output::captured(|| cli.verb.run(&cli.global)));
    Ok(Answer {
        outcome: outcome?,
        json,
    })
}

/// How far a piece of work has come: a bar on a terminal, calls to a listener, or nothing.
pub struct Progress {
    bar: ProgressBar,
    listener: Option<ProgressListener>,
    done: AtomicU64,
    length: AtomicU64,
    what: &'static str,
}

impl Progress {
    pub(super) fn new(
        bar: ProgressBar,
        listener: Option<ProgressListener>,
        length: u64,
        what: &'static str,
    ) -> Self {
        Self {
            bar,
            listener,
            done: AtomicU64::new(0),
            length: AtomicU64::new(length),
            what,
        }
    }

    /// So many units more are done.
    pub fn inc(&self, units: u64) {
        self.bar.inc(units);
        let done = self.done.fetch_add(units, Ordering::Relaxed) + units;
        self.tell(done);
    }

    /// So many units are done in all.
    pub fn set_position(&self, done: u64) {
        self.bar.set_position(done);
        self.done.store(done, Ordering::Relaxed);
        self.tell(done);
    }

    /// There are so many units.
    pub fn set_length(&self, length: u64) {
        self.bar.set_length(length);
        self.length.store(length, Ordering::Relaxed);
    }

    /// What is being done now, for the bar.
    pub fn set_message(&self, message: String) {
        self.bar.set_message(message);
    }

    /// The work is over; nothing of the bar is left.
    pub fn finish_and_clear(&self) {
        self.bar.finish_and_clear();
    }

    fn tell(&self, done: u64) {
        if let Some(listener) = &self.listener {
            listener(done, self.length.load(Ordering::Relaxed), self.what);
        }
    }
}
