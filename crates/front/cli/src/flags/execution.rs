//! Flags for the execution of a run, shared by every verb that runs in a directory.

use crate::front::Front;
use anyhow::{Result, bail};
use clap::Args;
use protomer_common::range;
use protomer_results::Execution;
use std::time::Duration;

/// Time limit of a run and interval between its checkpoints.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Run")]
pub struct ExecutionArgs {
    /// Stop (resumably, exit code 3) after this many minutes.
    #[arg(
        long,
        env = "ACTION_WALLTIME_IN_MINUTES", value_parser = range::MINUTES.number())]
    time_limit: Option<f64>,
    /// Seconds between checkpoints: the most that a killed run loses.
    #[arg(long, default_value_t = 20.0, value_parser = range::SECONDS.number())]
    checkpoint_every: f64,
}

impl ExecutionArgs {
    /// The execution of the run. After this call, Ctrl-C stops the run resumably.
    pub fn execution(&self, front: &Front) -> Result<Execution> {
        let Ok(checkpoint_interval) = Duration::try_from_secs_f64(self.checkpoint_every) else {
            bail!(
                "--checkpoint-every is {} seconds; give zero or more",
                self.checkpoint_every
            );
        };
        let notice = "stopping at the next step; the same command continues from there";
        Ok(Execution {
            checkpoint_interval,
            ..front.execution(notice, self.time_limit)?
        })
    }
}
