//! `protomer inspect`: overlaps, energies and size of an assembly as it stands.

use super::choices::Energy;
use super::medium::ConditionArgs;
use super::tables::TablesArgs;
use super::tolerance::ToleranceArgs;
use super::{Global, Outcome, output};
use anyhow::Result;
use clap::Args;
use protomer::assemblies::assembly_file::Assembly;
use protomer::stability::inspect::{inspect, inspection_settings};
use protomer::stability::run::Engine;
use std::path::PathBuf;

/// Look at an assembly as it stands: overlaps, pair energies, radius of gyration.
#[derive(Debug, Args)]
pub struct InspectArgs {
    /// Assembly file.
    assembly: PathBuf,
    /// How energies are computed.
    #[arg(long, value_enum, default_value_t = Energy::Direct)]
    energy: Energy,
    #[command(flatten)]
    tolerance: ToleranceArgs,
    /// Surfaces closer than this are in contact, Å.
    #[arg(long, default_value_t = 5.0)]
    contact_gap: f64,
    #[command(flatten)]
    conditions: ConditionArgs,
    #[command(flatten)]
    tables: TablesArgs,
}

impl InspectArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        let interaction = self.conditions.interaction()?;
        let engine =
            Engine::new(Assembly::read(&self.assembly)?)?.with_tables(self.tables.tables(global));
        let settings = inspection_settings(
            self.energy.into(),
            self.tolerance.tolerance,
            self.contact_gap,
        );
        let inspection = inspect(&engine, &settings, interaction)?;
        if global.json {
            output::json(&inspection)?
        } else {
            output::text(&inspection.describe())?
        }
        Ok(Outcome::Done)
    }
}
