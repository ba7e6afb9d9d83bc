//! `protomer surface`: the solvent-excluded surface of a structure.

use crate::flags::body::{Cavities, SurfaceFlags};
use crate::front::Front;
use crate::reply::Reply;
use anyhow::Result;
use clap::Args;
use protomer::bodies::surface_of_file::measure_surface;
use protomer_body::SurfaceSettings;
use std::path::PathBuf;

/// Compute the solvent-excluded surface of a structure, a PQR, a body, or an .xyzr file (x y z
/// radius per line): mesh, exact area and volume. Cavities are kept by default.
#[derive(Debug, Args)]
pub struct SurfaceArgs {
    /// Structure, PQR, body or .xyzr file, optionally gzipped.
    input: PathBuf,
    /// Mesh vertices per Å².
    #[arg(long, default_value_t = 1.0)]
    density: f64,
    /// Spacing of the lattice on which the surface is first found, Å; a coarser one is faster and
    /// may close or open what is narrower.
    #[arg(long, default_value_t = SurfaceSettings::LATTICE_SPACING_ANGSTROM, allow_negative_numbers = true)]
    lattice_spacing: f64,
    /// Probe radius, Å.
    #[arg(long, default_value_t = 1.4)]
    probe: f64,
    /// What to do with cavities.
    #[arg(long, value_enum, default_value_t = Cavities::Keep)]
    cavities: Cavities,
    /// A cavity is an enclosed interior if a ball of this radius fits into it, Å; interiors
    /// are never filled.
    #[arg(long, default_value_t = SurfaceSettings::INTERIOR_RADIUS_ANGSTROM)]
    interior_radius: f64,
    /// Move the surface inward by this much, Å.
    #[arg(long, default_value_t = 0.0)]
    offset: f64,
    /// Mesh file to write: .ply, .obj, .off or .stl.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

impl SurfaceArgs {
    pub fn run(&self, front: &Front) -> Result<Reply> {
        let flags = SurfaceFlags {
            density: self.density,
            lattice_spacing: self.lattice_spacing,
            probe: self.probe,
            cavities: self.cavities,
            interior_radius: self.interior_radius,
            offset: self.offset,
        };
        let (settings, output) = (flags.settings(), self.output.as_deref());
        let report = measure_surface(&self.input, &settings, output, front.force())?;
        Ok(Reply::data(report))
    }
}
