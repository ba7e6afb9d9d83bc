//! Calls a verb on a separate thread, while this thread listens for Ctrl-C and reports progress.

use crate::errors::{StoppedError, exception};
use protomer_cli::{Command, Host, Outcome, ProgressListener, Reply};
use protomer_protein_verbs::stability::run::Column;
use protomer_results::Interrupt;
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde_json::Value;
use std::ffi::OsString;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

/// Interval for checking Ctrl-C and reporting progress.
const PAUSE: Duration = Duration::from_millis(50);

type Call = JoinHandle<anyhow::Result<Answer>>;
/// Units done, total units, name of a unit.
type Latest = Arc<Mutex<Option<(u64, u64, String)>>>;

/// Whether everything was done, the answer as Python values (`None` if there is none), the warnings, and
/// the figure of the answer (`None` if there is none).
type Called = (bool, Py<PyAny>, Vec<String>, Py<PyAny>);

/// Runs `protomer WORDS`.
///
/// `progress(done, total, unit)` is called in the calling thread. Ctrl-C stops the work at its next
/// step and raises KeyboardInterrupt; the same call continues it.
#[pyfunction]
#[pyo3(signature = (words, progress=None))]
pub fn call(py: Python<'_>, words: Vec<String>, progress: Option<Py<PyAny>>) -> PyResult<Called> {
    let interrupt = Interrupt::default();
    let latest = Latest::default();
    let host = Host {
        progress: progress.is_some().then(|| listener(&latest)),
        interrupt: Some(interrupt.clone()),
    };
    let (ended, end) = channel();
    let thread = std::thread::spawn(move || {
        let answer = protomer_cli::call(&words, host).and_then(Answer::from_reply);
        // Nobody listens any more only if the interpreter goes down.
        let _ = ended.send(());
        answer
    });
    let end = Mutex::new(end);
    let stopped = listen(py, &end, &latest, progress.as_ref()).inspect_err(|_| interrupt.request());
    let answer = join(py, thread)?;
    stopped?;
    match answer {
        Ok(Answer {
            outcome: Outcome::Stopped,
            ..
        }) => Err(StoppedError::new_err(
            "stopped before the end; the same call continues it",
        )),
        Ok(Answer {
            outcome,
            value,
            warnings,
            figure,
        }) => {
            let is_done = outcome == Outcome::Done;
            let figure = python_value(py, &figure)?;
            Ok((is_done, python_value(py, &value)?, warnings, figure))
        }
        Err(error) => Err(exception(&error)),
    }
}

/// The answer of a verb, independent of its thread.
struct Answer {
    outcome: Outcome,
    value: Value,
    warnings: Vec<String>,
    figure: Value,
}

impl Answer {
    fn from_reply(reply: Reply) -> anyhow::Result<Self> {
        Ok(Self {
            outcome: reply.outcome(),
            value: reply.value()?.unwrap_or_default(),
            warnings: reply.warnings().into_iter().map(str::to_owned).collect(),
            figure: reply.figure()?.unwrap_or_default(),
        })
    }
}

/// Keeps the latest progress for the calling thread.
fn listener(latest: &Latest) -> ProgressListener {
    let latest = Arc::clone(latest);
    Arc::new(move |done, total, unit| {
        if let Ok(mut latest) = latest.lock() {
            *latest = Some((done, total, unit.to_owned()));
        }
    })
}

/// A JSON value as Python has it: dictionaries keep the order of the keys, null is None.
fn python_value(py: Python<'_>, value: &Value) -> PyResult<Py<PyAny>> {
    Ok(match value {
        Value::Null => py.None(),
        Value::Bool(truth) => truth.into_py_any(py)?,
        Value::Number(number) => match (number.as_u64(), number.as_i64()) {
            (Some(natural), _) => natural.into_py_any(py)?,
            (None, Some(integer)) => integer.into_py_any(py)?,
            (None, None) => number.as_f64().into_py_any(py)?,
        },
        Value::String(text) => text.into_py_any(py)?,
        Value::Array(items) => {
            let items = items.iter().map(|item| python_value(py, item));
            PyList::new(py, items.collect::<PyResult<Vec<_>>>()?)?.into_py_any(py)?
        }
        Value::Object(fields) => {
            let dictionary = PyDict::new(py);
            for (key, field) in fields {
                dictionary.set_item(key, python_value(py, field)?)?;
            }
            dictionary.into_py_any(py)?
        }
    })
}

/// Until the work ends, or Ctrl-C or the progress function raises.
fn listen(
    py: Python<'_>,
    end: &Mutex<Receiver<()>>,
    latest: &Latest,
    progress: Option<&Py<PyAny>>,
) -> PyResult<()> {
    loop {
        // Only this function holds the lock; it makes the receiver one that may be waited for
        // without the interpreter.
        let state = py.detach(|| {
            end.lock()
                .map_or(Err(RecvTimeoutError::Disconnected), |end| {
                    end.recv_timeout(PAUSE)
                })
        });
        py.check_signals()?;
        let news = latest.lock().ok().and_then(|mut latest| latest.take());
        if let (Some(news), Some(progress)) = (news, progress) {
            progress.call1(py, news)?;
        }
        if !matches!(state, Err(RecvTimeoutError::Timeout)) {
            return Ok(());
        }
    }
}

fn join(py: Python<'_>, thread: Call) -> PyResult<anyhow::Result<Answer>> {
    py.detach(|| thread.join())
        .map_err(|_| PyRuntimeError::new_err("a fault inside protomer; please report it"))
}

/// The command line: the words after the program's name; returns the exit code.
#[pyfunction]
pub fn main(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| protomer_cli::run(std::iter::once("protomer".into()).chain(words)))
}

/// A command taken apart: verb, flags and their values (switches have none), places. Paths are made
/// absolute.
#[pyfunction]
#[allow(
    clippy::type_complexity,
    reason = "a tuple of lists is what Python unpacks"
)]
pub fn take_apart(
    words: Vec<String>,
) -> PyResult<(Vec<String>, Vec<(String, Option<String>)>, Vec<String>)> {
    let Command {
        verb,
        flags,
        places,
    } = Command::from_words(&words).map_err(|error| exception(&error.into()))?;
    Ok((verb, flags, places))
}

/// The verbs as functions: a list of groups, as `protomer_cli::python_functions` describes them.
#[pyfunction]
pub fn verbs(py: Python<'_>) -> PyResult<Py<PyAny>> {
    let groups = serde_json::to_value(protomer_cli::python_functions())
        .map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    python_value(py, &groups)
}

/// The columns of the log of a simulation, with their names in the table of a sweep.
#[pyfunction]
pub fn columns(py: Python<'_>) -> PyResult<Py<PyAny>> {
    let columns: Vec<Value> = Column::all().into_iter().map(Column::description).collect();
    python_value(py, &Value::Array(columns))
}
