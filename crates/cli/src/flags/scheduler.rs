//! The flag of verbs whose parts many machines may share. What understands it is the Python
//! package.

use anyhow::{Result, bail};
use clap::Args;

/// Who shares the work out.
#[derive(Debug, Clone, Args)]
pub struct SchedulerArgs {
    /// Have the work done by the workers of a Dask scheduler, such as tcp://host:8786; `local`, or
    /// nothing: of this machine. Needs the Python package.
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = "local")]
    scheduler: Option<String>,
}

impl SchedulerArgs {
    /// Refuses an address: the Python package takes it out of the words before they come here.
    ///
    /// # Errors
    /// If there is one.
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
