//! Search of the tilts and spins of all arrangements of a ring or stack for low energies.

use super::{CandidatesSettings, MOST_LISTED, SHOWN, SearchMedium, Written, enumerate, letters};
use crate::assemblies::assemble::BodyFiles;
use crate::assemblies::search::ring::{FoundRing, Pattern, RingGrid, search_rings};
use crate::assemblies::search::{Found, Searched};
use crate::stability::interaction::ScreenedCoulomb;
use anyhow::{Result, bail};
use protomer_common::answer::{Answer, columns, heading};
use protomer_kernel::setting::Choices;
use protomer_results::{End, Execution};
use serde::Serialize;
use serde_json::json;
use std::path::PathBuf;

/// Arrangements of low energy.
#[derive(Debug, Clone, Serialize)]
pub struct SearchReport {
    /// The arrangements, the lowest energy first; at most a hundred.
    pub arrangements: Vec<FoundRing>,
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

/// Searches the tilts and spins of all arrangements for low energies, and refines this many of the lowest. If a
/// folder is given, the refined ones are written there as assemblies.
///
/// # Errors
/// As [`candidates`](super::candidates); for a medium without screening, and bodies without what a term needs.
pub fn search_candidates(
    settings: &CandidatesSettings,
    grid: &RingGrid,
    refined: usize,
    medium: &SearchMedium,
    execution: &Execution,
) -> Result<End<SearchReport>> {
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
    let (potentials, model) = medium.potentials(&files)?;
    let patterns: Vec<Pattern> = enumeration
        .arrangements
        .iter()
        .map(|arrangement| Pattern {
            up: arrangement.up.clone(),
            recipe: stack.recipe(arrangement),
        })
        .collect();
    let searched = Searched {
        bodies: &files.hard,
        potentials,
        gap_angstrom: settings.gap_angstrom,
        refined,
    };
    let Some(found) = search_rings(searched, &patterns, grid, execution)? else {
        return Ok(End::Stopped);
    };
    let assemblies = write(settings, &files, &found.arrangements)?;
    let Found {
        mut arrangements,
        evaluated,
        unusable,
        cpu_seconds,
    } = found;
    let different = arrangements.len();
    arrangements.truncate(MOST_LISTED);
    Ok(End::Finished(SearchReport {
        arrangements,
        different,
        evaluated,
        unusable,
        patterns: patterns.len(),
        arrangements_per_cpu_second: evaluated as f64 / cpu_seconds.max(1e-9),
        model,
        interaction: medium.interaction,
        assemblies,
        ring: settings.ring,
    }))
}

/// Writes the refined arrangements.
fn write(
    settings: &CandidatesSettings,
    files: &BodyFiles,
    found: &[FoundRing],
) -> Result<Vec<PathBuf>> {
    let Some(folder) = &settings.output else {
        return Ok(Vec::new());
    };
    let gap_angstrom = settings.gap_angstrom;
    let mut written = Written::new(files, folder, settings.box_angstrom, settings.force);
    for arrangement in found.iter().filter(|found| found.is_refined) {
        let recipe = &arrangement.recipe;
        let placements = files.hard.close(recipe, gap_angstrom)?.placements;
        let provenance = json!({
            "arrangement": arrangement, "recipe": recipe, "gap_angstrom": gap_angstrom
        });
        written.add("arrangement", &placements, provenance)?;
    }
    written.write()
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
