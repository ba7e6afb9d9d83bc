//! The format of a file, told by its content.
//!
//! Names mislead: PDB files are called `.ent`, `.pqr` and `.cif`, and the reverse. The name decides
//! only where the content fits several formats, and a name that contradicts the content is a
//! warning.
//!
//! * mmCIF begins with `data_`, `loop_` or an item, after comments.
//! * A PDB atom has its coordinates in columns 31-54, and occupancy and B in columns 55-66 with two
//!   decimals each.
//! * A PQR atom ends with five numbers between blanks: coordinates, charge, radius.

use super::columns::Line;
use super::element;
use super::messages::{parse_error, quoted};
use crate::{BodyError, Result};
use protomer_kernel::plain_text;
use std::borrow::Cow;

/// The structure formats that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Protein Data Bank format, fixed columns.
    Pdb,
    /// PDBx/mmCIF.
    Mmcif,
    /// PQR: PDB-like with charges and radii.
    Pqr,
}

impl Format {
    /// The format by the extension of a file name, `.gz` apart.
    ///
    /// ```
    /// use protomer_body::structure::Format;
    /// assert_eq!(Format::of_name("1CRN.cif.gz"), Some(Format::Mmcif));
    /// assert_eq!(Format::of_name("1hho.pdb1"), Some(Format::Pdb));
    /// ```
    pub fn of_name(name: &str) -> Option<Self> {
        let extension = extension(name)?;
        match extension.as_str() {
            "ent" => Some(Format::Pdb),
            "cif" | "mmcif" | "pdbx" => Some(Format::Mmcif),
            "pqr" => Some(Format::Pqr),
            // Biological assemblies are called .pdb1, .pdb2, ...
            other => {
                let number = other.strip_prefix("pdb")?;
                let is_number = number.bytes().all(|byte| byte.is_ascii_digit());
                is_number.then_some(Format::Pdb)
            }
        }
    }

    /// The format of a file by its content, and by its name where the content does not decide.
    ///
    /// ```
    /// use protomer_body::structure::Format;
    /// let atom = "ATOM 1 CA ALA A 1 0.0 1.0 -2.0 -0.25 1.70\n";
    /// assert_eq!(Format::of_file("named.pdb", atom.as_bytes())?, Format::Pqr);
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    ///
    /// # Errors
    /// [`crate::BodyError::Parse`] for what is not text, and if nothing in the text looks like a
    /// structure.
    pub fn of_file(name: &str, bytes: &[u8]) -> Result<Self> {
        Self::detect(name, &as_text(name, bytes)?)
    }

    /// Variant of [`Self::of_file`] for decoded text.
    pub(crate) fn detect(name: &str, text: &str) -> Result<Self> {
        let by_name = Self::of_name(name);
        let mut has_pdb_record = false;
        for line in text.lines() {
            if let Some(format) = of_line(line) {
                return Ok(format);
            }
            has_pdb_record |= PDB_RECORDS.iter().any(|record| line.starts_with(record));
        }
        let by_record = has_pdb_record.then_some(Format::Pdb);
        by_name
            .or(by_record)
            .ok_or_else(|| not_a_structure(name, text))
    }

    /// The name of the format.
    ///
    /// ```
    /// use protomer_body::structure::Format;
    /// assert_eq!(Format::of_name("1crn.cif").map(Format::name), Some("mmCIF"));
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Format::Pdb => "PDB",
            Format::Mmcif => "mmCIF",
            Format::Pqr => "PQR",
        }
    }

    /// The warning for a file whose name promises another format than this one, which it has.
    ///
    /// ```
    /// use protomer_body::structure::Format;
    /// let warning = Format::Pqr.contradiction("named.pdb").ok_or("no warning")?;
    /// assert!(warning.contains("this is PQR"));
    /// # Ok::<(), &str>(())
    /// ```
    pub fn contradiction(self, name: &str) -> Option<String> {
        let promised = Self::of_name(name).filter(|promised| *promised != self)?;
        Some(format!(
            "the name promises {}, but this is {} by its content, and is read as that; rename it",
            promised.name(),
            self.name()
        ))
    }
}

/// The extension of a file name in lower case, `.gz` apart.
fn extension(name: &str) -> Option<String> {
    let lower = name.to_ascii_lowercase();
    let stem = lower.strip_suffix(".gz").unwrap_or(&lower);
    Some(stem.rsplit_once('.')?.1.to_owned())
}

/// The format that a line shows by itself.
fn of_line(text: &str) -> Option<Format> {
    let start = text.trim_start();
    let is_cif = ["data_", "loop_", "_atom_site.", "_entry."]
        .iter()
        .any(|word| starts_with(start, word));
    if is_cif {
        return Some(Format::Mmcif);
    }
    if !(start.starts_with("ATOM") || start.starts_with("HETATM")) {
        return None;
    }
    let line = Line::of_atom("", 0, text);
    match (line.coordinates_fit(), is_pqr_atom(start)) {
        (true, true) if !has_pdb_decimals(&line) => Some(Format::Pqr),
        (true, _) => Some(Format::Pdb),
        (false, true) => Some(Format::Pqr),
        (false, false) => None,
    }
}

