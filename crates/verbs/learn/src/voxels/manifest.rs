//! Manifests list structures with their labels: CSV with the columns `file`, `label`, `cluster`
//! and optionally `family`, `name`. For an interface they also name the second body, `partner`, the
//! chains of both, and how the second one is moved.

use anyhow::{Result, bail};
use protomer_common::input::{InputFile, stem};
use protomer_io::csv::cells;
use protomer_io::digest::Digest;
use protomer_kernel::name::{first_forbidden, printable};
use protomer_kernel::{Pose, Vec3};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// An entry of a manifest.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Position among the entries, from zero.
    pub number: usize,
    /// A unique name; by default that of the file without folder and extensions.
    pub name: String,
    /// The file as named in the manifest.
    pub file: String,
    /// The path of the file for this process.
    pub path: PathBuf,
    /// The class.
    pub label: String,
    /// Related structures share a cluster. If left empty, the entry has its own cluster, with
    /// the name of the entry.
    pub cluster: String,
    /// Copies of one crystal form share a family; may be empty.
    pub family: String,
    /// The second body of an interface; `None` for a structure alone.
    pub partner: Option<Partner>,
}

/// The second body of an interface, its place, and the chains of both bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct Partner {
    /// The file as named in the manifest.
    pub file: String,
    /// The path of the file for this process.
    pub path: PathBuf,
    /// Chains of the first body; empty for all of its file.
    pub chains: Vec<String>,
    /// Chains of the second body; empty for all of its file.
    pub partner_chains: Vec<String>,
    /// Motion of the second body: a point p of its file goes to R p + t in that of the first, Å.
    pub pose: Pose,
}

/// A manifest: its text, from which an entry is read when it is requested. That takes a tenth of
/// the memory of all entries.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Manifest {
    /// SHA-256 of the file.
    pub sha256: String,
    file: String,
    folder: PathBuf,
    text: String,
    columns: Columns,
    /// The first byte of each entry.
    begins: Vec<usize>,
}

impl Manifest {
    /// Reads a manifest. Relative paths in it refer to its folder.
    ///
    /// # Errors
    /// Names the line and the column.
    ///
    /// ```
    /// # let folder = tempfile::tempdir()?;
    /// let path = folder.path().join("set.csv");
    /// std::fs::write(&path, "file,label,cluster\n1abc.pdb,\"P 1\",a\n")?;
    /// let manifest = protomer_learn_verbs::voxels::manifest::Manifest::read(&path)?;
    /// let entry = manifest.entry(0)?;
    /// assert_eq!((entry.name.as_str(), entry.label.as_str()), ("1abc", "P 1"));
    /// # Ok::<(), anyhow::Error>(())
    /// ```
    pub fn read(path: &Path) -> Result<Self> {
        let file = InputFile::read(path)?;
        let Ok(mut text) = String::from_utf8(file.bytes) else {
            bail!("{} is not UTF-8 text", file.name)
        };
        text.shrink_to_fit();
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::of_text(file.name, file.sha256, text, folder)
    }

    fn of_text(file: String, sha256: String, mut text: String, folder: &Path) -> Result<Self> {
        if text.starts_with('\u{feff}') {
            text.remove(0);
        }
        let Some(heading) = lines(&text).next() else {
            bail!("{file} is empty; give a heading file,label,cluster and a line per structure");
        };
        let columns = Columns::read(&file, &heading)?;
        let mut manifest = Self {
            sha256,
            file,
            folder: folder.to_owned(),
            text,
            columns,
            begins: Vec::new(),
        };
        manifest.begins = manifest.checked_begins()?;
        if manifest.is_empty() {
            let file = manifest.file;
            bail!("{file} has a heading but no entries; give a line per structure");
        }
        Ok(manifest)
    }

    /// The first byte of each entry; every entry can be read, and no name is there twice.
    fn checked_begins(&self) -> Result<Vec<usize>> {
        let count = lines(&self.text).skip(1).count();
        let (mut begins, mut hashes) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for line in lines(&self.text).skip(1) {
            let name = self.entry_of(begins.len(), &line)?.name;
            hashes.push(Digest::hash(name.as_bytes()).short());
            begins.push(line.begin);
        }
        hashes.sort_unstable();
        if hashes.windows(2).any(|pair| pair[0] == pair[1]) {
            self.check_names()?;
        }
        Ok(begins)
    }

