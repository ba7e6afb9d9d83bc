//! Body files: everything an engine needs to know about a body, in one versioned, checksummed file.

use super::group_arrays;
use crate::file_kind::FileKind;
use anyhow::{Context, Result, bail};
use protomer_body::chemistry::titration::BodyTitration;
use protomer_body::{Body, Provenance, Residue, Site, check_name};
use protomer_common::output_file;
use protomer_io::atomic::{sha256_hex, write_atomically};
use protomer_io::container::{Array, Container};
use protomer_kernel::mesh::LARGEST_COORDINATE_ANGSTROM;
use protomer_kernel::name::{first_forbidden, printable};
use protomer_kernel::point_record::LARGEST_CHARGE_E;
use protomer_kernel::{Number, TriangleMesh, Vec3};
use serde::{Deserialize, Serialize};
use std::io::Read;
use std::path::Path;

/// The kind of content that the container declares.
const KIND: &str = "body";
/// An upper limit for the file size, beyond any body that a mesh index can address.
const LARGEST_FILE_BYTES: u64 = 8_000_000_000;
/// Array of the vertices of the hard core, in the files of bodies that have one in addition to
/// their surface.
const CAPACITANCES: &str = "capacitances_e2";
const CORE_VERTICES: &str = "core_vertices_angstrom";
/// Array of the triangles of the hard core.
const CORE_TRIANGLES: &str = "core_triangles";
/// Marks "no residue" in the array of residue indices.
const NO_RESIDUE: u32 = u32::MAX;

/// The parts of a body that are not arrays of numbers.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BodyHeader {
    name: String,
    atom_names: Vec<String>,
    residues: Vec<Residue>,
    provenance: Provenance,
    /// Conditions of the titratable groups, whose numbers are arrays.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    titration: Option<BodyTitration>,
}

/// Writes a body file.
///
/// # Errors
/// If the file cannot be written.
pub fn write(path: &Path, body: &Body) -> Result<()> {
    let bytes = to_bytes(body)?;
    write_atomically(path, |file| file.write_all(&bytes))?;
    Ok(())
}

/// Reads a body file; returns the body and the SHA-256 of the file.
///
/// # Errors
/// If the file cannot be read, is damaged, or does not hold a valid body.
///
/// ```no_run
/// use std::path::Path;
/// let (body, sha256) = protomer_protein_verbs::bodies::body_file::read(Path::new("bodies/5pti.body"))?;
/// println!("{}: {} sites, {sha256}", body.name, body.sites.len());
/// # Ok::<(), anyhow::Error>(())
/// ```
pub fn read(path: &Path) -> Result<(Body, String)> {
    FileKind::Body.require(path)?;
    let mut bytes = Vec::new();
    protomer_io::input::open(path)
        // Bounded: a device or a growing file must not fill the memory.
        .and_then(|file| file.take(LARGEST_FILE_BYTES).read_to_end(&mut bytes))
        .with_context(|| {
            format!(
                "cannot read {}; make it with 'protomer ingest' or 'protomer body'",
                path.display()
            )
        })?;
    Ok((
        from_bytes(&path.display().to_string(), &bytes)?,
        sha256_hex(&bytes),
    ))
}

/// Writes a body file, unless it holds another body. The same input with the same settings gives the
/// same bytes, so a repeated command recognises its own output.
///
/// # Errors
/// As [`refuse_another`]; also if the file cannot be written.
pub fn write_once(path: &Path, body: &Body, force: bool) -> Result<()> {
    output_file::write_once(path, &to_bytes(body)?, force)
}

/// Refuses a file that exists and holds anything but exactly this body, unless `force` is set.
///
/// # Errors
/// If it does.
pub fn refuse_another(path: &Path, body: &Body, force: bool) -> Result<()> {
    output_file::refuse_to_replace(path, &to_bytes(body)?, force)
}

