//! `protomer completions` and `protomer man`, generated from the table of flags.

use crate::front::Front;
use crate::reply::Reply;
use crate::syntax;
use anyhow::{Context, Result};
use clap::Args;
use protomer_common::output_file::{refuse_to_replace, write_once};
use protomer_results::ResultKind;
use std::path::PathBuf;

/// Print shell completions on stdout.
#[derive(Debug, Args)]
#[command(after_long_help = examples!("completions bash", "completions zsh"))]
pub struct CompletionsArgs {
    /// The shell.
    shell: clap_complete::Shell,
}

/// Write the man pages, one per verb, into a folder.
#[derive(Debug, Args)]
#[command(after_long_help = examples!("man", "man -o ~/.local/share/man/man1"))]
pub struct ManArgs {
    /// Folder for the pages.
    #[arg(short, long, default_value = "man")]
    output: PathBuf,
}

impl CompletionsArgs {
    pub fn run(&self, _: &Front) -> Result<Reply> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut syntax(), "protomer", &mut script);
        let script = String::from_utf8(script)?;
        Ok(Reply::text(script.trim_end_matches('\n').to_owned()))
    }
}

impl ManArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        ResultKind::VoxelSet.refuse_in(&self.output)?;
        let made = tempfile::tempdir().context("cannot make a temporary folder")?;
        clap_mangen::generate_to(syntax(), made.path())?;
        let mut pages = Vec::new();
        for entry in made.path().read_dir()? {
            let entry = entry?;
            let page = self.output.join(entry.file_name());
            let bytes = std::fs::read(entry.path())?;
            refuse_to_replace(&page, &bytes, front.force())?;
            pages.push((page, bytes));
        }
        std::fs::create_dir_all(&self.output)?;
        for (page, bytes) in pages {
            write_once(&page, &bytes, front.force())?;
        }
        Ok(Reply::nothing())
    }
}
