//! A folder of bodies that are made on the way to something else, with the tables of `ingest`.

use super::ingest::{FileOutcome, IngestSettings, keep, refuse_path};
use super::tables::{Paths, Tables, record_of};
use anyhow::{Context, Result, bail};
use protomer_body::Draft;
use protomer_body::surface::ExactSurface;
use protomer_results::{FileRecord, LogMark, Shard};
use std::fs::File;
use std::path::{Path, PathBuf};

/// A folder of bodies, whose tables no other process may write.
pub struct BodyFolder {
    folder: PathBuf,
    settings: IngestSettings,
    paths: Paths,
    _held: File,
}

impl BodyFolder {
    /// Opens or makes a folder for the bodies of these names, all those of a part, and removes what an
    /// earlier run has not finished of them. With `force`, other bodies and tables are replaced.
    ///
    /// # Errors
    /// If a name is a path, or the folder cannot be made, holds other results or is in use.
    pub fn open(folder: &Path, names: &[String], shard: Shard, force: bool) -> Result<Self> {
        for name in names {
            refuse_path(name)?;
        }
        let (paths, held) = Paths::claim(folder, shard)?;
        if paths.done.exists() && !force {
            bail!(
                "{} is of 'protomer ingest --stream'; choose another folder, or replace its tables \
                 with --force",
                paths.done.display()
            );
        }
        let of_bodies = names.iter().map(String::as_str);
        paths.remove_unfinished(folder, &of_bodies.collect())?;
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

    /// Makes the body of a file and keeps it in the folder; returns the record of the file for the
    /// tables.
    ///
    /// # Errors
    /// If the body cannot be written, which says nothing of the file.
    pub fn keep(&self, file: &Path, draft: Draft, surface: ExactSurface) -> Result<FileRecord> {
        let name = draft.name().to_owned();
        let built = draft
            .finish(surface)
            .with_context(|| file.display().to_string());
        match built {
            Ok(built) => {
                let outcome = keep(file, &name, built, &self.folder, &self.settings)?;
                Ok(record_of(&outcome))
            }
            Err(error) => Ok(self.failed(file, &error)),
        }
    }

    /// Record of a file without a body, for the tables.
    pub fn failed(&self, file: &Path, error: &anyhow::Error) -> FileRecord {
        record_of(&FileOutcome::failed(file, error))
    }

    /// The table with a row per warning or error.
    pub fn warnings_table(&self) -> &Path {
        &self.paths.warnings_table
    }

    /// Writes the tables, and returns the number of files without a body and that of all files.
    ///
    /// # Errors
    /// Names the file that cannot be written; and the errors of the records.
    pub fn write_tables(
        &self,
        records: impl Iterator<Item = Result<FileRecord>>,
    ) -> Result<[usize; 2]> {
        if self.paths.done.exists() {
            std::fs::remove_file(&self.paths.done)
                .with_context(|| format!("cannot remove {}", self.paths.done.display()))?;
        }
        let begin = LogMark::default();
        let mut tables = Tables::open(&self.paths, [&begin, &begin])?;
        let (mut failed, mut files) = (0, 0);
        for record in records {
            let record = record?;
            failed += usize::from(record.error.is_some());
            files += 1;
            tables.append(&record)?;
        }
        tables.sync()?;
        Ok([failed, files])
    }
}

/// Whether a folder has the tables of a part, or those of the first of its parts.
pub fn has_tables(folder: &Path, shard: Shard) -> bool {
    let of_first_part = |name: &str| name.starts_with("ingest-1-of-") && name.ends_with(".csv");
    let mut entries = folder.read_dir().into_iter().flatten().flatten();
    Paths::new(folder, shard).table.exists()
        || entries.any(|entry| entry.file_name().to_str().is_some_and(of_first_part))
}