fn to_bytes(body: &Body) -> Result<Vec<u8>> {
    let (mut charges, mut radii) = (Vec::new(), Vec::new());
    let (mut residues, mut atom_names) = (Vec::new(), Vec::new());
    for site in &body.sites {
        charges.push(site.charge_e);
        radii.push(site.radius_angstrom);
        residues.push(site.residue.unwrap_or(NO_RESIDUE));
        atom_names.push(site.atom_name.clone());
    }
    let header = BodyHeader {
        name: body.name.clone(),
        atom_names,
        residues: body.residues.clone(),
        provenance: body.provenance.clone(),
        titration: body.titration.clone(),
    };
    let header = serde_json::to_value(header).context("the body cannot be serialised")?;
    let mut container = Container::new(KIND, header);
    let (triangles, sites) = (body.mesh.triangles.len(), body.sites.len());
    let corners = body.mesh.triangles.iter().flatten().copied().collect();
    container.insert("vertices_angstrom", points(body.mesh.vertices.iter())?);
    container.insert("triangles", Array::u32(corners, [triangles, 3])?);
    if let Some(core) = &body.core {
        let corners = core.triangles.iter().flatten().copied().collect();
        let triangles = Array::u32(corners, [core.triangles.len(), 3])?;
        container.insert(CORE_VERTICES, points(core.vertices.iter())?);
        container.insert(CORE_TRIANGLES, triangles);
    }
    container.insert(
        "positions_angstrom",
        points(body.sites.iter().map(|site| &site.position))?,
    );
    container.insert("charges_e", Array::f64(charges, [sites])?);
    container.insert("radii_angstrom", Array::f64(radii, [sites])?);
    if !body.capacitances_e2.is_empty() {
        let capacitances = Array::f64(body.capacitances_e2.clone(), [sites])?;
        container.insert(CAPACITANCES, capacitances);
    }
    if let Some(titration) = &body.titration {
        group_arrays::insert(&mut container, titration)?;
    }
    container.insert("residues", Array::u32(residues, [sites])?);
    Ok(container.to_bytes()?)
}

fn points<'a>(points: impl Iterator<Item = &'a Vec3>) -> Result<Array> {
    let values: Vec<f64> = points
        .flat_map(|point| [point.x, point.y, point.z])
        .collect();
    let count = values.len() / 3;
    Ok(Array::f64(values, [count, 3])?)
}

/// Decodes a body from the bytes of a file named `file`.
///
/// # Errors
/// If the bytes are damaged or do not hold a valid body. No input causes a panic or an allocation
/// larger than the input.
pub fn from_bytes(file: &str, bytes: &[u8]) -> Result<Body> {
    let container = Container::from_bytes(file, KIND, bytes)?;
    decode(file, container)
        .with_context(|| format!("{file} does not hold a valid body; make it again"))
}

