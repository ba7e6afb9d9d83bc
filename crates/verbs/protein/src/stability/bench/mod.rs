//! How many trial moves per CPU-second an assembly allows, and what they decide; and the same on
//! states made here.
//!
//! Trial moves only: half translations, half rotations, of fixed small steps, from the assembly as
//! it stands. Two energy modes that make the same decisions print the same hash.
//!
//! | module | one idea |
//! |---|---|
//! | `bodies` | barrels with bumps, and charges inside them |
//! | `states` | sixteen bodies close to contact; many bodies spread through a box |
//! | `measure` | moves from a state, timed, again and again |
//! | `meter` | an energy model that watches another one: the parts of a move |
//! | [`suite`] | what is measured for the tables |
//! | [`tables`] | the tables |

pub(crate) mod bodies;
mod measure;
mod meter;
mod states;
pub mod suite;
pub mod tables;

use crate::assemblies::assembly_file::Assembly;
use crate::stability::effective::{EffectiveBody, EffectiveStore};
use crate::stability::energy_tables::EnergyTables;
use crate::stability::interaction::ScreenedCoulomb;
use crate::stability::run::{EnergyMode, Engine, Promise, RunSettings};
use anyhow::Result;
use protomer_common::answer::Answer;
use protomer_common::cpu_time::{ProcessClock, Stopwatch};
use protomer_io::atomic::sha256_hex;
use protomer_mc::energy::LevelReport;
use protomer_mc::{Settings, Simulation};
use serde::Serialize;
use std::sync::Arc;

/// Settings of [`bench()`].
#[derive(Debug, Clone, PartialEq)]
pub struct BenchSettings {
    /// Number of trial moves.
    pub moves: u64,
    /// Energies; without a mode, the fastest one with the decisions of the direct sum.
    pub run: RunSettings,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Largest displacement of a trial move, Å.
    pub translation_step_angstrom: f64,
    /// Largest angle of a trial move, rad.
    pub rotation_step_rad: f64,
}

impl Default for BenchSettings {
    fn default() -> Self {
        Self {
            moves: 10_000,
            run: RunSettings::default(),
            seed: 1,
            translation_step_angstrom: 0.3,
            rotation_step_rad: 0.04,
        }
    }
}

/// Result of [`bench()`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BenchResult {
    /// Mode of the energies.
    pub energy: EnergyMode,
    /// Cut-off of the interaction, in words.
    pub definition: String,
    /// Basis of the claim that the decisions are those of the direct sum.
    pub promise: Promise,
    /// Number of decisions that each level made, and the calibration of the levels if they have
    /// one.
    #[serde(flatten)]
    pub levels: Option<LevelReport>,
    /// Trial moves made.
    pub moves: u64,
    /// Trial moves per second of processor time, start-up not counted.
    pub moves_per_cpu_second: f64,
    /// Accepted fraction.
    pub acceptance: f64,
    /// Processor time before the first move, all threads together, s.
    pub setup_seconds: f64,
    /// Whether there are energy tables and all came from the cache folder.
    pub tables_from_cache: bool,
    /// Memory of the prepared bodies and of the energy model, bytes.
    pub memory_bytes: usize,
    /// The largest bound of a pair energy's error that was used, kT; zero for sums.
    pub error_bound_kt_per_pair: f64,
    /// SHA-256 of the decisions, a byte 1 or 0 each.
    pub decisions_sha256: String,
    /// Number of bodies.
    pub bodies: usize,
    /// The medium.
    #[serde(flatten)]
    pub interaction: ScreenedCoulomb,
    /// Effective charges of each kind of body, where they interact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effective_bodies: Option<Vec<EffectiveBody>>,
}

impl Answer for BenchResult {
    fn text(&self) -> String {
        let bound = match self.error_bound_kt_per_pair {
            0.0 => String::new(),
            bound => format!(", pair energies to within {bound:.2e} kT"),
        };
        format!(
            "{:.0} trial moves per CPU-second, acceptance {:.3}, set-up {:.2} s, memory {:.1} MB{bound}\n\
             decisions {}",
            self.moves_per_cpu_second,
            self.acceptance,
            self.setup_seconds,
            self.memory_bytes as f64 / 1e6,
            self.decisions_sha256
        )
    }
}

/// Number of moves so large that the set-up of energies does not count.
const MANY_MOVES: f64 = 1e12;

/// Makes the moves and measures them.
///
/// # Errors
/// For a mesh that bounds no solid, an overlapping start, a box too small for the interaction, an
/// energy that is not finite, or effective charges that cannot be fitted.
pub fn bench(
    assembly: Assembly,
    settings: &BenchSettings,
    interaction: ScreenedCoulomb,
    tables: Arc<EnergyTables>,
    effective_store: Arc<EffectiveStore>,
) -> Result<BenchResult> {
    let clock = ProcessClock::start();
    let mut engine = Engine::new(assembly)?
        .with_tables(Arc::clone(&tables))
        .with_effective_store(effective_store);
    if let Some(solute) = &settings.run.effective_charges
        && settings.run.energy != Some(EnergyMode::None)
    {
        engine = engine.with_effective_charges(&interaction, solute)?;
    }
    engine = engine.with_terms(&settings.run.further_terms(), &interaction)?;
    let energy = match interaction.cutoff_angstrom.is_finite() {
        true => EnergyMode::Direct,
        false => engine.costs(&interaction, MANY_MOVES)?.fastest(),
    };
    let energy = settings.run.energy.unwrap_or(energy);
    let run = RunSettings {
        energy: Some(energy),
        ..settings.run.clone()
    };
    run.check()?;
    let system = engine.system()?;
    let bodies = system.len();
    let shapes: usize = system
        .types()
        .iter()
        .map(|kind| kind.shape.memory_bytes())
        .sum();
    let model = engine.energy_model(&run, &interaction)?;
    let mc = Settings {
        translation_step_angstrom: settings.translation_step_angstrom,
        rotation_step_rad: settings.rotation_step_rad,
        equilibration_sweeps: 0,
        ..engine.settings(&run, &interaction)?
    };
    let mut simulation = Simulation::with_model(system, mc, model, settings.seed, 0)?;
    let memory_bytes = shapes + simulation.energy_memory_bytes().max(tables.memory_bytes());
    let setup_seconds = clock.seconds();
    let mut watch = Stopwatch::default();
    let mut decisions = Vec::new();
    watch.time(|| {
        simulation.trial_moves(settings.moves, &mut |accepted| {
            decisions.push(u8::from(accepted))
        })
    })?;
    let accepted = decisions.iter().filter(|decision| **decision == 1).count();
    Ok(BenchResult {
        energy,
        definition: interaction.definition(),
        promise: energy.promise(),
        levels: simulation.energy_levels(),
        moves: settings.moves,
        moves_per_cpu_second: settings.moves as f64 / watch.seconds(),
        acceptance: accepted as f64 / settings.moves as f64,
        setup_seconds,
        tables_from_cache: tables.all_from_cache(),
        memory_bytes,
        error_bound_kt_per_pair: simulation.energy_error_bound_kt(),
        decisions_sha256: sha256_hex(&decisions),
        bodies,
        interaction,
        effective_bodies: engine.effective_bodies().map(<[_]>::to_vec),
    })
}
