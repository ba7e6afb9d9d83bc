//! Simulations in memory: their state as arrays, loops in Python.

use crate::errors::{ConfigError, exception};
use anyhow::{Result, bail};
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use protomer_common::live::{Arrays, Column, Live, Rows};
use protomer_common::remedy;
use protomer_io::gsd::FrameWriter;
use protomer_linkage_verbs::lattice;
use protomer_shape_verbs::{dynamics, hard_bodies};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard};

/// A simulation in memory. `python/protomer/simulation.py` is what a user sees.
#[pyclass(subclass, frozen, module = "protomer")]
pub struct LiveSimulation {
    engine: Mutex<Box<dyn Live>>,
    /// Arrays of the state, filled again after every change.
    arrays: BTreeMap<&'static str, Py<PyArray2<f64>>>,
    trajectory: Mutex<Option<FrameWriter>>,
}

#[pymethods]
impl LiveSimulation {
    /// Begins a simulation of this kind, by settings and, if there are any, arrays.
    #[new]
    #[pyo3(signature = (kind, settings, arrays=None))]
    fn new(
        py: Python<'_>,
        kind: String,
        settings: String,
        arrays: Option<BTreeMap<String, PyReadonlyArray2<'_, f64>>>,
    ) -> PyResult<Self> {
        let arrays = arrays.map(given);
        let begin = || -> Result<Box<dyn Live>> {
            let settings: Value = serde_json::from_str(&settings)?;
            match kind.as_str() {
                "hard bodies" => hard_bodies::live::hard_bodies(&settings, arrays),
                "dynamics" => dynamics::live::dynamics(&settings, arrays),
                "lattice" => lattice::live::lattice(&settings, arrays),
                _ => bail!("there is no simulation of {kind}"),
            }
        };
        let engine = py.detach(begin).map_err(|error| raised(&error))?;
        Self::from_engine(py, engine)
    }

    /// Begins the simulation of an assembly by the words of `simulate`; also its warnings.
    #[staticmethod]
    #[pyo3(signature = (words, arrays=None))]
    fn _of_assembly(
        py: Python<'_>,
        words: Vec<String>,
        arrays: Option<BTreeMap<String, PyReadonlyArray2<'_, f64>>>,
    ) -> PyResult<(Self, Vec<String>)> {
        let arrays = arrays.map(given);
        let begin = || protomer_cli::simulation(&words, arrays);
        let (engine, warnings) = py.detach(begin).map_err(|error| raised(&error))?;
        Ok((Self::from_engine(py, engine)?, warnings))
    }

