//! Search of cages of a cubic group for low energies.

use super::{MOST_LISTED, SHOWN, SearchMedium, Written};
use crate::assemblies::assemble::BodyFiles;
use crate::assemblies::search::cage::{CageSamples, FoundCage, search_cages};
use crate::assemblies::search::{Found, Searched};
use crate::stability::interaction::ScreenedCoulomb;
use anyhow::{Result, bail};
use protomer_body::assembly::CubicGroup;
use protomer_common::answer::{Answer, columns, heading};
use protomer_kernel::setting::Choices;
use protomer_results::{End, Execution};
use serde::Serialize;
use serde_json::json;
use std::path::PathBuf;

/// Settings of a search of cages.
#[derive(Debug, Clone, PartialEq)]
pub struct CagesSettings {
    /// Body files, one for each kind.
    pub bodies: Vec<PathBuf>,
    /// The group.
    pub group: CubicGroup,
    /// Number of random starting points.
    pub samples: usize,
    /// Number of the lowest cages that are refined.
    pub refined: usize,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Gap between the nearest bodies beyond contact, Å.
    pub gap_angstrom: f64,
    /// Periodic box, Å.
    pub box_angstrom: Option<[f64; 3]>,
    /// Folder for the refined cages; with `None` they are only listed.
    pub output: Option<PathBuf>,
    /// Whether to overwrite existing files.
    pub force: bool,
}

/// Cages of low energy.
#[derive(Debug, Clone, Serialize)]
pub struct CagesReport {
    /// The cages, the lowest energy first; at most a hundred.
    pub cages: Vec<FoundCage>,
    /// Different cages that were found.
    pub different: usize,
    /// Cages that were tried.
    pub evaluated: usize,
    /// Starting points that cannot be closed, because bodies interlock.
    pub unusable: usize,
    /// Cages for each second of processor time.
    pub cages_per_cpu_second: f64,
    /// Name of the model whose terms the energies have, or `own terms`.
    pub model: &'static str,
    /// Medium between the bodies.
    #[serde(flatten)]
    pub interaction: ScreenedCoulomb,
    /// Assembly files of the refined cages, if any were written.
    pub assemblies: Vec<PathBuf>,
}

/// Searches cages of a group for low energies. If a folder is given, the refined ones are written there as
/// assemblies.
///
/// # Errors
/// If a file cannot be read or written; for a medium without screening, bodies without what a term needs, and a
/// gap that is no length.
pub fn search_cage_candidates(
    settings: &CagesSettings,
    medium: &SearchMedium,
    execution: &Execution,
) -> Result<End<CagesReport>> {
    let gap_angstrom = settings.gap_angstrom;
    if !(gap_angstrom.is_finite() && gap_angstrom >= 0.0) {
        bail!("--gap is {gap_angstrom} Å; give zero or more");
    }
    let files = BodyFiles::read(&settings.bodies)?;
    let (potentials, model) = medium.potentials(&files)?;
    let searched = Searched {
        bodies: &files.hard,
        potentials,
        gap_angstrom,
        refined: settings.refined,
    };
    let samples = CageSamples {
        group: settings.group,
        kinds: files.bodies.len(),
        samples: settings.samples,
        seed: settings.seed,
    };
    let Some(found) = search_cages(searched, &samples, execution) else {
        return Ok(End::Stopped);
    };
    if found.arrangements.is_empty() {
        bail!(
            "none of {} cages can be closed; give more --samples",
            found.evaluated
        );
    }
    let assemblies = write(settings, &files, &found.arrangements)?;
    let Found {
        arrangements: mut cages,
        evaluated,
        unusable,
        cpu_seconds,
    } = found;
    let different = cages.len();
    cages.truncate(MOST_LISTED);
    Ok(End::Finished(CagesReport {
        cages,
        different,
        evaluated,
        unusable,
        cages_per_cpu_second: evaluated as f64 / cpu_seconds.max(1e-9),
        model,
        interaction: medium.interaction,
        assemblies,
    }))
}

/// Writes the refined cages.
fn write(settings: &CagesSettings, files: &BodyFiles, found: &[FoundCage]) -> Result<Vec<PathBuf>> {
    let Some(folder) = &settings.output else {
        return Ok(Vec::new());
    };
    let mut written = Written::new(files, folder, settings.box_angstrom, settings.force);
    for each in found.iter().filter(|each| each.is_refined) {
        let provenance = json!({
            "arrangement": each, "cage": each.cage, "gap_angstrom": settings.gap_angstrom
        });
        written.add("cage", &each.placements, provenance)?;
    }
    written.write()
}

impl Answer for CagesReport {
    fn text(&self) -> String {
        let names = [
            "",
            "group",
            "bodies",
            "radius (Å)",
            "energy (kT)",
            "for each body (kT)",
            "assembly",
        ];
        let mut rows = vec![heading(names)];
        let mut assemblies = self.assemblies.iter();
        for (number, found) in self.cages.iter().take(SHOWN).enumerate() {
            let assembly = match found.is_refined {
                true => assemblies.next().map(|path| path.display().to_string()),
                false => Some("not refined".into()),
            };
            rows.push(vec![
                (number + 1).to_string(),
                found.group.name().to_owned(),
                found.bodies.to_string(),
                format!("{:.1}", found.radius_angstrom),
                format!("{:.1}", found.energy_kt),
                format!("{:.2}", found.energy_per_body_kt),
                assembly.unwrap_or_default(),
            ]);
        }
        format!(
            "{} cages, {} different\nmodel: {}; medium: {}\n{}",
            self.evaluated,
            self.different,
            self.model,
            self.interaction.describe(),
            columns(&rows)
        )
    }
}
