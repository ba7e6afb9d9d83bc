//! The up/down arrangements of a ring or stack that are distinct under its symmetry, and searches of
//! symmetric arrangements for low energies.
//!
//! | module | one idea |
//! |---|---|
//! | `medium` | model and medium of a search |
//! | [`rings`] | tilts and spins of the arrangements of a ring or stack |
//! | [`cages`] | cages of a cubic group |

pub mod cages;
mod medium;
pub mod rings;

pub use medium::SearchMedium;

use crate::assemblies::assemble::{BodyFiles, refuse_another, write_assembly};
use crate::assemblies::assembly_file::AssemblyFile;
use anyhow::{Result, bail};
use protomer_body::assembly::{Candidates, Placement, Stack, Symmetry};
use protomer_common::answer::{Answer, columns, heading};
use serde::Serialize;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Arrangements of a search that are listed at most.
const MOST_LISTED: usize = 100;
/// Arrangements in the table for a reader.
const SHOWN: usize = 20;

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
    let (stack, enumeration) = enumerate(settings)?;
    let Some(folder) = &settings.output else {
        return Ok(CandidatesReport {
            candidates: enumeration,
            assemblies: Vec::new(),
            ring: settings.ring,
        });
    };
    let files = BodyFiles::read(&settings.bodies)?;
    let mut written = Written::new(&files, folder, settings.box_angstrom, settings.force);
    for arrangement in &enumeration.arrangements {
        let recipe = stack.recipe(arrangement);
        let placements = files.hard.close(&recipe, settings.gap_angstrom)?.placements;
        let provenance = json!({
            "arrangement": arrangement, "recipe": recipe, "gap_angstrom": settings.gap_angstrom
        });
        written.add("candidate", &placements, provenance)?;
    }
    let assemblies = written.write()?;
    Ok(CandidatesReport {
        candidates: enumeration,
        assemblies,
        ring: settings.ring,
    })
}

fn enumerate(settings: &CandidatesSettings) -> Result<(Stack, Candidates)> {
    let gap = settings.gap_angstrom;
    if !(gap.is_finite() && gap >= 0.0) {
        bail!("--gap is {gap} Å; give zero or more");
    }
    let kinds = (0..settings.bodies.len()).collect();
    let stack = Stack::new(settings.ring, settings.stack, kinds)?;
    let enumeration = stack.candidates(settings.symmetry);
    Ok((stack, enumeration))
}

/// Assemblies for a folder, which are written when all of them are made.
struct Written<'a> {
    files: &'a BodyFiles,
    folder: &'a Path,
    box_angstrom: Option<[f64; 3]>,
    force: bool,
    assemblies: Vec<(PathBuf, AssemblyFile)>,
}

impl<'a> Written<'a> {
    fn new(
        files: &'a BodyFiles,
        folder: &'a Path,
        box_angstrom: Option<[f64; 3]>,
        force: bool,
    ) -> Self {
        Self {
            files,
            folder,
            box_angstrom,
            force,
            assemblies: Vec::new(),
        }
    }

    /// Adds the assembly `NAME_1.json`, `NAME_2.json` ...
    fn add(&mut self, name: &str, placements: &[Placement], provenance: Value) -> Result<()> {
        self.files.require_room(placements, self.box_angstrom)?;
        let number = self.assemblies.len() + 1;
        let path = self.folder.join(format!("{name}_{number}.json"));
        let file = self
            .files
            .assembly_file(&path, placements, self.box_angstrom, provenance)?;
        refuse_another(&path, &file, self.force)?;
        self.assemblies.push((path, file));
        Ok(())
    }

    fn write(self) -> Result<Vec<PathBuf>> {
        for (path, file) in &self.assemblies {
            write_assembly(path, file, self.force)?;
        }
        Ok(self.assemblies.into_iter().map(|(path, _)| path).collect())
    }
}
