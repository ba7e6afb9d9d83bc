//! `protomer bench`: trial moves per CPU-second.

use super::medium::ConditionArgs;
use super::{Global, Outcome, output};
use crate::assembly_file::Assembly;
use crate::bench::{BenchSettings, bench};
use crate::run::EnergyMode;
use anyhow::{Result, bail};
use clap::Args;
use std::path::PathBuf;

/// Measure trial moves per CPU-second on an assembly, from the state it is in, and hash the decisions made.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// Assembly file.
    assembly: PathBuf,
    #[command(flatten)]
    conditions: ConditionArgs,
    /// Trial moves.
    #[arg(long, default_value_t = 10_000)]
    moves: u64,
    /// How energies are computed.
    #[arg(long, value_enum, default_value_t = EnergyMode::Direct)]
    energy: EnergyMode,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

impl BenchArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        if self.moves == 0 {
            bail!("--moves is 0; give at least 1");
        }
        let interaction = self.conditions.interaction()?;
        let assembly = Assembly::read(&self.assembly)?;
        let settings =
            BenchSettings { moves: self.moves, energy: self.energy, seed: self.seed, ..BenchSettings::default() };
        let result = bench(assembly, &settings, interaction)?;
        if global.json {
            output::json(&result)?;
        } else {
            output::text(&format!(
                "{:.0} trial moves per CPU-second, acceptance {:.3}, set-up {:.2} s, memory {:.1} MB\ndecisions {}",
                result.moves_per_cpu_second,
                result.acceptance,
                result.setup_seconds,
                result.memory_bytes as f64 / 1e6,
                result.decisions_sha256
            ))?;
        }
        Ok(Outcome::Done)
    }
}
