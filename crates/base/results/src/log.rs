//! Tables that grow by rows, as CSV, and can be truncated to the length recorded in a checkpoint.

use crate::{Error, Result};
use protomer_io::csv;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Name of the log in the directory of a run.
pub const FILE: &str = "log.csv";

/// One row of a log.
pub trait Row: Sized {
    /// The names of the columns, in order.
    fn columns() -> Vec<&'static str>;

    /// The columns that logs of earlier versions may lack.
    fn later_columns() -> Vec<&'static str> {
        Vec::new()
    }

    /// The cells of the row. Numbers must read back exactly, as with Rust's formatting of floats,
    /// which prints the shortest decimal that does.
    fn to_cells(&self) -> Vec<String>;

    /// The names of the columns with the cells of the row.
    fn named(&self) -> Vec<(&'static str, String)> {
        Self::columns().into_iter().zip(self.to_cells()).collect()
    }

    /// Parses a cell for each column, `None` for a later column that the log lacks; `None` if they
    /// are not a row.
    fn from_cells(cells: &[Option<&str>]) -> Option<Self>;

    /// The curves of a figure of the log, panel by panel.
    fn curves() -> Vec<Curve<Self>> {
        Vec::new()
    }
}

/// A column of a log, or a part of one, as a curve of a figure.
#[derive(Debug, Clone, Copy)]
pub struct Curve<R> {
    /// Label of the panel, with the unit; curves with the same label share a panel.
    pub panel: &'static str,
    /// Name in the legend; empty for a curve that needs none.
    pub name: &'static str,
    part: usize,
    number: fn(&R, usize) -> Option<f64>,
}

impl<R> Curve<R> {
    /// Curves of the parts of a column, by their names; without names, of its first part.
    ///
    /// ```
    /// use protomer_results::log::Curve;
    /// let curves = Curve::parts("pressure", &["xx", "yy"], |row: &[f64; 2], part| row.get(part).copied());
    /// let values: Vec<Option<f64>> = curves.iter().map(|curve| curve.value(&[1.5, 2.5])).collect();
    /// assert_eq!((curves[1].name, values), ("yy", vec![Some(1.5), Some(2.5)]));
    /// ```
    pub fn parts(
        panel: &'static str,
        names: &[&'static str],
        number: fn(&R, usize) -> Option<f64>,
    ) -> Vec<Self> {
        let names = if names.is_empty() { &[""][..] } else { names };
        let parts = names.iter().enumerate();
        let curves = parts.map(|(part, name)| Self {
            panel,
            name: *name,
            part,
            number,
        });
        curves.collect()
    }

    /// Ordinate of a row; `None` if the row has none.
    pub fn value(&self, row: &R) -> Option<f64> {
        (self.number)(row, self.part)
    }
}

/// A value of a column.
///
/// ```
/// use protomer_results::log::Cell;
/// let pressure = vec![1.5, 0.1];
/// assert_eq!(pressure.write(), "1.5 0.1");
/// assert_eq!(Vec::<f64>::read("1.5 0.1"), Some(pressure.clone()));
/// assert_eq!((pressure.number(1), pressure.number(2)), (Some(0.1), None));
/// ```
pub trait Cell: Sized {
    /// The text of the cell. Numbers must read back exactly.
    fn write(&self) -> String;

    /// Parses the text; `None` if it is of another kind.
    fn read(text: &str) -> Option<Self>;

    /// A number among those of the cell; `None` if there are fewer.
    fn number(&self, part: usize) -> Option<f64> {
        self.write().split(' ').nth(part)?.parse().ok()
    }
}

macro_rules! numbers {
    ($($type:ty),*) => {
        $(impl Cell for $type {
            fn write(&self) -> String {
                self.to_string()
            }

            fn read(text: &str) -> Option<Self> {
                text.parse().ok()
            }
        })*
    };
}

numbers!(f64, i64, u64, usize);

/// An empty cell where there is no number.
impl Cell for Option<f64> {
    fn write(&self) -> String {
        self.map_or_else(String::new, |number| number.to_string())
    }

