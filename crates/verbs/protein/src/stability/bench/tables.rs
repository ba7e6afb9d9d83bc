//! The tables of the benchmark, as values and as text.

use crate::stability::interaction::ScreenedCoulomb;
use crate::stability::run::EnergyMode;
use protomer_common::answer::{Answer, columns};
use protomer_kernel::setting::Choices;
use serde::Serialize;

/// Moves per CPU-second of one energy mode.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RateRow {
    /// Charges per body.
    pub charges: usize,
    /// Mode of the energies.
    pub energy: EnergyMode,
    /// Moves timed.
    pub moves: u64,
    /// Moves per second of processor time.
    pub moves_per_cpu_second: f64,
    /// Moves per second of processor time, in units of those of the direct sum.
    pub speed_up: Option<f64>,
    /// Accepted fraction.
    pub acceptance: f64,
    /// Processor time of the tables, s.
    pub setup_seconds: f64,
    /// Memory of the energy model, bytes.
    pub memory_bytes: usize,
    /// The largest bound of a pair energy's error that was used, kT; zero for sums.
    pub error_bound_kt_per_pair: f64,
    /// Number of decisions in the hash.
    pub decisions: u64,
    /// SHA-256 of the first decisions, a byte 1 or 0 each.
    pub decisions_sha256: String,
    /// Whether the decisions are those of the direct sum.
    pub decides_as_direct: Option<bool>,
}

/// Parts of a trial move with energies by levels.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PartsRow {
    /// Charges per body.
    pub charges: usize,
    /// Moves timed.
    pub moves: u64,
    /// Processor time of a move, µs.
    pub move_microseconds: f64,
    /// Time to propose a move, find neighbours and test for overlaps, µs.
    pub overlap_microseconds: f64,
    /// Time for coarse energies, and decisions by them, µs.
    pub coarse_microseconds: f64,
    /// Time for finer levels where the coarse one left a decision open, µs.
    pub refinement_microseconds: f64,
    /// Time to keep the energies of accepted moves and drop those of rejected ones, µs.
    pub keeping_microseconds: f64,
    /// Fraction of the moves that reached the energies, the others being stopped by an overlap.
    pub decided_by_energy: f64,
    /// Pair energies at the coarse level per move.
    pub coarse_energies_per_move: f64,
    /// Fraction of the energy decisions that needed finer levels.
    pub refined: f64,
}

/// Cost of a move in a system of many bodies.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BodiesRow {
    /// Number of bodies.
    pub bodies: usize,
    /// Edge of the periodic cube, Å.
    pub box_angstrom: f64,
    /// Mode of the energies.
    pub energy: EnergyMode,
    /// Other bodies within the range of the interaction (of the surfaces, for hard bodies), on
    /// average.
    pub neighbours: f64,
    /// Moves timed.
    pub moves: u64,
    /// Processor time of a move, µs.
    pub move_microseconds: f64,
    /// Processor time of a move per neighbour, µs.
    pub microseconds_per_neighbour: f64,
}

/// Independent replicas on some threads.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ThreadsRow {
    /// Mode of the energies.
    pub energy: EnergyMode,
    /// Threads.
    pub threads: usize,
    /// Replicas.
    pub replicas: u32,
    /// Moves of all replicas.
    pub moves: u64,
    /// Wall-clock time, s.
    pub wall_seconds: f64,
    /// Processor time of all threads, s.
    pub cpu_seconds: f64,
    /// Wall-clock time of the first row of this mode over that of this row.
    pub speed_up: f64,
    /// SHA-256 of the decisions of all replicas: the same on any number of threads.
    pub decisions_sha256: String,
}

/// The tables.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SuiteResult {
    /// Version of the program.
    pub version: String,
    /// Name of the processor, where the system tells.
    pub processor: Option<String>,
    /// Threads the machine runs at once.
    pub machine_threads: usize,
    /// Seed of bodies, states and moves.
    pub seed: u64,
    /// Whether the benchmark ran to its end; otherwise rows are missing.
    pub complete: bool,
    /// The medium.
    #[serde(flatten)]
    pub interaction: ScreenedCoulomb,
    /// Moves per CPU-second of each energy mode.
    pub charges: Vec<RateRow>,
    /// Parts of a move.
    pub parts: Vec<PartsRow>,
    /// Cost of a move against the number of bodies.
    pub bodies: Vec<BodiesRow>,
    /// Replicas against threads.
    pub threads: Vec<ThreadsRow>,
}