fn decode(file: &str, container: Container) -> Result<Body> {
    let surface = mesh(file, &container, "vertices_angstrom", "triangles")?;
    let core = match container
        // Either of the two shows that a core was meant; then both must be there.
        .get(CORE_VERTICES)
        .or(container.get(CORE_TRIANGLES))
    {
        Some(_) => Some(mesh(file, &container, CORE_VERTICES, CORE_TRIANGLES)?),
        None => None,
    };
    let positions = vectors(file, &container, "positions_angstrom")?;
    let charges = numbers(file, &container, "charges_e", &[None])?;
    let radii = numbers(file, &container, "radii_angstrom", &[None])?;
    require_at_most("charges_e", charges, LARGEST_CHARGE_E, "e")?;
    require_at_most("radii_angstrom", radii, LARGEST_COORDINATE_ANGSTROM, "Å")?;
    let capacitances = match container.get(CAPACITANCES) {
        Some(_) => numbers(file, &container, CAPACITANCES, &[None])?,
        None => &[],
    };
    require_at_most(CAPACITANCES, capacitances, LARGEST_CHARGE_E, "e²")?;
    let residue_of = container.u32(file, "residues", &[None])?;
    let header: BodyHeader = serde_json::from_value(container.header.clone())?;
    check_name(&header.name)?;
    refuse_names_of(&header)?;
    let count = positions.len();
    // Before sites are put together by index.
    if [
        charges.len(),
        radii.len(),
        residue_of.len(),
        header.atom_names.len(),
    ] != [count; 4]
    {
        bail!("its arrays differ in length");
    }
    if !(capacitances.is_empty() || capacitances.len() == count) {
        bail!(
            "it has {} capacitances for {count} sites",
            capacitances.len()
        );
    }
    if residue_of
        .iter()
        .any(|index| *index != NO_RESIDUE && *index as usize >= header.residues.len())
    {
        bail!("a site refers to a residue that does not exist");
    }
    let mut sites = Vec::with_capacity(count);
    for (index, atom_name) in header.atom_names.into_iter().enumerate() {
        sites.push(Site {
            position: positions[index],
            charge_e: charges[index],
            radius_angstrom: radii[index],
            atom_name,
            residue: (residue_of[index] != NO_RESIDUE).then_some(residue_of[index]),
        });
    }
    let mass_properties = surface.mass_properties()?;
    let titration = match header.titration {
        Some(conditions) => Some(group_arrays::read(file, &container, conditions, count)?),
        None => None,
    };
    Ok(Body {
        name: header.name,
        mesh: surface,
        core,
        sites,
        capacitances_e2: capacitances.to_vec(),
        titration,
        residues: header.residues,
        mass_properties,
        provenance: header.provenance,
    })
}

/// A closed mesh from two arrays.
fn mesh(
    file: &str,
    container: &Container,
    vertices: &str,
    triangles: &str,
) -> Result<TriangleMesh> {
    let mesh = TriangleMesh {
        vertices: vectors(file, container, vertices)?,
        triangles: container
            .u32(file, triangles, &[None, Some(3)])?
            .as_chunks::<3>()
            .0
            .to_vec(),
    };
    // Closed and oriented, or neither volume nor overlap would mean anything.
    mesh.topology()?;
    Ok(mesh)
}

/// Refuses names that could become something else where they are written.
fn refuse_names_of(header: &BodyHeader) -> Result<()> {
    let residues = header.residues.iter();
    let of_residues = residues.flat_map(|residue| {
        [&residue.name, &residue.chain, &residue.insertion_code].map(String::as_str)
    });
    let mut names = header
        .atom_names
        .iter()
        .map(String::as_str)
        .chain(of_residues);
    match names.find(|name| first_forbidden(name).is_some()) {
        Some(name) => bail!(
            "the name '{}' of an atom, a residue or a chain holds a control character",
            printable(name)
        ),
        None => Ok(()),
    }
}

fn numbers<'a>(
    file: &str,
    container: &'a Container,
    name: &str,
    shape: &[Option<usize>],
) -> Result<&'a [f64]> {
    let values = container.f64(file, name, shape)?;
    if values.iter().any(|value| !value.is_finite()) {
        bail!("array '{name}' has a value that is not a finite number");
    }
    Ok(values)
}

fn require_at_most(name: &str, values: &[f64], most: f64, unit: &str) -> Result<()> {
    if let Some(value) = values.iter().find(|value| value.abs() > most) {
        bail!(
            "array '{name}' has the value {} {unit}; {most} {unit} is the most",
            Number(*value)
        );
    }
    Ok(())
}

