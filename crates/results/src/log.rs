//! Tables that grow by rows, as CSV, and can be truncated to the length recorded in a checkpoint.

use crate::{Error, Result};
use protomer_io::csv;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// One row of a log.
pub trait Row: Sized {
    /// The names of the columns, in order.
    fn columns() -> Vec<&'static str>;

    /// The cells of the row. Numbers must read back exactly, as with Rust's formatting of floats,
    /// which prints the shortest decimal that does.
    fn to_cells(&self) -> Vec<String>;

    /// Parses cells; `None` if they are not a row.
    fn from_cells(cells: &[String]) -> Option<Self>;
}

/// The part of a log that belongs to a checkpoint.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LogMark {
    /// Length of the part in bytes; zero for a new log.
    pub bytes: u64,
    /// SHA-256 of the part.
    pub sha256: String,
}

/// A log that is being written.
///
/// ```
/// use protomer_results::{Log, LogMark, Row, log};
///
/// #[derive(Debug, PartialEq)]
/// struct Position(f64);
///
/// impl Row for Position {
///     fn columns() -> Vec<&'static str> {
///         vec!["position"]
///     }
///
///     fn to_cells(&self) -> Vec<String> {
///         vec![self.0.to_string()]
///     }
///
///     fn from_cells(cells: &[String]) -> Option<Self> {
///         let [position] = cells else { return None };
///         position.parse().ok().map(Self)
///     }
/// }
///
/// # let folder = tempfile::tempdir().unwrap();
/// let path = folder.path().join("log.csv");
/// let mut log = Log::open::<Position>(&path, &LogMark::default())?;
/// log.append(&Position(0.1))?;
/// let mark = log.sync()?;
/// log.append(&Position(0.2))?;
/// log.sync()?;
/// // A run that continues from the first mark drops the second row.
/// Log::open::<Position>(&path, &mark)?.sync()?;
/// assert_eq!(log::read::<Position>(&path)?, [Position(0.1)]);
/// # Ok::<(), protomer_results::Error>(())
/// ```
#[derive(Debug)]
pub struct Log {
    path: PathBuf,
    file: BufWriter<File>,
    length: u64,
    hash: Sha256,
}

impl Log {
    /// Opens a log and truncates it to the part that belongs to the checkpoint. An empty mark
    /// starts a new log.
    ///
    /// # Errors
    /// If the file cannot be written, or was changed since the checkpoint; it is then left
    /// unchanged.
    pub fn open<R: Row>(path: &Path, mark: &LogMark) -> Result<Self> {
        let hash = match mark.bytes {
            0 => Sha256::new(),
            _ => hash_of_marked(path, mark)?,
        };
        let file = cut(path, mark.bytes).map_err(Error::file("write the log", path))?;
        let mut log = Self {
            path: path.to_owned(),
            file: BufWriter::new(file),
            length: mark.bytes,
            hash,
        };
        if mark.bytes == 0 {
            log.write(&R::columns())?;
        }
        Ok(log)
    }

    /// Appends a row.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn append(&mut self, row: &impl Row) -> Result<()> {
        self.write(&row.to_cells())
    }

    /// Flushes everything to disk and returns the mark for a checkpoint.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn sync(&mut self) -> Result<LogMark> {
        let flushed = self.file.flush();
        flushed
            .and_then(|()| self.file.get_ref().sync_data())
            .map_err(Error::file("write the log", &self.path))?;
        Ok(LogMark {
            bytes: self.length,
            sha256: hexadecimal(&self.hash),
        })
    }

    fn write(&mut self, cells: &[impl AsRef<str>]) -> Result<()> {
        let line = csv::line(cells)?;
        self.hash.update(&line);
        self.length += line.len() as u64;
        self.file
            .write_all(line.as_bytes())
            .map_err(Error::file("write the log", &self.path))
    }
}

/// Opens the file, truncated to `bytes` bytes, for appending.
fn cut(path: &Path, bytes: u64) -> std::io::Result<File> {
    let mut file = OpenOptions::new()
        .create(true)
        .truncate(false)
        .write(true)
        .open(path)?;
    file.set_len(bytes)?;
    file.seek(SeekFrom::End(0))?;
    Ok(file)
}

/// Checks that a log begins with the part that belongs to a checkpoint.
///
/// # Errors
/// [`Error::ChangedLog`] if it was changed or truncated since; [`Error::LostLog`] if it cannot be
/// read.
pub fn check(path: &Path, mark: &LogMark) -> Result<()> {
    hash_of_marked(path, mark).map(drop)
}

