//! A fluid: bodies at random places and in random orientations in a periodic box, none overlapping
//! another.

use crate::answer::Answer;
use crate::assemblies::assemble::{BodyFiles, write_assembly};
use anyhow::{Result, bail};
use protomer_body::assembly::Placement;
use protomer_kernel::random::CounterRng;
use protomer_kernel::units::NUMBER_DENSITY_PER_MOLAR;
use protomer_kernel::{Boundary, Pose, Vec3};
use serde::Serialize;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Places tried for one body before the box counts as full.
pub const ATTEMPTS_PER_BODY: u64 = 10_000;

/// Sets these random numbers apart from those of a simulation with the same seed.
const PURPOSE: u8 = 1;

/// A fluid that was written.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FluidAssembly {
    /// The assembly file.
    pub assembly: PathBuf,
    /// Bodies.
    pub bodies: usize,
    /// Their concentration, mmol/L.
    pub concentration_millimolar: f64,
}

impl Answer for FluidAssembly {
    fn text(&self) -> String {
        format!(
            "{}: {} bodies at random places, {:.3} mM",
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
pub fn assemble_fluid(
    bodies: &[PathBuf],
    counts: &[usize],
    box_angstrom: [f64; 3],
    seed: u64,
    output: &Path,
) -> Result<FluidAssembly> {
    let files = BodyFiles::read(bodies)?;
    let placements = fluid(&files, counts, box_angstrom, seed)?;
    let provenance = json!({ "fluid": { "counts": counts, "seed": seed } });
    let file = files.assembly_file(output, &placements, Some(box_angstrom), provenance)?;
    write_assembly(output, &file)?;
    let volume_angstrom3: f64 = box_angstrom.iter().product();
    Ok(FluidAssembly {
        assembly: output.to_owned(),
        bodies: placements.len(),
        concentration_millimolar: 1e3 * placements.len() as f64
            / volume_angstrom3
            / NUMBER_DENSITY_PER_MOLAR,
    })
}

/// Bodies inserted one after the other: body n of the fluid is placed uniformly at random, position
/// and orientation, until it overlaps none of the bodies before it nor one of their images (random
/// sequential insertion). While the fluid is dilute this is close to the equilibrium of hard
/// bodies; a dense one is left to a run with `--energy none`.
///
/// `counts` has the number of bodies of each kind, in the order of `files`; the first kind comes
/// first. The same seed gives the same fluid.
///
/// # Errors
/// If `counts` does not fit `files`, the box is too small for a body beside its own image, or it is
/// too full.
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
        bail!("--counts asks for no body at all; give at least one");
    }
    let boundary = Boundary::periodic(Vec3::from(box_angstrom))?;
    require_room(files, counts, &boundary)?;
    let mut placements: Vec<Placement> = Vec::new();
    for kind in counts
        .iter()
        .enumerate()
        .flat_map(|(kind, count)| std::iter::repeat_n(kind, *count))
    {
        let inserted = placements.len();
        let mut trials = (0..ATTEMPTS_PER_BODY)
            .map(|attempt| (kind, random_pose(seed, inserted, attempt, box_angstrom)));
        match trials.find(|trial| !files.overlaps_any(trial, &placements, &boundary)) {
            Some(placement) => placements.push(placement),
            None => bail!(
                "no room for body {} in the box after {ATTEMPTS_PER_BODY} attempts; enlarge --box, or ask for fewer bodies",
                inserted + 1
            ),
        }
    }
    Ok(placements)
}

/// The bodies must fit in by volume. Only the nearest image of a pair is looked at, so no body may
/// reach two images of another: an edge must hold two diameters of the largest.
fn require_room(files: &BodyFiles, counts: &[usize], boundary: &Boundary) -> Result<()> {
    let placed = || {
        files
            .bodies
            .iter()
            .zip(counts)
            .filter(|(_, count)| **count > 0)
    };
    let volume: f64 = placed()
        .map(|(body, count)| body.mass_properties.volume_angstrom3 * *count as f64)
        .sum();
    if volume > boundary.volume_angstrom3() {
        bail!(
            "--counts asks for {volume:.3e} Å³ of bodies in a box of {:.3e} Å³; enlarge --box, or ask for fewer bodies",
            boundary.volume_angstrom3()
        );
    }
    let diameter = placed()
        .map(|(body, _)| 2.0 * body.mesh_radius_angstrom())
        .fold(0.0, f64::max);
    if boundary.smallest_length_angstrom() < 2.0 * diameter {
        bail!(
            "--box has an edge of {} Å, and the largest body a diameter of {diameter:.1} Å; an edge must hold two",
            boundary.smallest_length_angstrom()
        );
    }
    Ok(())
}

/// A stream of random numbers for each attempt at each body.
fn random_pose(seed: u64, body: usize, attempt: u64, box_angstrom: [f64; 3]) -> Pose {
    let mut rng = CounterRng::for_purpose(seed, body as u32, attempt, PURPOSE);
    let position = Vec3::from(box_angstrom.map(|edge| rng.uniform_in(-0.5 * edge, 0.5 * edge)));
    Pose {
        position,
        rotation: rng.rotation(),
    }
}
