//! `protomer fetch`: download an entry from the Protein Data Bank.

use super::{Global, Outcome, output};
use anyhow::Result;
use clap::Args;
use protomer::bodies::fetch::{RCSB_DOWNLOAD, fetch};
use std::path::PathBuf;

/// Download entries (mmCIF, gzipped) from the RCSB Protein Data Bank. Nothing else in protomer uses
/// the network.
#[derive(Debug, Args)]
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
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        let mut files = Vec::new();
        for entry in &self.entries {
            let path = fetch(entry, &self.base, &self.output, global.force)?;
            global.say(&format!("{entry}: {}", path.display()));
            files.push(serde_json::json!({"entry": entry, "file": path}));
        }
        if global.json {
            output::json(&serde_json::json!({"files": files}))?;
        }
        Ok(Outcome::Done)
    }
}
