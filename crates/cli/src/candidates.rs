//! `protomer candidates`: the up/down arrangements of a ring or stack that are different under its
//! symmetry.

use super::assemble::SpaceArgs;
use super::{Global, Outcome, output};
use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use protomer::assemblies::assemble::{BodyFiles, write_assembly};
use protomer_body::assembly::{Stack, Symmetry};
use std::path::PathBuf;

/// Enumerate the up/down arrangements of bodies in a ring or a stack of two rings that are
/// different under the stack's own symmetry, and write each as an assembly closed to contact.
#[derive(Debug, Args)]
pub struct CandidatesArgs {
    /// Body files, in the order in which they alternate.
    #[arg(required = true)]
    bodies: Vec<PathBuf>,
    /// Bodies per ring.
    #[arg(long)]
    ring: usize,
    /// Rings: one or two.
    #[arg(long, default_value_t = 1)]
    stack: usize,
    /// Symmetry asked of an arrangement.
    #[arg(long, value_enum, default_value_t = Asked::Dihedral)]
    symmetry: Asked,
    /// How much further apart than at contact neighbours around the ring, and the rings, are
    /// placed, Å.
    #[arg(long, default_value_t = 0.5)]
    gap: f64,
    #[command(flatten)]
    space: SpaceArgs,
    /// Folder for the assemblies; only counted if left out.
    #[arg(short, long)]
    output: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Asked {
    /// None: every arrangement that differs in its contacts.
    None,
    /// All rotations about the axis.
    Cyclic,
    /// The whole group, half turns included.
    Dihedral,
}

impl CandidatesArgs {
    pub(super) fn run(&self, global: &Global) -> Result<Outcome> {
        let symmetry = match self.symmetry {
            Asked::None => Symmetry::None,
            Asked::Cyclic => Symmetry::Cyclic,
            Asked::Dihedral => Symmetry::Dihedral,
        };
        if !(self.gap.is_finite() && self.gap >= 0.0) {
            bail!("--gap is {} Å; give zero or more", self.gap);
        }
        let stack = Stack::new(self.ring, self.stack, (0..self.bodies.len()).collect())?;
        let found = stack.candidates(symmetry);
        let mut written = Vec::new();
        if let Some(folder) = &self.output {
            let files = BodyFiles::read(&self.bodies)?;
            for (index, arrangement) in found.arrangements.iter().enumerate() {
                let recipe = stack.recipe(arrangement);
                let closed = files.close(&recipe, self.gap)?;
                let path = folder.join(format!("candidate_{}.json", index + 1));
                let provenance = serde_json::json!({"arrangement": arrangement, "recipe": recipe, "gap_angstrom": self.gap});
                let space = self.space.box_angstrom()?;
                write_assembly(
                    &path,
                    &files.assembly_file(&path, &closed.placements, space, provenance)?,
                )?;
                written.push(path);
            }
        }
        if global.json {
            output::json(&serde_json::json!({"candidates": found, "assemblies": written}))?;
            return Ok(Outcome::Done);
        }
        let mut rows = vec![
            ["candidate", "directions", "equivalent"]
                .map(str::to_owned)
                .to_vec(),
        ];
        for (index, arrangement) in found.arrangements.iter().enumerate() {
            let rings: Vec<String> = arrangement.up.chunks(self.ring).map(letters).collect();
            rows.push(vec![
                (index + 1).to_string(),
                rings.join(" / "),
                arrangement.equivalent.to_string(),
            ]);
        }
        output::text(&format!(
            "{} arrangements, {} of the symmetry asked for, {} different under a group of order {}, {} in their contacts\n{}",
            found.total,
            found.symmetric,
            found.distinct,
            found.group_order,
            found.arrangements.len(),
            output::table(&rows)
        ))?;
        Ok(Outcome::Done)
    }
}

fn letters(up: &[bool]) -> String {
    up.iter().map(|up| if *up { 'u' } else { 'd' }).collect()
}
