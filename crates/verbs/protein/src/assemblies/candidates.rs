//! The up/down arrangements of a ring or stack that are distinct under its symmetry.

use crate::assemblies::assemble::{BodyFiles, refuse_another, write_assembly};
use anyhow::{Result, bail};
use protomer_body::assembly::{Candidates, Stack, Symmetry};
use protomer_common::answer::{Answer, columns, heading};
use serde::Serialize;
use serde_json::json;
use std::path::PathBuf;

/// Settings for the enumeration of arrangements.
#[derive(Debug, Clone, PartialEq)]
pub struct CandidatesSettings {
    /// Body files, in the order in which they alternate.
    pub bodies: Vec<PathBuf>,
    /// Bodies per ring.
    pub ring: usize,
    /// Number of rings: one or two.
    pub stack: usize,
    /// Symmetry required of an arrangement.
    pub symmetry: Symmetry,
    /// Gap left between neighbours and between rings, beyond contact, Å.
    pub gap_angstrom: f64,
    /// Periodic box, Å.
    pub box_angstrom: Option<[f64; 3]>,
    /// Folder for one assembly file per arrangement; with `None` they are only counted.
    pub output: Option<PathBuf>,
    /// Whether to overwrite existing files.
    pub force: bool,
}

/// The arrangements that were found.
#[derive(Debug, Clone, Serialize)]
pub struct CandidatesReport {
    /// The arrangements.
    pub candidates: Candidates,
    /// Assembly files of the arrangements, if any were written.
    pub assemblies: Vec<PathBuf>,
    #[serde(skip)]
    ring: usize,
}

impl Answer for CandidatesReport {
    fn text(&self) -> String {
        let enumeration = &self.candidates;
        let mut rows = vec![heading(["candidate", "directions", "equivalent"])];
        for (index, arrangement) in enumeration.arrangements.iter().enumerate() {
            let rings: Vec<String> = arrangement.up.chunks(self.ring).map(letters).collect();
            rows.push(vec![
                (index + 1).to_string(),
                rings.join(" / "),
                arrangement.equivalent.to_string(),
            ]);
        }
        format!(
            "{} arrangements, {} of the required symmetry, {} distinct under a group of order {}, \
             {} with distinct contacts\n{}",
            enumeration.total,
            enumeration.symmetric,
            enumeration.distinct,
            enumeration.group_order,
            enumeration.arrangements.len(),
            columns(&rows)
        )
    }
}

fn letters(up: &[bool]) -> String {
    up.iter().map(|up| if *up { 'u' } else { 'd' }).collect()
}

/// Enumerates the arrangements. If a folder is given, closes each to contact and writes it there.
///
/// # Errors
/// If the numbers do not describe a ring or stack, a recipe does not fit the bodies, or a file
/// cannot be read or written.
///
/// ```no_run
/// use protomer_common::answer::Answer;
/// use protomer_protein_verbs::assemblies::candidates::{CandidatesSettings, candidates};
/// use protomer_body::assembly::Symmetry;
/// let settings = CandidatesSettings {
///     bodies: vec!["a.body".into(), "b.body".into()],
///     ring: 6,
///     stack: 2,
///     symmetry: Symmetry::Dihedral,
///     gap_angstrom: 0.5,
///     box_angstrom: None,
///     output: None,
///     force: false,
/// };
/// println!("{}", candidates(&settings)?.text());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn candidates(settings: &CandidatesSettings) -> Result<CandidatesReport> {
    let gap = settings.gap_angstrom;
    if !(gap.is_finite() && gap >= 0.0) {
        bail!("--gap is {gap} Å; give zero or more");
    }
    let kinds = (0..settings.bodies.len()).collect();
    let stack = Stack::new(settings.ring, settings.stack, kinds)?;
    let enumeration = stack.candidates(settings.symmetry);
    let assemblies = write(settings, &stack, &enumeration)?;
    Ok(CandidatesReport {
        candidates: enumeration,
        assemblies,
        ring: settings.ring,
    })
}

fn write(
    settings: &CandidatesSettings,
    stack: &Stack,
    enumeration: &Candidates,
) -> Result<Vec<PathBuf>> {
    let Some(folder) = &settings.output else {
        return Ok(Vec::new());
    };
    let gap = settings.gap_angstrom;
    let files = BodyFiles::read(&settings.bodies)?;
    let mut written = Vec::new();
    for (index, arrangement) in enumeration.arrangements.iter().enumerate() {
        let recipe = stack.recipe(arrangement);
        let placements = files.hard.close(&recipe, gap)?.placements;
        files.require_room(&placements, settings.box_angstrom)?;
        let path = folder.join(format!("candidate_{}.json", index + 1));
        let provenance = json!({"arrangement": arrangement, "recipe": recipe, "gap_angstrom": gap});
        let file = files.assembly_file(&path, &placements, settings.box_angstrom, provenance)?;
        refuse_another(&path, &file, settings.force)?;
        written.push((path, file));
    }
    for (path, file) in &written {
        write_assembly(path, file, settings.force)?;
    }
    Ok(written.into_iter().map(|(path, _)| path).collect())
}
