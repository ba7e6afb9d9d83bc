//! A body from a custom mesh and charges.

use crate::bodies::body_file;
use crate::bodies::ingest::BodyMeasures;
use anyhow::{Context, Result};
use protomer_body::{Body, Provenance, Site, check_name};
use protomer_common::answer::Answer;
use protomer_common::input::InputFile;
use protomer_io::mesh::read_mesh;
use protomer_io::points::read_points;
use protomer_kernel::Vec3;
use protomer_kernel::overlap::check_embedding;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The files a body is made from.
#[derive(Debug, Clone, PartialEq)]
pub struct OwnBody {
    /// Name of the body.
    pub name: String,
    /// Mesh file.
    pub mesh: PathBuf,
    /// Charge file.
    pub charges: Option<PathBuf>,
}

/// A body that was written.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WrittenBody {
    /// The body file.
    pub body: PathBuf,
    /// Name of the body.
    pub name: String,
    /// The size and charge of the body.
    pub measures: BodyMeasures,
}

impl Answer for WrittenBody {
    fn text(&self) -> String {
        let measures = &self.measures;
        format!(
            "{}: {} triangles, {:.1} Å³, {} charges, net {:+.3} e",
            self.body.display(),
            measures.triangles,
            measures.mesh_volume_angstrom3,
            measures.atoms,
            measures.net_charge_e
        )
    }
}

/// Makes a body and writes it to a file.
///
/// # Errors
/// As [`build`]; also if the file holds another body and `force` is not set, or cannot be written.
///
/// ```no_run
/// use protomer_protein_verbs::bodies::own_body::{OwnBody, make};
/// use std::path::Path;
/// let own = OwnBody {
///     name: "patchy".into(),
///     mesh: "patchy.ply".into(),
///     charges: Some("patchy.xyzq".into()),
/// };
/// let written = make(&own, Path::new("patchy.body"), false)?;
/// assert_eq!(written.name, "patchy");
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn make(description: &OwnBody, output: &Path, force: bool) -> Result<WrittenBody> {
    let body = build(description)?;
    body_file::write_once(output, &body, force)?;
    Ok(WrittenBody {
        body: output.to_owned(),
        name: body.name.clone(),
        measures: BodyMeasures::from_body(&body),
    })
}

/// Reads the files and checks that the mesh bounds a solid once.
///
/// # Errors
/// Names the file and the line, or the defect of the mesh.
pub fn build(description: &OwnBody) -> Result<Body> {
    check_name(&description.name)?;
    let file = InputFile::read(&description.mesh)?;
    let mesh = read_mesh(&file.name, &file.bytes)?;
    let of_mesh = || -> Result<Body> {
        check_embedding(&mesh)?;
        Ok(Body::of_mesh(&description.name, mesh, Vec::new())?)
    };
    let mut body = of_mesh().with_context(|| file.name.clone())?;
    let mut settings = BTreeMap::from([("mesh".to_owned(), file.name.clone())]);
    if let Some(path) = &description.charges {
        let charges = InputFile::read(path)?;
        body.sites = read_points(&charges.name, &charges.bytes)?
            .into_iter()
            .map(site)
            .collect();
        settings.insert("charges".into(), charges.name);
        settings.insert("charges_sha256".into(), charges.sha256);
    }
    body.provenance = Provenance {
        source: file.name,
        source_sha256: file.sha256,
        origin_angstrom: Vec3::zeros(),
        settings,
    };
    Ok(body)
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
