//! `checkpoint.bin`: the state from which a run continues.

use crate::{Error, Result};
use protomer_io::atomic::write_bytes;
use protomer_io::container::Container;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// The name of the checkpoint in the directory of a run.
pub const CHECKPOINT: &str = "checkpoint.bin";

/// The header key for the identity of the work.
const IDENTITY: &str = "identity";

/// A state in bytes. Every serialisable struct is a checkpoint: JSON in a container with a
/// checksum, which also holds the identity of the work. An engine with its own format
/// implements this trait.
///
/// ```
/// use protomer_results::checkpoint::{read, write};
/// use serde::{Deserialize, Serialize};
///
/// #[derive(Debug, PartialEq, Serialize, Deserialize)]
/// struct State {
///     step: u64,
/// }
///
/// # let folder = tempfile::tempdir().unwrap();
/// let path = folder.path().join("checkpoint.bin");
/// write(&path, "walk", "identity", &State { step: 7 })?;
/// assert_eq!(read(&path, "walk", "identity")?, Some(State { step: 7 }));
/// assert!(read::<State>(&path, "walk", "another identity").is_err());
/// # Ok::<(), protomer_results::Error>(())
/// ```
pub trait Checkpoint: Sized {
    /// The bytes of a checkpoint of this kind, which belongs to the work of this identity.
    ///
    /// # Errors
    /// If the state cannot be serialised.
    fn to_bytes(&self, kind: &str, identity: &str) -> Result<Vec<u8>>;

    /// The state in these bytes.
    ///
    /// # Errors
    /// If they are damaged, or belong to another kind, another version or other work.
    fn from_bytes(path: &Path, kind: &str, identity: &str, bytes: &[u8]) -> Result<Self>;
}

impl<T: Serialize + DeserializeOwned> Checkpoint for T {
    fn to_bytes(&self, kind: &str, identity: &str) -> Result<Vec<u8>> {
        let unwritable = |cause: String| Error::Unwritable {
            content: "the state",
            cause,
        };
        let mut header =
            serde_json::to_value(self).map_err(|error| unwritable(error.to_string()))?;
        // Only objects have room for the identity.
        let Some(fields) = header.as_object_mut() else {
            return Err(unwritable("it is not a struct with named fields".into()));
        };
        fields.insert(IDENTITY.into(), identity.into());
        Ok(Container::new(kind, header).to_bytes()?)
    }

    fn from_bytes(path: &Path, kind: &str, identity: &str, bytes: &[u8]) -> Result<Self> {
        let name = path.display().to_string();
        let container = Container::from_bytes(&name, kind, bytes).map_err(|source| {
            Error::DamagedCheckpoint {
                path: path.to_owned(),
                source,
            }
        })?;
        let mut header = container.header;
        let owner = header
            .as_object_mut()
            .and_then(|fields| fields.remove(IDENTITY));
        // A valid checkpoint of other work would continue it under this one's name.
        if owner.as_ref().and_then(serde_json::Value::as_str) != Some(identity) {
            return Err(Error::ForeignCheckpoint(path.to_owned()));
        }
        serde_json::from_value(header).map_err(|source| Error::OldCheckpoint {
            path: path.to_owned(),
            source,
        })
    }
}

/// Reads the checkpoint in a file, if it exists.
///
/// # Errors
/// If it exists but cannot be used.
pub fn read<C: Checkpoint>(path: &Path, kind: &str, identity: &str) -> Result<Option<C>> {
    match protomer_io::input::read(path) {
        Ok(bytes) => C::from_bytes(path, kind, identity, &bytes).map(Some),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(Error::file("read", path)(error)),
    }
}

/// Refuses a state whose lists are not as long as those of the work: name, length and the length that
/// is needed. A checksum shows that a checkpoint is what was written, not that it fits. So every run
/// calls this for the lists that it has in memory before it takes them over.
///
/// ```
/// use protomer_results::checkpoint::require_lengths;
/// assert!(require_lengths(&[("positions", 12, 12), ("velocities", 12, 12)]).is_ok());
/// let error = require_lengths(&[("positions", 12, 12), ("velocities", 11, 12)]).unwrap_err();
/// assert!(error.to_string().contains("11 velocities where the run has 12"));
/// ```
///
/// # Errors
/// [`Error::UnfitCheckpoint`] names the first list of another length.
pub fn require_lengths(lists: &[(&'static str, usize, usize)]) -> Result<()> {
    for &(list, count, expected) in lists {
        if count != expected {
            return Err(Error::UnfitCheckpoint {
                list,
                count,
                expected,
            });
        }
    }
    Ok(())
}

/// Writes a checkpoint; the old one stays until the new one is complete.
///
/// # Errors
/// If the file cannot be written.
pub fn write<C: Checkpoint>(path: &Path, kind: &str, identity: &str, checkpoint: &C) -> Result<()> {
    let bytes = checkpoint.to_bytes(kind, identity)?;
    write_bytes(path, &bytes)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct State {
        steps: u64,
        position: f64,
    }

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct NewerState {
        steps: u64,
    }

    #[test]
    fn a_checkpoint_reads_back_and_others_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(CHECKPOINT);
        let state = State {
            steps: 3,
            position: 0.1 + 0.2,
        };
        assert_eq!(read::<State>(&path, "walk", "me").unwrap(), None);
        write(&path, "walk", "me", &state).unwrap();
        assert_eq!(read(&path, "walk", "me").unwrap(), Some(state));

        let refusal = |kind: &str, identity: &str| {
            read::<State>(&path, kind, identity)
                .unwrap_err()
                .to_string()
        };
        assert!(refusal("walk", "you").contains("other settings or other input"));
        assert!(refusal("swim", "me").contains("--force"));
        let newer = read::<NewerState>(&path, "walk", "me").unwrap_err();
        assert!(newer.to_string().contains("another version"));

        let mut bytes = std::fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        std::fs::write(&path, bytes).unwrap();
        assert!(refusal("walk", "me").contains("cannot continue"));
    }

    #[test]
    fn a_state_without_fields_is_no_checkpoint() {
        assert!(3_u64.to_bytes("walk", "me").is_err());
    }
}
