//! Rings, and stacks of two rings, closed to contact.

use crate::assemblies::assemble::{BodyFiles, write_assembly};
use anyhow::{Result, bail};
use protomer_body::assembly::{Recipe, RecipeSite};
use protomer_common::answer::Answer;
use serde::Serialize;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Settings of a ring or a stack of rings.
#[derive(Debug, Clone, PartialEq)]
pub struct RingSettings {
    /// Bodies per ring.
    pub members: usize,
    /// Number of rings: one, or two stacked with dihedral symmetry.
    pub stack: usize,
    /// One site per body file; they alternate around the ring.
    pub pattern: Vec<RecipeSite>,
    /// Gap left between neighbours and between rings, beyond contact, Å.
    pub gap_angstrom: f64,
    /// Periodic box, Å.
    pub box_angstrom: Option<[f64; 3]>,
    /// Whether to overwrite an existing file.
    pub force: bool,
}

/// A ring or stack that was written.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RingAssembly {
    /// The assembly file.
    pub assembly: PathBuf,
    /// Number of bodies in all rings.
    pub bodies: usize,
    /// Radius of a ring, Å.
    pub radius_angstrom: f64,
    /// Distance of the two rings of a stack, Å.
    pub ring_distance_angstrom: f64,
}

impl Answer for RingAssembly {
    fn text(&self) -> String {
        format!(
            "{}: {} bodies, ring radius {:.2} Å, ring distance {:.2} Å",
            self.assembly.display(),
            self.bodies,
            self.radius_angstrom,
            self.ring_distance_angstrom
        )
    }
}

/// Closes a ring or a stack to contact and writes it to an assembly file.
///
/// # Errors
/// If the bodies do not alternate evenly, the recipe does not fit them, or a file cannot be read
/// or written.
pub fn assemble_ring(
    bodies: &[PathBuf],
    settings: &RingSettings,
    output: &Path,
) -> Result<RingAssembly> {
    let files = BodyFiles::read(bodies)?;
    let recipe = recipe(settings)?;
    let closed = files.hard.close(&recipe, settings.gap_angstrom)?;
    let provenance = json!({
        "recipe": recipe, "gap_angstrom": settings.gap_angstrom,
        "radius_angstrom": closed.radius_angstrom,
        "ring_distance_angstrom": closed.ring_distance_angstrom,
    });
    let placements = &closed.placements;
    files.require_room(placements, settings.box_angstrom)?;
    let file = files.assembly_file(output, placements, settings.box_angstrom, provenance)?;
    write_assembly(output, &file, settings.force)?;
    Ok(RingAssembly {
        assembly: output.to_owned(),
        bodies: placements.len(),
        radius_angstrom: closed.radius_angstrom,
        ring_distance_angstrom: closed.ring_distance_angstrom,
    })
}

fn recipe(settings: &RingSettings) -> Result<Recipe> {
    let (members, kinds) = (settings.members, settings.pattern.len());
    let gap = settings.gap_angstrom;
    if !(gap.is_finite() && gap >= 0.0) {
        bail!("--gap is {gap} Å; give zero or more");
    }
    if members == 1 && settings.stack == 1 {
        bail!("a ring of one body is no assembly; give --members 2 or more");
    }
    let recipe = match settings.stack {
        1 => Recipe::ring(members, &settings.pattern),
        2 => Recipe::dihedral(members, &settings.pattern),
        other => bail!("--stack is {other}; one ring or a stack of two can be closed"),
    };
    if !members.is_multiple_of(kinds) {
        bail!(
            "{kinds} bodies do not alternate evenly in a ring of {members}; choose a multiple of \
             {kinds} for --members"
        );
    }
    Ok(recipe)
}