    fn read(text: &str) -> Option<Self> {
        match text {
            "" => Some(None),
            number => Some(Some(number.parse().ok()?)),
        }
    }
}

/// Several numbers in one cell, with blanks between them.
impl Cell for Vec<f64> {
    fn write(&self) -> String {
        let words: Vec<String> = self.iter().map(f64::to_string).collect();
        words.join(" ")
    }

    fn read(text: &str) -> Option<Self> {
        let words = text.split_whitespace();
        words.map(|word| word.parse().ok()).collect()
    }
}

/// Declares a struct that is a [`Row`], with a column for each field, in their order: a [`Cell`] under
/// the name of the field, or under another name in parentheses.
///
/// A field may have a value for the logs of earlier versions, which lack its column: logs are read by
/// the names in their heading. A field may state the panel of the figure of the log in which it is drawn,
/// and the names of its parts there.
///
/// ```
/// use protomer_results::{Row, log_row};
///
/// log_row! {
///     /// Where a walker is.
///     #[derive(Debug, PartialEq)]
///     pub struct Place {
///         /// Steps so far.
///         pub step: u64,
///         /// Distance from the start.
///         pub position_metre("position_m"): f64 => "distance (m)",
///         /// Velocity along each axis.
///         pub velocity: Vec<f64> = vec![0.0, 0.0] => "velocity" as "x" | "y",
///     }
/// }
///
/// let place = Place { step: 3, position_metre: 0.1, velocity: vec![1.0, -0.5] };
/// assert_eq!(Place::columns(), ["step", "position_m", "velocity"]);
/// assert_eq!(place.to_cells(), ["3", "0.1", "1 -0.5"]);
/// let earlier = [Some("3"), Some("0.1"), None];
/// assert_eq!(Place::from_cells(&earlier).unwrap().velocity, [0.0, 0.0]);
/// assert_eq!(Place::from_cells(&[Some("3"), None, Some("1 -0.5")]), None);
///
/// let curves = Place::curves();
/// let drawn = curves.iter().map(|curve| (curve.panel, curve.name, curve.value(&place)));
/// assert_eq!(
///     drawn.collect::<Vec<_>>(),
///     [
///         ("distance (m)", "", Some(0.1)),
///         ("velocity", "x", Some(1.0)),
///         ("velocity", "y", Some(-0.5)),
///     ]
/// );
/// ```
#[macro_export]
macro_rules! log_row {
    (@column $field:ident) => {
        stringify!($field)
    };
    (@column $field:ident $column:literal) => {
        $column
    };
    (
        $(#[$about:meta])*
        $visible:vis struct $name:ident {
            $(
                $(#[$text:meta])*
                $field_visible:vis $field:ident $(($column:literal))?: $type:ty
                    $(= $earlier:expr)? $(=> $panel:literal $(as $($curve:literal)|+)?)?
            ),* $(,)?
        }
    ) => {
        $(#[$about])*
        $visible struct $name {
            $($(#[$text])* $field_visible $field: $type),*
        }

        impl $crate::Row for $name {
            fn columns() -> Vec<&'static str> {
                vec![$($crate::log_row!(@column $field $($column)?)),*]
            }

            fn to_cells(&self) -> Vec<String> {
                vec![$($crate::log::Cell::write(&self.$field)),*]
            }

            fn later_columns() -> Vec<&'static str> {
                let texts = [$(concat!("" $(, stringify!($earlier))?)),*];
                let columns = Self::columns().into_iter().zip(texts);
                columns.filter(|(_, text)| !text.is_empty()).map(|(name, _)| name).collect()
            }

            fn from_cells(cells: &[Option<&str>]) -> Option<Self> {
                let mut cells = cells.iter();
                Some(Self {
                    $($field: match cells.next()? {
                        Some(cell) => $crate::log::Cell::read(cell)?,
                        None => None $(.or(Some($earlier)))? ?,
                    }),*
                })
            }

            fn curves() -> Vec<$crate::log::Curve<Self>> {
                let panels: Vec<Vec<$crate::log::Curve<Self>>> = vec![$($(
                    $crate::log::Curve::parts($panel, &[$($($curve),+)?], |row: &Self, part| {
                        $crate::log::Cell::number(&row.$field, part)
                    }),
                )?)*];
                panels.into_iter().flatten().collect()
            }
        }
    };
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

impl LogMark {
    /// Whether nothing of a log belongs to the checkpoint.
    pub fn is_empty(&self) -> bool {
        self.bytes == 0
    }
}

/// A log that is being written.
///
/// ```
/// use protomer_results::{Log, LogMark, log, log_row};
///
/// log_row! {
///     #[derive(Debug, PartialEq)]
///     struct Place {
///         position: f64,
///     }
/// }
///
/// # let folder = tempfile::tempdir().unwrap();
/// let path = folder.path().join("log.csv");
/// let mut log = Log::open::<Place>(&path, &LogMark::default())?;
/// log.append(&Place { position: 0.1 })?;
/// let mark = log.sync()?;
/// log.append(&Place { position: 0.2 })?;
/// log.sync()?;
/// // A run that continues from the first mark drops the second row.
/// Log::open::<Place>(&path, &mark)?.sync()?;
/// assert_eq!(log::read::<Place>(&path)?, [Place { position: 0.1 }]);
/// # Ok::<(), protomer_results::Error>(())
/// ```
#[derive(Debug)]
pub struct Log {
    path: PathBuf,
    file: BufWriter<File>,
    /// Places in a row of the columns of the file: a log that an earlier version began goes on without
    /// later columns.
    places: Vec<usize>,
    length: u64,
    hash: Sha256,
}

impl Log {
    /// Opens a log and truncates it to the part that belongs to the checkpoint. An empty mark
    /// starts a new log.
    ///
    /// # Errors
    /// If the file cannot be written, was changed since the checkpoint, or has columns that no version
    /// up to this one has written; it is then left unchanged.
    pub fn open<R: Row>(path: &Path, mark: &LogMark) -> Result<Self> {
        Self::open_without::<R>(path, mark, &[])
    }

    /// Opens a log as [`Log::open`] does; a new one does not get these of the later columns, which say nothing in this run.
    ///
    /// ```
    /// use protomer_results::{Log, LogMark, log, log_row};
    ///
    /// log_row! {
    ///     #[derive(Debug, PartialEq)]
    ///     struct Place {
    ///         position: f64,
    ///         height: Option<f64> = None,
    ///     }
    /// }
    ///
    /// # let folder = tempfile::tempdir()?;
    /// let path = folder.path().join("log.csv");
    /// let mut log = Log::open_without::<Place>(&path, &LogMark::default(), &["height"])?;
    /// let place = Place { position: 0.1, height: None };
    /// log.append(&place)?;
    /// log.sync()?;
    /// assert_eq!(std::fs::read_to_string(&path)?, "position\n0.1\n");
    /// assert_eq!(log::read::<Place>(&path)?, [place]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Log::open`].
    pub fn open_without<R: Row>(path: &Path, mark: &LogMark, left_out: &[&str]) -> Result<Self> {
        let (columns, later) = (R::columns(), R::later_columns());
        let is_written = |column: &str| !(left_out.contains(&column) && later.contains(&column));
        // The hash goes on from the part that is kept, so that `sync` need not read it again.
        let (hash, places) = match mark.bytes {
            0 => {
                let written = (0..columns.len()).filter(|place| is_written(columns[*place]));
                (Sha256::new(), written.collect())
            }
            _ => (
                hash_of_marked(path, mark)?,
                heading_of_file::<R>(path)?.in_file(),
            ),
        };
        let file = cut(path, mark.bytes).map_err(Error::file("write the log", path))?;
        let mut log = Self {
            path: path.to_owned(),
            file: BufWriter::new(file),
            places,
            length: mark.bytes,
            hash,
        };
        // A new log begins with its columns, an old one has them.
        if mark.bytes == 0 {
            let heading: Vec<&str> = log.places.iter().map(|place| columns[*place]).collect();
            log.write(&heading)?;
        }
        Ok(log)
    }

    /// Appends a row.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn append(&mut self, row: &impl Row) -> Result<()> {
        let cells = row.to_cells();
        let in_file: Vec<&String> = self.places.iter().map(|place| &cells[*place]).collect();
        self.write(&in_file)
    }

    /// Flushes everything to disk and returns the mark for a checkpoint.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn sync(&mut self) -> Result<LogMark> {
        let flushed = self.file.flush();
        flushed
            // Data, not times: the length counts among the data.
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
    // Rows after the checkpoint will be written again, and the same.
    file.set_len(bytes)?;
    file.seek(SeekFrom::End(0))?;
    Ok(file)
}

/// Checks that a log begins with the part that belongs to a checkpoint.
///
/// ```
/// use protomer_results::{Log, LogMark, log, log_row};
///
/// log_row! {
///     struct Place {
///         position: f64,
///     }
/// }
///
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("log.csv");
/// let mut log = Log::open::<Place>(&path, &LogMark::default())?;
/// log.append(&Place { position: 0.1 })?;
/// let mark = log.sync()?;
/// assert!(log::check(&path, &mark).is_ok());
/// std::fs::write(&path, "position\n0.2\n")?;
/// assert!(log::check(&path, &mark).is_err(), "it was changed");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
        // No more than the mark states: a log may be longer than memory has room for.
        .and_then(|file| file.take(mark.bytes).read_to_end(&mut start))
        .map_err(|source| Error::LostLog {
            path: path.to_owned(),
            source,
        })?;
    let hash = Sha256::new_with_prefix(&start);
    // A shorter part is lost rows; another hash, another log.
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
/// ```
/// use protomer_results::{log, log_row};
///
/// log_row! {
///     #[derive(Debug, PartialEq)]
///     struct Place {
///         position: f64,
///     }
/// }
///
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("log.csv");
/// std::fs::write(&path, "position\n0.5\n0.")?;
/// assert_eq!(log::read_so_far::<Place>(&path)?, [Place { position: 0.5 }]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`read`].
pub fn read_so_far<R: Row>(path: &Path) -> Result<Vec<R>> {
    let text = text_of(path)?;
    // A killed process may leave half a row; the last line end is where it is whole.
    let complete = text.rfind('\n').map_or("", |end| &text[..end]);
    rows_of(path, complete)
}

fn text_of(path: &Path) -> Result<String> {
    protomer_io::input::read_to_string(path).map_err(Error::file("read the log", path))
}

fn rows_of<R: Row>(path: &Path, text: &str) -> Result<Vec<R>> {
    let mut lines = text.lines().enumerate();
    // A run that was killed at once leaves no heading, and no rows.
    let Some((_, first)) = lines.next() else {
        return Ok(Vec::new());
    };
    let heading = Heading::read::<R>(path, first)?;
    let not_a_row = |index: usize, line: &str| Error::NotARow {
        path: path.to_owned(),
        line: index + 1,
        text: line.to_owned(),
    };
    lines
        .map(|(index, line)| heading.row(line).ok_or_else(|| not_a_row(index, line)))
        .collect()
}

fn heading_of_file<R: Row>(path: &Path) -> Result<Heading> {
    let text = text_of(path)?;
    Heading::read::<R>(path, text.lines().next().unwrap_or_default())
}

/// The heading of a log: where its file has the columns of a row.
struct Heading {
    /// For each column of a row its place in the file; `None` for a later column that the file lacks.
    places: Vec<Option<usize>>,
    /// Number of columns in the file.
    width: usize,
}

impl Heading {
    /// Reads the first line of a log.
    fn read<R: Row>(path: &Path, line: &str) -> Result<Self> {
        let other = |problem: String| Error::OtherColumns {
            path: path.to_owned(),
            problem,
        };
        let names = csv::cells("", 0, line).map_err(|_| other("no heading".into()))?;
        let (columns, later) = (R::columns(), R::later_columns());
        let mut places = Vec::with_capacity(columns.len());
        for column in &columns {
            let place = names.iter().position(|name| name == column);
            if place.is_none() && !later.contains(column) {
                return Err(other(format!("no column '{column}'")));
            }
            places.push(place);
        }
        let has_place = |place| places.contains(&Some(place));
        match (0..names.len()).find(|place| !has_place(*place)) {
            Some(place) => Err(other(format!("the column '{}'", names[place]))),
            None => Ok(Self {
                places,
                width: names.len(),
            }),
        }
    }

    /// The columns of the file as places in a row.
    fn in_file(&self) -> Vec<usize> {
        let mut in_file = vec![0; self.width];
        for (column, place) in self.places.iter().enumerate() {
            if let Some(place) = place {
                in_file[*place] = column;
            }
        }
        in_file
    }

    /// Parses a line below the heading.
    fn row<R: Row>(&self, line: &str) -> Option<R> {
        let cells = csv::cells("", 0, line).ok()?;
        if cells.len() != self.width {
            return None;
        }
        let of_column = |place: &Option<usize>| place.map(|place| cells[place].as_str());
        let ordered: Vec<Option<&str>> = self.places.iter().map(of_column).collect();
        R::from_cells(&ordered)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    log_row! {
        #[derive(Debug, Clone, Copy, PartialEq)]
        struct Step {
            number: u64,
            position: f64,
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

    log_row! {
        /// A row that has gained columns twice, the second time between others.
        #[derive(Debug, Clone, Copy, PartialEq)]
        struct Grown {
            number: u64,
            colour: u64 = 7,
            position: f64,
            weight: f64 = 0.5,
        }
    }

    #[test]
    fn logs_of_every_earlier_version_are_read_and_continued_in_their_columns() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        let row = |number, colour, weight| Grown {
            number,
            colour,
            position: 0.25,
            weight,
        };
        for (before, first, after) in [
            ("number,position\n1,0.25\n", row(1, 7, 0.5), "2,0.25\n"),
            (
                "number,position,weight\n1,0.25,3\n",
                row(1, 7, 3.0),
                "2,0.25,4\n",
            ),
            (
                "number,colour,position,weight\n1,2,0.25,3\n",
                row(1, 2, 3.0),
                "2,9,0.25,4\n",
            ),
        ] {
            std::fs::write(&path, before).unwrap();
            assert_eq!(read::<Grown>(&path).unwrap(), [first]);
            let mark = LogMark {
                bytes: before.len() as u64,
                sha256: hexadecimal(&Sha256::new_with_prefix(before)),
            };
            let mut log = Log::open::<Grown>(&path, &mark).unwrap();
            log.append(&row(2, 9, 4.0)).unwrap();
            log.sync().unwrap();
            assert_eq!(
                std::fs::read_to_string(&path).unwrap(),
                format!("{before}{after}")
            );
            assert_eq!(read::<Grown>(&path).unwrap().len(), 2);
        }
    }

    #[test]
    fn a_log_with_other_columns_is_refused_by_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        for (heading, named) in [
            ("number,colour", "has no column 'position'"),
            ("number,position,speed", "has the column 'speed'"),
            ("number,number,position", "has the column 'number'"),
        ] {
            std::fs::write(&path, format!("{heading}\n1,2,3\n")).unwrap();
            let refusal = read::<Grown>(&path).unwrap_err().to_string();
            assert!(refusal.contains(named), "{refusal}");
        }
        std::fs::write(&path, "").unwrap();
        assert_eq!(read::<Grown>(&path).unwrap(), []);
    }
}
