//! The up/down arrangements of a ring or stack that are distinct under its symmetry, and the search of
//! their tilts and spins for low energies.

use crate::assemblies::assemble::{BodyFiles, refuse_another, write_assembly};
use crate::assemblies::assembly_file::Assembly;
use crate::assemblies::search::{Found, FoundArrangement, Pattern, SearchSettings, search};
use crate::stability::interaction::ScreenedCoulomb;
use crate::stability::run::{Engine, RunSettings};
use anyhow::{Result, bail};
use protomer_body::assembly::{Candidates, Recipe, Stack, Symmetry};
use protomer_common::answer::{Answer, columns, heading};
use protomer_kernel::setting::Choices;
use protomer_kernel::{Boundary, Pose};
use protomer_results::{End, Execution};
use serde::Serialize;
use serde_json::json;
use std::path::PathBuf;
use std::sync::Arc;

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
    let recipes = enumeration.arrangements.iter().map(|arrangement| {
        let recipe = stack.recipe(arrangement);
        let provenance = json!({
            "arrangement": arrangement, "recipe": recipe, "gap_angstrom": settings.gap_angstrom
        });
        (recipe, provenance)
    });
    let assemblies = match settings.output {
        Some(_) => {
            let files = BodyFiles::read(&settings.bodies)?;
            write(settings, &files, "candidate", recipes.collect())?
        }
        None => Vec::new(),
    };
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

/// Closes recipes to contact and writes them as assemblies `NAME_1.json`, `NAME_2.json` ...
fn write(
    settings: &CandidatesSettings,
    files: &BodyFiles,
    name: &str,
    recipes: Vec<(Recipe, serde_json::Value)>,
) -> Result<Vec<PathBuf>> {
    let Some(folder) = &settings.output else {
        return Ok(Vec::new());
    };
    let mut written = Vec::new();
    for (index, (recipe, provenance)) in recipes.into_iter().enumerate() {
        let placements = files.hard.close(&recipe, settings.gap_angstrom)?.placements;
        files.require_room(&placements, settings.box_angstrom)?;
        let path = folder.join(format!("{name}_{}.json", index + 1));
        let file = files.assembly_file(&path, &placements, settings.box_angstrom, provenance)?;
        refuse_another(&path, &file, settings.force)?;
        written.push((path, file));
    }
    for (path, file) in &written {
        write_assembly(path, file, settings.force)?;
    }
    Ok(written.into_iter().map(|(path, _)| path).collect())
}

/// Model and medium of a search.
pub struct SearchMedium<'a> {
    /// The terms of the energy.
    pub run: &'a RunSettings,
    /// Medium between the bodies.
    pub interaction: ScreenedCoulomb,
    /// Makes the engine of an assembly, with the tables and the cache of the caller.
    pub prepare: &'a dyn Fn(Assembly) -> Result<Engine>,
}

/// Arrangements of low energy.
#[derive(Debug, Clone, Serialize)]
pub struct SearchReport {
    /// The arrangements, the lowest energy first; at most a hundred.
    pub arrangements: Vec<FoundArrangement>,
    /// Different arrangements that were found.
    pub different: usize,
    /// Arrangements that were tried.
    pub evaluated: usize,
    /// Arrangements of the grid that cannot be closed, because bodies interlock.
    pub unusable: usize,
    /// Up/down patterns that were searched.
    pub patterns: usize,
    /// Arrangements for each second of processor time.
    pub arrangements_per_cpu_second: f64,
    /// Name of the model whose terms the energies have, or `own terms`.
    pub model: &'static str,
    /// Medium between the bodies.
    #[serde(flatten)]
    pub interaction: ScreenedCoulomb,
    /// Assembly files of the refined arrangements, if any were written.
    pub assemblies: Vec<PathBuf>,
    #[serde(skip)]
    ring: usize,
}