    /// Compares the names themselves, all in memory: for when their hashes do not suffice.
    fn check_names(&self) -> Result<()> {
        let file = &self.file;
        let mut line_numbers: BTreeMap<String, usize> = BTreeMap::new();
        for (number, line) in lines(&self.text).skip(1).enumerate() {
            let name = self.entry_of(number, &line)?.name;
            if let Some(earlier) = line_numbers.insert(name.clone(), line.number) {
                bail!(
                    "{file}:{}, column file: line {earlier} has the name '{name}' too; distinguish them with a column 'name'",
                    line.number
                );
            }
        }
        Ok(())
    }

    /// Whether the entries are interfaces of two bodies.
    pub fn has_partners(&self) -> bool {
        self.columns.places[PARTNER].is_some()
    }

    /// Number of entries.
    pub fn len(&self) -> usize {
        self.begins.len()
    }

    /// Whether there are no entries; a manifest that was read has some.
    pub fn is_empty(&self) -> bool {
        self.begins.is_empty()
    }

    /// An entry by its position, from zero.
    ///
    /// # Errors
    /// If there is no such entry.
    pub fn entry(&self, number: usize) -> Result<Entry> {
        let text = self
            .begins
            .get(number)
            .and_then(|begin| self.text.get(*begin..));
        match text.and_then(|text| lines(text).next()) {
            Some(line) => self.entry_of(number, &line),
            None => bail!("{} has no entry {number}; it has {}", self.file, self.len()),
        }
    }

    fn entry_of(&self, number: usize, line: &Line) -> Result<Entry> {
        let cells = self.columns.cells_of(&self.file, line)?;
        self.refuse_characters(line, &cells)?;
        let partner = self.partner(line, &cells)?;
        let [file, label, cluster, family, name, ..] = cells;
        let name = if name.is_empty() {
            stem(Path::new(&file))
        } else {
            name
        };
        let cluster = if cluster.is_empty() {
            name.clone()
        } else {
            cluster
        };
        Ok(Entry {
            number,
            path: self.folder.join(&file),
            name,
            file,
            label,
            cluster,
            family,
            partner,
        })
    }

    /// The second body, if the line names its file.
    fn partner(&self, line: &Line, cells: &[String; KNOWN.len()]) -> Result<Option<Partner>> {
        let (words, motion) = (&cells[PARTNER..MOTION], &cells[MOTION..]);
        let [file, chains, partner_chains] = words else {
            return Ok(None);
        };
        if !self.has_partners() {
            return match cells[PARTNER..].iter().find(|cell| !cell.is_empty()) {
                Some(stray) => bail!(
                    "{}:{}: '{stray}' belongs to the second body of an interface; add a column 'partner'",
                    self.file,
                    line.number
                ),
                None => Ok(None),
            };
        }
        if file.is_empty() {
            bail!(
                "{}:{}, column partner: the cell is empty; give the file of the second body",
                self.file,
                line.number
            );
        }
        let of_group = |group: &str| -> Vec<String> {
            let chains = group.split('+').map(str::trim);
            chains
                .filter(|chain| !chain.is_empty())
                .map(str::to_owned)
                .collect()
        };
        Ok(Some(Partner {
            path: self.folder.join(file),
            file: file.clone(),
            chains: of_group(chains),
            partner_chains: of_group(partner_chains),
            pose: self.motion(line, motion)?,
        }))
    }

