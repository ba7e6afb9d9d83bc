//! Manifests list structures with their labels: CSV with the columns `file`, `label`, `cluster`
//! and optionally `family`, `name`.

use anyhow::{Context, Result, bail};
use protomer_common::input::{InputFile, stem};
use protomer_io::csv::cells;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// An entry of a manifest.
#[derive(Debug, Clone, PartialEq, Eq)]
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
}

/// A manifest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Manifest {
    /// SHA-256 of the file.
    pub sha256: String,
    /// The structures in order.
    pub entries: Vec<Entry>,
}

const KNOWN: [&str; 5] = ["file", "label", "cluster", "family", "name"];

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
    /// let manifest = protomer_training::voxels::manifest::Manifest::read(&path)?;
    /// assert_eq!((manifest.entries[0].name.as_str(), manifest.entries[0].label.as_str()), ("1abc", "P 1"));
    /// # Ok::<(), anyhow::Error>(())
    /// ```
    pub fn read(path: &Path) -> Result<Self> {
        let file = InputFile::read(path)?;
        let text = std::str::from_utf8(&file.bytes)
            .with_context(|| format!("{} is not UTF-8 text", file.name))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Ok(Self {
            entries: entries(&file.name, text, folder)?,
            sha256: file.sha256,
        })
    }
}

fn entries(file: &str, text: &str, folder: &Path) -> Result<Vec<Entry>> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = (1..)
        .zip(text.lines())
        .filter(|(_, line)| !line.trim().is_empty());
    let Some((number, heading)) = lines.next() else {
        bail!("{file} is empty; give a heading file,label,cluster and a line per structure");
    };
    let columns = cells(file, number, heading)?;
    for (place, column) in columns.iter().enumerate() {
        if !KNOWN.contains(&column.as_str()) {
            let known = KNOWN.join(", ");
            bail!(
                "{file}:{number}, column {}: '{column}' is not a known column; remove it, or use one of {known}",
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
    let place_of = |name: &str| columns.iter().position(|column| column == name);
    for needed in ["file", "label", "cluster"] {
        if place_of(needed).is_none() {
            bail!(
                "{file}:{number}: there is no column '{needed}'; the heading must have file, label and cluster"
            );
        }
    }
    let mut entries = Vec::new();
    let mut seen: HashMap<String, usize> = HashMap::new();
    for (line, text) in lines {
        let cells = cells(file, line, text)?;
        if cells.len() != columns.len() {
            bail!(
                "{file}:{line}: {} columns, the heading has {}; quote cells with commas",
                cells.len(),
                columns.len()
            );
        }
        let cell = |name: &str| {
            place_of(name)
                .and_then(|place| cells.get(place))
                .cloned()
                .unwrap_or_default()
        };
        for needed in ["file", "label"] {
            if cell(needed).is_empty() {
                bail!("{file}:{line}, column {needed}: the cell is empty; fill it in");
            }
        }
        let name = Some(cell("name")).filter(|name| !name.is_empty());
        let name = name.unwrap_or_else(|| stem(Path::new(&cell("file"))));
        if let Some(earlier) = seen.insert(name.clone(), line) {
            bail!(
                "{file}:{line}, column file: line {earlier} has the name '{name}' too; distinguish them with a column 'name'"
            );
        }
        entries.push(Entry {
            number: entries.len(),
            path: folder.join(cell("file")),
            file: cell("file"),
            label: cell("label"),
            cluster: Some(cell("cluster"))
                .filter(|cluster| !cluster.is_empty())
                .unwrap_or_else(|| name.clone()),
            family: cell("family"),
            name,
        });
    }
    if entries.is_empty() {
        bail!("{file} has a heading but no entries; give a line per structure");
    }
    Ok(entries)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn message(text: &str) -> String {
        entries("m.csv", text, Path::new(""))
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn columns_may_stand_in_any_order() {
        let read = entries(
            "m.csv",
            "label,family,file,cluster\nA,f,x/1abc.pdb.gz,\n\nB,,2abc.cif,c\n",
            Path::new("d"),
        );
        let read = read.unwrap();
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
