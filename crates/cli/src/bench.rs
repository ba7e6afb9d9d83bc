//! `protomer bench`: trial moves per CPU-second.

use super::choices::{BenchPart, Energy};
use super::medium::ConditionArgs;
use super::tables::TablesArgs;
use super::tolerance::ToleranceArgs;
use super::{Global, Outcome, interrupt_saying, output};
use anyhow::{Result, bail};
use clap::Args;
use protomer::assemblies::assembly_file::Assembly;
use protomer::stability::bench::suite::{SuiteResult, SuiteSettings, run_suite};
use protomer::stability::bench::{BenchSettings, bench};
use protomer::stability::interaction::{Interaction, Medium};
use protomer::stability::run::EnergyMode;
use protomer_results::Execution;
use std::path::{Path, PathBuf};

/// More charges than a direct sum over sixteen bodies can be waited for.
const MOST_CHARGES: usize = 50_000;

/// Measure trial moves per CPU-second on an assembly, from the state it is in, and hash the
/// decisions made.
///
/// Without an assembly: measure on states that the program makes itself, and print a table of each
/// energy mode's rate against the number of charges, of the parts of a move, of the cost against
/// the number of bodies, and of replicas on several threads. That takes a few minutes.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// Assembly file; left out, the program makes its own states.
    assembly: Option<PathBuf>,
    /// Trial moves [default: 10000; without an assembly, as many as the direct sum makes in a few
    /// seconds].
    #[arg(long)]
    moves: Option<u64>,
    /// How energies are computed [default: direct; without an assembly, each way].
    #[arg(long, value_enum, requires = "assembly")]
    energy: Option<Energy>,
    #[command(flatten)]
    tolerance: ToleranceArgs,
    /// Only this table (repeat for several).
    #[arg(long, value_enum, conflicts_with = "assembly")]
    part: Vec<BenchPart>,
    /// Numbers of charges per body in the tables [default: 500,3000].
    #[arg(long, value_delimiter = ',', conflicts_with = "assembly")]
    charges: Vec<usize>,
    /// Seed of the random numbers, and of the program's own states.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    conditions: ConditionArgs,
    #[command(flatten)]
    tables: TablesArgs,
}

impl BenchArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        if self.moves == Some(0) {
            bail!("--moves is 0; give at least 1");
        }
        match &self.assembly {
            Some(path) => self.on_assembly(path, global),
            None => self.on_own_states(global),
        }
    }

    fn on_assembly(&self, path: &Path, global: &Global) -> Result<Outcome> {
        let interaction = self.conditions.interaction()?;
        let assembly = Assembly::read(path)?;
        let usual = BenchSettings::default();
        let settings = BenchSettings {
            moves: self.moves.unwrap_or(usual.moves),
            energy: self.energy.map_or(usual.energy, Into::into),
            tolerance_kt: self.tolerance.tolerance,
            seed: self.seed,
            ..usual
        };
        let result = bench(assembly, &settings, interaction, self.tables.tables(global))?;
        if global.json {
            output::json(&result)?;
        } else {
            output::text(&format!(
                "{:.0} trial moves per CPU-second, acceptance {:.3}, set-up {:.2} s, memory {:.1} MB{}\n\
                 decisions {}",
                result.moves_per_cpu_second,
                result.acceptance,
                result.setup_seconds,
                result.memory_bytes as f64 / 1e6,
                match result.error_bound_kt_per_pair {
                    0.0 => String::new(),
                    bound => format!(", pair energies to within {bound:.2e} kT"),
                },
                result.decisions_sha256
            ))?;
        }
        Ok(Outcome::Done)
    }

    fn on_own_states(&self, global: &Global) -> Result<Outcome> {
        let usual = SuiteSettings::default();
        let parts = if self.part.is_empty() {
            usual.parts.clone()
        } else {
            self.part.iter().map(|part| (*part).into()).collect()
        };
        if let Some(charges) = self
            .charges
            .iter()
            .find(|charges| !(1..=MOST_CHARGES).contains(*charges))
        {
            bail!(
                "--charges has {charges}; give numbers from 1 to {MOST_CHARGES}, such as 500,3000"
            );
        }
        let charges = if self.charges.is_empty() {
            usual.charges.clone()
        } else {
            self.charges.clone()
        };
        let tolerance_kt = EnergyMode::Approximate
            .tolerance_kt(self.tolerance.tolerance)?
            .unwrap_or(usual.tolerance_kt);
        let settings = SuiteSettings {
            parts,
            charges,
            moves: self.moves,
            seed: self.seed,
            tolerance_kt,
            ..usual
        };
        let interaction = self.interaction_of_own_states()?;
        let interrupt = interrupt_saying(global, "stopping after the present run of moves", None)?;
        let execution = Execution {
            interrupt,
            progress: global.progress(),
            ..Execution::default()
        };
        let tables = self.tables.tables(global);
        let result = run_suite(&settings, interaction, &tables, &execution)?;
        drop(execution);
        if global.json {
            output::json(&result)?;
        } else {
            output::text(&describe(&result))?;
        }
        if !result.complete {
            global.say("stopped; rows that were not measured are left out");
            return Ok(Outcome::Stopped);
        }
        Ok(Outcome::Done)
    }

    /// The medium of the flags; without salt and Debye length, a plain one of fixed lengths.
    fn interaction_of_own_states(&self) -> Result<Interaction> {
        let stated = self.conditions.medium.medium();
        if self.conditions.salt.is_some() || stated.debye_length_angstrom.is_some() {
            return self.conditions.interaction();
        }
        let usual = Medium {
            bjerrum_length_angstrom: Some(7.0),
            debye_length_angstrom: Some(9.6),
            cutoff_angstrom: Some(48.0),
            ..Medium::default()
        };
        let mut medium = usual;
        self.conditions.medium.override_in(&mut medium);
        medium.interaction(None)
    }
}

