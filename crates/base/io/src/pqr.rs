//! PQR: a PDB-like file with charge and radius, whitespace separated (the format of PDB2PQR and
//! APBS):
//!
//! `ATOM serial name residue [chain] number x y z charge radius`

use crate::text::{self, Line, shown};
use crate::{IoError, Result};
use protomer_kernel::PointRecord;
use std::fmt::Write;

/// The atoms of a PQR file, and how many models it holds.
///
/// ```
/// use protomer_io::pqr::read_pqr_file;
/// let atom = "ATOM 1 CA ALA 1 0.0 1.0 -2.0 -0.25 1.7\n";
/// let text = format!("MODEL 1\n{atom}ENDMDL\nMODEL 2\n{atom}ENDMDL\n");
/// let file = read_pqr_file("two.pqr", text.as_bytes())?;
/// assert_eq!((file.atoms.len(), file.models), (1, 2));
/// # Ok::<(), protomer_io::IoError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PqrFile {
    /// Atoms of the first model.
    pub atoms: Vec<PointRecord>,
    /// Models with atoms, of which the first was read.
    pub models: usize,
}

impl PqrFile {
    /// Warning that only the first of several models was read, if there are several.
    ///
    /// ```
    /// use protomer_io::pqr::PqrFile;
    /// let file = |models| PqrFile { models, ..PqrFile::default() };
    /// assert_eq!(file(1).models_warning(), None);
    /// assert_eq!(file(20).models_warning(), Some("the first of 20 models is used".to_owned()));
    /// ```
    pub fn models_warning(&self) -> Option<String> {
        let models = self.models;
        (models > 1).then(|| format!("the first of {models} models is used"))
    }
}

/// Reads the atoms of a PQR file: [`read_pqr_file`] without the number of models.
///
/// ```
/// let atoms = protomer_io::pqr::read_pqr("one.pqr", b"ATOM 1 CA ALA A 52B 0.0 1.0 -2.0 -0.25 1.7\n")?;
/// assert_eq!((atoms[0].residue_number, atoms[0].insertion_code.as_str()), (52, "B"));
/// # Ok::<(), protomer_io::IoError>(())
/// ```
///
/// # Errors
/// As [`read_pqr_file`].
pub fn read_pqr(name: &str, bytes: &[u8]) -> Result<Vec<PointRecord>> {
    Ok(read_pqr_file(name, bytes)?.atoms)
}

/// Reads the `ATOM` and `HETATM` records of a PQR file up to the first `ENDMDL`. The chain may be
/// absent or glued to the residue number, an insertion code may be glued to the number, and
/// negative coordinates may be glued to their neighbours.
///
/// ```
/// let text = b"MODEL 1\nATOM 1 CA ALA 1 0 0 0 -0.25 1.7\nENDMDL\nMODEL 2\nATOM 1 CA ALA 1 9 0 0 -0.25 1.7\n";
/// let file = protomer_io::pqr::read_pqr_file("two.pqr", text)?;
/// assert_eq!((file.atoms.len(), file.models), (1, 2));
/// # Ok::<(), protomer_io::IoError>(())
/// ```
///
/// # Errors
/// [`IoError::Parse`] names the line: an atom that cannot be read, or one under a record of another
/// name.
pub fn read_pqr_file(name: &str, bytes: &[u8]) -> Result<PqrFile> {
    let text = text::decode(name, bytes)?;
    let mut file = PqrFile::default();
    let mut in_model = false;
    for (index, text) in text.lines().enumerate() {
        // Only the name is taken off: in long files the serial number is glued to it.
        let after_name = text
            .strip_prefix("ATOM")
            .or_else(|| text.strip_prefix("HETATM"));
        let line = Line {
            file: name,
            number: index + 1,
            text: after_name.unwrap_or(text),
        };
        if text.starts_with("ENDMDL") {
            in_model = false;
        } else if after_name.is_none() {
            refuse_unknown_atom(&line)?;
        } else {
            file.models += usize::from(!in_model);
            // Atoms after ENDMDL, also without a MODEL line, are those of the next model.
            in_model = true;
            if file.models == 1 {
                file.atoms.push(read_atom(&line)?);
            }
        }
    }
    if file.atoms.is_empty() {
        let cause = "the file holds no ATOM records";
        return Err(IoError::parse(name, 0, cause, "give a PQR file"));
    }
    Ok(file)
}

/// Refuses a line that holds an atom under another name than ATOM and HETATM, because the atom would
/// be lost silently.
fn refuse_unknown_atom(line: &Line) -> Result<()> {
    let fields: Vec<&str> = line.text.split_whitespace().collect();
    let Some((record, fields)) = fields.split_first() else {
        return Ok(());
    };
    if *record == "REMARK" || record.starts_with('#') {
        return Ok(());
    }
    match read_fields(line, fields) {
        Ok(Some(_)) => {
            let cause = format!(
                "{} is no record of a PQR file, but has an atom",
                shown(record)
            );
            Err(line.error(cause, "write ATOM or HETATM, or delete the line"))
        }
        _ => Ok(()),
    }
}

fn read_atom(line: &Line) -> Result<PointRecord> {
    let tokens: Vec<&str> = line.text.split_whitespace().collect();
    // As it is first: a minus sign within a name is no separator.
    if let Some(record) = read_fields(line, &tokens)? {
        return Ok(record);
    }
    let separated = separate_minus_signs(line.text);
    let tokens: Vec<&str> = separated.split_whitespace().collect();
    match read_fields(line, &tokens)? {
        Some(record) => Ok(record),
        None => {
            let remedy =
                "write serial, name, residue, chain (or none), number, x, y, z, charge, radius";
            Err(line.error("the columns are not those of a PQR atom", remedy))
        }
    }
}

