//! The one error type of this crate: where, what, and what to do about it.

use crate::ResultKind;
use std::path::{Path, PathBuf};

/// Errors of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system reported an error.
    #[error("cannot {action} {}", path.display())]
    File {
        /// The attempted operation, as a verb phrase ("read", "create the directory").
        action: &'static str,
        /// The file or directory.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A file could not be written, or a container is damaged.
    #[error(transparent)]
    Io(#[from] protomer_io::IoError),
    /// JSON or TOML that cannot be parsed.
    #[error("{}:{line}: {problem}", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// Line, counted from one.
        line: usize,
        /// Cause of the error, and what to do.
        problem: String,
    },
    /// A value that cannot be represented in JSON or TOML.
    #[error("{content} cannot be serialised: {cause}")]
    Unwritable {
        /// The value to be written.
        content: &'static str,
        /// Reason why the value cannot be represented.
        cause: String,
    },
    /// A file was given where a directory is needed.
    #[error("{} is a file; give a directory for the results", .0.display())]
    NotADirectory(PathBuf),
    /// The directory holds another kind of result.
    #[error("{} holds {holds}; give {}", path.display(), other_directory(wanted.as_ref()))]
    OtherKind {
        /// The directory.
        path: PathBuf,
        /// Kind of results in the directory.
        holds: ResultKind,
        /// Kind of results that the directory should hold; `None` if any directory but this one
        /// will do.
        wanted: Option<ResultKind>,
    },
    /// The directory holds the same kind of result with other settings.
    #[error(
        "{} holds {holds} with other settings ({differences}); choose another directory, or start \
         again with --force",
        path.display()
    )]
    OtherSettings {
        /// The directory.
        path: PathBuf,
        /// Name of the results in the directory.
        holds: String,
        /// The settings that differ, as in `seed: 1 there, 2 here`.
        differences: String,
    },
    /// The directory holds the same kind of result for other input or other settings.
    #[error(
        "{} holds {kind} with other input: an input file is another one, or has changed since; \
         choose another directory, or start again with --force",
        path.display()
    )]
    OtherInput {
        /// The directory.
        path: PathBuf,
        /// Kind of results in the directory.
        kind: ResultKind,
    },
    /// The settings match, but the existing run cannot be continued with them.
    #[error("{} {reason}, or choose another directory", path.display())]
    NoContinuation {
        /// The directory.
        path: PathBuf,
        /// Reason, and what to do instead.
        reason: String,
    },
    /// The settings in the directory are those of another version, or of something else.
    #[error(
        "{} does not hold {kind} of this version; choose another directory",
        path.display()
    )]
    OtherVersion {
        /// The directory.
        path: PathBuf,
        /// The expected kind.
        kind: ResultKind,
        /// The error in its settings.
        source: Box<Error>,
    },
    /// `--force` was given for a directory that holds no results of this kind.
    #[error(
        "{} does not hold {kind}, so --force does not remove it; choose another directory",
        path.display()
    )]
    Foreign {
        /// The directory.
        path: PathBuf,
        /// The expected kind.
        kind: ResultKind,
    },
    /// `--force` was given for a part of shared work.
    #[error(
        "a part of {0} cannot start again, because other parts may be at work; remove the \
         directory, or omit --force"
    )]
    SharedStart(ResultKind),
    /// Another process holds the directory.
    #[error("another process works in {}; wait for it, or choose another directory", .0.display())]
    Busy(PathBuf),
    /// A checkpoint is damaged.
    #[error("cannot continue {}; restore it, or start again with --force", path.display())]
    DamagedCheckpoint {
        /// The checkpoint.
        path: PathBuf,
        /// Error in the checkpoint.
        source: protomer_io::IoError,
    },
    /// A checkpoint holds something else than this version expects.
    #[error("{} was written by another version of protomer; start again with --force", path.display())]
    OldCheckpoint {
        /// The checkpoint.
        path: PathBuf,
        /// Error that names the mismatch.
        source: serde_json::Error,
    },
    /// A checkpoint belongs to other work.
    #[error(
        "{} is the checkpoint of a run with other settings or other input; choose another directory, \
         or start again with --force",
        .0.display()
    )]
    ForeignCheckpoint(PathBuf),
    /// A list of a checkpoint is not as long as the work needs it.
    #[error(
        "the checkpoint has {count} {list} where the run has {expected}; restore it, or start again \
         with --force"
    )]
    UnfitCheckpoint {
        /// Contents of the list, in the plural.
        list: &'static str,
        /// Length of the list.
        count: usize,
        /// The length that the work needs.
        expected: usize,
    },
    /// A log that a checkpoint vouches for cannot be read.
    #[error("cannot read the log {}; restore it, or start again with --force", path.display())]
    LostLog {
        /// The log.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A log differs from what its checkpoint vouches for.
    #[error("{} was changed since its checkpoint; restore it, or start again with --force", .0.display())]
    ChangedLog(PathBuf),
    /// A log lacks a column, or has one that this version does not write.
    #[error(
        "the log {} has {problem}, so another version wrote it; continue with that version, or start \
         again with --force",
        path.display()
    )]
    OtherColumns {
        /// The log.
        path: PathBuf,
        /// The column that is missing or unknown.
        problem: String,
    },
    /// A line of a log is not a row.
    #[error("{}:{line}: '{text}' is not a row of a log; run again with --force", path.display())]
    NotARow {
        /// The log.
        path: PathBuf,
        /// Line, counted from one.
        line: usize,
        /// The text of the line.
        text: String,
    },
    /// Text that does not name a part of some work.
    #[error("'{0}' is not a part; give one such as 2/8, from 1/8 to 8/8")]
    NotAShard(String),
}

/// The result of an operation of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// Converts an operating system error to one that names the file and the attempted operation.
    pub(crate) fn file(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Error::File {
            action,
            path,
            source,
        }
    }
}

fn other_directory(wanted: Option<&ResultKind>) -> String {
    match wanted {
        Some(kind) => format!("the directory of {kind}"),
        None => "another directory".into(),
    }
}
