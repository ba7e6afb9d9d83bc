//! `protomer completions` and `protomer man`: made from the same table as the flags.

use super::{Cli, Outcome};
use anyhow::Result;
use clap::{Args, CommandFactory};
use protomer_results::ResultKind;
use std::io::Write;
use std::path::PathBuf;

/// Print shell completions on stdout.
#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// The shell.
    shell: clap_complete::Shell,
}

/// Write the man pages, one per verb, into a folder.
#[derive(Debug, Args)]
pub struct ManArgs {
    /// Folder for the pages.
    #[arg(short, long, default_value = "man")]
    output: PathBuf,
}

impl CompletionsArgs {
    pub(super) fn run(&self) -> Result<Outcome> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "protomer", &mut script);
        std::io::stdout().lock().write_all(&script)?;
        Ok(Outcome::Done)
    }
}

impl ManArgs {
    pub(super) fn run(&self) -> Result<Outcome> {
        ResultKind::VoxelSet.refuse_in(&self.output)?;
        std::fs::create_dir_all(&self.output)?;
        clap_mangen::generate_to(Cli::command(), &self.output)?;
        Ok(Outcome::Done)
    }
}