impl Answer for SuiteResult {
    fn text(&self) -> String {
        let processor = self.processor.as_deref().unwrap_or("unknown processor");
        let mut parts = vec![
            format!(
                "protomer {}, {processor}, {} threads",
                self.version, self.machine_threads
            ),
            format!("medium: {}", self.interaction.describe()),
        ];
        let sections = [
            section(
                "Trial moves per CPU-second: sixteen bodies close to contact",
                &RATE_HEADING,
                self.charges.iter().map(RateRow::cells),
            ),
            section(
                "Parts of a move with energies by levels (µs of processor time)",
                &PARTS_HEADING,
                self.parts.iter().map(PartsRow::cells),
            ),
            section(
                "Cost of a move at equal density",
                &BODIES_HEADING,
                self.bodies.iter().map(BodiesRow::cells),
            ),
            section(
                "Independent replicas",
                &THREADS_HEADING,
                self.threads.iter().map(ThreadsRow::cells),
            ),
        ];
        parts.extend(sections.into_iter().flatten());
        parts.join("\n")
    }
}

/// A titled table; `None` without rows.
fn section(
    title: &str,
    heading: &[&str],
    cells: impl Iterator<Item = Vec<String>>,
) -> Option<String> {
    let heading = heading.iter().map(|name| (*name).to_owned()).collect();
    let rows: Vec<Vec<String>> = std::iter::once(heading).chain(cells).collect();
    (rows.len() > 1).then(|| format!("\n{title}\n{}", columns(&rows)))
}

const RATE_HEADING: [&str; 9] = [
    "charges",
    "energy",
    "moves/s",
    "speed-up",
    "acceptance",
    "set-up (s)",
    "memory (MB)",
    "error bound (kT)",
    "decides as direct",
];
const PARTS_HEADING: [&str; 8] = [
    "charges",
    "move",
    "overlap",
    "coarse",
    "refinement",
    "keeping",
    "pairs/move",
    "refined",
];
const BODIES_HEADING: [&str; 6] = [
    "bodies",
    "box (Å)",
    "energy",
    "neighbours",
    "move (µs)",
    "per neighbour (µs)",
];
const THREADS_HEADING: [&str; 8] = [
    "energy",
    "threads",
    "replicas",
    "moves",
    "wall (s)",
    "CPU (s)",
    "speed-up",
    "decisions",
];

impl RateRow {
    fn cells(&self) -> Vec<String> {
        let verdict = match self.decides_as_direct {
            None => "-".to_owned(),
            Some(_) if self.energy == EnergyMode::Direct => {
                format!("({} decisions)", self.decisions)
            }
            Some(true) => "yes".to_owned(),
            Some(false) => "no".to_owned(),
        };
        vec![
            self.charges.to_string(),
            self.energy.name().to_owned(),
            figures(self.moves_per_cpu_second),
            self.speed_up.map_or_else(|| "-".to_owned(), figures),
            format!("{:.2}", self.acceptance),
            format!("{:.1}", self.setup_seconds),
            format!("{:.1}", self.memory_bytes as f64 / 1e6),
            match self.energy {
                EnergyMode::None => "-".to_owned(),
                _ if self.error_bound_kt_per_pair == 0.0 => "0".to_owned(),
                _ => format!("{:.1e}", self.error_bound_kt_per_pair),
            },
            verdict,
        ]
    }
}

impl PartsRow {
    fn cells(&self) -> Vec<String> {
        let part = |microseconds: f64| {
            format!(
                "{} ({:.0} %)",
                figures(microseconds),
                100.0 * microseconds / self.move_microseconds
            )
        };
        vec![
            self.charges.to_string(),
            figures(self.move_microseconds),
            part(self.overlap_microseconds),
            part(self.coarse_microseconds),
            part(self.refinement_microseconds),
            part(self.keeping_microseconds),
            format!("{:.1}", self.coarse_energies_per_move),
            format!("{:.1} %", 100.0 * self.refined),
        ]
    }
}

impl BodiesRow {
    fn cells(&self) -> Vec<String> {
        vec![
            self.bodies.to_string(),
            format!("{:.0}", self.box_angstrom),
            self.energy.name().to_owned(),
            format!("{:.2}", self.neighbours),
            figures(self.move_microseconds),
            figures(self.microseconds_per_neighbour),
        ]
    }
}

impl ThreadsRow {
    fn cells(&self) -> Vec<String> {
        vec![
            self.energy.name().to_owned(),
            self.threads.to_string(),
            self.replicas.to_string(),
            self.moves.to_string(),
            format!("{:.2}", self.wall_seconds),
            format!("{:.2}", self.cpu_seconds),
            format!("{:.2}", self.speed_up),
            self.decisions_sha256.chars().take(8).collect(),
        ]
    }
}

/// A number with three significant figures.
fn figures(value: f64) -> String {
    let digits = if value.is_finite() && value > 0.0 {
        2 - value.log10().floor() as i32
    } else {
        0
    };
    let unit = 10_f64.powi(-digits);
    format!(
        "{:.*}",
        digits.max(0) as usize,
        (value / unit).round() * unit
    )
}
