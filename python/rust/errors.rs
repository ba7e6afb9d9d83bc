//! Errors as Python exceptions: one for each kind of error that a user can act on.

use protomer_body::BodyError;
use protomer_common::remedy;
use protomer_field::FieldError;
use protomer_io::IoError;
use protomer_kernel::KernelError;
use protomer_linkage::CrystalError;
use protomer_mc::McError;
use pyo3::create_exception;
use pyo3::exceptions::{PyFileNotFoundError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyType};
use std::io::ErrorKind;
use std::path::Path;

create_exception!(
    protomer,
    ProtomerError,
    PyValueError,
    "An error of a verb: where, what, and what to do about it."
);
create_exception!(
    protomer,
    ParseError,
    ProtomerError,
    "A file that cannot be understood; has `path` and `line`."
);
create_exception!(
    protomer,
    ConfigError,
    ProtomerError,
    "An invalid argument or setting."
);
create_exception!(
    protomer,
    GeometryError,
    ProtomerError,
    "Bodies that overlap, meshes that bound no solid, networks that contradict themselves."
);
create_exception!(
    protomer,
    ConvergenceError,
    ProtomerError,
    "A solve, a step or a minimisation that did not come to its end."
);
create_exception!(
    protomer,
    CheckpointError,
    ProtomerError,
    "A checkpoint that belongs to something else."
);
create_exception!(
    protomer,
    StoppedError,
    ProtomerError,
    "Stopped before the end; the same call continues the work."
);

/// The class of errors about missing files: a `ProtomerError` and a `FileNotFoundError`.
///
/// # Errors
/// If the interpreter cannot make the class.
pub fn missing_file_error(py: Python<'_>) -> PyResult<&Py<PyType>> {
    static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    CLASS.get_or_try_init(py, || {
        let bases = (
            py.get_type::<ProtomerError>(),
            py.get_type::<PyFileNotFoundError>(),
        );
        let fields = PyDict::new(py);
        fields.set_item("__module__", "protomer")?;
        fields.set_item(
            "__doc__",
            "A file or a folder that does not exist; has `path`, if it is known.",
        )?;
        let made = py
            .get_type::<PyType>()
            .call1(("MissingFileError", bases, fields))?;
        Ok(made.cast_into::<PyType>()?.unbind())
    })
}

/// The exception for an error of a verb.
pub fn exception(error: &anyhow::Error) -> PyErr {
    let message = remedy::message(error);
    for cause in error.chain() {
        match cause.downcast_ref() {
            Some(IoError::File { path, cause, .. }) if cause.kind() == ErrorKind::NotFound => {
                return missing_file(message, Some(path));
            }
            _ => {}
        }
        match cause.downcast_ref::<std::io::Error>() {
            Some(cause) if cause.kind() == ErrorKind::NotFound => {
                return missing_file(message, None);
            }
            _ => {}
        }
        if let Some(IoError::Parse { file, line, .. }) = cause.downcast_ref() {
            return parse_error(message, file, *line);
        }
        if let Some(BodyError::Parse { file, line, .. }) = cause.downcast_ref() {
            return parse_error(message, file, *line);
        }
        if cause.is::<protomer_cli::UsageError>() {
            return ConfigError::new_err(message);
        }
        match cause.downcast_ref() {
            Some(McError::OverlappingStart { .. } | McError::NonFiniteEnergy { .. }) => {
                return GeometryError::new_err(message);
            }
            Some(McError::ForeignCheckpoint(_) | McError::UnusableTable(_)) => {
                return CheckpointError::new_err(message);
            }
            Some(McError::BadSetting { .. }) => return ConfigError::new_err(message),
            _ => {}
        }
        match cause.downcast_ref() {
            Some(FieldError::NotConverged { .. }) => return ConvergenceError::new_err(message),
            Some(FieldError::BadSetting { .. } | FieldError::TooLarge { .. }) => {
                return ConfigError::new_err(message);
            }
            _ => {}
        }
        if is_setting_of_a_network(cause) {
            return ConfigError::new_err(message);
        }
        match kernel_error(cause) {
            Some(KernelError::OutOfRange { .. } | KernelError::BoxTooSmall { .. }) => {
                return ConfigError::new_err(message);
            }
            Some(_) => return GeometryError::new_err(message),
            None => {}
        }
        match cause.downcast_ref() {
            Some(CrystalError::BadSetting { .. }) => return ConfigError::new_err(message),
            Some(
                CrystalError::StepTooLarge { .. }
                | CrystalError::Jammed { .. }
                | CrystalError::NoMinimum(_),
            ) => {
                return ConvergenceError::new_err(message);
            }
            Some(_) => return GeometryError::new_err(message),
            None => {}
        }
        if let Some(error) = cause.downcast_ref() {
            return of_hard_bodies(error, message);
        }
        if let Some(error) = cause.downcast_ref() {
            return of_motion(error, message);
        }
    }
    ProtomerError::new_err(message)
}

fn of_hard_bodies(error: &protomer_hpmc::Error, message: String) -> PyErr {
    use protomer_hpmc::Error;
    match error {
        Error::Jammed { .. }
        | Error::Dense { .. }
        | Error::Overlap { .. }
        | Error::PlacedOverlap { .. } => GeometryError::new_err(message),
        _ => ConfigError::new_err(message),
    }
}

fn of_motion(error: &protomer_md::Error, message: String) -> PyErr {
    use protomer_md::Error;
    match error {
        Error::Overlap | Error::Met { .. } | Error::OverlappingParts { .. } | Error::NoVolume => {
            GeometryError::new_err(message)
        }
        Error::Diverged => ConvergenceError::new_err(message),
        Error::OtherBodies => CheckpointError::new_err(message),
        _ => ConfigError::new_err(message),
    }
}

#[cfg(feature = "learning")]
fn is_setting_of_a_network(cause: &(dyn std::error::Error + 'static)) -> bool {
    use protomer_learn::LearnError;
    matches!(cause.downcast_ref(), Some(LearnError::Settings(_)))
}

#[cfg(not(feature = "learning"))]
fn is_setting_of_a_network(_: &(dyn std::error::Error + 'static)) -> bool {
    false
}

/// The kernel error that this is, or that another crate passes on.
fn kernel_error<'a>(cause: &'a (dyn std::error::Error + 'static)) -> Option<&'a KernelError> {
    if let Some(McError::Kernel(error)) = cause.downcast_ref() {
        return Some(error);
    }
    if let Some(BodyError::Kernel(error)) = cause.downcast_ref() {
        return Some(error);
    }
    if let Some(protomer_hpmc::Error::Shape(error)) = cause.downcast_ref() {
        return Some(error);
    }
    cause.downcast_ref()
}

/// Adds the location as attributes.
fn parse_error(message: String, path: &str, line: usize) -> PyErr {
    let error = ParseError::new_err(message);
    Python::attach(|py| {
        let value = error.value(py);
        // An exception without attributes is better than another exception.
        let _ = value.setattr("path", path);
        let _ = value.setattr("line", line);
    });
    error
}

/// Adds the path, if it is known.
fn missing_file(message: String, path: Option<&Path>) -> PyErr {
    Python::attach(|py| {
        let class = match missing_file_error(py) {
            Ok(class) => class.bind(py).clone(),
            Err(error) => return error,
        };
        let error = PyErr::from_type(class, message);
        if let Some(path) = path {
            // An exception without attributes is better than another exception.
            let _ = error.value(py).setattr("path", path);
        }
        error
    })
}