/// The tables for people.
fn describe(result: &SuiteResult) -> String {
    let processor = result.processor.as_deref().unwrap_or("unknown processor");
    let mut text = vec![
        format!(
            "protomer {}, {processor}, {} threads",
            result.version, result.machine_threads
        ),
        format!("medium: {}", result.interaction.describe()),
    ];
    let mut section = |title: &str, heading: &[&str], rows: Vec<Vec<String>>| {
        if !rows.is_empty() {
            let heading = heading.iter().map(|cell| (*cell).to_owned()).collect();
            let rows: Vec<Vec<String>> = std::iter::once(heading).chain(rows).collect();
            text.push(format!("\n{title}\n{}", output::table(&rows)));
        }
    };
    section(
        "Trial moves per CPU-second: sixteen bodies close to contact",
        &[
            "charges",
            "energy",
            "moves/s",
            "speed-up",
            "acceptance",
            "set-up (s)",
            "memory (MB)",
            "error bound (kT)",
            "decides as direct",
        ],
        result.charges.iter().map(rate_cells).collect(),
    );
    section(
        "Parts of a move with certified energies (µs of processor time)",
        &[
            "charges",
            "move",
            "overlap",
            "bounds",
            "refinement",
            "keeping",
            "intervals/move",
            "refined",
        ],
        result.parts.iter().map(parts_cells).collect(),
    );
    section(
        "Cost of a move at equal density",
        &[
            "bodies",
            "box (Å)",
            "energy",
            "neighbours",
            "move (µs)",
            "per neighbour (µs)",
        ],
        result.bodies.iter().map(bodies_cells).collect(),
    );
    section(
        "Independent replicas",
        &[
            "energy",
            "threads",
            "replicas",
            "moves",
            "wall (s)",
            "CPU (s)",
            "speed-up",
            "decisions",
        ],
        result.threads.iter().map(threads_cells).collect(),
    );
    text.join("\n")
}

fn rate_cells(row: &protomer::stability::bench::suite::RateRow) -> Vec<String> {
    let verdict = match row.decides_as_direct {
        None => "-".to_owned(),
        Some(_) if row.energy == EnergyMode::Direct => format!("({} decisions)", row.decisions),
        Some(true) => "yes".to_owned(),
        Some(false) => "no".to_owned(),
    };
    vec![
        row.charges.to_string(),
        row.energy.name().to_owned(),
        figures(row.moves_per_cpu_second),
        row.speed_up.map_or_else(|| "-".to_owned(), figures),
        format!("{:.2}", row.acceptance),
        format!("{:.1}", row.setup_seconds),
        format!("{:.1}", row.memory_bytes as f64 / 1e6),
        match row.energy {
            EnergyMode::None => "-".to_owned(),
            _ if row.error_bound_kt_per_pair == 0.0 => "0".to_owned(),
            _ => format!("{:.1e}", row.error_bound_kt_per_pair),
        },
        verdict,
    ]
}

fn parts_cells(row: &protomer::stability::bench::suite::PartsRow) -> Vec<String> {
    let part = |microseconds: f64| {
        format!(
            "{} ({:.0} %)",
            figures(microseconds),
            100.0 * microseconds / row.move_microseconds
        )
    };
    vec![
        row.charges.to_string(),
        figures(row.move_microseconds),
        part(row.overlap_microseconds),
        part(row.bounds_microseconds),
        part(row.refinement_microseconds),
        part(row.keeping_microseconds),
        format!("{:.1}", row.intervals_per_move),
        format!("{:.1} %", 100.0 * row.refined),
    ]
}

fn bodies_cells(row: &protomer::stability::bench::suite::BodiesRow) -> Vec<String> {
    vec![
        row.bodies.to_string(),
        format!("{:.0}", row.box_angstrom),
        row.energy.name().to_owned(),
        format!("{:.2}", row.neighbours),
        figures(row.move_microseconds),
        figures(row.microseconds_per_neighbour),
    ]
}

fn threads_cells(row: &protomer::stability::bench::suite::ThreadsRow) -> Vec<String> {
    vec![
        row.energy.name().to_owned(),
        row.threads.to_string(),
        row.replicas.to_string(),
        row.moves.to_string(),
        format!("{:.2}", row.wall_seconds),
        format!("{:.2}", row.cpu_seconds),
        format!("{:.2}", row.speed_up),
        row.decisions_sha256.chars().take(8).collect(),
    ]
}

/// Three figures.
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
