//! The conditions of a sweep: box, concentration, temperature, and the lengths of each salt.

use crate::assemblies::assembly_file::Assembly;
use crate::stability::run::RunSettings;
use crate::stability::sweep::result::SweepResult;
use anyhow::Result;
use protomer_common::page::{Part, Section, millimolar, significant};

/// The conditions of the bodies.
///
/// # Errors
/// If the medium is out of range.
pub fn section(
    settings: &RunSettings,
    result: Option<&SweepResult>,
    assembly: Option<&Assembly>,
) -> Result<Section> {
    let mut rows = vec![("periodic box (Å)", periodic_box(result, assembly))];
    let concentration_molar = result.map_or(0.0, |result| result.concentration_molar);
    if concentration_molar > 0.0 {
        rows.push((
            "concentration of bodies",
            format!("{} mM", significant(1e3 * concentration_molar, 4)),
        ));
    }
    rows.push((
        "temperature",
        format!("{} K", settings.medium.temperature_kelvin),
    ));
    rows.push((
        "contact",
        format!("surfaces closer than {} Å", settings.contact_gap_angstrom),
    ));
    rows.push((
        "cluster moves per sweep",
        settings.cluster_moves_per_sweep.to_string(),
    ));
    if settings.binding_moves_per_sweep > 0 {
        rows.push((
            "moves per sweep that form and dissolve contacts",
            settings.binding_moves_per_sweep.to_string(),
        ));
    }
    if let Some(depletants) = settings.depletants()? {
        rows.push((
            "depletants",
            format!(
                "radius {} Å, {} of the reservoir",
                depletants.radius_angstrom, depletants.reservoir_fraction
            ),
        ));
    }
    if settings.proton_moves_per_sweep > 0 {
        rows.push((
            "moves of protons per sweep",
            settings.proton_moves_per_sweep.to_string(),
        ));
    }
    let columns = vec![
        "salt (mM)",
        "relative permittivity",
        "Bjerrum length (Å)",
        "Debye length (Å)",
        "cut-off (Å)",
    ];
    let mut lines = Vec::new();
    for salt in &settings.salt_molar {
        let interaction = settings.medium.interaction(Some(*salt))?;
        let lengths = [
            interaction.electrolyte.relative_permittivity(),
            interaction.electrolyte.bjerrum_length_angstrom(),
            interaction.electrolyte.debye_length_angstrom(),
            interaction.cutoff_angstrom,
        ];
        let mut line = vec![millimolar(*salt)];
        line.extend(lengths.map(|length| significant(length, 5)));
        lines.push(line);
    }
    Ok(Section::new(
        "Conditions",
        vec![
            Part::Values(rows),
            Part::Table {
                columns,
                rows: lines,
            },
        ],
    ))
}

/// The edges of the box in words.
fn periodic_box(result: Option<&SweepResult>, assembly: Option<&Assembly>) -> String {
    let lengths = match (assembly, result) {
        (Some(assembly), _) => assembly.box_angstrom(),
        (None, Some(result)) => result.box_angstrom,
        (None, None) => return "not known until all simulations are done".into(),
    };
    match lengths {
        None => "none".into(),
        Some(lengths) => lengths.map(|length| length.to_string()).join(" × "),
    }
}
