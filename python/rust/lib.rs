//! The native half of the Python package: verbs are called by their words, bodies are arrays.
//! Everything that a user sees is in `python/protomer`.

mod assembly;
mod body;
mod errors;
#[cfg(feature = "learning")]
mod sets;
mod simulation;
mod verbs;

use pyo3::prelude::*;

/// The native module `protomer._protomer`.
#[pymodule]
mod _protomer {
    #[pymodule_export]
    use crate::assembly::{Trajectory, read_assembly};
    #[pymodule_export]
    use crate::body::Body;
    #[pymodule_export]
    use crate::errors::{
        CheckpointError, ConfigError, ConvergenceError, GeometryError, ParseError, ProtomerError,
        StoppedError,
    };
    #[cfg(feature = "learning")]
    #[pymodule_export]
    use crate::sets::parts;
    #[pymodule_export]
    use crate::simulation::LiveSimulation;
    #[pymodule_export]
    use crate::verbs::{call, columns, main, take_apart, verbs};
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let missing = crate::errors::missing_file_error(module.py())?;
        module.add("MissingFileError", missing.bind(module.py()))?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
