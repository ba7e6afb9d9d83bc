//! What to do about errors of the operating system, which say only what happened.

use anyhow::Error;
use protomer_io::IoError;
use std::io::{self, ErrorKind};

/// An error in full, with a remedy if the operating system is its cause and nothing in it says what
/// to do.
///
/// ```
/// use anyhow::Context;
/// use protomer_common::remedy::message;
/// let error = std::fs::read("nowhere.pdb").context("cannot read nowhere.pdb").unwrap_err();
/// assert!(message(&error).ends_with("; check the path"), "{}", message(&error));
/// let error = protomer_io::atomic::write_atomically("no/a.csv".as_ref(), |file| file.write_all(b"1")).unwrap_err();
/// assert!(message(&error.into()).ends_with("; check the path"));
/// let error = std::fs::read("a.body").context("cannot read a.body; make it first").unwrap_err();
/// assert!(!message(&error).contains("check the path"));
/// ```
pub fn message(error: &Error) -> String {
    let message = format!("{error:#}");
    match remedy(error) {
        // Remedies stand behind a semicolon.
        Some(remedy) if !message.contains("; ") => format!("{message}; {remedy}"),
        _ => message,
    }
}

fn remedy(error: &Error) -> Option<&'static str> {
    let cause = error.chain().find_map(|error| match error.downcast_ref() {
        Some(IoError::File { cause, .. }) => Some(cause),
        _ => error.downcast_ref(),
    });
    match cause.map(io::Error::kind)? {
        ErrorKind::NotFound => Some("check the path"),
        ErrorKind::PermissionDenied => Some("check the permissions, or name another place"),
        ErrorKind::IsADirectory => Some("name a file"),
        ErrorKind::NotADirectory => Some("name a folder"),
        ErrorKind::FileTooLarge => {
            Some("raise the limit of the size of files (ulimit -f), then repeat the command")
        }
        ErrorKind::StorageFull => Some("make room, then repeat the command"),
        _ => None,
    }
}
