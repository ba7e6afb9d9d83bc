//! The flags of the energy tables, shared by the verbs that make them.

use crate::energy_tables::EnergyTables;
use crate::quantity;
use clap::Args;
use std::sync::Arc;

/// What tables of certified energies may take.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Energy tables")]
pub struct TablesArgs {
    /// Memory that tables of certified energies may take together, such as 500MB.
    #[arg(long, value_parser = quantity::memory_bytes, default_value = "4GB", allow_hyphen_values = true)]
    pub memory_limit: u64,
}

impl TablesArgs {
    /// The tables of a run.
    pub fn tables(&self) -> Arc<EnergyTables> {
        Arc::new(EnergyTables::new(self.memory_limit))
    }
}
