//! Flags of verbs that can be distributed over machines. The scheduler is handled by the Python package.

use anyhow::{Result, bail};
use clap::Args;
use protomer_results::Shard;

/// The part of the work that this process does.
#[derive(Debug, Clone, Args)]
pub struct PartArgs {
    /// Do only a part of the work, such as 2/8, alongside other processes in the same directory; the command
    /// without this flag collects the parts.
    #[arg(long, value_parser = Shard::parse, default_value = "1/1")]
    shard: Shard,
    #[command(flatten)]
    scheduler: SchedulerArgs,
}

impl PartArgs {
    /// Refuses an address, as [`SchedulerArgs::check`].
    ///
    /// # Errors
    /// If an address is given.
    pub fn check(&self) -> Result<()> {
        self.scheduler.check()
    }

    /// The part; `None` for the whole.
    pub fn shard(&self) -> Option<Shard> {
        (!self.shard.is_whole()).then_some(self.shard)
    }
}

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
