//! A program that calls a verb, and the progress of the verb.

use crate::global::Global;
use crate::stderr::note;
use indicatif::style::TemplateError;
use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};
use protomer_results::{Interrupt, Progress};
use std::fmt;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// Interval between updates of the bar, which shows the time that has passed even while nothing is
/// done.
const TICK: Duration = Duration::from_millis(500);

/// Receives the progress of long work: units done, total units (0: unknown), and the name of a
/// unit.
pub type ProgressListener = Arc<dyn Fn(u64, u64, &str) + Send + Sync>;

/// A program that calls a verb.
#[derive(Clone, Default)]
pub struct Host {
    /// Listener that receives progress.
    pub progress: Option<ProgressListener>,
    /// Interrupt that long work checks instead of signals.
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

/// The progress of a piece of work: a bar on a terminal, calls to a listener, or nothing.
pub struct Bar {
    bar: ProgressBar,
    listener: Option<ProgressListener>,
    explains: bool,
    done: AtomicU64,
    total: AtomicU64,
    unit: OnceLock<&'static str>,
}

impl Bar {
    /// A progress bar.
    pub fn on_terminal(flags: &Global) -> Self {
        Self {
            explains: flags.verbose,
            ..Self::new(terminal_bar(flags), None)
        }
    }

    /// A bar that calls a listening program.
    pub fn for_listener(listener: Option<ProgressListener>) -> Self {
        Self::new(ProgressBar::hidden(), listener)
    }

    fn new(bar: ProgressBar, listener: Option<ProgressListener>) -> Self {
        Self {
            bar,
            listener,
            explains: false,
            done: AtomicU64::new(0),
            total: AtomicU64::new(0),
            unit: OnceLock::new(),
        }
    }

    /// Removes the bar.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Bar {
    fn begin(&self, total: u64, unit: &'static str) {
        self.bar.set_length(total);
        self.bar.set_message(unit);
        self.bar.enable_steady_tick(TICK);
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

    fn describe(&self, activity: &str) {
        self.bar.set_message(activity.to_owned());
        self.bar.enable_steady_tick(TICK);
        if self.explains {
            note(activity);
        }
    }
}

fn terminal_bar(flags: &Global) -> ProgressBar {
    if flags.quiet || flags.no_progress || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(0);
    match style() {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

fn style() -> Result<ProgressStyle, TemplateError> {
    let style =
        ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {rate}{elapsed}, {left} left")?;
    Ok(style.with_key("left", left).with_key("rate", rate))
}

/// Writes the units per second, where they are so fast that the number says something.
fn rate(state: &ProgressState, out: &mut dyn fmt::Write) {
    let rate = state.per_sec();
    if rate >= 0.05 && state.pos() > 0 {
        let _ = write!(out, "{rate:.1}/s ");
    }
}

/// Writes the time that is left; unknown before the first unit is done.
fn left(state: &ProgressState, out: &mut dyn fmt::Write) {
    let _ = match state.pos() {
        0 => out.write_str("?"),
        _ => write!(out, "{:#}", HumanDuration(state.eta())),
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With a template that cannot be read the bar would fall back to one without times.
    #[test]
    fn the_bar_shows_times() {
        assert!(style().is_ok());
    }
}
