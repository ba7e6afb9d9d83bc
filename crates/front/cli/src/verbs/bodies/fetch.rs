//! `protomer fetch`: download entries from the Protein Data Bank.

use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_protein_verbs::bodies::fetch::{RCSB_DOWNLOAD, fetch_all};
use std::path::PathBuf;

/// Download entries (mmCIF, gzipped) from the RCSB Protein Data Bank. Nothing else in protomer uses
/// the network.
#[derive(Debug, Args)]
#[command(after_long_help = examples!("fetch 6MDR -o structures", "fetch 5PTI 1BRS"))]
pub struct FetchArgs {
    /// Entries, such as 6MDR.
    #[arg(required = true)]
    entries: Vec<String>,
    /// Folder for the files.
    #[arg(short, long, default_value = ".")]
    output: PathBuf,
    /// Base address of the server; ENTRY.cif.gz is added.
    #[arg(long, default_value = RCSB_DOWNLOAD, env = "PROTOMER_FETCH_BASE")]
    base: String,
}

impl FetchArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let progress = front.progress();
        let fetched = fetch_all(
            &self.entries,
            &self.base,
            &self.output,
            front.force(),
            progress.as_ref(),
        )?;
        Ok(Reply::from_answer(fetched))
    }
}
