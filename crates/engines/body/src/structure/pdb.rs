//! PDB coordinate records (wwPDB format 3.3, section 9), read as files in practice write them.
//!
//! Tolerated: lines that end early; missing occupancy, B or element; hybrid-36, hexadecimal and
//! overflowing serial numbers; five-digit residue numbers; two-letter chains (columns 21-22);
//! atoms outside MODEL ... ENDMDL.
//!
//! Corrected and counted ([`super::corrections`]): columns shifted by a long number, residues without
//! a number, names in small letters, four-letter residue names, elements that contradict names.
//!
//! Accepted with a warning, and noted as the [`Ending`]: a deposited entry (one with HEADER or
//! SEQRES) without END or MASTER, probably cut off between two lines; a model that is not closed;
//! a last line that stops in a word. Files of other origin often have none of these records, so
//! nothing is known about them.
//!
//! Refused: a coordinate or residue number that cannot be read, and an atom under a record of another
//! name (`ATAM`), because the atom would be lost silently.

use super::columns::{Line, serial_number, whole_number};
use super::contents::{Atom, Model, Structure};
use super::corrections::Correction;
use super::element::Statement;
use super::ending::{Ending, cut_in_last_line};
use super::messages::quoted;
use super::names::Names;
use super::pdb_names::ResidueNames;
use super::{element, pdb_header};
use crate::Result;
use crate::chemistry::residue_names;
use std::collections::HashMap;
use std::sync::Arc;

/// Records of deposited entries, which end with MASTER and END.
const DEPOSITED: [&str; 2] = ["HEADER", "SEQRES"];

/// Reads a PDB file.
pub(crate) fn read(source: &str, text: &str) -> Result<Structure> {
    let mut reader = Reader::new(source, ResidueNames::of_file(text));
    let mut header = pdb_header::HeaderReader::default();
    for (index, text) in text.lines().enumerate() {
        let line = Line::new(source, index + 1, text);
        match Record::from_line(&line) {
            Record::Atom => reader.atom(&Line::of_atom(source, index + 1, text))?,
            Record::Master => reader.has_end = true,
            Record::Model => reader.open_model(&line),
            Record::EndOfModel => reader.close_model(),
            Record::End => {
                reader.has_end = true;
                reader.close_model();
            }
            Record::EndOfChain => reader.end_of_polymer(),
            Record::Other(record) => {
                refuse_unknown_atom(record, &line)?;
                reader.note_deposited(record);
                header.read(record, &line, &mut reader.names)?;
            }
        }
    }
    reader.finish(header, text)
}

/// Kind of a line, by its first six columns.
enum Record<'a> {
    Atom,
    Master,
    Model,
    EndOfModel,
    End,
    EndOfChain,
    Other(&'a str),
}

impl<'a> Record<'a> {
    fn from_line(line: &Line<'a>) -> Self {
        match line.field(1, 6) {
            record if is_atom(record) => Record::Atom,
            "MASTER" => Record::Master,
            "MODEL" => Record::Model,
            "ENDMDL" => Record::EndOfModel,
            "END" => Record::End,
            "TER" => Record::EndOfChain,
            record => Record::Other(record),
        }
    }
}

/// Whether the first six columns begin an atom: long serial numbers run into the record's name.
fn is_atom(record: &str) -> bool {
    let serial = record.strip_prefix("ATOM").map(str::trim_start);
    let is_number = |text: &str| text.bytes().all(|byte| byte.is_ascii_alphanumeric());
    match serial {
        Some(serial) => {
            serial.is_empty()
                || serial.starts_with(|c: char| c.is_ascii_digit()) && is_number(serial)
        }
        None => record.starts_with("HETAT"),
    }
}

/// Records of the format that may have numbers in the columns of coordinates.
const RECORDS_WITH_NUMBERS: [&str; 9] = [
    "REMARK", "SIGATM", "ANISOU", "SIGUIJ", "MTRIX1", "MTRIX2", "MTRIX3", "TVECT", "CRYST1",
];

/// Refuses an atom under a record that is in no version of the format.
fn refuse_unknown_atom(record: &str, line: &Line) -> Result<()> {
    if RECORDS_WITH_NUMBERS.contains(&record) || !line.coordinates_fit() {
        return Ok(());
    }
    let cause = format!(
        "{} is no record of a PDB file, but has coordinates",
        quoted(record)
    );
    Err(line.error(cause, "write ATOM or HETATM, or delete the line"))
}

