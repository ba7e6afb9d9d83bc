//! Locks a directory against other processes.

use crate::{Error, Result};
use std::fs::{File, TryLockError};
use std::path::Path;

/// The file that is locked while a process works in a directory.
pub const LOCK: &str = ".lock";

/// Whether others may work in a directory too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hold {
    /// Exclusive lock: no other process may work in the directory.
    Alone,
    /// Shared lock: other processes that share it may work in the directory too.
    Shared,
}

/// Locks a directory against other processes, where the file system can, for as long as the file is
/// open.
///
/// ```
/// use protomer_results::lock::{Hold, lock};
/// # let folder = tempfile::tempdir().unwrap();
/// let held = lock(folder.path(), Hold::Alone).unwrap();
/// assert!(lock(folder.path(), Hold::Alone).is_err());
/// drop(held);
/// assert!(lock(folder.path(), Hold::Alone).is_ok());
/// ```
///
/// # Errors
/// [`Error::Busy`] if another process holds it; [`Error::File`] if the file cannot be written.
pub fn lock(directory: &Path, hold: Hold) -> Result<File> {
    lock_file(&directory.join(LOCK), hold)
}

/// Locks a part of a directory, represented by its own lock file.
///
/// # Errors
/// As [`lock`].
pub fn lock_file(file: &Path, hold: Hold) -> Result<File> {
    let directory = file.parent().unwrap_or(file);
    // Never removed: another process may hold or wait for it,
    // and a new file under the same name would be another lock.
    let file = File::create(file).map_err(Error::file("write into", directory))?;
    let held = match hold {
        Hold::Alone => file.try_lock(),
        Hold::Shared => file.try_lock_shared(),
    };
    match held {
        Err(TryLockError::WouldBlock) => Err(Error::Busy(directory.to_owned())),
        // Some network file systems have no locks; work on them proceeds without.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
    }
}
