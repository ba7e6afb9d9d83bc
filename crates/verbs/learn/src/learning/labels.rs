//! Labels from a table instead of the set: joined by name, so that a set need not be made again to
//! ask another question of it.

use crate::voxels::records::exclusions;
use crate::voxels::samples::VoxelSet;
use anyhow::{Result, bail};
use protomer_common::input::InputFile;
use protomer_io::atomic::write_bytes;
use protomer_io::csv::{Table, cells};
use protomer_kernel::name::{first_forbidden, printable};
use protomer_learn::SampleSource;
use protomer_learn::targets::{Target, number};
use protomer_learn::view::View;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The labels of a training that took them from a table: a row for each sample, `name,label`.
pub const LABELS: &str = "labels.csv";

/// The column that joins a table to a set.
const NAME: &str = "name";
/// The columns of labels that need not be named.
const USUAL: [&str; 2] = ["label", "number"];

/// The table that the labels of a training come from, instead of the set.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LabelSource {
    /// The table.
    pub path: PathBuf,
    /// SHA-256 of the file.
    pub sha256: String,
    /// The column of the labels.
    pub column: String,
}

impl LabelSource {
    /// Whether both are the same column of the same file, wherever it lies.
    pub fn is_same(&self, other: &Self) -> bool {
        self.without_path() == other.without_path()
    }

    /// The same table, wherever it lies.
    pub(super) fn without_path(&self) -> Self {
        Self {
            path: PathBuf::new(),
            ..self.clone()
        }
    }
}

/// A table of labels by name.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelTable {
    /// File and column of the labels.
    pub source: LabelSource,
    file: String,
    /// Label and line of each name.
    rows: BTreeMap<String, (String, usize)>,
}

impl LabelTable {
    /// Reads a table with a heading: a column `name`, and one of labels, which is `column`, or
    /// `label` or `number`. Cells are separated by tabs if the heading has any, otherwise by
    /// commas. Other columns are ignored.
    ///
    /// ```
    /// # let folder = tempfile::tempdir()?;
    /// use protomer_learn_verbs::learning::labels::LabelTable;
    /// use protomer_learn::targets::Target;
    /// let path = folder.path().join("melting.tsv");
    /// std::fs::write(&path, "name\tmethod\ttm_celsius\n5pti\tDSC\t101.5\n")?;
    /// let table = LabelTable::read(&path, Some("tm_celsius"))?;
    /// assert_eq!(table.target(), Target::Number);
    /// assert!(LabelTable::read(&path, None).is_err(), "which column has the labels?");
    /// # Ok::<(), anyhow::Error>(())
    /// ```
    ///
    /// # Errors
    /// Names the line and the column.
    pub fn read(path: &Path, column: Option<&str>) -> Result<Self> {
        let file = InputFile::read(path)?;
        let Ok(text) = String::from_utf8(file.bytes) else {
            bail!("{} is not UTF-8 text", file.name)
        };
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        let mut lines = (1..).zip(text.lines());
        let mut lines = lines
            .by_ref()
            .filter(|(_, line): &(usize, &str)| !line.trim().is_empty());
        let Some((line, heading)) = lines.next() else {
            bail!(
                "{} is empty; give a heading name,label and a line per sample",
                file.name
            );
        };
        let split = Cells {
            file: &file.name,
            by_tabs: heading.contains('\t'),
        };
        let heading = split.split(line, heading)?;
        let places = Places::from_heading(&file.name, line, &heading, column)?;
        let mut rows: BTreeMap<String, (String, usize)> = BTreeMap::new();
        for (line, text) in lines {
            let row = split.split(line, text)?;
            if row.len() != heading.len() {
                bail!(
                    "{}:{line}: {} cells for the {} columns of the heading; give one for each",
                    file.name,
                    row.len(),
                    heading.len()
                );
            }
            let (name, label) = (&row[places.name], &row[places.label]);
            refuse_characters(&file.name, line, NAME, name)?;
            refuse_characters(&file.name, line, &heading[places.label], label)?;
            if name.is_empty() {
                bail!(
                    "{}:{line}, column {NAME}: the name is missing; give that of a sample of the set",
                    file.name
                );
            }
            if let Some((_, earlier)) = rows.insert(name.clone(), (label.clone(), line)) {
                bail!(
                    "{}:{line}, column {NAME}: line {earlier} has '{name}' too; remove one of them",
                    file.name
                );
            }
        }
        if rows.is_empty() {
            bail!(
                "{} has a heading but no rows; give a line per sample",
                file.name
            );
        }
        let table = Self {
            source: LabelSource {
                path: path.to_owned(),
                sha256: file.sha256,
                column: heading[places.label].clone(),
            },
            file: file.name,
            rows,
        };
        if table.source.column == "number" {
            table.require_numbers()?;
        }
        Ok(table)
    }

    /// The table of a training, found again.
    ///
    /// # Errors
    /// If it cannot be read, or has changed since.
    pub fn found_again(source: &LabelSource) -> Result<Self> {
        let table = Self::read(&source.path, Some(&source.column))?;
        if table.source.sha256 != source.sha256 {
            bail!(
                "{} has changed since these settings were written; give the table of labels with \
                 --labels",
                source.path.display()
            );
        }
        Ok(table)
    }

