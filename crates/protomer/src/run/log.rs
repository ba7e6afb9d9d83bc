//! The log of a run: one row of observables per sampled sweep, as CSV.

use anyhow::{Context, Result, bail};
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// The columns, in order.
const COLUMNS: [&str; 6] =
    ["sweep", "r_g_angstrom", "native_contacts", "largest_cluster", "energy_kT", "cluster_moved"];

/// One row of the log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogRow {
    /// Sweeps of production done.
    pub sweep: u64,
    /// Radius of gyration of the body positions, Å.
    pub r_g_angstrom: f64,
    /// Fraction of the contacts of the start that are still there; NaN where the start had none.
    pub native_contacts: f64,
    /// Bodies in the largest cluster.
    pub largest_cluster: usize,
    /// Total energy, kT.
    pub energy_kt: f64,
    /// Mean number of bodies moved by a cluster move since the last row.
    pub cluster_moved: f64,
}

/// A log that is being written. What lies beyond the last checkpoint is cut off when a run is resumed.
#[derive(Debug)]
pub struct Log {
    path: PathBuf,
    file: BufWriter<File>,
}

impl Log {
    /// Opens the log and cuts it to `length` bytes (zero starts a new one).
    ///
    /// # Errors
    /// If the file cannot be written, or is shorter than the checkpoint says.
    pub fn open(path: &Path, length: u64) -> Result<Self> {
        let context = || format!("cannot write the log {}", path.display());
        let file = OpenOptions::new().create(true).truncate(false).write(true).open(path).with_context(context)?;
        let present = file.metadata().with_context(context)?.len();
        if present < length {
            bail!(
                "{} holds {present} bytes where the checkpoint counts {length}; it was changed since. \
                 Restore it, or start anew with --force",
                path.display()
            );
        }
        file.set_len(length).with_context(context)?;
        let mut file = BufWriter::new(file);
        file.seek(SeekFrom::End(0)).with_context(context)?;
        let mut log = Self { path: path.to_owned(), file };
        if length == 0 {
            log.write_line(&COLUMNS.join(","))?;
        }
        Ok(log)
    }

    /// Appends a row.
    ///
    /// # Errors
    /// If the disk does not take it.
    pub fn append(&mut self, row: &LogRow) -> Result<()> {
        // Rust prints the shortest decimal that reads back as the same number, so nothing is lost.
        self.write_line(&format!(
            "{},{},{},{},{},{}",
            row.sweep, row.r_g_angstrom, row.native_contacts, row.largest_cluster, row.energy_kt, row.cluster_moved
        ))
    }

    /// Forces everything written so far onto the disk and returns the length in bytes.
    ///
    /// # Errors
    /// If the disk does not take it.
    pub fn sync(&mut self) -> Result<u64> {
        let path = self.path.clone();
        let context = || format!("cannot write the log {}", path.display());
        self.file.flush().with_context(context)?;
        self.file.get_ref().sync_data().with_context(context)?;
        Ok(self.file.get_ref().metadata().with_context(context)?.len())
    }

    fn write_line(&mut self, line: &str) -> Result<()> {
        writeln!(self.file, "{line}").with_context(|| format!("cannot write the log {}", self.path.display()))
    }
}

/// Reads a log.
///
/// # Errors
/// Names the file and line that is not a row.
pub fn read_log(path: &Path) -> Result<Vec<LogRow>> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read the log {}", path.display()))?;
    let mut rows = Vec::new();
    for (index, line) in text.lines().enumerate().skip(1) {
        match parse_row(line) {
            Some(row) => rows.push(row),
            None => bail!("{}:{}: '{line}' is not a row of a log; run again with --force", path.display(), index + 1),
        }
    }
    Ok(rows)
}

fn parse_row(line: &str) -> Option<LogRow> {
    let mut cells = line.split(',');
    let row = LogRow {
        sweep: cells.next()?.parse().ok()?,
        r_g_angstrom: cells.next()?.parse().ok()?,
        native_contacts: cells.next()?.parse().ok()?,
        largest_cluster: cells.next()?.parse().ok()?,
        energy_kt: cells.next()?.parse().ok()?,
        cluster_moved: cells.next()?.parse().ok()?,
    };
    cells.next().is_none().then_some(row)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_survive_a_round_trip_and_a_cut() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        let row = |sweep| LogRow {
            sweep,
            r_g_angstrom: 1.0 / 3.0,
            native_contacts: 0.1 + 0.2,
            largest_cluster: 3,
            energy_kt: -1e-17,
            cluster_moved: 0.0,
        };
        let mut log = Log::open(&path, 0).unwrap();
        log.append(&row(1)).unwrap();
        let length = log.sync().unwrap();
        log.append(&row(2)).unwrap();
        log.sync().unwrap();
        assert_eq!(read_log(&path).unwrap(), vec![row(1), row(2)]);
        let mut resumed = Log::open(&path, length).unwrap();
        resumed.append(&row(3)).unwrap();
        resumed.sync().unwrap();
        assert_eq!(read_log(&path).unwrap(), vec![row(1), row(3)]);
        assert!(Log::open(&path, 1 << 40).unwrap_err().to_string().contains("--force"));
    }
}
