//! The kind of results in a directory.
//!
//! Every directory of results states its kind: in the key `kind` of `run.json`, or in the
//! attributes of the zarr group for a voxel set. Only this module reads it. Several verbs use the
//! same file names; the kind prevents them from writing into each other's results.

use crate::{Error, Result, ResultKind, record};
use std::path::Path;

impl ResultKind {
    /// The kind of results in a directory; `None` if there are none that can be recognised.
    pub fn detect(directory: &Path) -> Option<Self> {
        // What a directory states counts before what its files look like.
        recorded(directory).or_else(|| earlier::kind_of(directory))
    }

    /// Refuses a directory that holds another kind of result. One without results is accepted.
    ///
    /// # Errors
    /// [`Error::OtherKind`].
    pub fn refuse_other(&self, directory: &Path) -> Result<()> {
        match Self::detect(directory) {
            Some(other) if other != *self => Err(Error::OtherKind {
                path: directory.to_owned(),
                holds: other,
                wanted: None,
            }),
            _ => Ok(()),
        }
    }

    /// Refuses a directory that holds this kind, for files that may lie next to any other result. A
    /// voxel set is replaced as a whole, with everything in its directory.
    ///
    /// # Errors
    /// [`Error::OtherKind`].
    pub fn refuse_in(&self, directory: &Path) -> Result<()> {
        match Self::detect(directory) {
            Some(kind) if kind == *self => Err(Error::OtherKind {
                path: directory.to_owned(),
                holds: kind,
                wanted: None,
            }),
            _ => Ok(()),
        }
    }

    /// Refuses to read a directory that holds another kind of result. One without results is left
    /// to the reader, which names the missing file.
    ///
    /// # Errors
    /// [`Error::OtherKind`] says what it should hold.
    pub fn expect_in(&self, directory: &Path) -> Result<()> {
        match Self::detect(directory) {
            Some(other) if other != *self => Err(Error::OtherKind {
                path: directory.to_owned(),
                holds: other,
                wanted: Some(self.clone()),
            }),
            _ => Ok(()),
        }
    }
}

/// The kind that a directory states; `None` if the file cannot be read. The error is reported by
/// the code that needs the file.
fn recorded(directory: &Path) -> Option<ResultKind> {
    // A record of an earlier version has no kind; the other file is asked then.
    let record = read(directory, record::FILE).unwrap_or_default();
    let kind = match record.get("kind") {
        Some(kind) => kind.clone(),
        None => read(directory, "zarr.json")?
            .get("attributes")?
            .get("kind")?
            .clone(),
    };
    serde_json::from_value(kind).ok()
}

fn read(directory: &Path, name: &str) -> Option<serde_json::Value> {
    let bytes = protomer_io::input::read(directory.join(name)).ok()?;
    serde_json::from_slice(&bytes).ok()
}

/// Recognises directories of earlier versions, which did not state their kind, by their files.
mod earlier {
    use super::ResultKind;
    use std::path::Path;

    /// Sets of keys of `run.toml` and `settings.toml` that are unique to one kind, in the order to
    /// look for them. They must also tell these kinds from newer ones: work that has just begun has
    /// settings, but no record yet.
    const KEYS: [(&str, &[&str], ResultKind); 5] = [
        ("run.toml", &["salt_M", "sweeps"], ResultKind::Sweep),
        ("run.toml", &["sweep"], ResultKind::LatticeSweep),
        ("run.toml", &["rows"], ResultKind::LatticeRun),
        ("settings.toml", &["base"], ResultKind::Search),
        ("settings.toml", &["training"], ResultKind::Training),
    ];

    /// Sets of files that are unique to one kind.
    const FILES: [(&[&str], ResultKind); 4] = [
        (&["zarr.json"], ResultKind::VoxelSet),
        (
            &["result.json", "network.toml"],
            ResultKind::ElasticConstants,
        ),
        (&["tables.json"], ResultKind::FrameworkTables),
        (&["run.json", "checkpoint.bin"], ResultKind::Simulation),
    ];

    pub fn kind_of(directory: &Path) -> Option<ResultKind> {
        for file in ["run.toml", "settings.toml"] {
            if let Some(settings) = table(&directory.join(file)) {
                return kind_of_settings(file, &settings);
            }
        }
        for (files, kind) in FILES {
            // All of them: some names occur in several kinds.
            if files.iter().all(|file| directory.join(file).is_file()) {
                return Some(kind);
            }
        }
        None
    }

    fn kind_of_settings(file: &str, settings: &toml::Table) -> Option<ResultKind> {
        for (settings_file, keys, kind) in KEYS {
            if settings_file == file && keys.iter().all(|key| settings.contains_key(*key)) {
                return Some(kind);
            }
        }
        None
    }

    fn table(path: &Path) -> Option<toml::Table> {
        protomer_io::input::read_to_string(path).ok()?.parse().ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_says_what_it_holds_and_older_ones_are_recognised() {
        type Case<'a> = (&'a [(&'a str, &'a str)], Option<ResultKind>);
        let cases: [Case; 10] = [
            (
                &[("run.json", r#"{"kind": "lattice run"}"#)],
                Some(ResultKind::LatticeRun),
            ),
            (
                &[("zarr.json", r#"{"attributes": {"kind": "voxel set"}}"#)],
                Some(ResultKind::VoxelSet),
            ),
            // The stated kind takes precedence over the files.
            (
                &[
                    ("run.json", r#"{"kind": "sweep"}"#),
                    ("run.toml", "rows = 3"),
                ],
                Some(ResultKind::Sweep),
            ),
            (
                &[
                    ("run.json", "{}"),
                    ("run.toml", "salt_M = [0.1]\nsweeps = 7"),
                ],
                Some(ResultKind::Sweep),
            ),
            // Two bodies, before the first record.
            (&[("run.toml", "salt_M = [0.1]")], None),
            (
                &[("run.toml", "rows = 3\n[sweep]\n")],
                Some(ResultKind::LatticeSweep),
            ),
            (
                &[("settings.toml", "[base.training]\n")],
                Some(ResultKind::Search),
            ),
            (&[("zarr.json", "{}")], Some(ResultKind::VoxelSet)),
            (
                &[("run.json", "{}"), ("checkpoint.bin", "")],
                Some(ResultKind::Simulation),
            ),
            (&[("notes.txt", "mine")], None),
        ];
        for (files, expected) in cases {
            let folder = tempfile::tempdir().unwrap();
            for (name, text) in files {
                std::fs::write(folder.path().join(name), text).unwrap();
            }
            assert_eq!(ResultKind::detect(folder.path()), expected, "{files:?}");
        }
    }
}
