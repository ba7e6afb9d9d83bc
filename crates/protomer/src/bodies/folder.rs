//! A folder of bodies that are made on the way to something else, with the tables of `ingest`.

use super::ingest::{FileOutcome, IngestSettings, keep};
use super::tables::{Entry, Paths, Tables};
use anyhow::{Context, Result};
use protomer_body::Draft;
use protomer_body::surface::ExactSurface;
use protomer_io::atomic::remove_abandoned_of;
use protomer_results::lock::lock_file;
use protomer_results::{Hold, LogMark, ResultKind, Shard};
use std::collections::HashSet;
use std::fs::File;
use std::path::{Path, PathBuf};

/// A folder of bodies, which no other process may add to.
pub struct BodyFolder {
    folder: PathBuf,
    settings: IngestSettings,
    paths: Paths,
    _held: File,
}

impl BodyFolder {
    /// Opens or makes a folder for the bodies of these names, which are those of a part, and removes
    /// what was not finished of them.
    ///
    /// # Errors
    /// If the folder cannot be made, holds other results or is in use.
    pub fn open(folder: &Path, names: &HashSet<String>, shard: Shard, force: bool) -> Result<Self> {
        ResultKind::VoxelSet.refuse_in(folder)?;
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot create the folder {}", folder.display()))?;
        let paths = Paths::new(folder, shard);
        let held = lock_file(&paths.lock, Hold::Alone)?;
        let is_own = |file: &str| {
            let stem = file.rsplit_once('.').map(|(stem, _)| stem);
            stem.is_some_and(|stem| names.contains(stem))
        };
        remove_abandoned_of(folder, is_own)?;
        Ok(Self {
            folder: folder.to_owned(),
            settings: IngestSettings {
                force,
                ..IngestSettings::default()
            },
            paths,
            _held: held,
        })
    }

    /// Makes the body of a file and keeps it in the folder; returns what the tables say of it.
    pub fn keep(&self, file: &Path, draft: Draft, surface: ExactSurface) -> Entry {
        let name = draft.name().to_owned();
        let built = draft
            .finish(surface)
            .with_context(|| file.display().to_string());
        let kept = built.and_then(|built| keep(file, &name, built, &self.folder, &self.settings));
        match kept {
            Ok(outcome) => Entry::of(&outcome),
            Err(error) => self.failed(file, &error),
        }
    }

    /// What the tables say of a file without a body.
    pub fn failed(&self, file: &Path, error: &anyhow::Error) -> Entry {
        Entry::of(&FileOutcome::failed(file, error))
    }

    /// Whether the tables are there, or those of a first part.
    pub fn has_tables(&self) -> bool {
        let of_first_part = |name: &str| name.starts_with("ingest-1-of-") && name.ends_with(".csv");
        let mut names = self.folder.read_dir().into_iter().flatten().flatten();
        self.paths.table.exists()
            || names.any(|entry| entry.file_name().to_str().is_some_and(of_first_part))
    }

    /// Writes the tables.
    ///
    /// # Errors
    /// Names the file that cannot be written; and the errors of the entries.
    pub fn write_tables(&self, entries: impl Iterator<Item = Result<Entry>>) -> Result<()> {
        let begin = LogMark::default();
        let mut tables = Tables::open(&self.paths, [&begin, &begin])?;
        for entry in entries {
            tables.append(&entry?)?;
        }
        tables.sync()?;
        Ok(())
    }
}
