//! What sets and samples depend on, hashed: equal hashes, equal content.

use super::manifest::Entry;
use super::row::Row;
use super::settings::VoxelizeSettings;
use super::work::FORMAT;
use anyhow::Result;
use protomer_field::BoundaryCondition;
use protomer_field::voxels::{Channel, PotentialModel, VoxelSettings};
use protomer_io::atomic::sha256_hex;
use serde_json::{Value, json};

/// How the Poisson-Boltzmann equation is solved where settings leave no choice; nothing where it is
/// not solved.
///
/// # Errors
/// For conditions that no solvent has.
pub(super) fn fixed_conditions(settings: &VoxelizeSettings) -> Result<Value> {
    if !settings.channels.contains(&Channel::Potential)
        || settings.potential != PotentialModel::PoissonBoltzmann
    {
        return Ok(Value::Null);
    }
    let VoxelSettings {
        dielectric, solve, ..
    } = settings.voxel_settings()?;
    let boundary = match solve.boundary {
        BoundaryCondition::ScreenedAtoms => "screened-atoms",
        BoundaryCondition::CoarseGrid => "coarse-grid",
    };
    Ok(json!({
        "inner_permittivity": dielectric.inner_permittivity,
        "solvent_permittivity": dielectric.electrolyte.relative_permittivity(),
        "ion_radius_angstrom": dielectric.ion_radius_angstrom,
        "spacing_angstrom": solve.spacing_angstrom,
        "margin_angstrom": solve.margin_angstrom,
        "boundary": boundary,
        "relative_tolerance": solve.relative_tolerance,
    }))
}

/// What all samples of a set depend on.
fn making(settings: &VoxelizeSettings) -> Result<Value> {
    Ok(json!([
        env!("CARGO_PKG_VERSION"),
        FORMAT,
        settings,
        fixed_conditions(settings)?
    ]))
}

/// A set's identity: a hash of its settings, its structures and what the manifest says of them.
///
/// # Errors
/// If the settings cannot be written down.
pub fn identity(settings: &VoxelizeSettings, rows: &[Row]) -> Result<String> {
    let text = serde_json::to_string(&json!([making(settings)?, rows]))?;
    Ok(sha256_hex(text.as_bytes()))
}

/// What a sample depends on, hashed: settings, name and the file's bytes; and what a record of it
/// holds.
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
        assert_eq!(
            (&fixed["ion_radius_angstrom"], &fixed["spacing_angstrom"]),
            (&json!(2.0), &json!(1.0))
        );
        assert_eq!(
            (&fixed["boundary"], &fixed["relative_tolerance"]),
            (&json!("screened-atoms"), &json!(1e-4))
        );
        for settings in [
            VoxelizeSettings {
                potential: PotentialModel::DebyeHueckel,
                ..solved.clone()
            },
            VoxelizeSettings {
                channels: vec![Channel::Shape],
                ..solved.clone()
            },
        ] {
            assert_eq!(fixed_conditions(&settings).unwrap(), Value::Null);
        }
        // Samples and sets are of their format and of these conditions.
        assert!(
            making(&solved)
                .unwrap()
                .as_array()
                .unwrap()
                .contains(&json!(FORMAT))
        );
        assert!(
            making(&solved)
                .unwrap()
                .as_array()
                .unwrap()
                .contains(&fixed)
        );
    }
}
