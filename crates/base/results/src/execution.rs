//! How work is carried out. Nothing here changes its result.

use crate::Interrupt;
use std::fmt;
use std::sync::Arc;
use std::time::Duration;

/// Receives the progress of long work.
pub trait Progress: Send + Sync {
    /// Work of `units` units begins; 0 if their number is not known.
    fn begin(&self, total: u64, unit: &'static str);

    /// Further units are done.
    fn advance(&self, units: u64);

    /// The current activity.
    fn describe(&self, _what: &str) {}
}

/// Ignores all progress.
impl Progress for () {
    fn begin(&self, _total: u64, _unit: &'static str) {}

    fn advance(&self, _units: u64) {}
}

/// Control of an execution: when to stop, how often to save, what to do with earlier results, and
/// where to report progress.
///
/// ```
/// use protomer_results::Execution;
/// use std::time::Duration;
/// let often = Execution { checkpoint_interval: Duration::from_secs(5), ..Execution::default() };
/// assert!(!often.start_anew && !often.interrupt.is_requested());
/// ```
#[derive(Clone)]
pub struct Execution {
    /// Asks the work to stop; the same work continues from there later.
    pub interrupt: Interrupt,
    /// Time between two checkpoints: the most that a killed run loses.
    pub checkpoint_interval: Duration,
    /// Remove the results of earlier work in the same directory, once the new settings have been
    /// checked.
    pub start_anew: bool,
    /// Receives the progress of the work.
    pub progress: Arc<dyn Progress>,
}

impl Execution {
    /// The execution of a part of larger work: its directory was cleared with the whole, and its
    /// progress is reported in units of the whole.
    ///
    /// ```
    /// use protomer_results::Execution;
    /// let whole = Execution { start_anew: true, ..Execution::default() };
    /// let part = whole.of_part();
    /// whole.interrupt.request();
    /// assert!(part.interrupt.is_requested() && !part.start_anew);
    /// ```
    #[must_use]
    pub fn of_part(&self) -> Self {
        Self {
            start_anew: false,
            progress: Arc::new(()),
            ..self.clone()
        }
    }
}

impl Default for Execution {
    fn default() -> Self {
        Self {
            interrupt: Interrupt::default(),
            checkpoint_interval: Duration::from_secs(20),
            start_anew: false,
            progress: Arc::new(()),
        }
    }
}

impl fmt::Debug for Execution {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Execution")
            .field("interrupt", &self.interrupt)
            .field("checkpoint_interval", &self.checkpoint_interval)
            .field("start_anew", &self.start_anew)
            .finish_non_exhaustive()
    }
}