    /// Translation and rotation of the second body; none if all cells are empty.
    fn motion(&self, line: &Line, cells: &[String]) -> Result<Pose> {
        if cells.iter().all(String::is_empty) {
            return Ok(Pose::identity());
        }
        let mut numbers = [0.0; KNOWN.len() - MOTION];
        for ((number, cell), column) in numbers.iter_mut().zip(cells).zip(&KNOWN[MOTION..]) {
            *number = match cell.parse::<f64>() {
                Ok(value) if value.is_finite() => value,
                _ => bail!(
                    "{}:{}, column {column}: '{cell}' is not a number; give all seven of a pose, or none",
                    self.file,
                    line.number
                ),
            };
        }
        let [x, y, z, w, i, j, k] = numbers;
        let norm = [w, i, j, k]
            .iter()
            .map(|part| part * part)
            .sum::<f64>()
            .sqrt();
        if (norm - 1.0).abs() > MOST_NORM_ERROR {
            bail!(
                "{}:{}, column qw: the quaternion has the norm {norm}, which is not 1; give that of a rotation",
                self.file,
                line.number
            );
        }
        Ok(Pose::from_wxyz(
            Vec3::new(x, y, z),
            [w, i, j, k].map(|part| part / norm),
        ))
    }
}

impl Manifest {
    /// Refuses names that could become something else where they are written.
    fn refuse_characters(&self, line: &Line, cells: &[String; KNOWN.len()]) -> Result<()> {
        for (column, cell) in KNOWN.iter().zip(cells) {
            if let Some(character) = first_forbidden(cell) {
                bail!(
                    "{}:{}, column {column}: '{}' holds the character U+{:04X}; write visible \
                     characters",
                    self.file,
                    line.number,
                    printable(cell),
                    u32::from(character)
                );
            }
        }
        Ok(())
    }
}

/// A line of a manifest.
struct Line<'a> {
    /// Number of the line, counted from one.
    number: usize,
    /// First byte of the line in the text.
    begin: usize,
    text: &'a str,
}

/// The lines that are not blank.
fn lines(text: &str) -> impl Iterator<Item = Line<'_>> {
    let begins = text.split_inclusive('\n').scan(0, |end, text| {
        let begin = *end;
        *end += text.len();
        Some((begin, text))
    });
    let lines = (1..).zip(begins).map(|(number, (begin, text))| Line {
        number,
        begin,
        text: text.trim_end_matches('\n'),
    });
    lines.filter(|line| !line.text.trim().is_empty())
}

/// Positions of the known columns.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Columns {
    /// Position of each column in the order of [`KNOWN`].
    places: [Option<usize>; KNOWN.len()],
    count: usize,
}

const KNOWN: [&str; 15] = [
    "file",
    "label",
    "cluster",
    "family",
    "name",
    "partner",
    "chains",
    "partner_chains",
    "x_angstrom",
    "y_angstrom",
    "z_angstrom",
    "qw",
    "qx",
    "qy",
    "qz",
];
/// Place of the first column of a partner.
const PARTNER: usize = 5;
/// Place of the first column of the motion of a partner.
const MOTION: usize = 8;
/// Largest difference of the norm of a quaternion from 1.
const MOST_NORM_ERROR: f64 = 1e-3;

impl Columns {
    fn read(file: &str, heading: &Line) -> Result<Self> {
        let number = heading.number;
        let columns = cells(file, number, heading.text)?;
        for (place, column) in columns.iter().enumerate() {
            if !KNOWN.contains(&column.as_str()) {
                let known_columns = KNOWN.join(", ");
                bail!(
                    "{file}:{number}, column {}: '{column}' is not a known column; remove it, or use one of {known_columns}",
                    place + 1
                );
            }
            if columns[..place].contains(column) {
                bail!(
                    "{file}:{number}, column {}: '{column}' appears twice; remove one",
                    place + 1
                );
            }
        }
        let places = KNOWN.map(|name| columns.iter().position(|column| column == name));
        for (needed, place) in KNOWN.into_iter().zip(places).take(3) {
            if place.is_none() {
                bail!(
                    "{file}:{number}: there is no column '{needed}'; the heading must have file, label and cluster"
                );
            }
        }
        Ok(Self {
            places,
            count: columns.len(),
        })
    }

