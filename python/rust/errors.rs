//! Errors as Python exceptions: one for each kind of error that a user can act on.

use protomer_body::BodyError;
use protomer_crystal::CrystalError;
use protomer_field::FieldError;
use protomer_io::IoError;
use protomer_kernel::KernelError;
use protomer_learn::LearnError;
use protomer_mc::McError;
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

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

/// The exception for an error of a verb.
pub fn exception(error: &anyhow::Error) -> PyErr {
    let message = format!("{error:#}");
    for cause in error.chain() {
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
        if let Some(LearnError::Settings(_)) = cause.downcast_ref() {
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
    }
    ProtomerError::new_err(message)
}

/// The kernel error that this is, or that another crate passes on.
fn kernel_error<'a>(cause: &'a (dyn std::error::Error + 'static)) -> Option<&'a KernelError> {
    if let Some(McError::Kernel(error)) = cause.downcast_ref() {
        return Some(error);
    }
    if let Some(BodyError::Kernel(error)) = cause.downcast_ref() {
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
