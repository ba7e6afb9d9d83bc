//! The benchmark without an assembly: how the cost of a trial move grows with charges and with
//! bodies, what it is made of, and what threads bring, on states made here.

use super::bodies::two_kinds;
use super::measure::{Prepared, Timing};
use super::meter::{Metered, Readings};
use super::states::{cluster, spread};
use super::tables::{BodiesRow, PartsRow, RateRow, SuiteResult, ThreadsRow};
use crate::stability::energy_tables::EnergyTables;
use crate::stability::interaction::ScreenedCoulomb;
use crate::stability::run::{DEFAULT_TOLERANCE_KT, EnergyMode};
use anyhow::{Context, Result};
use protomer_common::cpu_time::Stopwatch;
use protomer_io::atomic::sha256_hex;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::setting::Choices;
use protomer_mc::energy::{DirectSum, EnergyModel};
use protomer_mc::simulation::require_room;
use protomer_mc::{BodyType, Simulation, System};
use protomer_results::Execution;
use rayon::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

protomer_kernel::choices! {
    /// One table of the benchmark.
    pub enum Part {
        /// Moves per CPU-second of each energy mode against the number of charges.
        Charges = "charges",
        /// The parts that make up a move with energies by levels.
        Parts = "parts",
        /// Cost of a move against the number of bodies, at the same density.
        Bodies = "bodies",
        /// Wall-clock time of independent replicas against the number of threads.
        Threads = "threads",
    }
}

/// Settings of the benchmark without an assembly.
#[derive(Debug, Clone, PartialEq)]
pub struct SuiteSettings {
    /// The parts to run.
    pub parts: Vec<Part>,
    /// Charges per body.
    pub charges: Vec<usize>,
    /// Numbers of bodies of the part on bodies; the first one sets the density.
    pub bodies: Vec<usize>,
    /// Charges per body in the parts on bodies and on threads.
    pub few_charges: usize,
    /// Numbers of threads.
    pub threads: Vec<usize>,
    /// Trial moves that the direct sum makes and that are hashed; if `None`, chosen by the number
    /// of charges.
    pub moves: Option<u64>,
    /// Moves of a replica in the part on threads: hard bodies, calibrated energies, approximate
    /// energies.
    pub replica_moves: [u64; 3],
    /// Largest error of the energy of two bodies in the rows of approximate energies, kT.
    pub tolerance_kt: f64,
    /// Processor time to spend on each rate at least, s.
    pub seconds_per_rate: f64,
    /// Divisions of the edges of the octahedron that the bodies' meshes are made of.
    pub edge_divisions: i32,
    /// Seed of bodies, states and moves.
    pub seed: u64,
}

impl Default for SuiteSettings {
    fn default() -> Self {
        Self {
            parts: Part::ALL.to_vec(),
            charges: vec![500, 3000],
            bodies: vec![16, 128, 1000],
            few_charges: 500,
            threads: vec![1, 2],
            moves: None,
            replica_moves: [40_000, 10_000, 2_000],
            tolerance_kt: DEFAULT_TOLERANCE_KT,
            seconds_per_rate: 1.0,
            edge_divisions: 14,
            seed: 1,
        }
    }
}

/// Moves of the direct sum with this many charges: a few seconds' worth.
fn affordable_moves(charges: usize) -> u64 {
    const FEWEST: f64 = 10.0;
    const MOST: f64 = 200.0;
    let per_pair = charges.max(1) as f64 / 3000.0;
    (50.0 / (per_pair * per_pair)).clamp(FEWEST, MOST) as u64
}

/// Energy modes of the part on charges: the direct sum before those that are compared with it.
const MODES: [EnergyMode; 5] = [
    EnergyMode::None,
    EnergyMode::Direct,
    EnergyMode::Certified,
    EnergyMode::Calibrated,
    EnergyMode::Approximate,
];

/// Energy modes where moves must be cheap.
const CHEAP_MODES: [EnergyMode; 3] = [
    EnergyMode::None,
    EnergyMode::Calibrated,
    EnergyMode::Approximate,
];

/// Volume of the bodies in that of the cube at most, in the part on bodies.
const VOLUME_FRACTION: f64 = 0.15;

/// Rows of all tables together.
fn rows(settings: &SuiteSettings) -> usize {
    let row_count = |part: &Part| match part {
        Part::Charges => settings.charges.len() * MODES.len(),
        Part::Parts => settings.charges.len(),
        Part::Bodies => settings.bodies.len() * CHEAP_MODES.len(),
        Part::Threads => settings.threads.len() * CHEAP_MODES.len(),
    };
    settings.parts.iter().map(row_count).sum()
}

