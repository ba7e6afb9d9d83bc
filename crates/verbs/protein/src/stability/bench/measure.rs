//! Moves from a prepared state, measured.

use crate::stability::energy_tables::EnergyTables;
use crate::stability::run::EnergyMode;
use anyhow::Result;
use protomer_common::cpu_time::{ProcessClock, Stopwatch};
use protomer_io::atomic::sha256_hex;
use protomer_kernel::potential::Yukawa;
use protomer_mc::energy::certified::Certified;
use protomer_mc::energy::levels::Levels;
use protomer_mc::energy::{DirectSum, EnergyModel, NoCharges};
use protomer_mc::{Interaction, Settings, Simulation, System};
use protomer_results::Interrupt;

/// Least number of moves over which a rate is measured (what overlap tests remember fills up at
/// first); where moves are not cheap, at most `MOST_TIMES_THE_DIRECT_SUM` times those of the direct
/// sum.
const FEWEST_CHEAP_MOVES: u64 = 320;
/// Largest ratio of this least number of moves to the moves of the direct sum.
const MOST_TIMES_THE_DIRECT_SUM: u64 = 8;

/// A state with what an energy mode needs for it.
#[derive(Debug, Clone)]
pub(super) struct Prepared {
    system: System,
    yukawa: Yukawa,
    energy: EnergyMode,
    tolerance_kt: f64,
    /// Model of energies by levels, for the modes that have tables.
    levels: Option<Levels>,
    /// Model of energies with proven bounds, for the mode with cells, which its copies share.
    certified: Option<Certified>,
    /// Processor time of the tables, all threads together, s.
    pub(super) setup_seconds: f64,
}

/// Measurement of a number of moves.
#[derive(Debug, Clone)]
pub(super) struct Timing {
    pub(super) moves: u64,
    pub(super) accepted: u64,
    pub(super) watch: Stopwatch,
    /// The first decisions of the first run.
    pub(super) decisions: Vec<u8>,
    /// Bytes the energy model holds.
    pub(super) memory_bytes: usize,
    /// Largest bound of a pair energy's error, kT.
    pub(super) error_bound_kt: f64,
}

impl Timing {
    pub(super) fn moves_per_cpu_second(&self) -> f64 {
        self.moves as f64 / self.watch.seconds()
    }

    pub(super) fn acceptance(&self) -> f64 {
        self.accepted as f64 / self.moves as f64
    }

    pub(super) fn decisions_sha256(&self) -> String {
        sha256_hex(&self.decisions)
    }
}

impl Prepared {
    /// Gets the tables, if this mode has any. The tolerance (kT) is that of approximate energies.
    ///
    /// # Errors
    /// If they take more memory than is allowed.
    pub(super) fn new(
        system: &System,
        yukawa: Yukawa,
        energy: EnergyMode,
        tolerance_kt: f64,
        tables: &EnergyTables,
    ) -> Result<Self> {
        let clock = ProcessClock::start();
        let levels = match energy {
            EnergyMode::Calibrated | EnergyMode::Approximate => {
                Some(tables.levels(system, yukawa)?)
            }
            EnergyMode::None | EnergyMode::Direct | EnergyMode::Certified => None,
        };
        let certified = (energy == EnergyMode::Certified).then(|| tables.certified(system, yukawa));
        let setup_seconds = clock.seconds();
        Ok(Self {
            system: system.clone(),
            yukawa,
            energy,
            tolerance_kt,
            levels,
            certified,
            setup_seconds,
        })
    }

    /// A model of energies by levels, with the prepared tables if this mode has them.
    pub(super) fn levels(&self) -> Levels {
        let prepared = self.levels.clone();
        prepared.unwrap_or_else(|| Levels::for_system(self.yukawa, &self.system))
    }

    /// A model of energies with proven bounds, with the prepared cells if this mode has them.
    fn certified(&self) -> Certified {
        let prepared = self.certified.clone();
        prepared.unwrap_or_else(|| Certified::for_system(self.yukawa, &self.system))
    }

