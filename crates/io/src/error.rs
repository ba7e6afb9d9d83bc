//! The one error type of this crate: where, what, and what to do about it.

use std::path::{Path, PathBuf};

/// What can go wrong between bytes and values.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// Bytes that could not be understood.
    #[error("{}: {cause}; {remedy}", place(file, *line))]
    Parse {
        /// Name of the file as the user gave it.
        file: String,
        /// Line, counted from one; zero where the whole file is meant.
        line: usize,
        /// What is wrong.
        cause: String,
        /// What the user can do.
        remedy: String,
    },
    /// A file larger than the reader is willing to hold in memory.
    #[error("{file}: it holds more than {limit_bytes} bytes{}; {remedy}", if *.compressed { " once decompressed" } else { "" })]
    TooLarge {
        /// Name of the file.
        file: String,
        /// The limit that was passed.
        limit_bytes: u64,
        /// Whether the limit was met by decompressed bytes.
        compressed: bool,
        /// What the user can do.
        remedy: String,
    },
    /// The operating system refused.
    #[error("cannot {action} {}: {cause}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What was tried, as a verb phrase ("read", "write").
        action: &'static str,
        /// The operating system's answer; part of the message, and so no source of its own.
        cause: std::io::Error,
    },
    /// Values that a format cannot hold.
    #[error("{cause}; {remedy}")]
    Unwritable {
        /// What does not fit.
        cause: String,
        /// What the caller can do.
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

    /// Turns an operating system's error into one that names the file and what was tried.
    pub(crate) fn at(path: &Path, action: &'static str) -> impl FnOnce(std::io::Error) -> Self {
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
