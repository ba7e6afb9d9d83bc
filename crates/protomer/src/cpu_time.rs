//! Processor time of the calling thread, which says what work costs whatever else the machine is doing.

use std::sync::OnceLock;
use std::time::Instant;

/// Seconds the calling thread has spent on a processor; wall-clock seconds where the system does not tell.
pub fn thread_seconds() -> f64 {
    const NANOSECONDS: f64 = 1e-9;
    static START: OnceLock<Instant> = OnceLock::new();
    let from_system = std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
    match from_system {
        Some(nanoseconds) => nanoseconds * NANOSECONDS,
        None => START.get_or_init(Instant::now).elapsed().as_secs_f64(),
    }
}