    /// The energy model of this mode.
    pub(super) fn model(&self) -> Box<dyn EnergyModel> {
        match self.energy {
            EnergyMode::None => Box::new(NoCharges),
            EnergyMode::Direct => Box::new(DirectSum::new(self.yukawa)),
            EnergyMode::Certified => Box::new(self.certified()),
            EnergyMode::Calibrated => Box::new(self.levels()),
            EnergyMode::Approximate => Box::new(self.levels().with_tolerance(self.tolerance_kt)),
        }
    }

    /// A simulation of this state about to make its first move, with the benchmark's fixed small
    /// steps.
    ///
    /// # Errors
    /// If the box is too small for the interaction or an energy is not finite.
    pub(super) fn simulation(
        &self,
        model: Box<dyn EnergyModel>,
        seed: u64,
        replica: u32,
    ) -> Result<Simulation> {
        let steps = super::BenchSettings::default();
        // The model decides; the settings only travel with it.
        let settings = Settings {
            translation_step_angstrom: steps.translation_step_angstrom,
            rotation_step_rad: steps.rotation_step_rad,
            equilibration_sweeps: 0,
            ..Settings::new(Interaction::HardOnly)
        };
        Ok(Simulation::with_model(
            self.system.clone(),
            settings,
            model,
            seed,
            replica,
        )?)
    }

    /// Makes `moves` moves from the state, again and again with other random numbers, until
    /// `seconds` of processor time are spent: a state close to contact loosens as bodies move, so
    /// one long run would time another state. The first run decides what is hashed; how often it is
    /// repeated changes the rate's precision alone.
    ///
    /// # Errors
    /// As [`Prepared::simulation`].
    pub(super) fn time(
        &self,
        moves: u64,
        seconds: f64,
        seed: u64,
        interrupt: &Interrupt,
    ) -> Result<Timing> {
        self.time_with(&mut || self.model(), moves, seconds, seed, interrupt)
    }

    /// Variant of [`Prepared::time`] with a model of the caller's for each run.
    pub(super) fn time_with(
        &self,
        model: &mut dyn FnMut() -> Box<dyn EnergyModel>,
        moves: u64,
        seconds: f64,
        seed: u64,
        interrupt: &Interrupt,
    ) -> Result<Timing> {
        let fewest = match self.energy {
            EnergyMode::Direct => 0,
            EnergyMode::None => FEWEST_CHEAP_MOVES,
            EnergyMode::Certified | EnergyMode::Calibrated | EnergyMode::Approximate => {
                FEWEST_CHEAP_MOVES.min(MOST_TIMES_THE_DIRECT_SUM.saturating_mul(moves))
            }
        };
        let per_run = moves.max(fewest);
        let watch = Stopwatch::default();
        let mut timing = Timing {
            moves: 0,
            accepted: 0,
            watch,
            decisions: Vec::new(),
            memory_bytes: 0,
            error_bound_kt: 0.0,
        };
        for run in 0.. {
            let mut simulation = self.simulation(model(), seed, run)?;
            let mut decisions = Vec::with_capacity(per_run as usize);
            let mut note = |accepted| decisions.push(u8::from(accepted));
            timing
                .watch
                .time(|| simulation.trial_moves(per_run, &mut note))?;
            timing.moves += per_run;
            timing.error_bound_kt = timing
                .error_bound_kt
                .max(simulation.energy_error_bound_kt());
            timing.accepted += decisions
                .iter()
                .map(|decision| u64::from(*decision))
                .sum::<u64>();
            if run == 0 {
                decisions.truncate(moves as usize);
                timing.decisions = decisions;
                let tables = self.levels.as_ref().map_or(0, EnergyModel::memory_bytes);
                timing.memory_bytes = simulation.energy_memory_bytes().max(tables);
            }
            if timing.watch.seconds() >= seconds || interrupt.is_requested() {
                break;
            }
        }
        Ok(timing)
    }
}
