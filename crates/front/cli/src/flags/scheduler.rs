//! The scheduler flag, shared by verbs that can be distributed over machines. It is
//! handled by the Python package.

use anyhow::{Result, bail};
use clap::Args;

/// The scheduler of distributed work.
#[derive(Debug, Clone, Args)]
pub struct SchedulerArgs {
    /// Run the work on the workers of a Dask scheduler, such as tcp://host:8786; `local`, the
    /// default value, uses this machine. Needs the Python package.
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = "local")]
    scheduler: Option<String>,
}

impl SchedulerArgs {
    /// Refuses an address: the Python package removes the flag before it calls the program.
    ///
    /// # Errors
    /// If an address is given.
    pub fn check(&self) -> Result<()> {
        if let Some(address) = &self.scheduler {
            bail!(
                "--scheduler {address} needs the Python package, and its own 'protomer' command: \
                 pip install './python[cluster]'; or give each machine a part with --shard"
            );
        }
        Ok(())
    }
}