/// The record in these fields, which begin with the serial number; `None` if they are not laid out
/// like one.
fn read_fields(line: &Line, fields: &[&str]) -> Result<Option<PointRecord>> {
    let Some((chain, number, values)) = split_fields(fields) else {
        return Ok(None);
    };
    let Some((residue_number, insertion_code)) = split_number(number) else {
        return Ok(None);
    };
    let mut values = values.iter().copied();
    Ok(Some(PointRecord {
        position: line.position(&mut values, "the atom")?,
        charge_e: line.charge(values.next())?,
        radius_angstrom: line.radius(values.next())?,
        atom_name: line.name(fields[1], "the atom")?,
        residue_name: line.name(fields[2], "the residue")?,
        chain: line.name(chain, "the chain")?,
        residue_number,
        insertion_code: insertion_code.to_owned(),
    }))
}

/// Chain, residue number and the five values after them. The chain may be absent, or glued to the
/// number.
fn split_fields<'a, 'f>(fields: &'f [&'a str]) -> Option<(&'a str, &'a str, &'f [&'a str])> {
    const VALUES: usize = 5;
    if let [_, _, _, chain, number, values @ ..] = fields
        && values.len() >= VALUES
        // With a chain first: without one, x would have to pass
        // for a residue number, and a value would be missing.
        && split_number(number).is_some()
    {
        return Some((chain, number, values));
    }
    if let [_, _, _, number, values @ ..] = fields
        && values.len() >= VALUES
    {
        if split_number(number).is_some() {
            return Some(("", number, values));
        }
        let (chain, number) = split_chain(number)?;
        return Some((chain, number, values));
    }
    None
}

/// Splits an insertion code from a residue number: `52B` is residue 52 with insertion code B.
fn split_number(token: &str) -> Option<(i32, &str)> {
    let digits = token.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let code = &token[digits.len()..];
    (code.len() <= 1).then_some(())?;
    Some((digits.parse().ok()?, code))
}

/// Splits a chain from a residue number: `A1000` is residue 1000 of chain A.
fn split_chain(token: &str) -> Option<(&str, &str)> {
    let (chain, number) = token.split_at_checked(1)?;
    let lettered = chain.chars().all(|c| c.is_ascii_alphabetic());
    (lettered && split_number(number).is_some()).then_some((chain, number))
}

/// Puts a space before each minus sign that follows a digit: `1.234-5.678` are two numbers.
fn separate_minus_signs(text: &str) -> String {
    let mut separated = String::with_capacity(text.len() + 8);
    let mut previous = ' ';
    for character in text.chars() {
        if character == '-' && previous.is_ascii_digit() {
            separated.push(' ');
        }
        separated.push(character);
        previous = character;
    }
    separated
}

/// The text of a PQR file. Columns are aligned while they fit and stay separated by spaces when
/// they do not (more than 99 999 atoms, long names), so that every reader that splits at spaces
/// reads it. Positions have 5 decimals, charges 8, radii 4. An empty atom or residue name is
/// written as `X` and `UNK`.
///
/// ```
/// use protomer_io::pqr::{read_pqr, write_pqr};
/// use protomer_kernel::PointRecord;
/// let ion = PointRecord { charge_e: 1.0, radius_angstrom: 2.27, ..PointRecord::default() };
/// let text = write_pqr(&[ion])?;
/// assert_eq!(read_pqr("ion.pqr", text.as_bytes())?[0].residue_name, "UNK");
/// # Ok::<(), protomer_io::IoError>(())
/// ```
///
/// # Errors
/// [`IoError::Unwritable`] for a name with a space in it or a number that is not finite.
pub fn write_pqr(records: &[PointRecord]) -> Result<String> {
    let mut text = String::from(
        "REMARK   1 PQR written by protomer: x y z in angstrom, charge in e, radius in angstrom\n",
    );
    for (index, record) in records.iter().enumerate() {
        check_writable(index, record)?;
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "ATOM  {:>5} {:<4} {:>3} {:>1} {:>5} {:>11.5} {:>11.5} {:>11.5} {:>11.8} {:>7.4}",
            index + 1,
            or(&record.atom_name, "X"),
            or(&record.residue_name, "UNK"),
            record.chain,
            format!("{}{}", record.residue_number, record.insertion_code),
            record.position.x,
            record.position.y,
            record.position.z,
            record.charge_e,
            record.radius_angstrom
        );
    }
    text.push_str("END\n");
    Ok(text)
}

fn or<'a>(name: &'a str, otherwise: &'a str) -> &'a str {
    if name.is_empty() { otherwise } else { name }
}

fn check_writable(index: usize, record: &PointRecord) -> Result<()> {
    let atom = index + 1;
    for name in [
        &record.atom_name,
        &record.residue_name,
        &record.chain,
        &record.insertion_code,
    ] {
        if name.contains(char::is_whitespace) {
            let cause = format!("atom {atom} has the name {name:?}, which PQR cannot hold");
            return Err(IoError::unwritable(cause, "take the spaces out"));
        }
    }
    for number in [
        record.position.x,
        record.position.y,
        record.position.z,
        record.charge_e,
        record.radius_angstrom,
    ] {
        if !number.is_finite() {
            let cause = format!("atom {atom} has a position, charge or radius that is not finite");
            return Err(IoError::unwritable(cause, "check the body it comes from"));
        }
    }
    Ok(())
}