fn vectors(file: &str, container: &Container, name: &str) -> Result<Vec<Vec3>> {
    let values = numbers(file, container, name, &[None, Some(3)])?;
    require_at_most(name, values, LARGEST_COORDINATE_ANGSTROM, "Å")?;
    Ok(values
        .as_chunks::<3>()
        .0
        .iter()
        .map(|point| Vec3::from(*point))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_body::chemistry::titration::BodyGroup;

    /// A tetrahedron with one charged atom.
    fn example() -> Body {
        let residue = Residue {
            chain: "A".into(),
            number: 7,
            insertion_code: String::new(),
            name: "LYS".into(),
            charge_e: 1.0,
            hydropathy: Some(-3.9),
        };
        let site = Site {
            position: Vec3::new(0.1, 0.2, 0.3),
            charge_e: 1.0 / 3.0,
            radius_angstrom: 1.55,
            atom_name: "NZ".into(),
            residue: Some(0),
        };
        Body {
            residues: vec![residue],
            ..Body::of_mesh("example", TriangleMesh::tetrahedron(1.0), vec![site]).unwrap()
        }
    }

    #[test]
    fn a_body_survives_its_file() {
        let body = example();
        assert_eq!(
            from_bytes("x.body", &to_bytes(&body).unwrap()).unwrap(),
            body
        );
        let responding = Body {
            capacitances_e2: vec![0.125],
            ..body.clone()
        };
        let bytes = to_bytes(&responding).unwrap();
        assert_eq!(from_bytes("x.body", &bytes).unwrap(), responding);
        let group = BodyGroup {
            charge_e: -1.0,
            model_pka: 4.1,
            shift_kt: 0.1 + 0.2,
            tautomer_kt: None,
            charged_share: 0.25,
            change_e: vec![(0, -1.0)],
        };
        let base = BodyGroup {
            charge_e: 1.0,
            tautomer_kt: Some(-1.0 / 3.0),
            ..group.clone()
        };
        let titratable = Body {
            titration: Some(BodyTitration {
                ph: 7.1,
                salt_molar: 0.1,
                temperature_kelvin: 298.15,
                groups: vec![group, base],
                pair_kt: vec![0.0, -0.7, -0.7, 0.0],
                tautomer_pair_kt: vec![0.0, 0.1, 0.3, 0.0],
            }),
            ..body.clone()
        };
        let bytes = to_bytes(&titratable).unwrap();
        assert_eq!(from_bytes("x.body", &bytes).unwrap(), titratable);
        let mut foreign = titratable.clone();
        if let Some(titration) = &mut foreign.titration {
            titration.groups[0].change_e[0].0 = 1;
        }
        let refused = from_bytes("x.body", &to_bytes(&foreign).unwrap()).unwrap_err();
        assert!(format!("{refused:#}").contains("no change of charge of a site"));
        let damaged = Body {
            capacitances_e2: vec![0.125; 2],
            ..body.clone()
        };
        assert!(to_bytes(&damaged).is_err());
        let with_core = Body {
            core: Some(body.mesh.map_vertices(|vertex| 0.5 * vertex)),
            ..body
        };
        assert_eq!(
            from_bytes("x.body", &to_bytes(&with_core).unwrap()).unwrap(),
            with_core
        );
    }

    #[test]
    fn what_is_no_body_is_refused() {
        let checkpoint = Container::new("checkpoint", serde_json::Value::Null)
            .to_bytes()
            .unwrap();
        assert!(
            from_bytes("x", &checkpoint)
                .unwrap_err()
                .to_string()
                .contains("checkpoint")
        );
        let mut open = example();
        open.mesh.triangles.pop();
        let error = format!(
            "{:#}",
            from_bytes("x", &to_bytes(&open).unwrap()).unwrap_err()
        );
        assert!(error.contains("one side only"), "{error}");
        let mut core = example().mesh;
        core.triangles.pop();
        let hollow = Body {
            core: Some(core),
            ..example()
        };
        assert!(from_bytes("x", &to_bytes(&hollow).unwrap()).is_err());
        let mut charged = example();
        for charge_e in [f64::NAN, 1e308, -1e308] {
            charged.sites[0].charge_e = charge_e;
            assert!(from_bytes("x", &to_bytes(&charged).unwrap()).is_err());
        }
    }
}
