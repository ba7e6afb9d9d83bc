//! Hashes of everything that sets and samples depend on: equal hashes mean equal content.

use super::manifest::Entry;
use super::row::Row;
use super::settings::VoxelizeSettings;
use super::work::FORMAT;
use anyhow::Result;
use protomer_field::BoundaryCondition;
use protomer_field::voxels::{Channel, PotentialModel, VoxelSettings};
use protomer_io::atomic::sha256_hex;
use serde_json::{Value, json};

/// The fixed conditions of the Poisson-Boltzmann solution, which the settings cannot change; null
/// if it is not solved.
///
/// # Errors
/// For unphysical solvent conditions.
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

/// Everything that all samples of a set depend on.
fn making(settings: &VoxelizeSettings) -> Result<Value> {
    Ok(json!([
        env!("CARGO_PKG_VERSION"),
        FORMAT,
        settings,
        fixed_conditions(settings)?
    ]))
}

/// The identity of a set: a hash of its settings, its structures and their manifest entries.
///
/// # Errors
/// If the settings cannot be serialised.
pub fn identity(settings: &VoxelizeSettings, rows: &[Row]) -> Result<String> {
    let text = serde_json::to_string(&json!([making(settings)?, rows]))?;
    Ok(sha256_hex(text.as_bytes()))
}

/// The key of a sample: a hash of the settings, the name, the bytes of the file, and the record
/// format.
///
/// # Errors
/// If the settings cannot be serialised.
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
        // The hashes depend on the format and on the fixed conditions.
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
