//! How a run is carried out. Nothing here changes its result, but for the rounding of a device.

use crate::interrupt::Interrupt;
use protomer_learn::Device;
use std::time::Duration;

/// When to stop, how often to save, and what to do with earlier results.
#[derive(Debug, Clone)]
pub struct Execution {
    /// Asks the run to stop; the same run goes on from there later.
    pub interrupt: Interrupt,
    /// Time between two checkpoints: what a killed run loses at most.
    pub checkpoint_interval: Duration,
    /// Remove the results of an earlier run in the same directory, once the new one is known to
    /// make sense.
    pub start_anew: bool,
    /// Where networks are computed; everything else is computed on the processor.
    pub device: Device,
}

impl Default for Execution {
    fn default() -> Self {
        Self {
            interrupt: Interrupt::default(),
            checkpoint_interval: Duration::from_secs(20),
            start_anew: false,
            device: Device::Cpu,
        }
    }
}