/// Runs the parts. An interrupt ends the work within about a run of moves; the result then holds
/// what was measured until then.
///
/// # Errors
/// For an interaction that makes no sense or reaches too far for the states, tables over their
/// limit, and an energy that is not finite.
pub fn run_suite(
    settings: &SuiteSettings,
    interaction: ScreenedCoulomb,
    tables: &EnergyTables,
    execution: &Execution,
) -> Result<SuiteResult> {
    let yukawa = interaction.yukawa()?;
    let suite = Suite {
        settings,
        yukawa,
        execution,
        tables,
    };
    suite.check_room()?;
    execution.progress.begin(rows(settings) as u64, "bench");
    let mut result = SuiteResult {
        version: env!("CARGO_PKG_VERSION").into(),
        processor: processor(),
        machine_threads: std::thread::available_parallelism().map_or(1, usize::from),
        seed: settings.seed,
        complete: false,
        interaction,
        charges: Vec::new(),
        parts: Vec::new(),
        bodies: Vec::new(),
        threads: Vec::new(),
    };
    for part in Part::ALL
        .iter()
        .filter(|part| settings.parts.contains(part))
    {
        match part {
            Part::Charges => result.charges = suite.rates()?,
            Part::Parts => result.parts = suite.parts()?,
            Part::Bodies => result.bodies = suite.bodies()?,
            Part::Threads => result.threads = suite.threads()?,
        }
    }
    result.complete = !execution.interrupt.is_requested();
    Ok(result)
}

/// Data that the parts share.
struct Suite<'a> {
    settings: &'a SuiteSettings,
    yukawa: Yukawa,
    execution: &'a Execution,
    tables: &'a EnergyTables,
}

