//! `protomer body`: a body from a custom mesh and charges.

use crate::front::Front;
use crate::reply::Reply;
use anyhow::{Result, bail};
use clap::Args;
use protomer_common::output_file::MeshFormat;
use protomer_protein_verbs::bodies::own_body::{OwnBody, make};
use std::path::PathBuf;

/// Make a body from a mesh and charges (PQR, or whitespace-separated x y z
/// charge). Coordinates are kept: the body's origin is that of the files.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "body --mesh patchy.ply --charges patchy.xyzq -o patchy.body",
    "body --mesh cube.off -o cube.body"
))]
pub struct BodyArgs {
    #[arg(long, help = format!("Closed, outward mesh, Å: {}", MeshFormat::extensions()))]
    mesh: PathBuf,
    /// Charges; if omitted, the body is hard and neutral.
    #[arg(long)]
    charges: Option<PathBuf>,
    /// Body file to write.
    #[arg(short, long)]
    output: PathBuf,
    /// Name of the body; that of the output file if omitted.
    #[arg(long)]
    name: Option<String>,
}

impl BodyArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        if self.output.is_dir() {
            bail!(
                "{} is a folder; name the body file, such as a.body",
                self.output.display()
            );
        }
        let stem = self
            .output
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy();
        let body = OwnBody {
            name: self.name.clone().unwrap_or_else(|| stem.into_owned()),
            mesh: self.mesh.clone(),
            charges: self.charges.clone(),
        };
        Ok(Reply::from_answer(make(
            &body,
            &self.output,
            front.force(),
        )?))
    }
}
