//! Directories at work: what their records say if the process must end in the middle of a step.

use crate::{Exit, Record, Result};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Progress at the last checkpoint in this process, if there was one.
type Saved = Option<u64>;

/// Directories whose records say that they are running, for all threads of a piece of work.
#[derive(Debug, Clone, Default)]
pub(crate) struct AtWork(Arc<Mutex<BTreeMap<PathBuf, Saved>>>);

impl AtWork {
    /// Takes note of a directory before its record says that it is running.
    pub fn begin(&self, directory: &Path) {
        self.lock().insert(directory.to_owned(), None);
    }

    /// Takes note of a checkpoint.
    pub fn saved(&self, directory: &Path, done: u64) {
        if let Some(saved) = self.lock().get_mut(directory) {
            *saved = Some(done);
        }
    }

    /// Writes the record of how the work in a directory ended, which [`AtWork::stop`] leaves alone then.
    ///
    /// # Errors
    /// Those of `write`.
    pub fn end<T, E>(
        &self,
        directory: &Path,
        write: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        let mut directories = self.lock();
        // While the lock is held: `stop` either comes before, or finds the directory gone.
        let written = write();
        directories.remove(directory);
        written
    }

    /// Records the stop of every directory that is still at work. What cannot be written stays as it is:
    /// the process is about to end.
    pub fn stop(&self, exit: &Exit) {
        // Whoever holds the lock is writing such a record; a full disk must not hold up the end.
        let Ok(directories) = self.0.try_lock() else {
            return;
        };
        for (directory, saved) in directories.iter() {
            let Ok(Some(record)) = Record::read(directory) else {
                continue;
            };
            // Another end may have been written since, and it is the truer one.
            if record.exit == Exit::Running {
                let stopped = Record {
                    exit: exit.clone(),
                    // The checkpoint of this process is newer than
                    // the record, which is written at its start.
                    done: saved.or(record.done),
                    ..record
                };
                let _ = stopped.write(directory);
            }
        }
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<PathBuf, Saved>> {
        // The map is whole after each change, also after a panic elsewhere.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
