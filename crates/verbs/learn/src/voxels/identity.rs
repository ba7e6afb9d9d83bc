//! Hashes of everything that sets and samples depend on: equal hashes mean equal content.

use super::listed::Listed;
use super::row::Row;
use super::settings::VoxelizeSettings;
use super::work::FORMAT;
use anyhow::Result;
use protomer_field::BoundaryCondition;
use protomer_field::voxels::{Channel, PotentialModel, VoxelSettings};
use protomer_io::digest::Digest;
use serde::Serialize;
use serde_json::{Value, json};

/// The fixed conditions of the Poisson-Boltzmann solution, which the settings cannot change; null
/// if it is not solved.
///
/// # Errors
/// For unphysical solvent conditions.
pub(super) fn fixed_conditions(settings: &VoxelizeSettings) -> Result<Value> {
    let has = |channel| settings.channels.contains(&channel);
    if !(has(Channel::Potential) || has(Channel::PartnerPotential))
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
        "cells_multiple": solve.cells_multiple,
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

/// The identity of a set: a hash of its settings, its structures and their manifest entries. The
/// function returns the rows, which are hashed as they come.
///
/// # Errors
/// If the settings cannot be serialised, and for an error among the rows.
pub fn identity<I>(settings: &VoxelizeSettings, rows: impl Fn() -> I) -> Result<String>
where
    I: Iterator<Item = Result<Row>>,
{
    Ok(digest(&(making(settings)?, Listed(rows)))?.to_string())
}

/// The keys of the samples of a set.
pub struct Keys(Value);

impl Keys {
    /// The keys with these settings, and with the vertices per Å² of bodies that are stored.
    ///
    /// # Errors
    /// If the settings cannot be serialised.
    pub fn new(settings: &VoxelizeSettings, body_density: Option<f64>) -> Result<Self> {
        let making = making(settings)?;
        Ok(Self(match body_density {
            Some(density) => json!([making, density]),
            None => making,
        }))
    }

    /// The key of a sample: a hash of the settings, the name, the bytes of the file, and the record
    /// format.
    ///
    /// # Errors
    /// Never for text in memory.
    pub fn key(&self, name: &str, sha256: Option<Digest>) -> Result<Digest> {
        digest(&(&self.0, name, sha256.map(|digest| digest.to_string())))
    }
}

/// The hash of what is serialised, without its text in memory.
fn digest(value: &impl Serialize) -> Result<Digest> {
    let write = |writer: &mut dyn std::io::Write| Ok(serde_json::to_writer(writer, value)?);
    Ok(Digest::of_written(write)?)
}

#[cfg(test)]
mod tests {
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

    /// The twin: the text of everything at once, whose hashes existing sets and work files hold.
    #[test]
    fn hashes_are_those_of_the_whole_text() {
        let settings = VoxelizeSettings::default();
        let row = |entry| Row {
            entry,
            name: format!("é{entry}"),
            ..Row::default()
        };
        let rows: Vec<Row> = (0..3).map(row).collect();
        let whole = |value: Value| Digest::hash(value.to_string().as_bytes());
        let streamed = identity(&settings, || rows.iter().cloned().map(Ok)).unwrap();
        let made = making(&settings).unwrap();
        assert_eq!(streamed, whole(json!([made, rows])).to_string());
        let keys = Keys::new(&settings, None).unwrap();
        for sha256 in [None, Some(Digest::hash(b"file"))] {
            let text = sha256.map(|digest| digest.to_string());
            assert_eq!(
                keys.key("a\"b", sha256).unwrap(),
                whole(json!([made, "a\"b", text]))
            );
        }
    }
}