fn starts_with(text: &str, word: &str) -> bool {
    text.get(..word.len())
        .is_some_and(|start| start.eq_ignore_ascii_case(word))
}

/// Whether a line ends with the five numbers of a PQR atom, after at least its record, serial
/// number, name, residue and number.
fn is_pqr_atom(text: &str) -> bool {
    const WORDS_BEFORE: usize = 4;
    let words: Vec<&str> = text.split_whitespace().collect();
    let Some(values) = words.len().checked_sub(5) else {
        return false;
    };
    let is_number = |word: &&str| word.parse::<f64>().is_ok_and(f64::is_finite);
    values >= WORDS_BEFORE && words[values..].iter().all(is_number)
}

/// Whether columns 55-66 hold an occupancy and a B factor with two decimals each, as only PDB has
/// them (the numbers of PQR have other widths), or columns 77-78 an element. An occupancy is not
/// negative, as a charge may be.
fn has_pdb_decimals(line: &Line) -> bool {
    let is_fixed = |first, last| {
        let columns = line.columns(first, last);
        let is_not_negative = columns
            .trim()
            .parse::<f64>()
            .is_ok_and(|value| value >= 0.0);
        columns.as_bytes().get(3) == Some(&b'.') && is_not_negative
    };
    let has_b_factor = is_fixed(61, 66) && line.field(67, 67).is_empty();
    let has_element = element::parse_symbol(line.field(77, 78)).is_some();
    has_element || (is_fixed(55, 60) && (has_b_factor || line.field(61, 80).is_empty()))
}

fn not_a_structure(name: &str, text: &str) -> BodyError {
    let first = text.trim_start().lines().next().unwrap_or("");
    let cause = format!(
        "neither PDB nor mmCIF nor PQR; the text begins with {}",
        quoted(first)
    );
    let remedy = "give a .pdb, .ent, .cif or .pqr file (or one of them with .gz)";
    parse_error(name, 1, cause, remedy)
}

/// Records that only a PDB file has.
const PDB_RECORDS: [&str; 18] = [
    "HEADER", "OBSLTE", "TITLE ", "COMPND", "SOURCE", "EXPDTA", "AUTHOR", "REMARK", "SEQRES",
    "CRYST1", "ORIGX1", "SCALE1", "MODEL", "ATOM", "HETATM", "HELIX ", "DBREF ", "USER",
];

/// The bytes as text, in any encoding and with any line ends.
///
/// # Errors
/// [`crate::BodyError::Parse`] for an empty file, a compressed one, and binary data.
pub(crate) fn as_text<'a>(source: &str, bytes: &'a [u8]) -> Result<Cow<'a, str>> {
    plain_text::decode(bytes)
        .map_err(|error| parse_error(source, error.line(), error.cause(), error.remedy()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PDB: &str =
        "ATOM      1  N   ARG A   1      32.231  15.281 -13.143  1.00 10.00           N\n";
    const PDB_WITHOUT_ELEMENT: &str =
        "ATOM      1  N   ARG A   1      32.231  15.281 -13.143  1.00 10.00\n";
    const PDB_BARE: &str = "ATOM      1  N   ARG A   1      32.231  15.281 -13.143\n";
    const PQR: &str = "ATOM 1 N ARG A 1 32.231 15.281 -13.143 -0.1500 1.5500\n";
    /// PQR as PDB2PQR writes it, in the columns of PDB.
    const PQR_COLUMNS: &str =
        "ATOM      1  N   ARG     1      32.231  15.281 -13.143 -0.3000 1.8500\n";
    /// mmCIF that begins with a comment.
    const MMCIF: &str = "# by hand\ndata_1ABC\nloop_\n_atom_site.id\n1\n";

    #[test]
    fn content_decides_whatever_the_name() {
        for name in ["x.pdb", "x.ent", "x.cif", "x.pqr", "x", "x.txt.gz"] {
            for (text, format) in [
                (PDB, Format::Pdb),
                (PDB_WITHOUT_ELEMENT, Format::Pdb),
                (PDB_BARE, Format::Pdb),
                (PQR, Format::Pqr),
                (PQR_COLUMNS, Format::Pqr),
                (MMCIF, Format::Mmcif),
            ] {
                let found = Format::detect(name, text).unwrap();
                assert_eq!(found, format, "{name} {text}");
            }
        }
    }

    #[test]
    fn the_name_decides_where_the_content_does_not() {
        assert_eq!(Format::detect("x.ent", "just words").unwrap(), Format::Pdb);
        assert_eq!(
            Format::detect("x", "REMARK free text\nATOM").unwrap(),
            Format::Pdb
        );
        let error = Format::detect("x.txt", "just words").unwrap_err();
        assert!(error.to_string().contains("just words"), "{error}");
    }

    #[test]
    fn a_name_that_contradicts_the_content_is_a_warning() {
        assert_eq!(Format::Pdb.contradiction("x.pdb1"), None);
        assert_eq!(Format::Pdb.contradiction("x"), None);
        let warning = Format::Pdb.contradiction("x.cif.gz").unwrap();
        assert!(warning.contains("mmCIF") && warning.contains("this is PDB"));
    }
}
