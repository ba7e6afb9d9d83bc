//! How work is carried out. Nothing here changes its result.

use crate::Interrupt;
use std::fmt;
use std::sync::Arc;
use std::time::Duration;

/// Is told how far long work has come.
pub trait Progress: Send + Sync {
    /// Work of so many units begins; 0 if their number is not known.
    fn begin(&self, total: u64, unit: &'static str);

    /// So many units more are done.
    fn advance(&self, units: u64);

    /// What is being done now.
    fn describe(&self, _what: &str) {}
}

/// Tells nobody.
impl Progress for () {
    fn begin(&self, _total: u64, _unit: &'static str) {}

    fn advance(&self, _units: u64) {}
}

/// When to stop, how often to save, what to do with earlier results, and whom to tell.
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
    /// Time between two checkpoints: what a killed run loses at most.
    pub checkpoint_interval: Duration,
    /// Remove the results of earlier work in the same directory, once the new work is known to make
    /// sense.
    pub start_anew: bool,
    /// Is told how far the work has come.
    pub progress: Arc<dyn Progress>,
}

impl Execution {
    /// How a part of larger work is carried out: its directory was cleared with the whole, and its
    /// progress is told in units of the whole.
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
