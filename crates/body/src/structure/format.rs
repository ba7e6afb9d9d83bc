//! The format of a file.

use super::messages::{parse_error, quoted};
use crate::{BodyError, Result};
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
    /// ```
    pub fn of_name(name: &str) -> Option<Self> {
        let lower = name.to_ascii_lowercase();
        let stem = lower.strip_suffix(".gz").unwrap_or(&lower);
        match stem.rsplit_once('.')?.1 {
            "pdb" | "ent" | "pdb1" => Some(Format::Pdb),
            "cif" | "mmcif" | "pdbx" => Some(Format::Mmcif),
            "pqr" => Some(Format::Pqr),
            _ => None,
        }
    }

    /// The format by content, and by extension if the content does not decide.
    ///
    /// # Errors
    /// [`crate::BodyError::Parse`] if nothing in the text looks like a structure.
    pub fn detect(name: &str, text: &str) -> Result<Self> {
        /// Number of lines examined.
        const LINES: usize = 1000;
        let by_name = Self::of_name(name);
        if by_name == Some(Format::Pqr) {
            return Ok(Format::Pqr);
        }
        for line in text.lines().take(LINES) {
            match Self::of_line(line.trim_start()) {
                // A word of prose may begin like a PDB record.
                Some(Format::Pdb) if by_name == Some(Format::Mmcif) => {}
                Some(format) => return Ok(format),
                None => {}
            }
        }
        by_name.ok_or_else(|| not_a_structure(name, text))
    }

    /// The format that a line shows.
    fn of_line(line: &str) -> Option<Self> {
        let start = line.get(..5).unwrap_or("");
        if start.eq_ignore_ascii_case("data_") || line.starts_with("_atom_site.") {
            return Some(Format::Mmcif);
        }
        for record in PDB_RECORDS {
            if line.starts_with(record) {
                return Some(Format::Pdb);
            }
        }
        None
    }
}

fn not_a_structure(name: &str, text: &str) -> BodyError {
    let first = text.trim_start().lines().next().unwrap_or("");
    let cause = format!(
        "neither PDB nor mmCIF; the text begins with {}",
        quoted(first)
    );
    let remedy = "give a .pdb, .ent, .cif or .pqr file (or one of them with .gz)";
    parse_error(name, 1, cause, remedy)
}

/// Records a PDB file may begin with.
const PDB_RECORDS: [&str; 18] = [
    "HEADER", "OBSLTE", "TITLE ", "COMPND", "SOURCE", "EXPDTA", "AUTHOR", "REMARK", "SEQRES",
    "CRYST1", "ORIGX1", "SCALE1", "MODEL", "ATOM  ", "HETATM", "HELIX ", "DBREF ", "USER",
];

/// The bytes as text, without a byte-order mark. Bytes outside UTF-8 (old Latin-1 author names)
/// become replacement characters.
///
/// # Errors
/// [`crate::BodyError::Parse`] for an empty file, a compressed one, and binary data.
pub(crate) fn as_text<'a>(source: &str, bytes: &'a [u8]) -> Result<Cow<'a, str>> {
    const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
    const GZIP: &[u8] = &[0x1f, 0x8b];
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    let refuse =
        |line: usize, cause: &str, remedy: &str| Err(parse_error(source, line, cause, remedy));
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return refuse(0, "the file is empty", "fetch it again");
    }
    if bytes.starts_with(GZIP) {
        let remedy = "decompress them before reading";
        return refuse(0, "the data are gzip-compressed", remedy);
    }
    if let Some(at) = bytes.iter().position(|byte| *byte == 0) {
        let line = 1 + bytes[..at].iter().filter(|byte| **byte == b'\n').count();
        let remedy = "give the text format; BinaryCIF, MMTF and trajectories are not read";
        return refuse(line, "binary data, not text", remedy);
    }
    Ok(String::from_utf8_lossy(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_decides_over_the_extension_and_the_extension_over_nothing() {
        assert_eq!(
            Format::detect("x.pdb", "# made by hand\ndata_1ABC\n").unwrap(),
            Format::Mmcif
        );
        assert_eq!(
            Format::detect("x", "REMARK free text\nATOM").unwrap(),
            Format::Pdb
        );
        assert_eq!(Format::detect("x.ent", "just words").unwrap(), Format::Pdb);
        assert!(
            Format::detect("x.txt", "just words")
                .unwrap_err()
                .to_string()
                .contains("just words")
        );
    }

    #[test]
    fn a_byte_order_mark_is_not_part_of_the_first_line() {
        assert_eq!(as_text("x", b"\xef\xbb\xbfATOM").unwrap(), "ATOM");
        assert!(
            as_text("x", b"\xef\xbb\xbf\n")
                .unwrap_err()
                .to_string()
                .contains("empty")
        );
    }

    #[test]
    fn empty_compressed_and_binary_data_are_refused() {
        for (bytes, cause) in [
            (&b" \n\t"[..], "empty"),
            (&[0x1f, 0x8b, 8][..], "gzip"),
            (b"ATOM\n\0\0", "binary"),
        ] {
            assert!(as_text("x", bytes).unwrap_err().to_string().contains(cause));
        }
    }
}
