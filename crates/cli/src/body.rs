//! `protomer body`: a body from a user's own mesh and charges.

use super::{Global, Outcome, output};
use anyhow::{Result, bail};
use clap::Args;
use protomer::bodies::own_body::{OwnBody, build};
use protomer::bodies::{body_file, ingest};
use std::path::PathBuf;

/// Make a body from a mesh (PLY, OFF, OBJ, STL) and charges (PQR, or whitespace-separated x y z
/// charge). Coordinates are kept: the body's origin is that of the files.
#[derive(Debug, Args)]
pub struct BodyArgs {
    /// Closed, outward mesh, Å.
    #[arg(long)]
    mesh: PathBuf,
    /// Charges; without them the body is hard and neutral.
    #[arg(long)]
    charges: Option<PathBuf>,
    /// Body file to write.
    #[arg(short, long)]
    output: PathBuf,
    /// Name of the body; that of the output file if left out.
    #[arg(long)]
    name: Option<String>,
}

impl BodyArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
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
            .to_string_lossy()
            .into_owned();
        let own = OwnBody {
            name: self.name.clone().unwrap_or(stem),
            mesh: self.mesh.clone(),
            charges: self.charges.clone(),
        };
        let body = build(&own)?;
        body_file::write(&self.output, &body)?;
        if global.json {
            return output::json(&ingest::describe_body(&body, &self.output))
                .map(|()| Outcome::Done);
        }
        global.say(&format!(
            "{}: {} triangles, {:.1} Å³, {} charges, net {:+.3} e",
            self.output.display(),
            body.mesh.triangles.len(),
            body.mass_properties.volume_angstrom3,
            body.sites.len(),
            body.net_charge_e()
        ));
        Ok(Outcome::Done)
    }
}
