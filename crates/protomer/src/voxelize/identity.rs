//! What sets and samples depend on, hashed: equal hashes, equal content.

use super::manifest::Entry;
use super::set::SetContent;
use super::settings::VoxelizeSettings;
use super::work::FORMAT;
use anyhow::Result;
use protomer_field::Boundary;
use protomer_field::voxels::{Channel, PotentialModel, VoxelSettings};
use protomer_io::atomic::sha256_hex;
use serde_json::{Value, json};

/// How the Poisson-Boltzmann equation is solved where settings leave no choice; nothing where it is not solved.
///
/// # Errors
/// For conditions that no solvent has.
pub(super) fn fixed_conditions(settings: &VoxelizeSettings) -> Result<Value> {
    if !settings.channels.contains(&Channel::Potential) || settings.potential != PotentialModel::PoissonBoltzmann {
        return Ok(Value::Null);
    }
    let VoxelSettings { medium, solve, .. } = settings.voxel_settings()?;
    let boundary = match solve.boundary {
        Boundary::ScreenedAtoms => "screened-atoms",
        Boundary::CoarseGrid => "coarse-grid",
    };
    Ok(json!({
        "inner_permittivity": medium.inner_permittivity,
        "solvent_permittivity": medium.conditions.relative_permittivity,
        "ion_radius_angstrom": medium.ion_radius_angstrom,
        "spacing_angstrom": solve.spacing_angstrom,
        "margin_angstrom": solve.margin_angstrom,
        "boundary": boundary,
        "relative_tolerance": solve.relative_tolerance,
    }))
}

/// What all samples of a set depend on.
fn making(settings: &VoxelizeSettings) -> Result<Value> {
    Ok(json!([env!("CARGO_PKG_VERSION"), FORMAT, settings, fixed_conditions(settings)?]))
}

/// A set's identity: a hash of its settings, its structures and what the manifest says of them.
///
/// # Errors
/// If the settings cannot be written down.
pub fn identity<'a>(
    settings: &VoxelizeSettings,
    entries: impl Iterator<Item = (&'a Entry, Option<&'a str>)>,
) -> Result<String> {
    let rows: Vec<Value> = entries
        .map(|(e, sha256)| json!([e.number, e.name, e.file, e.label, e.cluster, e.family, sha256.unwrap_or_default()]))
        .collect();
    identity_of_rows(settings, &rows)
}

fn identity_of_rows(settings: &VoxelizeSettings, rows: &[Value]) -> Result<String> {
    let text = serde_json::to_string(&json!([making(settings)?, rows]))?;
    Ok(sha256_hex(text.as_bytes()))
}

/// The identity of a set with this content: of structures sorted as in their one manifest, or as they follow each other.
///
/// # Errors
/// If the settings cannot be written down.
pub fn identity_of_content(settings: &VoxelizeSettings, content: &SetContent, one_manifest: bool) -> Result<String> {
    let samples = content
        .samples
        .iter()
        .map(|e| (e.entry, json!([e.entry, e.name, e.file, e.label, e.cluster, e.family, e.sha256])));
    let excluded = content
        .excluded
        .iter()
        .map(|e| (e.entry, json!([e.entry, e.name, e.file, e.label, e.cluster, e.family, e.sha256])));
    let mut rows: Vec<(usize, Value)> = samples.chain(excluded).collect();
    if one_manifest {
        rows.sort_by_key(|(entry, _)| *entry);
    }
    identity_of_rows(settings, &rows.into_iter().map(|(_, row)| row).collect::<Vec<Value>>())
}

/// What a sample depends on, hashed: settings, name and the file's bytes; and what a record of it holds.
///
/// # Errors
/// If the settings cannot be written down.
pub fn key(settings: &VoxelizeSettings, entry: &Entry, sha256: Option<&str>) -> Result<String> {
    let text = serde_json::to_string(&json!([making(settings)?, entry.name, sha256]))?;
    Ok(sha256_hex(text.as_bytes()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn how_the_potential_is_solved_belongs_to_the_conditions_where_it_is_solved() {
        let solved = VoxelizeSettings::default();
        let fixed = fixed_conditions(&solved).unwrap();
        assert_eq!(fixed["inner_permittivity"], 2.0);
        assert_eq!((&fixed["ion_radius_angstrom"], &fixed["spacing_angstrom"]), (&json!(2.0), &json!(1.0)));
        assert_eq!((&fixed["boundary"], &fixed["relative_tolerance"]), (&json!("screened-atoms"), &json!(1e-4)));
        for settings in [
            VoxelizeSettings { potential: PotentialModel::DebyeHueckel, ..solved.clone() },
            VoxelizeSettings { channels: vec![Channel::Shape], ..solved.clone() },
        ] {
            assert_eq!(fixed_conditions(&settings).unwrap(), Value::Null);
        }
        // Samples and sets are of their format and of these conditions.
        assert!(making(&solved).unwrap().as_array().unwrap().contains(&json!(FORMAT)));
        assert!(making(&solved).unwrap().as_array().unwrap().contains(&fixed));
    }
}
