//! A body from a user's own mesh and charges.

use crate::input::InputFile;
use anyhow::{Context, Result};
use protomer_body::{Body, Provenance, Site};
use protomer_io::mesh::read_mesh;
use protomer_io::points::read_points;
use protomer_kernel::Vec3;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// What to make a body of.
#[derive(Debug, Clone, PartialEq)]
pub struct OwnBody {
    /// Name of the body.
    pub name: String,
    /// Mesh file.
    pub mesh: PathBuf,
    /// Charge file.
    pub charges: Option<PathBuf>,
}

/// Reads the files and checks that the mesh bounds a solid.
///
/// # Errors
/// Names the file, the line or the defect of the mesh.
pub fn build(own: &OwnBody) -> Result<Body> {
    let file = InputFile::read(&own.mesh)?;
    let mesh = read_mesh(&file.name, &file.bytes)?;
    let checked = || -> Result<_> {
        mesh.topology()?;
        Ok(mesh.mass_properties()?)
    };
    let mass_properties = checked().with_context(|| file.name.clone())?;
    let mut settings = BTreeMap::from([("mesh".to_owned(), file.name.clone())]);
    let mut sites = Vec::new();
    if let Some(path) = &own.charges {
        let charges = InputFile::read(path)?;
        sites = read_points(&charges.name, &charges.bytes)?
            .into_iter()
            .map(site)
            .collect();
        settings.insert("charges".into(), charges.name);
        settings.insert("charges_sha256".into(), charges.sha256);
    }
    let provenance = Provenance {
        source: file.name,
        source_sha256: file.sha256,
        origin_angstrom: Vec3::zeros(),
        settings,
    };
    Ok(Body {
        name: own.name.clone(),
        mesh,
        sites,
        residues: Vec::new(),
        mass_properties,
        provenance,
    })
}

fn site(record: protomer_io::points::PointRecord) -> Site {
    Site {
        position: record.position,
        charge_e: record.charge_e,
        radius_angstrom: record.radius_angstrom,
        atom_name: record.atom_name,
        residue: None,
    }
}