    /// The target that the labels suggest: numbers in a column `number`, classes in a column `label`,
    /// and in any other column numbers if all its labels are numbers.
    pub fn target(&self) -> Target {
        let is_number = |(label, _): &(String, usize)| label.is_empty() || number(label).is_ok();
        match self.source.column.as_str() {
            "label" => Target::Label,
            "number" => Target::Number,
            _ if self.rows.values().all(is_number) => Target::Number,
            _ => Target::Label,
        }
    }

    /// Refuses a label that is no number.
    fn require_numbers(&self) -> Result<()> {
        let mut rows: Vec<_> = self.rows.values().collect();
        rows.sort_by_key(|(_, line)| *line);
        for (label, line) in rows {
            if !label.is_empty() && number(label).is_err() {
                bail!(
                    "{}:{line}, column number: '{label}' is not a finite number; correct it, leave it \
                     empty, or call the column 'label' for classes",
                    self.file
                );
            }
        }
        Ok(())
    }

    /// The set with the labels of the table. A sample with an empty label is left out of a training.
    /// Rows of structures that the set left out (`excluded`, by name) are ignored.
    ///
    /// # Errors
    /// Names a sample without a row, and a row without a sample.
    pub fn join<'a>(&self, set: &'a dyn SampleSource, excluded: &[String]) -> Result<View<'a>> {
        let samples = set.descriptions();
        let mut without = samples
            .iter()
            .filter(|sample| !self.rows.contains_key(&sample.name));
        if let Some(first) = without.next() {
            bail!(
                "{}, column {NAME}: {} of {} samples of the set have no row, such as '{}'; add them, \
                 with an empty label for those that are to be left out",
                self.file,
                1 + without.count(),
                samples.len(),
                first.name
            );
        }
        let names: std::collections::BTreeSet<&str> = samples
            .iter()
            .map(|sample| sample.name.as_str())
            .chain(excluded.iter().map(String::as_str))
            .collect();
        let mut surplus: Vec<(usize, &String)> = self
            .rows
            .iter()
            .filter(|(name, _)| !names.contains(name.as_str()))
            .map(|(name, (_, line))| (*line, name))
            .collect();
        surplus.sort_unstable();
        if let Some((line, name)) = surplus.first() {
            bail!(
                "{}:{line}, column {NAME}: the set has no sample '{name}'{}; correct the name, or \
                 remove the row",
                self.file,
                match surplus.len() {
                    1 => String::new(),
                    more => format!(" (and {} more rows have none)", more - 1),
                }
            );
        }
        Ok(self.relabelled(set))
    }

    /// The set with the labels of the table; samples without a row have an empty label.
    pub fn relabelled<'a>(&self, set: &'a dyn SampleSource) -> View<'a> {
        View::new(set).relabelled(|sample| {
            let row = self.rows.get(&sample.name);
            Some(row.map_or_else(String::new, |(label, _)| label.clone()))
        })
    }
}

/// Names of the structures that a set left out.
///
/// # Errors
/// If the attribute is damaged.
pub fn excluded_names(set: &VoxelSet) -> Result<Vec<String>> {
    let excluded = exclusions(set.reader())?;
    Ok(excluded
        .into_iter()
        .map(|left_out| left_out.row.name)
        .collect())
}

/// Writes the labels of a set into the directory of a training.
///
/// # Errors
/// If the file cannot be written.
pub(super) fn write(set: &dyn SampleSource, directory: &Path) -> Result<()> {
    let mut table = Table::new([NAME, USUAL[0]]);
    for sample in set.descriptions() {
        table.push([sample.name.as_str().into(), sample.label.as_str().into()])?;
    }
    Ok(write_bytes(
        &directory.join(LABELS),
        table.to_csv()?.as_bytes(),
    )?)
}

/// Separation of lines into cells.
struct Cells<'a> {
    file: &'a str,
    by_tabs: bool,
}

impl Cells<'_> {
    fn split(&self, line: usize, text: &str) -> Result<Vec<String>> {
        if self.by_tabs {
            let cells = text.split('\t');
            return Ok(cells.map(|cell| cell.trim().to_owned()).collect());
        }
        Ok(cells(self.file, line, text)?)
    }
}

/// Places of the columns that are read.
struct Places {
    name: usize,
    label: usize,
}

