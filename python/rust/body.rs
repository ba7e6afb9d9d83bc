//! Bodies as arrays.

use crate::errors::exception;
use anyhow::{Result, bail, ensure};
use numpy::ndarray::{Array1, Array2};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use protomer_body::{Provenance, Site};
use protomer_kernel::overlap::check_embedding;
use protomer_kernel::{TriangleMesh, Vec3};
use protomer_protein_verbs::bodies::body_file;
use pyo3::prelude::*;
use std::path::PathBuf;

/// A rigid body: a closed surface mesh with point charges.
#[pyclass(subclass, frozen, module = "protomer")]
pub struct Body {
    body: protomer_body::Body,
}

#[pymethods]
impl Body {
    /// Reads a body file.
    #[staticmethod]
    fn _read(path: PathBuf) -> PyResult<Self> {
        let (body, _) = body_file::read(&path).map_err(|error| exception(&error))?;
        Ok(Self { body })
    }

    /// A copy of another body, for subclasses.
    #[new]
    fn new(body: PyRef<'_, Self>) -> Self {
        Self {
            body: body.body.clone(),
        }
    }

    /// A body of a mesh (vertices in Å, outward counter-clockwise triangles) and point charges (Å,
    /// e).
    #[staticmethod]
    fn _from_arrays(
        name: String,
        vertices: PyReadonlyArray2<'_, f64>,
        triangles: PyReadonlyArray2<'_, u32>,
        charge_positions: PyReadonlyArray2<'_, f64>,
        charges: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Self> {
        let build = || -> Result<protomer_body::Body> {
            protomer_body::check_name(&name)?;
            let vertices = places(&vertices, "vertices_angstrom")?;
            let triangles = corners(&triangles, vertices.len())?;
            let mesh = TriangleMesh {
                vertices,
                triangles,
            };
            check_embedding(&mesh)?;
            let positions = places(&charge_positions, "charge_positions_angstrom")?;
            let charges = charges.as_array();
            ensure!(
                positions.len() == charges.len(),
                "{} charges at {} positions; give one position per charge",
                charges.len(),
                positions.len()
            );
            let site = |(position, charge): (Vec3, &f64)| Site {
                position,
                charge_e: *charge,
                radius_angstrom: 0.0,
                atom_name: String::new(),
                residue: None,
            };
            let sites = positions.into_iter().zip(charges).map(site).collect();
            let provenance = Provenance {
                source: "arrays".into(),
                ..Provenance::default()
            };
            Ok(protomer_body::Body {
                provenance,
                ..protomer_body::Body::of_mesh(&name, mesh, sites)?
            })
        };
        Ok(Self {
            body: build().map_err(|error| exception(&error))?,
        })
    }

    /// Writes a body file.
    fn write(&self, path: PathBuf) -> PyResult<()> {
        body_file::write(&path, &self.body).map_err(|error| exception(&error))
    }

    /// Name, as it appears in assemblies and tables.
    #[getter]
    fn name(&self) -> &str {
        &self.body.name
    }

    /// Vertices of the surface in the body's frame, Å, (N, 3).
    #[getter]
    fn vertices_angstrom<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        rows(py, &self.body.mesh.vertices)
    }