impl Suite<'_> {
    /// Says what is measured next, unless it is time to stop.
    fn goes_on(&self, measurement: &str) -> bool {
        let goes_on = !self.execution.interrupt.is_requested();
        if goes_on {
            self.execution.progress.describe(measurement);
        }
        goes_on
    }

    fn kinds(&self, charges: usize) -> Result<Vec<Arc<BodyType>>> {
        two_kinds(charges, self.settings.edge_divisions, self.settings.seed)
    }

    fn cluster(&self, charges: usize) -> Result<System> {
        cluster(&self.kinds(charges)?, self.settings.seed)
    }

    /// Prepares the cluster for an energy mode.
    fn prepared(&self, charges: usize, energy: EnergyMode) -> Result<Prepared> {
        self.prepared_from(&self.cluster(charges)?, energy)
    }

    fn prepared_from(&self, system: &System, energy: EnergyMode) -> Result<Prepared> {
        Prepared::new(
            system,
            self.yukawa,
            energy,
            self.settings.tolerance_kt,
            self.tables,
        )
    }

    /// Checks, before anything is measured, that the cluster has room for the interaction.
    fn check_room(&self) -> Result<()> {
        let system = self.cluster(self.settings.few_charges)?;
        require_room(&system, &DirectSum::new(self.yukawa))
            .context("the interaction reaches too far for the benchmark's states")
    }

    fn rates(&self) -> Result<Vec<RateRow>> {
        let mut rows = Vec::new();
        for &charges in &self.settings.charges {
            let moves = self.settings.moves.unwrap_or(affordable_moves(charges));
            let mut direct: Option<Timing> = None;
            for energy in MODES {
                if !self.goes_on(&format!("{charges} charges, energy {}", energy.name())) {
                    return Ok(rows);
                }
                let prepared = self.prepared(charges, energy)?;
                // The direct sum makes its moves once.
                let seconds = if energy == EnergyMode::Direct {
                    0.0
                } else {
                    self.settings.seconds_per_rate
                };
                let timing = prepared.time(
                    moves,
                    seconds,
                    self.settings.seed,
                    &self.execution.interrupt,
                )?;
                if energy == EnergyMode::Direct {
                    direct = Some(timing.clone());
                }
                let charged = direct.as_ref().filter(|_| energy != EnergyMode::None);
                rows.push(RateRow {
                    charges,
                    energy,
                    moves: timing.moves,
                    moves_per_cpu_second: timing.moves_per_cpu_second(),
                    speed_up: charged.map(|direct| {
                        timing.moves_per_cpu_second() / direct.moves_per_cpu_second()
                    }),
                    acceptance: timing.acceptance(),
                    setup_seconds: prepared.setup_seconds,
                    memory_bytes: timing.memory_bytes,
                    error_bound_kt_per_pair: timing.error_bound_kt,
                    decisions: moves,
                    decisions_sha256: timing.decisions_sha256(),
                    decides_as_direct: charged.map(|direct| timing.decisions == direct.decisions),
                });
                self.execution.progress.advance(1);
            }
        }
        Ok(rows)
    }

    fn parts(&self) -> Result<Vec<PartsRow>> {
        let mut rows = Vec::new();
        for &charges in &self.settings.charges {
            if !self.goes_on(&format!("{charges} charges, parts of a move")) {
                return Ok(rows);
            }
            let prepared = self.prepared(charges, EnergyMode::Calibrated)?;
            let readings = Arc::new(Mutex::new(Readings::default()));
            let mut model = || -> Box<dyn EnergyModel> {
                Box::new(Metered::new(prepared.levels(), Arc::clone(&readings)))
            };
            let moves = self.settings.moves.unwrap_or(affordable_moves(charges));
            let seconds = self.settings.seconds_per_rate;
            let timing = prepared.time_with(
                &mut model,
                moves,
                seconds,
                self.settings.seed,
                &self.execution.interrupt,
            )?;
            let readings = *readings.lock().unwrap_or_else(PoisonError::into_inner);
            rows.push(parts_row(charges, &timing, &readings));
            self.execution.progress.advance(1);
        }
        Ok(rows)
    }

    fn bodies(&self) -> Result<Vec<BodiesRow>> {
        let mut rows = Vec::new();
        let kinds = self.kinds(self.settings.few_charges)?;
        for energy in CHEAP_MODES {
            for &bodies in &self.settings.bodies {
                if !self.goes_on(&format!("{bodies} bodies, energy {}", energy.name())) {
                    return Ok(rows);
                }
                let box_angstrom = self.box_angstrom(&kinds, energy, bodies);
                let system = spread(&kinds, bodies, box_angstrom, self.settings.seed)?;
                let prepared = self.prepared_from(&system, energy)?;
                let range = self.neighbour_range_angstrom(&kinds, energy);
                let neighbours = mean_neighbours(&system, range);
                // Every body moves some times in each run, so that gaps are remembered as in a long
                // simulation.
                let moves = self.settings.moves.unwrap_or(10 * bodies as u64);
                let timing = prepared.time(
                    moves,
                    self.settings.seconds_per_rate,
                    self.settings.seed,
                    &self.execution.interrupt,
                )?;
                let move_microseconds = 1e6 / timing.moves_per_cpu_second();
                rows.push(BodiesRow {
                    bodies,
                    box_angstrom,
                    energy,
                    neighbours,
                    moves: timing.moves,
                    move_microseconds,
                    microseconds_per_neighbour: move_microseconds
                        / neighbours.max(f64::MIN_POSITIVE),
                });
                self.execution.progress.advance(1);
            }
        }
        Ok(rows)
    }

    /// Edge of the cube for this many bodies, Å. The first number of bodies gets a cube with room
    /// for the interaction and for [`VOLUME_FRACTION`]; the others have its density.
    fn box_angstrom(&self, kinds: &[Arc<BodyType>], energy: EnergyMode, bodies: usize) -> f64 {
        const ROOM: f64 = 2.05;
        let range = self.neighbour_range_angstrom(kinds, energy);
        let largest_volume = kinds
            .iter()
            .map(|kind| kind.volume_angstrom3)
            .fold(0.0, f64::max);
        let first = self.settings.bodies.first().copied().unwrap_or(1).max(1) as f64;
        let full = (first * largest_volume / VOLUME_FRACTION).cbrt();
        (ROOM * range).max(full) * (bodies as f64 / first).cbrt()
    }

    /// The distance of origins within which bodies count as neighbours, Å: surfaces that may touch, or
    /// charges within five Debye lengths.
    fn neighbour_range_angstrom(&self, kinds: &[Arc<BodyType>], energy: EnergyMode) -> f64 {
        const DEBYE_LENGTHS: f64 = 5.0;
        let largest = |length: fn(&BodyType) -> f64| {
            kinds.iter().map(|kind| length(kind)).fold(0.0, f64::max)
        };
        let hard = 2.0 * largest(BodyType::hard_radius_angstrom);
        let debye_length = 1.0 / self.yukawa.inverse_debye_length_per_angstrom;
        let charged =
            2.0 * largest(BodyType::charge_radius_angstrom) + DEBYE_LENGTHS * debye_length;
        match energy {
            EnergyMode::None => hard,
            _ => charged.max(hard),
        }
    }

    fn threads(&self) -> Result<Vec<ThreadsRow>> {
        let most = self.settings.threads.iter().copied().max().unwrap_or(1);
        let replicas = (2 * most).max(4) as u32;
        let mut rows: Vec<ThreadsRow> = Vec::new();
        for (energy, moves) in CHEAP_MODES.into_iter().zip(self.settings.replica_moves) {
            let mut first_seconds = None;
            for &threads in &self.settings.threads {
                if !self.goes_on(&format!("{threads} threads, energy {}", energy.name())) {
                    return Ok(rows);
                }
                let prepared = self.prepared(self.settings.few_charges, energy)?;
                let done = run_replicas(&prepared, self.settings.seed, replicas, moves, threads)?;
                let first_seconds = *first_seconds.get_or_insert(done.wall_seconds);
                rows.push(ThreadsRow {
                    energy,
                    threads,
                    replicas,
                    moves: u64::from(replicas) * moves,
                    wall_seconds: done.wall_seconds,
                    cpu_seconds: done.cpu_seconds,
                    speed_up: first_seconds / done.wall_seconds,
                    decisions_sha256: sha256_hex(&done.decisions),
                });
                self.execution.progress.advance(1);
            }
        }
        Ok(rows)
    }
}