impl Places {
    fn from_heading(
        file: &str,
        line: usize,
        heading: &[String],
        column: Option<&str>,
    ) -> Result<Self> {
        for (place, name) in heading.iter().enumerate() {
            if heading[..place].contains(name) {
                bail!(
                    "{file}:{line}, column {}: '{name}' appears twice; rename one",
                    place + 1
                );
            }
        }
        let place = |wanted: &str| heading.iter().position(|column| column == wanted);
        let Some(name) = place(NAME) else {
            bail!(
                "{file}:{line}: there is no column '{NAME}'; give one with the names of the samples of \
                 the set"
            );
        };
        let label = match column {
            Some(NAME) => bail!("the column '{NAME}' holds names; give another --label-column"),
            Some(wanted) => match place(wanted) {
                Some(label) => label,
                None => bail!(
                    "{file}:{line}: there is no column '{wanted}'; it has {}",
                    heading.join(", ")
                ),
            },
            None => match USUAL.map(place) {
                [Some(label), None] | [None, Some(label)] => label,
                [Some(_), Some(_)] => bail!(
                    "{file}:{line}: there are columns 'label' and 'number'; choose with --label-column"
                ),
                [None, None] => bail!(
                    "{file}:{line}: there is no column 'label' or 'number'; name the column of the \
                     labels with --label-column"
                ),
            },
        };
        Ok(Self { name, label })
    }
}

fn refuse_characters(file: &str, line: usize, column: &str, cell: &str) -> Result<()> {
    match first_forbidden(cell) {
        Some(character) => bail!(
            "{file}:{line}, column {column}: '{}' holds the character U+{:04X}; write visible \
             characters",
            printable(cell),
            u32::from(character)
        ),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_learn::{Description, InMemory};

    fn table(text: &str, column: Option<&str>) -> Result<LabelTable> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("labels.csv");
        std::fs::write(&path, text)?;
        LabelTable::read(&path, column)
    }

    fn refusal(text: &str, column: Option<&str>) -> String {
        let error = table(text, column).unwrap_err().to_string();
        error.rsplit_once("labels.csv").unwrap().1.to_owned()
    }

    fn set(names: &[&str]) -> InMemory {
        let describe = |name: &&str| Description {
            name: (*name).to_owned(),
            label: "old".into(),
            ..Description::default()
        };
        InMemory {
            descriptions: names.iter().map(describe).collect(),
            ..InMemory::default()
        }
    }

    #[test]
    fn labels_are_joined_by_name_and_the_set_keeps_its_own() {
        let set = set(&["b", "a"]);
        let table = table("label,name\nx,a\n,b\nz,left out\n", None).unwrap();
        let view = table.join(&set, &["left out".into()]).unwrap();
        let labels: Vec<&str> = view.descriptions().iter().map(|s| &*s.label).collect();
        assert_eq!(labels, ["", "x"]);
        assert_eq!(set.descriptions[0].label, "old");
    }

    #[test]
    fn tables_that_do_not_fit_are_refused_with_line_and_column() {
        for (text, column, words) in [
            ("", None, " is empty"),
            ("name,label\n", None, "no rows"),
            ("file,label\na,x\n", None, ":1: there is no column 'name'"),
            (
                "name,tm\na,5\n",
                None,
                ":1: there is no column 'label' or 'number'",
            ),
            (
                "name,tm\na,5\n",
                Some("ph"),
                ":1: there is no column 'ph'; it has name, tm",
            ),
            ("name,label,number\na,x,1\n", None, "--label-column"),
            (
                "name,label,label\na,x,1\n",
                None,
                ":1, column 3: 'label' appears twice",
            ),
            (
                "name,label\na,x\n\na,y\n",
                None,
                ":4, column name: line 2 has 'a' too",
            ),
            ("name,label\na,x,y\n", None, ":2: 3 cells for the 2 columns"),
            (
                "name,label\n,x\n",
                None,
                ":2, column name: the name is missing",
            ),
            (
                "name,number\na,1\nb,hot\n",
                None,
                ":3, column number: 'hot' is not a finite",
            ),
        ] {
            let refused = refusal(text, column);
            assert!(refused.contains(words), "{refused}");
        }
    }

    #[test]
    fn samples_without_a_row_and_rows_without_a_sample_are_named() {
        let set = set(&["a", "b", "c"]);
        let refused = |text: &str| {
            let error = table(text, None).unwrap().join(&set, &[]).unwrap_err();
            error.to_string()
        };
        let error = refused("name,label\na,x\n");
        assert!(
            error.contains("2 of 3 samples of the set have no row, such as 'b'"),
            "{error}"
        );
        let error = refused("name,label\na,x\nb,x\nB,x\nc,x\n");
        assert!(
            error.contains(":4, column name: the set has no sample 'B'"),
            "{error}"
        );
    }

    #[test]
    fn a_column_says_whether_it_holds_numbers_or_classes() {
        let target = |text: &str, column| table(text, column).unwrap().target();
        assert_eq!(target("name,label\na,1\nb,0\n", None), Target::Label);
        assert_eq!(target("name,number\na,1\nb,\n", None), Target::Number);
        assert_eq!(
            target("name,tm\na,1.5\nb,-3e1\n", Some("tm")),
            Target::Number
        );
        assert_eq!(
            target("name,fold\na,1.5\nb,x\n", Some("fold")),
            Target::Label
        );
    }

    /// The twin: the same table with commas, quoted.
    #[test]
    fn tabs_and_commas_are_read_alike() {
        let tabs = table("name\tlabel\na, b\tP 1\r\nc\tP 2\n", None).unwrap();
        let commas = table("name,label\n\"a, b\",P 1\nc,\"P 2\"\n", None).unwrap();
        assert_eq!(tabs.rows, commas.rows);
    }
}