    /// The arrays of the state by name, those that are filled again after every change.
    fn _arrays(&self, py: Python<'_>) -> BTreeMap<&'static str, Py<PyArray2<f64>>> {
        let array =
            |(name, array): (&&'static str, &Py<PyArray2<f64>>)| (*name, array.clone_ref(py));
        self.arrays.iter().map(array).collect()
    }

    /// Number of steps or sweeps done.
    fn _done(&self) -> PyResult<u64> {
        Ok(self.engine()?.done())
    }

    /// Advances by so many steps or sweeps. Ctrl-C stops between two blocks of them.
    fn _advance(&self, py: Python<'_>, count: u64) -> PyResult<()> {
        let mut left = count;
        let advanced = loop {
            if left == 0 {
                break Ok(());
            }
            let outcome = py.detach(|| {
                let mut engine = self.engine()?;
                let block = engine.moves_at_once() / engine.count().max(1) as u64;
                let block = block.max(1).min(left);
                engine.advance(block).map_err(|error| raised(&error))?;
                Ok::<u64, PyErr>(block)
            });
            match outcome.and_then(|block| py.check_signals().map(|()| block)) {
                Ok(block) => left -= block,
                Err(error) => break Err(error),
            }
        };
        self.fill(py)?;
        advanced
    }

    /// Puts the bodies elsewhere.
    fn _place(
        &self,
        py: Python<'_>,
        arrays: BTreeMap<String, PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<()> {
        let arrays = given(arrays);
        self.with(|engine| engine.place(arrays))?;
        self.fill(py)
    }

    /// The settings as JSON.
    fn _settings(&self) -> PyResult<String> {
        self.with(|engine| Ok(engine.settings()?.to_string()))
    }

    /// Goes on with settings whose keys replace those of the simulation.
    fn _change(&self, settings: &str) -> PyResult<()> {
        self.with(|engine| engine.change(&serde_json::from_str(settings)?))
    }

    /// The row of the log that a run would write now.
    fn _measure(&self) -> PyResult<Vec<(&'static str, String)>> {
        Ok(self.engine()?.measure())
    }

    /// Everything that changes during a simulation.
    fn _save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let saved = self.with(|engine| engine.save())?;
        Ok(PyBytes::new(py, &saved))
    }

    /// Goes back to a saved state.
    fn _restore(&self, py: Python<'_>, saved: &[u8]) -> PyResult<()> {
        self.with(|engine| engine.restore(saved))?;
        self.fill(py)
    }

    /// Opens a trajectory, in place of the one that is open.
    fn _open_trajectory(&self, path: PathBuf) -> PyResult<()> {
        let writer = self.with(|engine| Ok(FrameWriter::open(&path, engine.header()?, 0)?))?;
        *lock(&self.trajectory)? = Some(writer);
        Ok(())
    }

    /// Appends a frame to the trajectory that is open.
    fn _write_frame(&self) -> PyResult<()> {
        let frame = self.engine()?.frame();
        let mut trajectory = lock(&self.trajectory)?;
        let write = || -> Result<()> {
            let Some(writer) = trajectory.as_mut() else {
                bail!("no trajectory is open; open one first");
            };
            writer.append(frame)?;
            writer.sync()?;
            Ok(())
        };
        write().map_err(|error| raised(&error))
    }
}

impl LiveSimulation {
    /// A simulation with arrays for its state.
    fn from_engine(py: Python<'_>, engine: Box<dyn Live>) -> PyResult<Self> {
        let mut arrays = BTreeMap::new();
        for Column { name, columns } in engine.arrays() {
            let array = PyArray2::<f64>::zeros(py, [engine.count(), columns], false);
            arrays.insert(name, array.unbind());
        }
        arrays.insert("box", PyArray2::<f64>::zeros(py, [1, 6], false).unbind());
        let simulation = Self {
            engine: Mutex::new(engine),
            arrays,
            trajectory: Mutex::new(None),
        };
        simulation.fill(py)?;
        Ok(simulation)
    }

    fn engine(&self) -> PyResult<MutexGuard<'_, Box<dyn Live>>> {
        lock(&self.engine)
    }

    fn with<T>(&self, work: impl FnOnce(&mut Box<dyn Live>) -> Result<T>) -> PyResult<T> {
        work(&mut *self.engine()?).map_err(|error| raised(&error))
    }

    /// Copies the state into the arrays.
    fn fill(&self, py: Python<'_>) -> PyResult<()> {
        let engine = self.engine()?;
        for (name, array) in &self.arrays {
            let mut rows = array.bind(py).try_readwrite()?;
            let rows = rows.as_slice_mut()?;
            match *name {
                "box" => rows.copy_from_slice(&engine.space()),
                name => engine.copy(name, rows),
            }
        }
        Ok(())
    }
}

/// The exception for an error; a setting that cannot be read is a ConfigError.
fn raised(error: &anyhow::Error) -> PyErr {
    match error.downcast_ref::<serde_json::Error>() {
        Some(_) => ConfigError::new_err(remedy::message(error)),
        None => exception(error),
    }
}

fn lock<T>(mutex: &Mutex<T>) -> PyResult<MutexGuard<'_, T>> {
    let failed =
        |_| PyRuntimeError::new_err("an earlier call has failed; begin the simulation again");
    mutex.lock().map_err(failed)
}

fn given(arrays: BTreeMap<String, PyReadonlyArray2<'_, f64>>) -> Arrays {
    let rows = |(name, array): (String, PyReadonlyArray2<'_, f64>)| {
        let columns = array.shape()[1];
        let values = array.as_array().iter().copied().collect();
        (name, Rows { columns, values })
    };
    arrays.into_iter().map(rows).collect()
}
