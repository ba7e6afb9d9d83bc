//! The tables of a folder of bodies: `ingest.csv`, a row per file, and `warnings.csv`, a row per warning
//! or error.

use super::ingest::{BodyMeasures, FileOutcome, MeshDistance};
use anyhow::{Context, Result};
use protomer_io::atomic::remove_abandoned_of;
use protomer_results::lock::lock_file;
use protomer_results::{FileRecord, Hold, Log, LogMark, ResultKind, Row, Shard};
use std::collections::HashSet;
use std::fs::File;
use std::path::{Path, PathBuf};

/// A file in `ingest.csv`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FileRow(pub Vec<String>);

/// A warning or an error in `warnings.csv`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct WarningRow([String; 3]);

impl FileRow {
    /// SHA-256 of the file when it was read; empty if it could not be read.
    pub fn sha256(&self) -> &str {
        self.0.last().map_or("", String::as_str)
    }
}

impl Row for FileRow {
    fn columns() -> Vec<&'static str> {
        vec![
            "file",
            "status",
            "body",
            "atoms",
            "residues",
            "net_charge_e",
            "mesh_area_angstrom2",
            "mesh_volume_angstrom3",
            "mesh_rms_distance_angstrom",
            "mesh_largest_distance_angstrom",
            "radius_angstrom",
            "warnings",
            "sha256",
        ]
    }

    fn to_cells(&self) -> Vec<String> {
        self.0.clone()
    }

    fn from_cells(cells: &[Option<&str>]) -> Option<Self> {
        let cells = cells.iter().map(|cell| cell.map(str::to_owned));
        cells.collect::<Option<_>>().map(Self)
    }
}

impl Row for WarningRow {
    fn columns() -> Vec<&'static str> {
        vec!["file", "kind", "message"]
    }

    fn to_cells(&self) -> Vec<String> {
        self.0.to_vec()
    }

    fn from_cells(cells: &[Option<&str>]) -> Option<Self> {
        let cells = cells.iter().map(|cell| cell.map(str::to_owned));
        let cells: Vec<String> = cells.collect::<Option<_>>()?;
        Some(Self(cells.try_into().ok()?))
    }
}

/// Record of an outcome, for the tables.
pub(super) fn record_of(outcome: &FileOutcome) -> FileRecord {
    let measures = |value: fn(&BodyMeasures) -> String| {
        let measures = outcome.measures.as_ref();
        measures.map(value).unwrap_or_default()
    };
    let distance = |value: fn(&MeshDistance) -> f64| {
        let distance = outcome.distance.as_ref().map(value);
        distance.map_or(String::new(), |angstrom| angstrom.to_string())
    };
    let body = outcome.body.as_ref();
    let row = vec![
        outcome.file.clone(),
        outcome.status.to_owned(),
        body.map(|body| body.display().to_string())
            .unwrap_or_default(),
        measures(|body| body.atoms.to_string()),
        measures(|body| body.residues.to_string()),
        measures(|body| body.net_charge_e.to_string()),
        measures(|body| body.mesh_area_angstrom2.to_string()),
        measures(|body| body.mesh_volume_angstrom3.to_string()),
        distance(|mesh| mesh.mesh_rms_distance_angstrom),
        distance(|mesh| mesh.mesh_largest_distance_angstrom),
        measures(|body| body.radius_angstrom.to_string()),
        outcome.warnings.len().to_string(),
        outcome.sha256.clone(),
    ];
    FileRecord {
        file: outcome.file.clone(),
        row,
        warnings: outcome.warnings.clone(),
        error: outcome.error.clone(),
    }
}

impl WarningRow {
    fn from_message(file: &str, kind: &str, message: &str) -> Self {
        Self([file, kind, message].map(str::to_owned))
    }
}

/// The files that a part writes along with the bodies.
pub(super) struct Paths {
    pub table: PathBuf,
    pub warnings_table: PathBuf,
    pub done: PathBuf,
    pub lock: PathBuf,
}

impl Paths {
    pub fn new(folder: &Path, shard: Shard) -> Self {
        let part = match shard.is_whole() {
            true => String::new(),
            false => format!("-{}-of-{}", shard.index, shard.of),
        };
        Self {
            table: folder.join(format!("ingest{part}.csv")),
            warnings_table: folder.join(format!("warnings{part}.csv")),
            done: folder.join(format!("ingest{part}.json")),
            lock: folder.join(format!(".ingest{part}.lock")),
        }
    }

    /// Makes the folder if it is missing, and holds the tables of a part for this process alone until the
    /// lock is dropped.
    ///
    /// # Errors
    /// If the folder cannot be made or is a voxel set, or another process holds the tables.
    pub fn claim(folder: &Path, shard: Shard) -> Result<(Self, File)> {
        ResultKind::VoxelSet.refuse_in(folder)?;
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot create the folder {}", folder.display()))?;
        let paths = Self::new(folder, shard);
        let held = lock_file(&paths.lock, Hold::Alone)?;
        Ok((paths, held))
    }

    /// Removes the files that this part was writing when it was killed. Other parts may be at work in
    /// the folder.
    pub fn remove_unfinished(&self, folder: &Path, bodies: &HashSet<&str>) -> Result<()> {
        let is_own = |file: &str| {
            let is_of_body = |(body, _ending): (&str, &str)| bodies.contains(body);
            self.done.ends_with(file) || file.rsplit_once('.').is_some_and(is_of_body)
        };
        Ok(remove_abandoned_of(folder, is_own)?)
    }
}

/// The two tables.
pub(super) struct Tables {
    files: Log,
    warnings: Log,
}

impl Tables {
    /// Opens the tables and cuts them back to these lengths.
    pub fn open(paths: &Paths, [table, warnings_table]: [&LogMark; 2]) -> Result<Self> {
        Ok(Self {
            files: Log::open::<FileRow>(&paths.table, table)?,
            warnings: Log::open::<WarningRow>(&paths.warnings_table, warnings_table)?,
        })
    }

    /// Appends the lines of a file.
    pub fn append(&mut self, record: &FileRecord) -> Result<()> {
        self.files.append(&FileRow(record.row.clone()))?;
        let warnings = record.warnings.iter().map(|text| ("warning", text));
        let errors = record.error.iter().map(|text| ("error", text));
        for (kind, text) in warnings.chain(errors) {
            let row = WarningRow::from_message(&record.file, kind, text);
            self.warnings.append(&row)?;
        }
        Ok(())
    }

    /// Writes what was appended, and returns the lengths.
    pub fn sync(&mut self) -> Result<(LogMark, LogMark)> {
        Ok((self.files.sync()?, self.warnings.sync()?))
    }
}
