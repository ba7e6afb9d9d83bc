//! The flags that every verb has.

use anyhow::{Result, bail};
use clap::Args;

/// Upper limit for the number of threads.
const MOST_THREADS: usize = 1024;

/// Global options.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Global options")]
pub struct Global {
    /// Print one JSON object on stdout instead of text.
    #[arg(long, global = true)]
    pub json: bool,
    /// Threads to use; 0 means all.
    #[arg(
        short = 'j',
        long,
        global = true,
        default_value_t = 0,
        env = "PROTOMER_THREADS"
    )]
    pub threads: usize,
    /// Print only errors, and data that was requested.
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Print settings and timings as well.
    #[arg(short, long, global = true)]
    pub verbose: bool,
    /// Do not draw progress bars.
    #[arg(long, global = true)]
    pub no_progress: bool,
    /// Overwrite existing results.
    #[arg(long, global = true)]
    pub force: bool,
}

impl Global {
    /// The thread pool requested by the flags.
    pub fn thread_pool(&self) -> Result<rayon::ThreadPoolBuilder> {
        if self.threads > MOST_THREADS {
            bail!("--threads is {}; give at most {MOST_THREADS}", self.threads);
        }
        Ok(rayon::ThreadPoolBuilder::new().num_threads(self.threads))
    }
}