/// Row of the parts of a move. The time outside the energy model is that of the overlap test and of
/// proposing and finding neighbours. Shares are told by the wall clock within the run and applied
/// to its processor time, which other work on the machine does not lengthen.
fn parts_row(charges: usize, timing: &Timing, readings: &Readings) -> PartsRow {
    let moves = timing.moves as f64;
    let move_microseconds = 1e6 / timing.moves_per_cpu_second();
    let per_move = |part: std::time::Duration| {
        part.as_secs_f64() / timing.watch.wall_seconds().max(f64::MIN_POSITIVE) * move_microseconds
    };
    let (settled, refined) = (readings.settled, readings.refined);
    let decisions = settled.count + refined.count;
    let [coarse, refinement, keeping] =
        [readings.coarse(), readings.refinement(), readings.keeping].map(per_move);
    PartsRow {
        charges,
        moves: timing.moves,
        move_microseconds,
        overlap_microseconds: (move_microseconds - coarse - refinement - keeping).max(0.0),
        coarse_microseconds: coarse,
        refinement_microseconds: refinement,
        keeping_microseconds: keeping,
        decided_by_energy: decisions as f64 / moves,
        coarse_energies_per_move: (settled.coarse + refined.coarse) as f64 / moves,
        refined: refined.count as f64 / decisions.max(1) as f64,
    }
}

/// Number of other bodies with their origin within the range (Å), on average over the bodies.
fn mean_neighbours(system: &System, range_angstrom: f64) -> f64 {
    let near = |first: usize, second: &usize| {
        system.pair(first, *second).displacement.norm_squared() < range_angstrom * range_angstrom
    };
    let pairs: usize = (0..system.len())
        .map(|i| (i + 1..system.len()).filter(|j| near(i, j)).count())
        .sum();
    2.0 * pairs as f64 / system.len() as f64
}

/// Times and decisions of all replicas together.
struct Replicas {
    wall_seconds: f64,
    cpu_seconds: f64,
    decisions: Vec<u8>,
}

/// Makes moves in independent replicas on a separate pool; the simulations are set up before the
/// clock starts.
fn run_replicas(
    prepared: &Prepared,
    seed: u64,
    replicas: u32,
    moves: u64,
    threads: usize,
) -> Result<Replicas> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .context("cannot start the threads")?;
    let simulations = (0..replicas)
        .map(|replica| prepared.simulation(prepared.model(), seed, replica))
        .collect::<Result<Vec<_>>>()?;
    let run = |mut simulation: Simulation| -> Result<(f64, Vec<u8>)> {
        let mut watch = Stopwatch::default();
        let mut decisions = Vec::with_capacity(moves as usize);
        watch.time(|| {
            simulation.trial_moves(moves, &mut |accepted| decisions.push(u8::from(accepted)))
        })?;
        Ok((watch.seconds(), decisions))
    };
    let start = Instant::now();
    let done = pool.install(|| {
        simulations
            .into_par_iter()
            .with_max_len(1)
            .map(run)
            .collect::<Result<Vec<_>>>()
    })?;
    Ok(Replicas {
        wall_seconds: start.elapsed().as_secs_f64(),
        cpu_seconds: done.iter().map(|(seconds, _)| seconds).sum(),
        decisions: done
            .into_iter()
            .flat_map(|(_, decisions)| decisions)
            .collect(),
    })
}

/// The first processor's name.
fn processor() -> Option<String> {
    let text = protomer_io::input::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}