/// The state between one line and the next.
#[derive(Default)]
struct Reader {
    structure: Structure,
    names: Names,
    /// Whether atoms that follow belong to the last model.
    model_is_open: bool,
    /// Whether a MODEL record has no ENDMDL yet.
    awaits_endmdl: bool,
    /// Number of TER records that have ended a polymer of each chain and segment of this model.
    ended_polymers: HashMap<[Arc<str>; 2], u32>,
    residue_names: ResidueNames,
    serial: i64,
    /// The record that identifies a deposited entry.
    deposited: Option<&'static str>,
    /// Whether one of the two records that end deposited entries was found.
    has_end: bool,
}

impl Reader {
    fn new(source: &str, residue_names: ResidueNames) -> Self {
        Self {
            residue_names,
            structure: Structure {
                source: source.to_string(),
                ..Structure::default()
            },
            ..Self::default()
        }
    }

    fn note_deposited(&mut self, record: &str) {
        for name in DEPOSITED {
            if record == name && self.deposited.is_none() {
                self.deposited = Some(name);
            }
        }
    }

    fn open_model(&mut self, line: &Line) {
        let next = self.next_model_number();
        let number = line.field(7, 14).parse().unwrap_or(next);
        self.push_model(number);
        self.awaits_endmdl = true;
    }

    fn next_model_number(&self) -> i32 {
        match self.structure.models.last() {
            Some(model) => model.number.saturating_add(1),
            None => 1,
        }
    }

    fn push_model(&mut self, number: i32) {
        self.structure.models.push(Model {
            number,
            atoms: Vec::new(),
        });
        self.model_is_open = true;
        self.ended_polymers.clear();
    }

    fn close_model(&mut self) {
        self.model_is_open = false;
        self.awaits_endmdl = false;
    }

    fn end_of_polymer(&mut self) {
        if let Some(model) = self.structure.models.last()
            && let Some(atom) = model.atoms.last()
        {
            let chain = [atom.chain.clone(), atom.segment.clone()];
            *self.ended_polymers.entry(chain).or_default() += 1;
        }
    }

    fn atom(&mut self, line: &Line) -> Result<()> {
        if !self.model_is_open {
            if !self.structure.models.is_empty() {
                let message = "atoms after the end of a model, read as a model of their own";
                self.structure.warnings.add(line.number, message);
            }
            self.push_model(self.next_model_number());
        }
        let atom = self.parse_atom(line)?;
        self.serial = atom.serial;
        if let Some(model) = self.structure.models.last_mut() {
            model.atoms.push(atom);
        }
        Ok(())
    }

    fn parse_atom(&mut self, line: &Line) -> Result<Atom> {
        let hetero = line.text.starts_with('H');
        let position = line.position()?;
        let name = line.field(13, 16);
        if name.is_empty() {
            let cause = "no atom name in columns 13-16".into();
            return Err(line.error(cause, "correct or delete the line"));
        }
        let residue = self.residue(line)?;
        let (element, is_corrected) = element::of_atom(&Statement {
            symbol: line.field(77, 78),
            name: line.columns(13, 16),
            residue_name: &residue.name,
            hetero,
        });
        let segment = self.names.share(line.field(73, 76));
        let ended = [residue.chain.clone(), segment.clone()];
        let polymer = self.ended_polymers.get(&ended).copied().unwrap_or(0);
        let next_serial = self.serial.saturating_add(1);
        let atom = Atom {
            serial: serial_number(line.serial_field()).unwrap_or(next_serial),
            name: self.names.share(name),
            alternate: line.character(17),
            residue_name: residue.name,
            label_chain: residue.chain.clone(),
            segment,
            polymer,
            outside_polymer: hetero && polymer > 0,
            chain: residue.chain,
            residue_number: residue.number,
            insertion_code: residue.insertion_code,
            element: self.names.share(element),
            occupancy: self.number_or(line, "occupancy", 55, 60, 1.0),
            b_factor_angstrom2: self.number_or(line, "B factor", 61, 66, 0.0),
            formal_charge_e: formal_charge(line.field(79, 80)),
            position,
            hetero,
        };
        let corrections = &mut self.structure.corrections;
        for (is_case, correction) in [
            (is_corrected, Correction::Element),
            (line.is_shifted(), Correction::ShiftedColumns),
        ] {
            if is_case {
                corrections.add(correction, line.number, || quoted(line.text));
            }
        }
        Ok(atom)
    }

