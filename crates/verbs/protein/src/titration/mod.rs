//! pKa values, charges and the titration curve of the proteins in a structure file.
//!
//! ```text
//! structure --selection, hydrogens (body)--> groups --one solve each (field)--> energies
//! energies --equilibrium (field)--> pKa values, net charge against pH, isoelectric point
//! ```
//!
//! | module | one idea |
//! |---|---|
//! | `ph_range` | the values of the pH, read from text |
//! | `shifts` | what shifts a pKa, term by term |
//! | `answer` | the answer: text, tables, figure |
//! | `directory` | its files, with the record of their kind |
//! | [`page`] | what the page of its directory shows |

mod answer;
mod directory;
pub mod page;
mod ph_range;
mod shifts;

pub use answer::{CurvePoint, GroupRow, Neighbour, TitrationReport};
pub use ph_range::PhRange;

use crate::file_kind::FileKind;
use anyhow::{Context, Result, bail};
use protomer_body::chemistry::titration::{TitratableSites, titratable_sites};
use protomer_body::chemistry::{SiteSettings, build_sites};
use protomer_body::structure::{Selection, SelectionSettings, Structure};
use protomer_body::structure_warnings;
use protomer_common::input::InputFile;
use protomer_field::titration::{TitratingGroups, TitrationModel, group_energies, solve_settings};
use protomer_kernel::Electrolyte;
use protomer_results::{End, Execution};
use rayon::prelude::*;
use std::path::PathBuf;
use std::time::Instant;

/// Temperature of the pKa values in water, K.
const FITTED_KELVIN: f64 = 298.15;
/// Difference from it without a warning, K.
const TOLERATED_KELVIN: f64 = 15.0;

/// Settings of [`titrate`].
///
/// ```no_run
/// use protomer_protein_verbs::titration::{TitrateSettings, titrate};
/// use protomer_results::Execution;
/// let settings = TitrateSettings::new("5pti.cif.gz".into(), 0.1)?;
/// let end = titrate(&settings, &Execution::default())?;
/// for group in end.finished().into_iter().flat_map(|report| report.groups) {
///     println!("{} {}: {:?}", group.residue, group.residue_number, group.pka);
/// }
/// # Ok::<(), anyhow::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct TitrateSettings {
    /// Structure file (PDB, mmCIF).
    pub input: PathBuf,
    /// The part of the structure that is titrated.
    pub selection: SelectionSettings,
    /// Values of the pH.
    pub ph: PhRange,
    /// Solvent and salt.
    pub electrolyte: Electrolyte,
    /// Numbers of the model.
    pub model: TitrationModel,
    /// Directory for tables, JSON and figure.
    pub output: Option<PathBuf>,
    /// Whether existing files are replaced.
    pub force: bool,
}

impl TitrateSettings {
    /// Default settings for a file in water at 298.15 K with a salt concentration in mol/L.
    ///
    /// # Errors
    /// For a concentration out of range.
    pub fn new(input: PathBuf, salt_molar: f64) -> Result<Self> {
        Ok(Self {
            input,
            selection: SelectionSettings::default(),
            ph: PhRange::default(),
            electrolyte: Electrolyte::in_water(298.15, salt_molar)?,
            model: TitrationModel::default(),
            output: None,
            force: false,
        })
    }
}

