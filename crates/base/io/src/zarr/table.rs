//! The table of properties: a row of numbers per sample, written and read a file at a time.

use super::group::words;
use super::layout::{self, Kind, PROPERTIES, in_order, succeeded};
use super::samples::MAKE_AGAIN;
use super::stored::Stored;
use crate::{IoError, Result};
use serde_json::{Map, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zarrs::array::Array;
use zarrs::filesystem::FilesystemStore;

/// Rows in one file: few, because a file is put together and taken apart in memory.
const ROWS_PER_FILE: u64 = 1 << 10;

/// Writes the table.
pub(super) struct TableWriter {
    array: Array<FilesystemStore>,
    width: usize,
    rows_per_file: usize,
    waiting: Vec<f64>,
    rows: u64,
    files: u64,
}

impl TableWriter {
    pub(super) fn new(
        store: &Arc<FilesystemStore>,
        columns: &[String],
        samples: u64,
    ) -> Result<Self> {
        // A table without columns is one wide, so that its files have a size.
        let width = columns.len().max(1);
        let rows_per_file = samples.clamp(1, ROWS_PER_FILE);
        let array = layout::array(
            store,
            PROPERTIES,
            Kind::Properties,
            &[samples, width as u64],
            &[rows_per_file, width as u64],
            Map::from_iter([("columns".to_owned(), json!(columns))]),
        )?;
        Ok(Self {
            array,
            width: columns.len(),
            rows_per_file: rows_per_file as usize,
            waiting: Vec::new(),
            rows: 0,
            files: 0,
        })
    }

    /// The rows so far.
    pub(super) fn rows(&self) -> u64 {
        self.rows
    }

    pub(super) fn push(&mut self, row: &[f64]) -> Result<()> {
        if row.len() != self.width {
            let cause = format!("a row has {} numbers for {} columns", row.len(), self.width);
            return Err(IoError::unwritable(cause, "give a number per column"));
        }
        self.waiting.extend(row);
        self.rows += 1;
        if self.rows.is_multiple_of(self.rows_per_file as u64) {
            self.store()?;
        }
        Ok(())
    }

    /// Stores the rows that wait, if any, as a file.
    fn store(&mut self) -> Result<()> {
        if self.waiting.is_empty() {
            return Ok(());
        }
        let numbers = self.rows_per_file * self.width;
        // The last file is padded to its full shape.
        self.waiting.resize(numbers, f64::NAN);
        let rows = self.waiting.as_slice();
        let stored = self
            .array
            .store_chunk_opt(&[self.files, 0], rows, &in_order());
        self.files += 1;
        self.waiting.clear();
        succeeded(PROPERTIES, stored)
    }

    pub(super) fn finish(mut self) -> Result<()> {
        self.store()?;
        succeeded(PROPERTIES, self.array.store_metadata())
    }
}

/// The table of an open set.
pub struct Table {
    file: PathBuf,
    stored: Stored,
    columns: Vec<String>,
    samples: usize,
}

impl Table {
    pub(super) fn open(path: &Path, store: &Arc<FilesystemStore>, samples: usize) -> Result<Self> {
        let stored = Stored::open(path, store, PROPERTIES, Kind::Properties)?;
        let columns = stored.attributes().get("columns").and_then(words);
        let table = Self {
            file: path.join(PROPERTIES),
            columns: columns.clone().unwrap_or_default(),
            samples,
            stored,
        };
        match columns {
            None => Err(table.damaged("there is no list 'columns'")),
            Some(_) => table.checked(),
        }
    }

    /// The table, if it has a row for each sample.
    fn checked(self) -> Result<Self> {
        let expected = [self.samples as u64, self.columns.len().max(1) as u64];
        if self.stored.shape() == expected {
            return self.with_all_files();
        }
        let (shape, [samples, width]) = (self.stored.shape(), expected);
        let cause = format!("its shape is {shape:?} for {samples} samples of {width} columns");
        Err(self.damaged(&cause))
    }

    /// The table, if none of its files is missing: zarrs reads them as rows without numbers.
    fn with_all_files(self) -> Result<Self> {
        let files = match self.columns.is_empty() {
            true => 0,
            false => (self.samples as u64).div_ceil(self.stored.per_file()),
        };
        let folder = self.file.join("c");
        match (0..files).find(|file| !folder.join(file.to_string()).join("0").is_file()) {
            Some(file) => Err(self.damaged(&format!("its file c/{file}/0 is missing"))),
            None => Ok(self),
        }
    }

    fn damaged(&self, cause: &str) -> IoError {
        IoError::parse(&self.file.display().to_string(), 0, cause, MAKE_AGAIN)
    }

    /// Names of the columns.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The rows of the samples one after another, in parts as long as a file holds.
    ///
    /// # Errors
    /// Each part may be an [`IoError::Parse`] that names the table.
    pub fn parts(&self) -> impl Iterator<Item = Result<Vec<f64>>> + '_ {
        let samples = self.samples as u64;
        let per_file = self.stored.per_file();
        (0..samples.div_ceil(per_file)).map(move |file| {
            let rows = file * per_file..((file + 1) * per_file).min(samples);
            let read = self.stored.read_rows(rows, self.columns.len() as u64);
            read.map_err(|cause| self.damaged(&cause))
        })
    }
}