    /// Vertex indices of the triangles, counter-clockwise seen from outside, (M, 3).
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        triangle_rows(py, &self.body.mesh.triangles)
    }

    /// Vertices of the hard core in the body's frame, Å, (N, 3); `None` where the surface is hard.
    #[getter]
    fn core_vertices_angstrom<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray2<f64>>> {
        let core = self.body.core.as_ref()?;
        Some(rows(py, &core.vertices))
    }

    /// Vertex indices of the triangles of the hard core, (M, 3); `None` where the surface is hard.
    #[getter]
    fn core_triangles<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray2<u32>>> {
        let core = self.body.core.as_ref()?;
        Some(triangle_rows(py, &core.triangles))
    }

    /// Positions of the charges in the body's frame, Å, (S, 3).
    #[getter]
    fn charge_positions_angstrom<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let positions: Vec<Vec3> = self.body.sites.iter().map(|site| site.position).collect();
        rows(py, &positions)
    }

    /// Charges, e, (S,).
    #[getter]
    fn charges_e<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.per_site(py, |site| site.charge_e)
    }

    /// Radii of the atoms that the surface was made of, Å, (S,); zero for bare charges.
    #[getter]
    fn radii_angstrom<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.per_site(py, |site| site.radius_angstrom)
    }

    /// Capacitance of each charge, e², (S,): its fall per kT/e of potential; empty for a body whose charges do
    /// not respond.
    #[getter]
    fn capacitances_e2<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        Array1::from_vec(self.body.capacitances_e2.clone()).into_pyarray(py)
    }

    /// Hydropathy index of each atom's residue, (S,); NaN where the scale has no value.
    #[getter]
    fn hydropathy<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.per_site(py, |site| {
            let residue = site
                .residue
                .and_then(|residue| self.body.residues.get(residue as usize));
            residue
                .and_then(|residue| residue.hydropathy)
                .unwrap_or(f64::NAN)
        })
    }

    /// Atom names, one per charge; empty for bare charges.
    #[getter]
    fn atom_names(&self) -> Vec<&str> {
        self.body
            .sites
            .iter()
            .map(|site| site.atom_name.as_str())
            .collect()
    }

    /// Index of each charge's residue, -1 for none, (S,).
    #[getter]
    fn residue_indices<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let index = |site: &Site| site.residue.map_or(-1, i64::from);
        self.body
            .sites
            .iter()
            .map(index)
            .collect::<Array1<i64>>()
            .into_pyarray(py)
    }

    /// Residues as (chain, number, insertion code, name).
    #[getter]
    fn residues(&self) -> Vec<(&str, i32, &str, &str)> {
        let residues = self.body.residues.iter();
        residues
            .map(|r| {
                (
                    r.chain.as_str(),
                    r.number,
                    r.insertion_code.as_str(),
                    r.name.as_str(),
                )
            })
            .collect()
    }

    /// Sum of the charges, e.
    #[getter]
    fn net_charge_e(&self) -> f64 {
        self.body.net_charge_e()
    }

    /// Enclosed volume, Å³.
    #[getter]
    fn volume_angstrom3(&self) -> f64 {
        self.body.mass_properties.volume_angstrom3
    }

    /// Area of the surface, Å².
    #[getter]
    fn area_angstrom2(&self) -> f64 {
        self.body.mesh.area_angstrom2()
    }

    /// Centre of the enclosed volume, Å, (3,).
    #[getter]
    fn centroid_angstrom<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.body
            .mass_properties
            .centroid
            .iter()
            .copied()
            .collect::<Array1<f64>>()
            .into_pyarray(py)
    }

    /// Inertia tensor of the solid about its centroid at unit density, Å⁵, (3, 3).
    #[getter]
    fn inertia_angstrom5<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let inertia = &self.body.mass_properties.inertia_angstrom5;
        Array2::from_shape_fn((3, 3), |(row, column)| inertia[(row, column)]).into_pyarray(py)
    }

    /// The body frame's origin in the coordinates of the file it came from, Å, (3,).
    #[getter]
    fn origin_angstrom<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.body
            .provenance
            .origin_angstrom
            .iter()
            .copied()
            .collect::<Array1<f64>>()
            .into_pyarray(py)
    }

    /// The file the body came from, as it was named.
    #[getter]
    fn source(&self) -> &str {
        &self.body.provenance.source
    }
}

impl Body {
    pub(crate) fn from_body(body: &protomer_body::Body) -> Self {
        Self { body: body.clone() }
    }

    fn per_site<'py>(
        &self,
        py: Python<'py>,
        value: impl Fn(&Site) -> f64,
    ) -> Bound<'py, PyArray1<f64>> {
        self.body
            .sites
            .iter()
            .map(value)
            .collect::<Array1<f64>>()
            .into_pyarray(py)
    }
}

fn rows<'py>(py: Python<'py>, places: &[Vec3]) -> Bound<'py, PyArray2<f64>> {
    Array2::from_shape_fn((places.len(), 3), |(row, axis)| places[row][axis]).into_pyarray(py)
}

fn places(array: &PyReadonlyArray2<'_, f64>, name: &str) -> Result<Vec<Vec3>> {
    let array = array.as_array();
    ensure!(
        array.ncols() == 3,
        "{name} has the shape {:?}; give (N, 3)",
        array.shape()
    );
    ensure!(
        array.iter().all(|value| value.is_finite()),
        "{name} contains NaN; remove these values"
    );
    Ok(array
        .rows()
        .into_iter()
        .map(|row| Vec3::new(row[0], row[1], row[2]))
        .collect())
}

fn corners(array: &PyReadonlyArray2<'_, u32>, vertices: usize) -> Result<Vec<[u32; 3]>> {
    let array = array.as_array();
    ensure!(
        array.ncols() == 3,
        "triangles has the shape {:?}; give (M, 3)",
        array.shape()
    );
    if let Some(far) = array.iter().find(|corner| **corner as usize >= vertices) {
        bail!("triangles name the vertex {far} of {vertices}; count vertices from zero");
    }
    Ok(array
        .rows()
        .into_iter()
        .map(|row| [row[0], row[1], row[2]])
        .collect())
}

/// Corners of triangles as rows.
fn triangle_rows<'py>(py: Python<'py>, triangles: &[[u32; 3]]) -> Bound<'py, PyArray2<u32>> {
    Array2::from_shape_fn((triangles.len(), 3), |(row, corner)| triangles[row][corner])
        .into_pyarray(py)
}
