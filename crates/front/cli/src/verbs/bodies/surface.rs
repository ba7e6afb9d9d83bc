//! `protomer surface`: the solvent-excluded surface of a structure.

use crate::flags::body::{Cavities, SurfaceFlags};
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer_common::output_file::MeshFormat;
use protomer_protein_verbs::bodies::surface_of_file::measure_surface;
use std::path::PathBuf;

/// Compute the solvent-excluded surface of a structure, a PQR, a body, or an .xyzr file (x y z
/// radius per line): mesh, exact area and volume. Cavities are kept by default.
#[derive(Debug, Args)]
#[command(after_long_help = examples!(
    "surface 5pti.cif.gz -o bpti.ply",
    "surface spheres.xyzr --probe 1.4 --density 4 --json"
))]
pub struct SurfaceArgs {
    /// Structure, PQR, body or .xyzr file, optionally gzipped.
    input: PathBuf,
    #[arg(short, long, help = format!("Mesh file to write: {}", MeshFormat::extensions()))]
    output: Option<PathBuf>,
    #[command(flatten)]
    surface: SurfaceFlags,
}

impl SurfaceArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let settings = self.surface.settings(Cavities::Keep);
        let output = self.output.as_deref();
        let report = measure_surface(&self.input, &settings, output, front.force())?;
        Ok(Reply::data(report))
    }
}
