//! CPU time, which measures the cost of work regardless of what else the machine is doing.

use std::sync::OnceLock;
use std::time::Instant;

/// CPU time of the calling thread, s; wall-clock time where the system does not report
/// it.
pub fn thread_seconds() -> f64 {
    const NANOSECONDS: f64 = 1e-9;
    let from_system = std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
    match from_system {
        Some(nanoseconds) => nanoseconds * NANOSECONDS,
        None => wall_seconds(),
    }
}

/// CPU time of all threads of this process, finished ones included, s, with a resolution
/// of 0.01 s; wall-clock time where the system does not report it.
pub fn process_seconds() -> f64 {
    // Linux counts in hundredths of a second here (USER_HZ); fields 14 and 15 of proc_pid_stat(5).
    // The second field, a name in parentheses, may hold spaces.
    const TICKS_PER_SECOND: f64 = 100.0;
    const USER_TIME_AFTER_NAME: usize = 11;
    let ticks = std::fs::read_to_string("/proc/self/stat")
        .ok()
        .and_then(|text| {
            let (_, fields) = text.rsplit_once(')')?;
            let mut times = fields
                .split_whitespace()
                .skip(USER_TIME_AFTER_NAME)
                .map(str::parse::<f64>);
            Some(times.next()?.ok()? + times.next()?.ok()?)
        });
    ticks.map_or_else(wall_seconds, |ticks| ticks / TICKS_PER_SECOND)
}

/// Adds up the CPU time of pieces of work on one thread.
#[derive(Debug, Clone, Copy, Default)]
pub struct Stopwatch {
    processor_seconds: f64,
    wall_seconds: f64,
}

impl Stopwatch {
    /// The system brings a running thread's time up to date every few milliseconds; sums below
    /// this, s, are too coarse.
    const COARSE_SECONDS: f64 = 0.05;

    /// Runs the work and adds its time.
    pub fn time<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let (processor, wall) = (thread_seconds(), Instant::now());
        let done = work();
        self.processor_seconds += thread_seconds() - processor;
        self.wall_seconds += wall.elapsed().as_secs_f64();
        done
    }

    /// Wall-clock time so far, s.
    pub fn wall_seconds(&self) -> f64 {
        self.wall_seconds
    }

    /// CPU time so far, s; wall-clock time while the CPU time is too short to be resolved.
    pub fn seconds(&self) -> f64 {
        if self.processor_seconds < Self::COARSE_SECONDS {
            self.wall_seconds
        } else {
            self.processor_seconds
        }
    }
}

fn wall_seconds() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_secs_f64()
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn the_process_counts_the_time_of_threads_that_have_ended() {
        let start = process_seconds();
        let busy = || {
            let start = thread_seconds();
            while thread_seconds() - start < 0.2 {}
        };
        std::thread::spawn(busy).join().unwrap_or_default();
        assert!(process_seconds() - start > 0.15);
    }
}
