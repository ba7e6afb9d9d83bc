//! Stopping long work on request: a signal or a time limit, noticed between steps.

use crate::Exit;
use crate::at_work::AtWork;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// A request to stop, shared by all threads of a piece of work; cheap to check.
///
/// ```
/// use protomer_results::Interrupt;
/// let interrupt = Interrupt::default();
/// let on_another_thread = interrupt.clone();
/// on_another_thread.request();
/// assert!(interrupt.is_requested());
/// assert_eq!(interrupt.reason(), "a signal");
/// ```
#[derive(Debug, Clone, Default)]
pub struct Interrupt {
    requested: Arc<AtomicBool>,
    after_failure: Arc<AtomicBool>,
    /// Number of checks that were answered by yes.
    times_heard: Arc<AtomicU64>,
    at_work: AtWork,
    deadline: Option<Instant>,
}

impl Interrupt {
    /// An interrupt that requests itself after `limit`, if there is one.
    ///
    /// ```
    /// use protomer_results::Interrupt;
    /// use std::time::Duration;
    /// let interrupt = Interrupt::after(Some(Duration::ZERO));
    /// assert!(interrupt.is_requested());
    /// assert_eq!(interrupt.reason(), "the time limit");
    /// assert!(!Interrupt::after(None).is_requested());
    /// ```
    pub fn after(limit: Option<Duration>) -> Self {
        Self {
            deadline: limit.map(|limit| Instant::now() + limit),
            ..Self::default()
        }
    }

    /// The same request, with an additional time limit.
    ///
    /// ```
    /// use protomer_results::Interrupt;
    /// use std::time::Duration;
    /// let whole = Interrupt::default();
    /// let part = whole.clone().with_limit(Some(Duration::ZERO));
    /// assert!(part.is_requested() && !whole.is_requested());
    /// whole.request();
    /// assert_eq!(part.reason(), "a signal", "the request is shared");
    /// ```
    pub fn with_limit(mut self, limit: Option<Duration>) -> Self {
        self.deadline = limit.map(|limit| Instant::now() + limit);
        self
    }

    /// Asks the work to stop at its next step.
    pub fn request(&self) {
        // Relaxed: the flag orders nothing else, and a step later is soon enough.
        self.requested.store(true, Ordering::Relaxed);
    }

    /// Asks the other parts of the work to stop at their next step, because one of them has failed.
    ///
    /// ```
    /// use protomer_results::Interrupt;
    /// let interrupt = Interrupt::default();
    /// interrupt.request_after_failure();
    /// assert_eq!(interrupt.reason(), "the failure of another part");
    /// ```
    pub fn request_after_failure(&self) {
        // Before the request, so that whoever hears it finds the reason.
        self.after_failure.store(true, Ordering::Relaxed);
        self.request();
    }

    /// The reason for the request, as in "stopped by *the time limit*".
    pub fn reason(&self) -> &'static str {
        if self.after_failure.load(Ordering::Relaxed) {
            "the failure of another part"
        } else if self.requested.load(Ordering::Relaxed) {
            "a signal"
        } else {
            "the time limit"
        }
    }

    /// Whether the work should stop now.
    pub fn is_requested(&self) -> bool {
        let is_requested = self.requested.load(Ordering::Relaxed)
            || self
                .deadline
                .is_some_and(|deadline| Instant::now() >= deadline);
        // Counted on `yes` only: this is how the watcher sees that work is still on its way out.
        if is_requested {
            self.times_heard.fetch_add(1, Ordering::Relaxed);
        }
        is_requested
    }

    /// Number of times that the work has heard that it should stop. As long as the number grows,
    /// the work is on its way to its end; if it stays, the work is in the middle of a step that
    /// asks nobody.
    ///
    /// ```
    /// use protomer_results::Interrupt;
    /// let interrupt = Interrupt::default();
    /// assert!(!interrupt.is_requested() && interrupt.times_heard() == 0);
    /// interrupt.request();
    /// assert!(interrupt.is_requested() && interrupt.times_heard() == 1);
    /// ```
    pub fn times_heard(&self) -> u64 {
        self.times_heard.load(Ordering::Relaxed)
    }

    /// Records that the work was stopped, in every directory whose record says that it is running. For a
    /// process that ends in the middle of a step.
    pub fn record_stop(&self) {
        self.at_work.stop(&Exit::stopped_by(self));
    }

    /// The directories in which the work goes on.
    pub(crate) fn at_work(&self) -> &AtWork {
        &self.at_work
    }
}