    /// The cells of a line in the order of [`KNOWN`], empty for columns that are not there.
    fn cells_of(&self, file: &str, line: &Line) -> Result<[String; KNOWN.len()]> {
        let number = line.number;
        let mut cells = cells(file, number, line.text)?;
        if cells.len() != self.count {
            bail!(
                "{file}:{number}: {} columns, the heading has {}; quote cells with commas",
                cells.len(),
                self.count
            );
        }
        let ordered_cells = self.places.map(|place| {
            let cell = place.and_then(|place| cells.get_mut(place));
            cell.map(std::mem::take).unwrap_or_default()
        });
        for (needed, cell) in ["file", "label"].into_iter().zip(&ordered_cells) {
            if cell.is_empty() {
                bail!("{file}:{number}, column {needed}: the cell is empty; fill it in");
            }
        }
        Ok(ordered_cells)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_text(text: &str, folder: &str) -> Result<Manifest> {
        let text = text.to_owned();
        Manifest::of_text("m.csv".into(), String::new(), text, Path::new(folder))
    }

    fn message(text: &str) -> String {
        of_text(text, "").unwrap_err().to_string()
    }

    #[test]
    fn columns_may_stand_in_any_order() {
        let read = of_text(
            "label,family,file,cluster\nA,f,x/1abc.pdb.gz,\n\nB,,2abc.cif,c\n",
            "d",
        );
        let read = read.unwrap();
        let read = [read.entry(0).unwrap(), read.entry(1).unwrap()];
        assert_eq!(read[0].path, Path::new("d/x/1abc.pdb.gz"));
        assert_eq!(
            (
                read[0].name.as_str(),
                read[0].cluster.as_str(),
                read[0].family.as_str()
            ),
            ("1abc", "1abc", "f")
        );
        assert_eq!(
            (
                read[1].number,
                read[1].label.as_str(),
                read[1].cluster.as_str()
            ),
            (1, "B", "c")
        );
    }

    /// The twin: all lines, split at once.
    #[test]
    fn an_entry_is_that_of_its_line_whatever_ends_the_lines() {
        let lines = [
            "\u{feff}file,label,cluster",
            "",
            "a.pdb,x,\"k, l\"",
            "  ",
            "é.pdb,y,m",
        ];
        for end in ["\n", "\r\n"] {
            for text in [lines.join(end), lines.join(end) + end] {
                let manifest = of_text(&text, "").unwrap();
                let split = text.lines().skip(1).filter(|line| !line.trim().is_empty());
                let split: Vec<Vec<String>> =
                    split.map(|line| cells("", 0, line).unwrap()).collect();
                assert_eq!(manifest.len(), split.len());
                for (number, cells) in split.iter().enumerate() {
                    let Entry {
                        file,
                        label,
                        cluster,
                        ..
                    } = manifest.entry(number).unwrap();
                    assert_eq!(&[file, label, cluster], cells.as_slice());
                }
                let beyond = manifest.entry(2).unwrap_err().to_string();
                assert_eq!(beyond, "m.csv has no entry 2; it has 2");
            }
        }
    }

    #[test]
    fn errors_name_line_and_column() {
        let cases = [
            ("", "empty"),
            ("file,label\n", "m.csv:1: there is no column 'cluster'"),
            ("file,label,cluster,colour\n", "m.csv:1, column 4: 'colour'"),
            (
                "file,label,cluster,label\n",
                "m.csv:1, column 4: 'label' appears twice",
            ),
            ("file,label,cluster\n", "no entries"),
            ("file,label,cluster\na,b\n", "m.csv:2: 2 columns"),
            (
                "file,label,cluster\na.pdb,x,y\n\nb.pdb,,y\n",
                "m.csv:4, column label",
            ),
            (
                "file,label,cluster\na.pdb,x,y\nd/a.pdb,x,y\n",
                "m.csv:3, column file: line 2 has the name 'a'",
            ),
            (
                "file,label,cluster\na.pdb,\"x,y\n",
                "m.csv:2: column 2: a quote",
            ),
            (
                "file,label,cluster\na.pdb,\"x\"z,y\n",
                "m.csv:2: column 2: 'z'",
            ),
        ];
        for (text, expected) in cases {
            assert!(
                message(text).contains(expected),
                "{text:?}: {}",
                message(text)
            );
        }
    }
}
