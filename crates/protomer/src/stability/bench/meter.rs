//! The parts of a move's cost: a model of energies that watches the one inside it. Only the
//! benchmark uses it, so ordinary runs carry no clocks.

use protomer_mc::Result;
use protomer_mc::energy::certified::CertifiedSum;
use protomer_mc::energy::{EnergyModel, PairEnergy};
use protomer_mc::system::{System, Trial};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// What was read in a simulation so far.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Readings {
    /// Decisions that bounds alone settled.
    pub(super) settled: Decisions,
    /// Decisions that asked for direct sums.
    pub(super) refined: Decisions,
    /// Direct sums made.
    pub(super) direct_sums: u64,
    /// Taking over or dropping the energies of a move.
    pub(super) keeping: Duration,
}

/// Decisions of one sort.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Decisions {
    pub(super) count: u64,
    /// Energies of pairs found as intervals.
    pub(super) intervals: u64,
    pub(super) time: Duration,
}

impl Readings {
    /// Time of the refinement alone: what refined decisions took beyond their intervals, at the
    /// price an interval has in a decision that bounds settled.
    pub(super) fn refinement(&self) -> Duration {
        let interval_seconds =
            self.settled.time.as_secs_f64() / self.settled.intervals.max(1) as f64;
        let bounds = Duration::from_secs_f64(interval_seconds * self.refined.intervals as f64);
        self.refined.time.saturating_sub(bounds)
    }

    /// Time of the intervals.
    pub(super) fn bounds(&self) -> Duration {
        self.settled.time + self.refined.time.saturating_sub(self.refinement())
    }
}

/// Certified energies with a clock.
pub(super) struct Metered {
    inner: CertifiedSum,
    readings: Arc<Mutex<Readings>>,
}

impl Metered {
    /// Watches this model and writes down what it sees.
    pub(super) fn new(inner: CertifiedSum, readings: Arc<Mutex<Readings>>) -> Self {
        Self { inner, readings }
    }

    fn read(&self, change: impl FnOnce(&mut Readings)) {
        change(&mut self.readings.lock().unwrap_or_else(PoisonError::into_inner));
    }

    fn watched(&mut self, decide: impl FnOnce(&mut CertifiedSum) -> Result<bool>) -> Result<bool> {
        let (before, start) = (self.inner.counts(), Instant::now());
        let decision = decide(&mut self.inner);
        let (time, after) = (start.elapsed(), self.inner.counts());
        let (intervals, direct_sums) = (
            after.intervals - before.intervals,
            after.direct_sums - before.direct_sums,
        );
        self.read(|readings| {
            readings.direct_sums += direct_sums;
            let sort = if direct_sums == 0 {
                &mut readings.settled
            } else {
                &mut readings.refined
            };
            sort.count += 1;
            sort.intervals += intervals;
            sort.time += time;
        });
        decision
    }

    fn kept(&mut self, keep: impl FnOnce(&mut CertifiedSum)) {
        let start = Instant::now();
        keep(&mut self.inner);
        let time = start.elapsed();
        self.read(|readings| readings.keeping += time);
    }
}

impl EnergyModel for Metered {
    fn range_angstrom(&self, system: &System) -> f64 {
        self.inner.range_angstrom(system)
    }

    fn reset(&mut self, system: &System) -> Result<()> {
        self.inner.reset(system)
    }

    fn restore(&mut self, system: &System, pairs: &[PairEnergy]) -> Result<()> {
        self.inner.restore(system, pairs)
    }

    fn accept(&mut self, trial: &Trial<'_>, partners: &[usize], budget_kt: f64) -> Result<bool> {
        self.watched(|inner| inner.accept(trial, partners, budget_kt))
    }

    fn exceeds(&mut self, trial: &Trial<'_>, partner: usize, threshold_kt: f64) -> Result<bool> {
        self.watched(|inner| inner.exceeds(trial, partner, threshold_kt))
    }

    fn commit(&mut self, moved: &[usize]) {
        self.kept(|inner| inner.commit(moved));
    }

    fn reject(&mut self) {
        self.kept(CertifiedSum::reject);
    }

    fn pairs(&self) -> Vec<PairEnergy> {
        self.inner.pairs()
    }

    fn error_bound_kt(&self) -> f64 {
        self.inner.error_bound_kt()
    }

    fn memory_bytes(&self) -> usize {
        self.inner.memory_bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refinement_is_what_exceeds_the_intervals() {
        let decisions = |count, intervals, milliseconds| Decisions {
            count,
            intervals,
            time: Duration::from_millis(milliseconds),
        };
        let mut readings = Readings {
            settled: decisions(10, 100, 200),
            refined: decisions(2, 20, 90),
            ..Readings::default()
        };
        assert_eq!(readings.refinement(), Duration::from_millis(50));
        assert_eq!(readings.bounds(), Duration::from_millis(240));
        readings.refined.time = Duration::from_millis(10);
        assert_eq!(readings.refinement(), Duration::ZERO);
    }
}
