//! The log of a run: one row of observables per sampled sweep, as CSV.

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// The columns, in order.
const COLUMNS: [&str; 6] = [
    "sweep",
    "r_g_angstrom",
    "native_contacts",
    "largest_cluster",
    "energy_kT",
    "cluster_moved",
];

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

/// The part of a log that a checkpoint vouches for.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LogMark {
    /// Its length in bytes; zero for a log that is yet to be begun.
    pub bytes: u64,
    /// Its SHA-256.
    pub sha256: String,
}

/// A log that is being written. What lies beyond the last checkpoint is cut off when a run is
/// resumed.
#[derive(Debug)]
pub struct Log {
    path: PathBuf,
    file: BufWriter<File>,
    length: u64,
    hash: Sha256,
}

impl Log {
    /// Opens the log and cuts it to what the checkpoint vouches for (nothing starts a new one).
    ///
    /// # Errors
    /// If the file cannot be written, or was changed since the checkpoint; then it stays as it is.
    pub fn open(path: &Path, mark: &LogMark) -> Result<Self> {
        Self::open_with_columns(path, &COLUMNS, mark)
    }

    /// The same for a log of other columns.
    ///
    /// # Errors
    /// As [`Log::open`].
    pub fn open_with_columns(path: &Path, columns: &[&str], mark: &LogMark) -> Result<Self> {
        let hash = if mark.bytes == 0 {
            Sha256::new()
        } else {
            check_log(path, mark)?
        };
        let context = || format!("cannot write the log {}", path.display());
        let file = OpenOptions::new()
            .create(true)
            .truncate(false)
            .write(true)
            .open(path)
            .with_context(context)?;
        file.set_len(mark.bytes).with_context(context)?;
        let mut file = BufWriter::new(file);
        file.seek(SeekFrom::End(0)).with_context(context)?;
        let mut log = Self {
            path: path.to_owned(),
            file,
            length: mark.bytes,
            hash,
        };
        if mark.bytes == 0 {
            log.write_line(&columns.join(","))?;
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
            row.sweep,
            row.r_g_angstrom,
            row.native_contacts,
            row.largest_cluster,
            row.energy_kt,
            row.cluster_moved
        ))
    }

    /// Forces everything written so far onto the disk and returns what a checkpoint can vouch for.
    ///
    /// # Errors
    /// If the disk does not take it.
    pub fn sync(&mut self) -> Result<LogMark> {
        let path = self.path.clone();
        let context = || format!("cannot write the log {}", path.display());
        self.file.flush().with_context(context)?;
        self.file.get_ref().sync_data().with_context(context)?;
        Ok(LogMark {
            bytes: self.length,
            sha256: hexadecimal(&self.hash),
        })
    }

    /// Appends a line as it is.
    ///
    /// # Errors
    /// If the disk does not take it.
    pub fn write_line(&mut self, line: &str) -> Result<()> {
        let line = format!("{line}\n");
        self.hash.update(&line);
        self.length += line.len() as u64;
        self.file
            .write_all(line.as_bytes())
            .with_context(|| format!("cannot write the log {}", self.path.display()))
    }
}

/// Checks that a log begins with what a checkpoint vouches for, and returns the state of its hash.
///
/// # Errors
/// If the log was changed or cut since.
pub fn check_log(path: &Path, mark: &LogMark) -> Result<Sha256> {
    let mut start = Vec::new();
    File::open(path)
        .and_then(|file| file.take(mark.bytes).read_to_end(&mut start))
        .with_context(|| {
            format!(
                "cannot read the log {}; restore it, or start anew with --force",
                path.display()
            )
        })?;
    let hash = Sha256::new_with_prefix(&start);
    if start.len() as u64 != mark.bytes || hexadecimal(&hash) != mark.sha256 {
        bail!(
            "{} was changed since its checkpoint; restore it, or start anew with --force",
            path.display()
        );
    }
    Ok(hash)
}

fn hexadecimal(hash: &Sha256) -> String {
    hash.clone()
        .finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

/// Reads a log.
///
/// # Errors
/// Names the file and line that is not a row.
pub fn read_log(path: &Path) -> Result<Vec<LogRow>> {
    rows_of(path, &read_text(path)?)
}

/// Reads the log of a run that may still go on, or was killed: without a last line that is not
/// complete.
///
/// # Errors
/// As [`read_log`].
pub fn read_log_so_far(path: &Path) -> Result<Vec<LogRow>> {
    let text = read_text(path)?;
    rows_of(path, complete_lines(&text))
}

/// The text up to its last line feed.
pub(crate) fn complete_lines(text: &str) -> &str {
    text.rfind('\n').map_or("", |end| &text[..end])
}

/// The text of a log.
pub(crate) fn read_text(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).with_context(|| format!("cannot read the log {}", path.display()))
}

fn rows_of(path: &Path, text: &str) -> Result<Vec<LogRow>> {
    let mut rows = Vec::new();
    for (index, line) in text.lines().enumerate().skip(1) {
        match parse_row(line) {
            Some(row) => rows.push(row),
            None => bail!(
                "{}:{}: '{line}' is not a row of a log; run again with --force",
                path.display(),
                index + 1
            ),
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
        let mut log = Log::open(&path, &LogMark::default()).unwrap();
        log.append(&row(1)).unwrap();
        let mark = log.sync().unwrap();
        log.append(&row(2)).unwrap();
        log.sync().unwrap();
        assert_eq!(read_log(&path).unwrap(), vec![row(1), row(2)]);
        let mut resumed = Log::open(&path, &mark).unwrap();
        resumed.append(&row(3)).unwrap();
        let mark = resumed.sync().unwrap();
        assert_eq!(read_log(&path).unwrap(), vec![row(1), row(3)]);
        let text = std::fs::read_to_string(&path).unwrap();
        for changed in [
            text.replace("0.3333", "0.4333"),
            text[..text.len() - 2].to_owned(),
        ] {
            std::fs::write(&path, &changed).unwrap();
            assert!(
                Log::open(&path, &mark)
                    .unwrap_err()
                    .to_string()
                    .contains("--force")
            );
            assert_eq!(
                std::fs::read_to_string(&path).unwrap(),
                changed,
                "a refused log stays as it is"
            );
        }
    }
}
