//! `protomer inspect`: overlaps, energies and size of an assembly.

use crate::flags::choices::Energy;
use crate::flags::medium::ConditionArgs;
use crate::flags::solute::SoluteArgs;
use crate::flags::tables::TablesArgs;
use crate::flags::tolerance::ToleranceArgs;
use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use protomer::assemblies::assembly_file::Assembly;
use protomer::stability::inspect::{inspect, inspection_settings};
use protomer::stability::run::Engine;
use std::path::PathBuf;

/// Inspect an assembly: overlaps, pair energies, radius of gyration.
#[derive(Debug, Args)]
pub struct InspectArgs {
    /// Assembly file.
    assembly: PathBuf,
    /// Energy model.
    #[arg(long, value_enum, default_value_t = Energy::Direct)]
    energy: Energy,
    #[command(flatten)]
    tolerance: ToleranceArgs,
    /// Whether the charges of the bodies act, or their effective charges: those that give the
    /// potential around bodies of low permittivity that salt does not enter.
    #[arg(long, value_enum, default_value_t = Charges::Bare)]
    interaction: Charges,
    /// Surfaces closer than this are in contact, Å.
    #[arg(long, default_value_t = 5.0)]
    contact_gap: f64,
    #[command(flatten)]
    conditions: ConditionArgs,
    #[command(flatten)]
    solute: SoluteArgs,
    #[command(flatten)]
    tables: TablesArgs,
}

/// The charges of an interaction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Charges {
    /// The charges of the bodies.
    Bare,
    /// Their effective charges.
    Effective,
}

impl InspectArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let assembly = Assembly::read(&self.assembly)?;
        let engine = Engine::new(assembly)?.with_tables(self.tables.tables(front));
        let energy = self.energy.into();
        let interaction = self.conditions.interaction_for(energy)?;
        let (engine, warnings) = match (self.interaction, self.solute.solute()) {
            (Charges::Bare, None) => (engine, Vec::new()),
            (Charges::Bare, Some(_)) => bail!(
                "--inner-permittivity and --ion-radius apply to effective charges only; add \
                 --interaction effective, or leave them out"
            ),
            (Charges::Effective, solute) => {
                engine.with_effective_charges(&interaction, &solute.unwrap_or_default())?
            }
        };
        let settings = inspection_settings(energy, self.tolerance.tolerance, self.contact_gap);
        Ok(Reply::data(inspect(&engine, &settings, interaction)?).with_notes(warnings))
    }
}
