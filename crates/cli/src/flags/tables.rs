//! The flags of the energy tables, shared by the verbs that use them.

use crate::front::Front;
use clap::Args;
use protomer::quantity;
use protomer::stability::disk_cache::DiskCache;
use protomer::stability::energy_tables::EnergyTables;
use std::sync::Arc;

/// The resources of tables of energies by levels.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Energy tables")]
pub struct TablesArgs {
    /// Memory limit for all tables of energies by levels, such as 500MB.
    #[arg(long, value_parser = quantity::memory_bytes, default_value = "4GB", allow_hyphen_values = true)]
    pub memory_limit: u64,
    /// Do not read or write the cache of tables of energies by levels. The cache folder is
    /// PROTOMER_CACHE_DIR (empty: no cache), or else protomer in XDG_CACHE_HOME or ~/.cache; it
    /// holds at most 2 GB.
    #[arg(long)]
    pub no_cache: bool,
}

impl TablesArgs {
    /// The tables of a run.
    pub fn tables(&self, front: &Front) -> Arc<EnergyTables> {
        let tables = EnergyTables::new(self.memory_limit);
        Arc::new(match DiskCache::of_user().filter(|_| !self.no_cache) {
            Some(cache) => tables.with_cache(cache, front.warner()),
            None => tables,
        })
    }
}
