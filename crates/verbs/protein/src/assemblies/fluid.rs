//! A fluid: bodies at random positions and orientations in a periodic box, without overlaps.

use crate::assemblies::assemble::{BodyFiles, write_assembly};
use anyhow::{Result, bail};
use protomer_body::assembly::Placement;
use protomer_common::answer::Answer;
use protomer_kernel::units::NUMBER_DENSITY_PER_MOLAR;
use serde::Serialize;
use serde_json::json;
use std::path::{Path, PathBuf};

/// A fluid that was written.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FluidAssembly {
    /// The assembly file.
    pub assembly: PathBuf,
    /// Number of bodies.
    pub bodies: usize,
    /// Concentration of the bodies, mmol/L.
    pub concentration_millimolar: f64,
}

impl Answer for FluidAssembly {
    fn text(&self) -> String {
        format!(
            "{}: {} bodies at random positions, {:.3} mM",
            self.assembly.display(),
            self.bodies,
            self.concentration_millimolar
        )
    }
}

/// Fills a box with bodies and writes it to an assembly file.
///
/// # Errors
/// As [`fluid`]; also if a file cannot be read or written.
///
/// ```no_run
/// use protomer_protein_verbs::assemblies::fluid::assemble_fluid;
/// use std::path::{Path, PathBuf};
/// let bodies = [PathBuf::from("a.body"), PathBuf::from("b.body")];
/// let (seed, output, force) = (1, Path::new("fluid.json"), false);
/// let fluid = assemble_fluid(&bodies, &[8, 8], [500.0; 3], seed, output, force)?;
/// assert_eq!(fluid.bodies, 16);
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn assemble_fluid(
    bodies: &[PathBuf],
    counts: &[usize],
    box_angstrom: [f64; 3],
    seed: u64,
    output: &Path,
    force: bool,
) -> Result<FluidAssembly> {
    let files = BodyFiles::read(bodies)?;
    let placements = fluid(&files, counts, box_angstrom, seed)?;
    let provenance = json!({ "fluid": { "counts": counts, "seed": seed } });
    let file = files.assembly_file(output, &placements, Some(box_angstrom), provenance)?;
    write_assembly(output, &file, force)?;
    let volume_angstrom3: f64 = box_angstrom.iter().product();
    Ok(FluidAssembly {
        assembly: output.to_owned(),
        bodies: placements.len(),
        concentration_millimolar: 1e3 * placements.len() as f64
            / volume_angstrom3
            / NUMBER_DENSITY_PER_MOLAR,
    })
}

/// Inserts bodies one after another ([`protomer_body::assembly::insertion`]). `counts` has the
/// number of bodies of each kind, in the order of `files`. The same seed gives the same fluid.
///
/// # Errors
/// If `counts` does not fit `files`, the box is too small for a body and its own image, or too
/// full.
pub fn fluid(
    files: &BodyFiles,
    counts: &[usize],
    box_angstrom: [f64; 3],
    seed: u64,
) -> Result<Vec<Placement>> {
    if counts.len() != files.bodies.len() {
        bail!(
            "--counts has {} values for {} bodies; give one per body",
            counts.len(),
            files.bodies.len()
        );
    }
    if counts.iter().all(|count| *count == 0) {
        bail!("--counts asks for no bodies; give at least one");
    }
    Ok(files.hard.insert_at_random(counts, box_angstrom, seed)?)
}
