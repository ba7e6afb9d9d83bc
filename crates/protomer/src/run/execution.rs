//! How a run is carried out. Nothing here changes its result.

use crate::interrupt::Interrupt;
use std::time::Duration;

/// When to stop, how often to save, and what to do with earlier results.
#[derive(Debug, Clone)]
pub struct Execution {
    /// Asks the run to stop; the same run goes on from there later.
    pub interrupt: Interrupt,
    /// Time between two checkpoints: what a killed run loses at most.
    pub checkpoint_interval: Duration,
    /// Remove the results of an earlier run in the same directory, once the new one is known to make sense.
    pub start_anew: bool,
}

impl Default for Execution {
    fn default() -> Self {
        Self { interrupt: Interrupt::default(), checkpoint_interval: Duration::from_secs(20), start_anew: false }
    }
}
