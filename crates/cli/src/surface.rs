//! `protomer surface`: the solvent-excluded surface of a structure.

use super::ingest::{Cavities, SurfaceFlags};
use super::{Global, Outcome, output};
use anyhow::Result;
use clap::Args;
use protomer::bodies::surface_of_file::{SurfaceReport, surface_of_file};
use protomer_io::atomic::write_atomically;
use protomer_io::mesh::{MeshFormat, write_mesh};
use std::path::PathBuf;

/// Compute the solvent-excluded surface of a structure, a PQR, a body, or an .xyzr file (x y z
/// radius per line): mesh, exact area and volume. Cavities are kept unless told otherwise.
#[derive(Debug, Args)]
pub struct SurfaceArgs {
    /// Structure, PQR, body or .xyzr file, perhaps gzipped.
    input: PathBuf,
    /// Mesh vertices per Å².
    #[arg(long, default_value_t = 1.0)]
    density: f64,
    /// Probe radius, Å.
    #[arg(long, default_value_t = 1.4)]
    probe: f64,
    /// What to do with cavities inside.
    #[arg(long, value_enum, default_value_t = Cavities::Keep)]
    cavities: Cavities,
    /// Move the surface inward by this much, Å.
    #[arg(long, default_value_t = 0.0)]
    offset: f64,
    /// Mesh file to write: .ply, .obj, .off or .stl.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

impl SurfaceArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        let flags = SurfaceFlags {
            density: self.density,
            probe: self.probe,
            cavities: self.cavities,
            offset: self.offset,
        };
        // A wrong ending is told before the work, not after it.
        let format = self
            .output
            .as_ref()
            .map(|path| MeshFormat::from_name(&path.display().to_string()))
            .transpose()?;
        let (mesh, report) = surface_of_file(&self.input, &flags.settings())?;
        if let (Some(path), Some(format)) = (&self.output, format) {
            let bytes = write_mesh(format, &mesh);
            write_atomically(path, |file| file.write_all(&bytes))?;
        }
        if global.json {
            output::json(&report)?
        } else {
            output::text(&describe(&report))?
        }
        Ok(Outcome::Done)
    }
}

fn describe(report: &SurfaceReport) -> String {
    format!(
        "{} atoms\n\
         exact:  area {:.3} Å², volume {:.3} Å³ (relative error about {:.0e})\n\
         mesh:   area {:.3} Å² ({:+.2} %), volume {:.3} Å³ ({:+.3} %)\n\
         {} vertices, {} triangles, {} components, {} of them cavities, genus {}",
        report.atoms,
        report.ses_area_angstrom2,
        report.ses_volume_angstrom3,
        report.relative_error_estimate,
        report.mesh_area_angstrom2,
        100.0 * (report.mesh_area_angstrom2 / report.ses_area_angstrom2 - 1.0),
        report.mesh_volume_angstrom3,
        100.0 * (report.mesh_volume_angstrom3 / report.ses_volume_angstrom3 - 1.0),
        report.vertices,
        report.triangles,
        report.components,
        report.cavities,
        report.genus
    )
}
