//! The one error type of this crate: where, what, and what to do about it.

use std::path::{Path, PathBuf};

/// Errors of reading and writing files.
///
/// ```
/// use protomer_io::points::read_xyzr;
/// let message = read_xyzr("two.xyzr", b"0 0 0 1.5\n0 0 3\n").map_err(|error| error.to_string());
/// assert_eq!(message, Err("two.xyzr:2: the radius is missing; complete the line".to_owned()));
/// ```
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// Bytes that could not be parsed.
    #[error("{}: {cause}; {remedy}", place(file, *line))]
    Parse {
        /// Name of the file as the user gave it.
        file: String,
        /// Line, counted from one; zero for the whole file.
        line: usize,
        /// Cause of the error.
        cause: String,
        /// Action that the user can take.
        remedy: String,
    },
    /// A file larger than the reader accepts.
    #[error("{file}: it holds more than {limit_bytes} bytes{}; {remedy}", if *.compressed { " once decompressed" } else { "" })]
    TooLarge {
        /// Name of the file.
        file: String,
        /// The limit that was passed.
        limit_bytes: u64,
        /// Whether the limit applies to decompressed bytes.
        compressed: bool,
        /// Action that the user can take.
        remedy: String,
    },
    /// The operating system reported an error.
    #[error("cannot {action} {}: {cause}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// The attempted operation, as a verb phrase ("read", "write").
        action: &'static str,
        /// The error of the operating system; part of the message, so not a separate source.
        cause: std::io::Error,
    },
    /// Values that a format cannot represent.
    #[error("{cause}; {remedy}")]
    Unwritable {
        /// Cause of the error.
        cause: String,
        /// Action that the caller can take.
        remedy: String,
    },
}

/// The result of an operation of this crate.
pub type Result<T> = std::result::Result<T, IoError>;

impl IoError {
    pub(crate) fn parse(
        file: &str,
        line: usize,
        cause: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        IoError::Parse {
            file: file.to_owned(),
            line,
            cause: cause.into(),
            remedy: remedy.into(),
        }
    }

    pub(crate) fn unwritable(cause: impl Into<String>, remedy: impl Into<String>) -> Self {
        IoError::Unwritable {
            cause: cause.into(),
            remedy: remedy.into(),
        }
    }

    /// Converts an operating system error to one that names the file and the attempted operation.
    pub(crate) fn file(path: &Path, action: &'static str) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |cause| IoError::File {
            path,
            action,
            cause,
        }
    }
}

fn place(file: &str, line: usize) -> String {
    if line == 0 {
        file.to_owned()
    } else {
        format!("{file}:{line}")
    }
}
