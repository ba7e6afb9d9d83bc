//! The interface of a verb to its caller: the global flags, messages, progress, and interruption.

use crate::global::Global;
use crate::host::{Bar, Host};
use crate::stderr::note;
use anyhow::{Context, Result, anyhow};
use protomer_results::{Execution, Interrupt, Progress};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Time for which a step that does not ask for signals may go on after one. Then the process ends:
/// results appear only when they are complete, so the same command continues from what was saved.
const DEAF_FOR: Duration = Duration::from_millis(1500);
/// Time for which work that has heard the signal may go on, to finish a structure or write what it
/// has done.
const SILENT_FOR: Duration = Duration::from_secs(6);
/// Interval between checks whether the signal has been heard.
const LOOKS_EVERY: Duration = Duration::from_millis(100);
/// Exit code of work that was stopped early and can be continued.
const STOPPED: i32 = 3;

/// The caller of a verb: a person at a terminal, or a program.
pub struct Front {
    flags: Global,
    host: Host,
    bar: Arc<Bar>,
    /// Warnings for a program, which gets them with the answer.
    warnings: Mutex<Vec<String>>,
}

impl Front {
    /// The front of a person at a terminal.
    pub fn terminal(flags: Global) -> Self {
        let bar = Arc::new(Bar::on_terminal(&flags));
        Self {
            flags,
            host: Host::default(),
            bar,
            warnings: Mutex::default(),
        }
    }

    /// The front of a program, which reads answers but not notes.
    pub fn program(flags: Global, host: Host) -> Self {
        let bar = Arc::new(Bar::for_listener(host.progress.clone()));
        Self {
            flags,
            host,
            bar,
            warnings: Mutex::default(),
        }
    }

    /// The global flags.
    pub fn flags(&self) -> &Global {
        &self.flags
    }

    /// Whether earlier results may be overwritten.
    pub fn force(&self) -> bool {
        self.flags.force
    }

    /// Prints a line immediately, unless quiet.
    pub fn say(&self, line: &str) {
        if !self.flags.quiet {
            note(line);
        }
    }

    /// Warns before the work begins: a person immediately, unless quiet; a program with the answer.
    pub fn warn(&self, lines: impl IntoIterator<Item = String>) {
        for line in lines {
            self.say(&line);
            if let Ok(mut warnings) = self.warnings.lock() {
                warnings.push(line);
            }
        }
    }

    /// The warnings so far.
    pub fn warnings(&self) -> Vec<String> {
        let warnings = self.warnings.lock();
        warnings.map_or_else(|_| Vec::new(), |warnings| warnings.clone())
    }

    /// Prints a line immediately if verbose.
    pub fn explain(&self, line: &str) {
        if self.flags.verbose {
            note(line);
        }
    }

    /// The function that prints urgent warnings.
    pub fn warner(&self) -> fn(&str) {
        if self.flags.quiet { |_| () } else { note }
    }

    /// A progress bar on a terminal, or calls to a listening program.
    pub fn progress(&self) -> Arc<dyn Progress> {
        Arc::clone(&self.bar) as Arc<dyn Progress>
    }

    /// Removes the bar after the work.
    pub fn clear_progress(&self) {
        self.bar.clear();
    }

    /// The execution of resumable work: the first Ctrl-C or SIGTERM, or a time limit, asks it
    /// to stop and prints `notice`. A second signal ends the process immediately.
    pub fn execution(&self, notice: &'static str, limit_minutes: Option<f64>) -> Result<Execution> {
        Ok(Execution {
            interrupt: self.interrupt(notice, limit_minutes)?,
            ..self.execution_without_signals()
        })
    }

    /// The execution of work that a signal ends immediately, because there is nothing to save. A
    /// calling program has its own interrupt.
    pub fn execution_without_signals(&self) -> Execution {
        Execution {
            interrupt: self.host.interrupt.clone().unwrap_or_default(),
            start_anew: self.flags.force,
            progress: self.progress(),
            ..Execution::default()
        }
    }

    fn interrupt(&self, notice: &'static str, limit_minutes: Option<f64>) -> Result<Interrupt> {
        let duration = |minutes: f64| {
            Duration::try_from_secs_f64(minutes * 60.0)
                .map_err(|_| anyhow!("--time-limit is {minutes} minutes; give zero or more"))
        };
        let limit = limit_minutes.map(duration).transpose()?;
        if let Some(interrupt) = &self.host.interrupt {
            return Ok(interrupt.clone().with_limit(limit));
        }
        let interrupt = Interrupt::after(limit);
        listen_for_signals(&interrupt, notice)?;
        Ok(interrupt)
    }
}

fn listen_for_signals(interrupt: &Interrupt, notice: &'static str) -> Result<()> {
    let on_signal = interrupt.clone();
    // Not `is_requested`: an expired time limit must not make the first signal count as the second.
    let signalled = AtomicBool::new(false);
    ctrlc::set_handler(move || {
        if signalled.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        note(&format!("{notice} (repeat to stop immediately)"));
        on_signal.request();
        // The signal handler has its own thread, which must be free for a second signal.
        let watched = on_signal.clone();
        std::thread::spawn(move || {
            let mut silence = Silence::from(Instant::now());
            while !silence.is_too_long(watched.times_heard(), Instant::now()) {
                std::thread::sleep(LOOKS_EVERY);
            }
            watched.record_stop();
            note("stopped in the middle of a step; the same command continues from what was saved");
            std::process::exit(STOPPED);
        });
    })
    .context("cannot listen for Ctrl-C")
}

/// Time for which nobody has asked whether to stop, after a signal.
struct Silence {
    heard: u64,
    since: Instant,
}

impl Silence {
    fn from(signal: Instant) -> Self {
        Self {
            heard: 0,
            since: signal,
        }
    }

    /// Whether it is time to end the process, if the signal has been heard so often by now.
    fn is_too_long(&mut self, heard: u64, now: Instant) -> bool {
        if heard != self.heard {
            (self.heard, self.since) = (heard, now);
        }
        let patience = if heard == 0 { DEAF_FOR } else { SILENT_FOR };
        now.duration_since(self.since) >= patience
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_that_hears_a_signal_is_given_more_time_than_work_that_does_not() {
        let signal = Instant::now();
        let mut silence = Silence::from(signal);
        assert!(!silence.is_too_long(0, signal + DEAF_FOR / 2));
        assert!(silence.is_too_long(0, signal + DEAF_FOR));
        let heard = signal + DEAF_FOR / 2;
        assert!(!silence.is_too_long(1, heard));
        assert!(!silence.is_too_long(1, heard + DEAF_FOR));
        // Whoever goes on asking is at work.
        assert!(!silence.is_too_long(2, heard + SILENT_FOR));
        assert!(!silence.is_too_long(2, heard + SILENT_FOR + DEAF_FOR));
        assert!(silence.is_too_long(2, heard + 2 * SILENT_FOR));
    }
}
