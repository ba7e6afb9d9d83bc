//! Protons that two bodies take up when they bind, by titrations of the complex and of each body.

use super::input::{Content, Inputs};
use super::settings::BindingSettings;
use anyhow::{Result, bail};
use protomer_body::chemistry::titration::titratable_sites;
use protomer_body::structure::Selection;
use protomer_field::titration::{TitratingGroups, TitrationModel, group_energies, solve_settings};
use protomer_results::{End, Execution};

/// The groups of the complex and of its two bodies, at each salt.
pub(super) struct ProtonUptake(Vec<[TitratingGroups; 3]>);

impl ProtonUptake {
    /// Solves for the groups at every salt. Nothing of it depends on the pH.
    ///
    /// # Errors
    /// For bodies that are no structures, and as [`group_energies`].
    pub fn new(
        inputs: &Inputs,
        settings: &BindingSettings,
        execution: &Execution,
    ) -> Result<End<Self>> {
        let mut parts = Vec::new();
        for input in &inputs.inputs {
            let Content::Residues(selection, _) = &input.content else {
                bail!(
                    "--proton-uptake titrates structures, but {} has charges of one protonation state; give \
                     the structure file (PDB, mmCIF), or leave it out",
                    input.file
                );
            };
            parts.push((**selection).clone());
        }
        let solutes = [joined(&parts), parts[0].clone(), parts[1].clone()];
        let solutes = solutes.map(|selection| titratable_sites(&selection));
        let groups: usize = solutes.iter().map(|sites| sites.groups.len()).sum();
        let total = groups * settings.salt_molar.len();
        execution.progress.begin(total as u64, "groups");
        let model = TitrationModel {
            anion_binding_per_molar: settings
                .titration
                .map_or(0.0, |titration| titration.anion_binding_per_molar),
            ..TitrationModel::default()
        };
        let advance = || {
            execution.progress.advance(1);
            !execution.interrupt.is_requested()
        };
        let mut at_salts = Vec::new();
        for salt_molar in &settings.salt_molar {
            let electrolyte = settings
                .medium()
                .interaction(Some(*salt_molar))?
                .electrolyte;
            let dielectric = model.dielectric(electrolyte);
            let mut solved = Vec::new();
            for sites in &solutes {
                let energies = group_energies(sites, &dielectric, &solve_settings(), &advance)?;
                if execution.interrupt.is_requested() {
                    return Ok(End::Stopped);
                }
                solved.push(model.groups(sites, &energies, *salt_molar));
            }
            at_salts.extend(<[TitratingGroups; 3]>::try_from(solved).ok());
        }
        Ok(End::Finished(Self(at_salts)))
    }

    /// Protons of the complex less those of both bodies at a pH and the salt of this number.
    pub fn value_at(&self, ph: f64, salt: usize) -> Option<f64> {
        let [complex, first, second] = self.0.get(salt)?;
        Some(complex.protons(ph) - first.protons(ph) - second.protons(ph))
    }
}

/// The residues of both bodies.
fn joined(parts: &[Selection]) -> Selection {
    let mut complex = parts[0].clone();
    for part in &parts[1..] {
        complex.residues.extend(part.residues.iter().cloned());
    }
    complex
}
