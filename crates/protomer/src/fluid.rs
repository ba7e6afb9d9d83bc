//! A fluid: bodies at random places and in random orientations in a periodic box, none overlapping
//! another.

use crate::assemble::BodyFiles;
use anyhow::{Result, bail};
use protomer_body::assembly::Placement;

/// Bodies inserted one after the other ([`protomer_body::assembly::insertion`]). `counts` has the
/// number of bodies of each kind, in the order of `files`. The same seed gives the same fluid.
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
    Ok(files.hard.insert_at_random(counts, box_angstrom, seed)?)
}