    /// Name, chain and number of the residue, with what had to be corrected.
    fn residue(&mut self, line: &Line) -> Result<ResiduePlace> {
        let (name, chain, is_four_letters) = self.residue_names.of_line(line);
        let (number, insertion_code) = residue_number(line)?;
        let capitals = name.to_ascii_uppercase();
        let is_small = capitals != name && residue_names::is_polymer(&capitals);
        let corrections = &mut self.structure.corrections;
        for (is_case, correction) in [
            (number.is_none(), Correction::NoResidueNumber),
            (is_four_letters, Correction::FourLetterName),
            (is_small, Correction::LowerCase),
        ] {
            if is_case {
                corrections.add(correction, line.number, || quoted(line.columns(13, 27)));
            }
        }
        Ok(ResiduePlace {
            name: self.names.share(if is_small { &capitals } else { name }),
            chain: self.names.share(chain),
            number: number.unwrap_or(0),
            insertion_code: self.names.share(insertion_code),
        })
    }

    /// An optional number; warns of one that cannot be read.
    fn number_or(
        &mut self,
        line: &Line,
        name: &str,
        first: usize,
        last: usize,
        default: f64,
    ) -> f64 {
        let field = line.field(first, last);
        match field.parse::<f64>() {
            Ok(value) if value.is_finite() => value,
            _ if field.is_empty() => default,
            _ => {
                let message = format!("{name} {} read as {default}", quoted(field));
                self.structure.warnings.add(line.number, &message);
                default
            }
        }
    }

    fn finish(mut self, header: pdb_header::HeaderReader, text: &str) -> Result<Structure> {
        let mut structure = std::mem::take(&mut self.structure);
        structure.ending = self.ending(text);
        if let Ending::CutOff(message) = &structure.ending {
            structure.warnings.add(text.lines().count(), message);
        }
        structure.models.retain(|model| !model.atoms.is_empty());
        header.finish(&mut structure);
        Ok(structure)
    }

    fn ending(&self, text: &str) -> Ending {
        if self.has_end {
            return Ending::Whole;
        }
        if let Some(record) = self.deposited {
            return Ending::CutOff(format!(
                "the file has a {record} but ends without END or MASTER: it may have been cut \
                 off; compare it with the entry, or fetch it again; if it is complete, add a line \
                 END"
            ));
        }
        if self.awaits_endmdl {
            let message = "the last MODEL has no ENDMDL: the file may have been cut off; fetch it \
                           again, or, if it is complete, add a line ENDMDL";
            return Ending::CutOff(message.into());
        }
        match cut_in_last_line(text) {
            Some(message) => Ending::CutOff(message),
            None => Ending::Unknown,
        }
    }
}

/// The residue of an atom record.
struct ResiduePlace {
    name: Arc<str>,
    chain: Arc<str>,
    number: i32,
    insertion_code: Arc<str>,
}

/// Residue number and insertion code; no number where its columns are blank or hold the stars of a
/// number that did not fit. Further digits may follow in the columns after it.
fn residue_number<'a>(line: &Line<'a>) -> Result<(Option<i32>, &'a str)> {
    let field = line.residue_number_field();
    let code = line.field(27, 27);
    let code = if code.starts_with(|c: char| c.is_ascii_digit()) {
        ""
    } else {
        code
    };
    if field.bytes().all(|byte| byte == b'*') {
        return Ok((None, code.trim_matches('*')));
    }
    match whole_number(field) {
        Some(number) => Ok((Some(number), code)),
        None => {
            let cause = format!("residue number in columns 23-26 is {}", quoted(field));
            Err(line.error(cause, "number the residue; columns may be shifted"))
        }
    }
}

