//! The flags of the energy tables, shared by the verbs that make them.

use crate::front::Front;
use clap::Args;
use protomer::quantity;
use protomer::stability::disk_cache::DiskCache;
use protomer::stability::energy_tables::EnergyTables;
use std::sync::Arc;

/// What tables of energies by levels may take.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Energy tables")]
pub struct TablesArgs {
    /// Memory that tables of energies by levels may take together, such as 500MB.
    #[arg(long, value_parser = quantity::memory_bytes, default_value = "4GB", allow_hyphen_values = true)]
    pub memory_limit: u64,
    /// Neither look for tables of energies by levels in the cache folder nor keep them there. The
    /// folder is PROTOMER_CACHE_DIR (empty: none), else protomer in XDG_CACHE_HOME or ~/.cache; it
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
