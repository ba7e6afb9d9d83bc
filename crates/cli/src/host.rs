//! Who a verb works for: a person at a terminal, or a program that called it.

use super::{Cli, Outcome, output};
use anyhow::{Result, anyhow};
use clap::Parser;
use indicatif::ProgressBar;
use protomer_results::{Interrupt, Progress};
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

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
/// use protomer_cli::{Host, call};
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
pub struct Bar {
    bar: ProgressBar,
    listener: Option<ProgressListener>,
    done: AtomicU64,
    total: AtomicU64,
    unit: OnceLock<&'static str>,
}

impl Bar {
    pub(super) fn new(bar: ProgressBar, listener: Option<ProgressListener>) -> Self {
        Self {
            bar,
            listener,
            done: AtomicU64::new(0),
            total: AtomicU64::new(0),
            unit: OnceLock::new(),
        }
    }
}

impl Progress for Bar {
    fn begin(&self, total: u64, unit: &'static str) {
        self.bar.set_length(total);
        self.bar.set_message(unit);
        self.total.store(total, Ordering::Relaxed);
        self.unit.get_or_init(|| unit);
    }

    fn advance(&self, units: u64) {
        self.bar.inc(units);
        let done = self.done.fetch_add(units, Ordering::Relaxed) + units;
        if let Some(listener) = &self.listener {
            let unit = self.unit.get().copied().unwrap_or_default();
            listener(done, self.total.load(Ordering::Relaxed), unit);
        }
    }

    fn describe(&self, what: &str) {
        self.bar.set_message(what.to_owned());
    }
}

/// The work is over; nothing of the bar is left.
impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
