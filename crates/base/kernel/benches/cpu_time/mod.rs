//! Processor time of this thread, which other work on the machine does not change.

use std::sync::OnceLock;
use std::time::Instant;

/// Seconds that this thread has spent on a processor; wall-clock seconds where the system does not
/// tell.
pub fn cpu_seconds() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let first = text.split_whitespace().next().unwrap_or_default();
    match first.parse::<f64>() {
        Ok(nanoseconds) => nanoseconds * 1e-9,
        Err(_) => START.get_or_init(Instant::now).elapsed().as_secs_f64(),
    }
}

/// Seconds that one call takes: the best of three blocks of a quarter of a second.
pub fn seconds_per_call(mut work: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..3 {
        let (begin, mut calls) = (cpu_seconds(), 0);
        while cpu_seconds() - begin < 0.25 {
            work();
            calls += 1;
        }
        best = best.min((cpu_seconds() - begin) / f64::from(calls));
    }
    best
}

/// Whether benchmarks were requested: nothing is timed under `cargo test`.
pub fn are_requested() -> bool {
    std::env::args().any(|argument| argument == "--bench")
}
