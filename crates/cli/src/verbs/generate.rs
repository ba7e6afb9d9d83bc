//! `protomer completions` and `protomer man`, generated from the table of flags.

use crate::Cli;
use crate::reply::Reply;
use anyhow::Result;
use clap::{Args, CommandFactory};
use protomer_results::ResultKind;
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
    pub fn run(&self) -> Result<Reply> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "protomer", &mut script);
        let script = String::from_utf8(script)?;
        Ok(Reply::text(script.trim_end_matches('\n').to_owned()))
    }
}

impl ManArgs {
    pub fn run(&self) -> Result<Reply> {
        ResultKind::VoxelSet.refuse_in(&self.output)?;
        std::fs::create_dir_all(&self.output)?;
        clap_mangen::generate_to(Cli::command(), &self.output)?;
        Ok(Reply::nothing())
    }
}