/// Formal charge such as `2+`, `1-` or `+1`; `None` for anything else.
fn formal_charge(field: &str) -> Option<i32> {
    if !field.contains(['+', '-']) {
        return None;
    }
    let sign = if field.contains('-') { -1 } else { 1 };
    let digits: i32 = field.trim_matches(['+', '-']).parse().ok()?;
    Some(sign * digits)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(line: &str) -> Result<Atom> {
        Ok(read("test.pdb", line)?.models.remove(0).atoms.remove(0))
    }

    #[test]
    fn a_full_line() {
        let atom =
            one("HETATM 1234 ZN  AZN2 B-101A     11.104   6.134  -6.504  0.50 10.25          ZN2+")
                .unwrap();
        assert_eq!(
            (atom.serial, &*atom.name, atom.alternate, &*atom.element),
            (1234, "ZN", Some('A'), "ZN")
        );
        assert_eq!(
            (&*atom.chain, atom.residue_number, &*atom.insertion_code),
            ("B", -101, "A")
        );
        assert_eq!(
            (
                atom.occupancy,
                atom.b_factor_angstrom2,
                atom.formal_charge_e
            ),
            (0.5, 10.25, Some(2))
        );
    }

    #[test]
    fn a_line_that_ends_at_its_coordinates() {
        let atom = one("ATOM      1  CA  GLY     7      11.104   6.134  -6.5\r").unwrap();
        assert_eq!(
            (
                atom.position.z,
                atom.occupancy,
                &*atom.element,
                &*atom.chain
            ),
            (-6.5, 1.0, "C", "")
        );
    }

    #[test]
    fn an_entry_that_was_cut_off_between_two_lines_is_warned_of() {
        let atom = |number: usize| {
            format!(
                "ATOM  {number:>5}  CA  GLY A{number:>4}      11.104   6.134  -6.504  1.00 10.00           C  \n"
            )
        };
        let atoms: String = (1..=5).map(atom).collect();
        let header =
            "HEADER    HYDROLASE                               01-JAN-00   1ABC              \n";
        let warnings = |text: &str| read("1abc.pdb", text).unwrap().warnings.messages;
        let whole = format!("{header}{atoms}MASTER        0\nEND   \n");
        assert!(warnings(&whole).is_empty());
        // For any cut before MASTER, the warning names the last line.
        for lines in 2..=6 {
            let cut: String = whole.split_inclusive('\n').take(lines).collect();
            let found = warnings(&cut);
            assert!(
                found.len() == 1 && found[0].starts_with(&format!("line {lines}: ")),
                "{lines}: {found:?}"
            );
            assert!(
                found[0].contains("END") && found[0].contains("fetch it again"),
                "{found:?}"
            );
        }
        assert!(
            warnings(&format!("{header}{atoms}MASTER        0\n")).is_empty(),
            "no atom is lost after MASTER"
        );
        assert!(
            warnings(&format!("{header}MODEL        1\n{atoms}ENDMDL\n")).len() == 1,
            "further models may be lost"
        );
        // Programs write files without HEADER and END: nothing is known about them.
        assert!(
            warnings(&atoms).is_empty()
                && warnings(&format!("REMARK made by a program\n{atoms}TER\n")).is_empty()
        );
    }

    #[test]
    fn a_file_by_hand_is_cut_off_only_where_its_text_shows_it() {
        let atom = |number: usize| {
            format!(
                "ATOM  {number:>5}  CA  GLY A{number:>4}      11.104   6.134  -6.504  1.00 10.00           C  \n"
            )
        };
        let atoms: String = (1..=5).map(atom).collect();
        let ending = |text: &str| read("own.pdb", text).map(|structure| structure.ending);
        assert_eq!(ending(&format!("{atoms}END\n")).unwrap(), Ending::Whole);
        assert_eq!(ending(&format!("{atoms}END")).unwrap(), Ending::Whole);
        for whole in [
            atoms.clone(),
            atoms.trim_end().into(),
            format!("{atoms}TER"),
            format!("MODEL 1\n{atoms}ENDMDL\n"),
        ] {
            assert_eq!(ending(&whole).unwrap(), Ending::Unknown, "{whole}");
        }
        for cut in [
            format!("SEQRES   1 A    5  GLY\n{atoms}"),
            format!("MODEL        1\n{atoms}"),
            format!("{atoms}EN"),
        ] {
            assert!(matches!(ending(&cut).unwrap(), Ending::CutOff(_)), "{cut}");
        }
        // If the last line is cut before its last letter, it either cannot be read or is known to
        // be cut: the coordinate -6.5 is not accepted for -6.504.
        let begin = atoms.len() - atom(5).len();
        for cut in begin + 1..atoms.trim_end().len() {
            let found = ending(&atoms[..cut]);
            assert!(
                matches!(found, Err(_) | Ok(Ending::CutOff(_))),
                "{cut}: {found:?}"
            );
        }
    }

    #[test]
    fn long_names_and_numbers() {
        let chains =
            one("ATOM  A0000  N   GLUBb4016     147.522   4.864  48.302  1.00 97.30         Z N")
                .unwrap();
        assert_eq!(
            (&*chains.chain, &*chains.residue_name, chains.serial),
            ("Bb", "GLU", 100_000)
        );
        let water =
            one("ATOM  *****  OH2 TIP3W12345    147.522   4.864  48.302  1.00 97.30").unwrap();
        assert_eq!(
            (&*water.chain, &*water.residue_name, water.residue_number),
            ("W", "TIP3", 12_345)
        );
    }

    #[test]
    fn a_bad_coordinate_names_its_line_and_columns() {
        let text = "REMARK\nATOM      1  CA  GLY A   7      11.104   6.1x4  -6.504  1.00 10.00           C";
        let message = read("bad.pdb", text).unwrap_err().to_string();
        assert!(
            message.contains("bad.pdb:2") && message.contains("39-46") && message.contains("6.1x4"),
            "{message}"
        );
        assert!(one("ATOM      1  CA  GLY A   7         nan   6.134  -6.504").is_err());
        assert!(one("ATOM      1  CA  GLY A   7       1e300   6.134  -6.504").is_err());
    }
}