fn hash_of_marked(path: &Path, mark: &LogMark) -> Result<Sha256> {
    let mut start = Vec::new();
    protomer_io::input::open(path)
        .and_then(|file| file.take(mark.bytes).read_to_end(&mut start))
        .map_err(|source| Error::LostLog {
            path: path.to_owned(),
            source,
        })?;
    let hash = Sha256::new_with_prefix(&start);
    if start.len() as u64 != mark.bytes || hexadecimal(&hash) != mark.sha256 {
        return Err(Error::ChangedLog(path.to_owned()));
    }
    Ok(hash)
}

fn hexadecimal(hash: &Sha256) -> String {
    let digest = hash.clone().finalize();
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Reads a log.
///
/// # Errors
/// [`Error::NotARow`] names the file and line that is not a row.
pub fn read<R: Row>(path: &Path) -> Result<Vec<R>> {
    rows_of(path, &text_of(path)?)
}

/// Reads the log of a run that may still be working, or was killed: without an incomplete last
/// line.
///
/// # Errors
/// As [`read`].
pub fn read_so_far<R: Row>(path: &Path) -> Result<Vec<R>> {
    let text = text_of(path)?;
    let complete = text.rfind('\n').map_or("", |end| &text[..end]);
    rows_of(path, complete)
}

fn text_of(path: &Path) -> Result<String> {
    protomer_io::input::read_to_string(path).map_err(Error::file("read the log", path))
}

fn rows_of<R: Row>(path: &Path, text: &str) -> Result<Vec<R>> {
    let not_a_row = |index: usize, line: &str| Error::NotARow {
        path: path.to_owned(),
        line: index + 1,
        text: line.to_owned(),
    };
    let lines = text.lines().enumerate().skip(1);
    lines
        .map(|(index, line)| row_of(line).ok_or_else(|| not_a_row(index, line)))
        .collect()
}

fn row_of<R: Row>(line: &str) -> Option<R> {
    R::from_cells(&csv::cells("", 0, line).ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Clone, Copy, PartialEq)]
    struct Step {
        number: u64,
        position: f64,
    }

    impl Row for Step {
        fn columns() -> Vec<&'static str> {
            vec!["number", "position"]
        }

        fn to_cells(&self) -> Vec<String> {
            vec![self.number.to_string(), self.position.to_string()]
        }

        fn from_cells(cells: &[String]) -> Option<Self> {
            let [number, position] = cells else {
                return None;
            };
            Some(Self {
                number: number.parse().ok()?,
                position: position.parse().ok()?,
            })
        }
    }

    fn step(number: u64) -> Step {
        Step {
            number,
            position: 1.0 / 3.0 * number as f64,
        }
    }

    #[test]
    fn rows_survive_a_round_trip_and_a_cut() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        let mut log = Log::open::<Step>(&path, &LogMark::default()).unwrap();
        log.append(&step(1)).unwrap();
        let mark = log.sync().unwrap();
        log.append(&step(2)).unwrap();
        log.sync().unwrap();
        assert_eq!(read::<Step>(&path).unwrap(), [step(1), step(2)]);

        let mut resumed = Log::open::<Step>(&path, &mark).unwrap();
        resumed.append(&step(3)).unwrap();
        resumed.sync().unwrap();
        assert_eq!(read::<Step>(&path).unwrap(), [step(1), step(3)]);
    }

    #[test]
    fn a_changed_or_cut_log_is_refused_and_left_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        let mut log = Log::open::<Step>(&path, &LogMark::default()).unwrap();
        log.append(&step(1)).unwrap();
        let mark = log.sync().unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        for changed in [
            text.replace("0.3333", "0.4333"),
            text[..text.len() - 2].to_owned(),
        ] {
            std::fs::write(&path, &changed).unwrap();
            let refusal = Log::open::<Step>(&path, &mark).unwrap_err();
            assert!(refusal.to_string().contains("--force"), "{refusal}");
            assert_eq!(std::fs::read_to_string(&path).unwrap(), changed);
        }
        std::fs::remove_file(&path).unwrap();
        assert!(matches!(check(&path, &mark), Err(Error::LostLog { .. })));
    }

    #[test]
    fn an_incomplete_last_line_is_no_row_yet() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        std::fs::write(&path, "number,position\n1,0.5\n2,0.").unwrap();
        assert_eq!(read_so_far::<Step>(&path).unwrap().len(), 1);
        std::fs::write(&path, "number,position\n1,half\n").unwrap();
        let refusal = read::<Step>(&path).unwrap_err();
        assert!(
            refusal.to_string().contains(":2: '1,half' is not a row"),
            "{refusal}"
        );
    }
}
