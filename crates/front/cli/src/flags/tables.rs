//! The flags of the energy tables, shared by the verbs that use them.

use crate::flags::cache::CacheArgs;
use crate::front::Front;
use anyhow::Result;
use clap::Args;
use protomer_common::quantity;
use protomer_protein_verbs::assemblies::assembly_file::Assembly;
use protomer_protein_verbs::stability::energy_tables::EnergyTables;
use protomer_protein_verbs::stability::run::Engine;
use std::sync::Arc;

/// The resources of tables of energies by levels.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Energy tables")]
pub struct TablesArgs {
    /// Memory limit for all tables of energies by levels, such as 500MB.
    #[arg(long, value_parser = quantity::memory_bytes, default_value = "4GB", allow_hyphen_values = true)]
    pub memory_limit: u64,
    #[command(flatten)]
    pub cache: CacheArgs,
}

impl TablesArgs {
    /// The engine of an assembly, with the tables and the effective charges of a run.
    pub fn engine(&self, assembly: Assembly, front: &Front) -> Result<Engine> {
        Ok(Engine::new(assembly)?
            .with_tables(self.tables(front))
            .with_effective_store(self.cache.effective_store(front)))
    }

    /// The tables of a run.
    pub fn tables(&self, front: &Front) -> Arc<EnergyTables> {
        let tables = EnergyTables::new(self.memory_limit);
        Arc::new(match self.cache.cache(front) {
            Some(cache) => tables.with_cache(cache, front.warner()),
            None => tables,
        })
    }
}