/// Titrates the groups of a structure; writes files if there is a directory for them. A stopped
/// titration leaves none.
///
/// # Errors
/// For a file that is no structure, a selection without titratable groups or with nothing but Cα
/// atoms, and files that exist or cannot be written.
pub fn titrate(settings: &TitrateSettings, execution: &Execution) -> Result<End<TitrationReport>> {
    let start = Instant::now();
    if let Some(folder) = &settings.output {
        directory::require_free(folder, settings.force)?;
    }
    FileKind::Structure.require(&settings.input)?;
    let file = InputFile::read(&settings.input)?;
    let structure = Structure::read(&file.name, &file.bytes)?;
    let selection = structure
        .select(&settings.selection)
        .with_context(|| file.name.clone())?;
    let mut warnings = structure_warnings(&structure, &selection.report);
    warnings.extend(outside_the_fit(settings));
    let ph = settings.ph.table_ph();
    let by_model =
        build_sites(&selection, &site_settings(ph)).with_context(|| file.name.clone())?;
    let sites = titratable_sites(&selection);
    if sites.groups.is_empty() {
        bail!(
            "{} has no titratable group in the selection; select chains of a protein",
            file.name
        );
    }
    let dielectric = settings.model.dielectric(settings.electrolyte);
    let total = sites.groups.len() as u64;
    execution.progress.begin(total, "groups");
    let advance = || {
        execution.progress.advance(1);
        !execution.interrupt.is_requested()
    };
    let energies = group_energies(&sites, &dielectric, &solve_settings(), &advance)
        .with_context(|| file.name.clone())?;
    if execution.interrupt.is_requested() {
        return Ok(End::Stopped);
    }
    let salt_molar = settings.electrolyte.salt_molar().unwrap_or(0.0);
    let groups = settings.model.groups(&sites, &energies, salt_molar);
    let fixed_charge_e: f64 = sites.background_e.iter().sum();
    let rows = shifts::rows(&selection, &sites, &energies, &groups, &settings.model, ph);
    let report = TitrationReport {
        version: env!("CARGO_PKG_VERSION").into(),
        file: file.name,
        ph,
        salt_molar: settings.electrolyte.salt_molar(),
        temperature_kelvin: settings.electrolyte.temperature_kelvin(),
        inner_permittivity: settings.model.inner_permittivity,
        anion_binding_per_molar: settings.model.anion_binding_per_molar,
        net_charge_e: rows.iter().map(|row| row.charge_e).sum::<f64>() + fixed_charge_e,
        model_net_charge_e: by_model.net_charge_e(),
        isoelectric_point: groups.isoelectric_point(fixed_charge_e),
        groups: rows,
        curve: curve(&groups, &settings.ph, fixed_charge_e),
        warnings: with_left_out(warnings, &selection, &sites),
        seconds: start.elapsed().as_secs_f64(),
    };
    if let Some(folder) = &settings.output {
        directory::write(&report, folder, &file.sha256, settings.force)?;
    }
    Ok(End::Finished(report))
}

/// Warnings about conditions for which the model was not fitted.
fn outside_the_fit(settings: &TitrateSettings) -> Vec<String> {
    let mut warnings = Vec::new();
    let (fitted, stated) = (
        TitrationModel::default().inner_permittivity,
        settings.model.inner_permittivity,
    );
    if stated != fitted {
        warnings.push(format!(
            "the factors of the model were fitted with a permittivity of {fitted} inside; with {stated} \
             the pKa values have unknown errors"
        ));
    }
    let temperature = settings.electrolyte.temperature_kelvin();
    if (temperature - FITTED_KELVIN).abs() > TOLERATED_KELVIN {
        warnings.push(format!(
            "the pKa values in water are those of 25 °C; at {temperature} K those of amines and \
             histidine shift by about 0.02 to 0.03 per kelvin"
        ));
    }
    warnings
}

fn site_settings(ph: f64) -> SiteSettings {
    SiteSettings {
        ph,
        ..SiteSettings::default()
    }
}

/// Net charge at each value of the pH.
fn curve(groups: &TitratingGroups, range: &PhRange, fixed_charge_e: f64) -> Vec<CurvePoint> {
    let values = range.curve();
    let point = |ph: &f64| CurvePoint {
        ph: *ph,
        net_charge_e: groups.net_charge_e(*ph) + fixed_charge_e,
    };
    values.par_iter().map(point).collect()
}

/// The warnings of the structure, and what its titration leaves out.
fn with_left_out(
    mut warnings: Vec<String>,
    selection: &Selection,
    sites: &TitratableSites,
) -> Vec<String> {
    let incomplete = &selection.report.incomplete;
    let mut names = Vec::new();
    for group in &sites.groups {
        let key = &selection.residues[group.residue].key;
        if incomplete.iter().any(|residue| residue.residue == *key) {
            names.push(format!("{} {}", key.chain, key.number));
        }
    }
    names.dedup();
    if !names.is_empty() {
        warnings.push(format!(
            "the pKa values of {} are those of incomplete residues: their charges are on the atoms \
             that are there; complete the side chains first",
            names.join(", ")
        ));
    }
    warnings
}
