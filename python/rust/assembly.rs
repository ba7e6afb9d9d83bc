//! Assembly files and trajectories as arrays.

use crate::body::Body;
use crate::errors::exception;
use anyhow::{Context, Result};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use protomer_io::gsd::{PosedFrame, TrajectoryReader};
use protomer_kernel::Pose;
use protomer_protein_verbs::assemblies::assembly_file::{Assembly, AssemblyFile};
use protomer_results::keys;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Positions, Å, (N, 3) and orientations as quaternions, scalar first, (N, 4).
type Poses<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);
/// Names of the kinds with their files and bodies; for each placement the name of its kind; poses;
/// edges of the box, Å; radius of the wall, Å.
type Parts<'py> = (
    Vec<(String, PathBuf, Body)>,
    Vec<String>,
    Poses<'py>,
    Option<[f64; 3]>,
    Option<f64>,
);
/// Sweeps done, edges of the box, Å, poses.
type Frame<'py> = (u64, [f64; 3], Poses<'py>);

/// Reads an assembly file and its bodies.
#[pyfunction]
pub fn read_assembly(py: Python<'_>, path: PathBuf) -> PyResult<Parts<'_>> {
    let (file, assembly) = read(&path).map_err(|error| exception(&error))?;
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut kinds = Vec::new();
    for (entry, body) in file.bodies.into_iter().zip(&assembly.bodies) {
        kinds.push((entry.name, folder.join(entry.file), Body::from_body(body)));
    }
    let placed = file.placements.into_iter().map(|placement| placement.body);
    Ok((
        kinds,
        placed.collect(),
        arrays(py, &assembly.poses),
        file.box_angstrom,
        file.wall_radius_angstrom,
    ))
}

fn read(path: &Path) -> Result<(AssemblyFile, Assembly)> {
    let assembly = Assembly::read(path)?;
    let bytes = std::fs::read(path)
        .with_context(|| format!("cannot read the assembly {}", path.display()))?;
    Ok((keys::from_json(path, &bytes)?, assembly))
}

/// A trajectory of rigid bodies, read frame by frame.
#[pyclass(subclass, frozen, module = "protomer")]
pub struct Trajectory {
    reader: Mutex<TrajectoryReader>,
}

#[pymethods]
impl Trajectory {
    /// Opens a file.
    #[new]
    fn new(path: PathBuf) -> PyResult<Self> {
        let reader = TrajectoryReader::open(&path).map_err(|error| exception(&error.into()))?;
        Ok(Self {
            reader: Mutex::new(reader),
        })
    }

    /// Number of frames.
    fn _frames(&self) -> PyResult<u64> {
        self.with(|reader| Ok(reader.frames()))
    }

    /// The name of the kind of each body.
    fn _names(&self) -> PyResult<Vec<String>> {
        self.with(|reader| {
            if reader.frames() == 0 {
                return Ok(Vec::new());
            }
            let names = reader.type_names()?;
            let kinds = reader.frame(0)?.type_ids.into_iter();
            let name = |kind: u32| names.get(kind as usize).cloned().unwrap_or_default();
            Ok(kinds.map(name).collect())
        })
    }

    /// A frame, counted from zero.
    fn _frame<'py>(&self, py: Python<'py>, frame: u64) -> PyResult<Frame<'py>> {
        let PosedFrame {
            step,
            box_lengths_angstrom,
            poses,
            ..
        } = self.with(|reader| Ok(reader.frame(frame)?))?;
        Ok((step, box_lengths_angstrom, arrays(py, &poses)))
    }
}

impl Trajectory {
    fn with<T>(&self, read: impl FnOnce(&mut TrajectoryReader) -> Result<T>) -> PyResult<T> {
        let mut reader = self
            .reader
            .lock()
            .map_err(|_| PyRuntimeError::new_err("an earlier read has failed; open it again"))?;
        read(&mut reader).map_err(|error| exception(&error))
    }
}

fn arrays<'py>(py: Python<'py>, poses: &[Pose]) -> Poses<'py> {
    let wxyz: Vec<[f64; 4]> = poses.iter().map(Pose::wxyz).collect();
    (
        Array2::from_shape_fn((poses.len(), 3), |(row, axis)| poses[row].position[axis])
            .into_pyarray(py),
        Array2::from_shape_fn((poses.len(), 4), |(row, part)| wxyz[row][part]).into_pyarray(py),
    )
}