/// Searches the tilts and spins of all arrangements for low energies. If a folder is given, the refined ones are
/// written there as assemblies.
///
/// # Errors
/// As [`candidates`]; for a medium without screening, and bodies without what a term needs.
pub fn search_candidates(
    settings: &CandidatesSettings,
    grid: &SearchSettings,
    medium: &SearchMedium,
    execution: &Execution,
) -> Result<End<SearchReport>> {
    if medium
        .interaction
        .yukawa()?
        .inverse_debye_length_per_angstrom
        <= 0.0
    {
        bail!("the charges have no screening without salt; give a --salt above zero");
    }
    let (stack, enumeration) = enumerate(settings)?;
    if enumeration.arrangements.is_empty() {
        bail!(
            "no up/down arrangement of {} bodies in {} ring(s) of {} has the symmetry '{}'; try --symmetry cyclic \
             or none",
            settings.ring * settings.stack,
            settings.stack,
            settings.ring,
            settings.symmetry.name()
        );
    }
    let files = BodyFiles::read(&settings.bodies)?;
    let kinds = files.bodies.len();
    let bodies: Vec<_> = files.bodies.iter().cloned().map(Arc::new).collect();
    let engine = (medium.prepare)(Assembly {
        bodies: bodies.clone(),
        kinds: (0..kinds).collect(),
        poses: vec![Pose::identity(); kinds],
        boundary: Boundary::Open,
        sha256: String::new(),
        path: None,
    })?;
    let engine = engine.in_medium(medium.run, &medium.interaction)?;
    let potentials = engine.pair_potentials(&medium.interaction)?;
    let patterns: Vec<Pattern> = enumeration
        .arrangements
        .iter()
        .map(|arrangement| Pattern {
            up: arrangement.up.clone(),
            recipe: stack.recipe(arrangement),
        })
        .collect();
    let Some(found) = search(&files.hard, potentials, &patterns, grid, execution)? else {
        return Ok(End::Stopped);
    };
    let Found {
        mut arrangements,
        evaluated,
        unusable,
        cpu_seconds,
    } = found;
    let different = arrangements.len();
    let refined = arrangements.iter().filter(|found| found.is_refined);
    let recipes = refined.map(|found| {
        let provenance = json!({
            "arrangement": found, "recipe": found.recipe, "gap_angstrom": settings.gap_angstrom
        });
        (found.recipe.clone(), provenance)
    });
    let assemblies = write(settings, &files, "arrangement", recipes.collect())?;
    arrangements.truncate(MOST_LISTED);
    Ok(End::Finished(SearchReport {
        arrangements,
        different,
        evaluated,
        unusable,
        patterns: patterns.len(),
        arrangements_per_cpu_second: evaluated as f64 / cpu_seconds.max(1e-9),
        model: medium.run.model_name(&bodies),
        interaction: medium.interaction,
        assemblies,
        ring: settings.ring,
    }))
}

impl Answer for SearchReport {
    fn text(&self) -> String {
        let names = [
            "",
            "directions",
            "tilt (°)",
            "spin (°)",
            "stagger",
            "radius (Å)",
            "ring distance (Å)",
            "energy (kT)",
            "assembly",
        ];
        let mut rows = vec![heading(names)];
        let mut assemblies = self.assemblies.iter();
        for (number, found) in self.arrangements.iter().take(SHOWN).enumerate() {
            let rings: Vec<String> = found.up.chunks(self.ring).map(letters).collect();
            let degrees = |angles: &[f64]| {
                let all: Vec<String> = angles.iter().map(|angle| format!("{angle:.0}")).collect();
                all.join(", ")
            };
            let assembly = match found.is_refined {
                true => assemblies.next().map(|path| path.display().to_string()),
                false => Some("not refined".into()),
            };
            rows.push(vec![
                (number + 1).to_string(),
                rings.join(" / "),
                degrees(&found.tilt_degrees),
                degrees(&found.spin_degrees),
                format!("{:.2}", found.stagger),
                format!("{:.1}", found.radius_angstrom),
                format!("{:.1}", found.ring_distance_angstrom),
                format!("{:.1}", found.energy_kt),
                assembly.unwrap_or_default(),
            ]);
        }
        format!(
            "{} up/down patterns, {} arrangements, {} different\nmodel: {}; medium: {}\n{}",
            self.patterns,
            self.evaluated,
            self.different,
            self.model,
            self.interaction.describe(),
            columns(&rows)
        )
    }
}
