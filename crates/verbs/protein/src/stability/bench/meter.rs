//! The parts of a move's cost: a model of energies that watches the one inside it. Only the
//! benchmark uses it, so ordinary runs carry no clocks.

use protomer_mc::Result;
use protomer_mc::energy::levels::Levels;
use protomer_mc::energy::{Effort, EnergyModel, PairEnergy, Pairs};
use protomer_mc::system::{System, Trial};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Readings of a simulation so far.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Readings {
    /// Decisions that the coarse level settled.
    pub(super) settled: Decisions,
    /// Decisions that needed finer levels.
    pub(super) refined: Decisions,
    /// Time to take over or drop the energies of moves.
    pub(super) keeping: Duration,
}

/// Decisions of one sort.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Decisions {
    pub(super) count: u64,
    /// Pair energies at the coarse level.
    pub(super) coarse: u64,
    pub(super) time: Duration,
}

impl Readings {
    /// Time of the refinement alone: what refined decisions took beyond their coarse energies, at
    /// the price that one has in a decision that the coarse level settled.
    pub(super) fn refinement(&self) -> Duration {
        let seconds_each = self.settled.time.as_secs_f64() / self.settled.coarse.max(1) as f64;
        let coarse = Duration::from_secs_f64(seconds_each * self.refined.coarse as f64);
        // Clocks jitter: a price from few decisions may exceed the whole.
        self.refined.time.saturating_sub(coarse)
    }

    /// Time of the coarse energies.
    pub(super) fn coarse(&self) -> Duration {
        self.settled.time + self.refined.time.saturating_sub(self.refinement())
    }
}

/// Energies by levels with a clock.
pub(super) struct Metered {
    inner: Levels,
    readings: Arc<Mutex<Readings>>,
}

impl Metered {
    /// Watches this model and writes down what it sees.
    pub(super) fn new(inner: Levels, readings: Arc<Mutex<Readings>>) -> Self {
        Self { inner, readings }
    }

    fn read(&self, change: impl FnOnce(&mut Readings)) {
        change(&mut self.readings.lock().unwrap_or_else(PoisonError::into_inner));
    }

    fn watched(&mut self, decide: impl FnOnce(&mut Levels) -> Result<bool>) -> Result<bool> {
        let (before, start) = (Counts::from_model(&self.inner), Instant::now());
        let decision = decide(&mut self.inner);
        let (time, after) = (start.elapsed(), Counts::from_model(&self.inner));
        self.read(|readings| {
            // A decision that went past the coarse level changes the count of refined ones.
            let sort = if after.refined == before.refined {
                &mut readings.settled
            } else {
                &mut readings.refined
            };
            sort.count += 1;
            sort.coarse += after.coarse - before.coarse;
            sort.time += time;
        });
        decision
    }

    fn kept(&mut self, keep: impl FnOnce(&mut Levels)) {
        let start = Instant::now();
        keep(&mut self.inner);
        let time = start.elapsed();
        self.read(|readings| readings.keeping += time);
    }
}

/// Counts of a model so far: refined decisions, and energies at the coarse level.
struct Counts {
    refined: u64,
    coarse: u64,
}

impl Counts {
    fn from_model(model: &Levels) -> Self {
        let decided = model.decided();
        Self {
            refined: decided.coarse + decided.fine + decided.direct,
            coarse: model.first_energies(),
        }
    }
}

impl EnergyModel for Metered {
    fn range_angstrom(&self, system: &System) -> f64 {
        self.inner.range_angstrom(system)
    }

    fn reach_angstrom(&self, system: &System) -> f64 {
        self.inner.reach_angstrom(system)
    }

    fn require_room(&self, system: &System) -> Result<()> {
        self.inner.require_room(system)
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

    fn commit(&mut self, bodies: &[usize]) {
        self.kept(|inner| inner.commit(bodies));
    }

    fn reject(&mut self) {
        self.kept(Levels::reject);
    }

    fn energy_elsewhere_kt(
        &self,
        system: &System,
        pairs: Pairs<'_>,
        effort: Effort,
    ) -> Result<f64> {
        self.inner.energy_elsewhere_kt(system, pairs, effort)
    }

    fn pairs(&self, system: &System) -> Vec<PairEnergy> {
        self.inner.pairs(system)
    }

    fn error_bound_kt(&self, system: &System) -> f64 {
        self.inner.error_bound_kt(system)
    }

    fn memory_bytes(&self) -> usize {
        self.inner.memory_bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refinement_is_what_exceeds_the_coarse_energies() {
        let decisions = |count, coarse, milliseconds| Decisions {
            count,
            coarse,
            time: Duration::from_millis(milliseconds),
        };
        let mut readings = Readings {
            settled: decisions(10, 100, 200),
            refined: decisions(2, 20, 90),
            ..Readings::default()
        };
        assert_eq!(readings.refinement(), Duration::from_millis(50));
        assert_eq!(readings.coarse(), Duration::from_millis(240));
        readings.refined.time = Duration::from_millis(10);
        assert_eq!(readings.refinement(), Duration::ZERO);
    }
}
