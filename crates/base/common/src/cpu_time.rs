//! Processor time: what work costs, whatever else the machine does.

use cpu_time::{ProcessTime, ThreadTime};
use std::time::{Duration, Instant};

/// Processor time of one thread.
///
/// ```
/// use protomer_common::cpu_time::ThreadClock;
/// let clock = ThreadClock::start();
/// let sum: u64 = (0..100_000).sum();
/// assert!(sum > 0 && clock.seconds() > 0.0);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct ThreadClock(ThreadTime);

impl ThreadClock {
    /// A clock that starts now. It belongs to the thread that starts it.
    pub fn start() -> Self {
        Self(ThreadTime::now())
    }

    /// Seconds that this thread has spent on a processor since the start.
    pub fn seconds(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

/// Processor time of all threads of this process, including those that have ended.
#[derive(Debug, Clone, Copy)]
pub struct ProcessClock(ProcessTime);

impl ProcessClock {
    /// A clock that starts now.
    pub fn start() -> Self {
        Self(ProcessTime::now())
    }

    /// Seconds that the process has spent on processors since the start.
    pub fn seconds(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

/// Adds up the processor time of several pieces of work on one thread.
///
/// ```
/// use protomer_common::cpu_time::Stopwatch;
/// let mut stopwatch = Stopwatch::default();
/// let sum: u64 = stopwatch.time(|| (0..1_000_000_u64).map(std::hint::black_box).sum());
/// assert_eq!(sum, 499_999_500_000);
/// assert!(stopwatch.seconds() > 0.0 && stopwatch.wall_seconds() > 0.0);
/// ```
#[derive(Debug, Clone, Copy, Default)]
pub struct Stopwatch {
    processor: Duration,
    wall: Duration,
}

impl Stopwatch {
    /// Does the work and adds its time.
    ///
    /// ```
    /// use protomer_common::cpu_time::Stopwatch;
    /// let mut stopwatch = Stopwatch::default();
    /// assert_eq!(stopwatch.time(|| 6 * 7), 42, "the result of the work passes through");
    /// ```
    pub fn time<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let (processor, wall) = (ThreadTime::now(), Instant::now());
        let done = work();
        self.processor += processor.elapsed();
        self.wall += wall.elapsed();
        done
    }

    /// Processor time so far, s.
    pub fn seconds(&self) -> f64 {
        self.processor.as_secs_f64()
    }

    /// Wall-clock time so far, s.
    pub fn wall_seconds(&self) -> f64 {
        self.wall.as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn work_for(seconds: f64) {
        let clock = ThreadClock::start();
        while clock.seconds() < seconds {}
    }

    #[test]
    fn the_process_counts_the_time_of_threads_that_have_ended() {
        let clock = ProcessClock::start();
        std::thread::spawn(|| work_for(0.2))
            .join()
            .unwrap_or_default();
        assert!(clock.seconds() > 0.15);
    }

    #[test]
    fn short_work_is_timed_by_the_processor_and_not_by_the_wall_clock() {
        let mut watch = Stopwatch::default();
        watch.time(|| {
            work_for(0.002);
            std::thread::sleep(Duration::from_millis(20));
        });
        assert!((0.002..0.015).contains(&watch.seconds()), "{watch:?}");
        assert!(watch.wall_seconds() > 0.02);
    }
}
