//! PDB title records and remarks: entry, method, resolution, cell, unobserved residues, assemblies,
//! disulfide bonds.

use super::biological_assembly::{AssemblyPart, BiologicalAssembly, Operator};
use super::columns::{Line, whole_number};
use super::contents::{Header, RecordedDisulfide, Structure, UnitCell, UnobservedResidue};
use super::messages::quoted;
use super::names::Names;
use super::residue_key::ResidueKey;
use crate::Result;
use nalgebra::Matrix3;
use protomer_kernel::Vec3;

/// Collects the content of all records other than coordinates.
#[derive(Default)]
pub(crate) struct HeaderReader {
    header: Header,
    assemblies: Vec<BiologicalAssembly>,
    disulfides: Vec<RecordedDisulfide>,
    /// Whether the list of REMARK 465 has begun (its own heading comes first).
    in_unobserved_list: bool,
    /// Rows of the operator being read.
    rows: Vec<[f64; 4]>,
    /// Whether the next list of chains begins a new part of the assembly.
    part_has_operators: bool,
}

impl HeaderReader {
    /// Reads one record that is not a coordinate record.
    pub(crate) fn read(&mut self, record: &str, line: &Line, names: &mut Names) -> Result<()> {
        match record {
            "HEADER" => self.header.entry = line.field(63, 66).to_string(),
            "TITLE" => append(&mut self.header.title, line.field(11, 80)),
            "EXPDTA" => append(&mut self.header.method, line.field(11, 79)),
            "CRYST1" => self.crystal(line),
            "SSBOND" => self.disulfides.extend(disulfide(line, names)),
            "REMARK" => self.remark(line, names)?,
            _ => {}
        }
        Ok(())
    }

    /// Puts what was collected into the structure.
    pub(crate) fn finish(self, structure: &mut Structure) {
        structure.header = self.header;
        structure.disulfides = self.disulfides;
        structure.assemblies = self.assemblies;
        for assembly in &mut structure.assemblies {
            assembly.parts.retain(|part| !part.operators.is_empty());
            if assembly.parts.iter().any(|part| part.chains.is_empty()) {
                let message = format!(
                    "REMARK 350 names no chains for assembly {}: it applies to all",
                    assembly.id
                );
                structure.warnings.messages.push(message);
                structure.warnings.count += 1;
            }
        }
        structure
            .assemblies
            .retain(|assembly| !assembly.parts.is_empty());
    }

    fn crystal(&mut self, line: &Line) {
        let lengths = [(7, 15), (16, 24), (25, 33)].map(|columns| number(line, columns));
        let angles = [(34, 40), (41, 47), (48, 54)].map(|columns| number(line, columns));
        self.header.cell = UnitCell::of_crystal(lengths, angles);
        let symbol = line.field(56, 66);
        let is_crystal = self.header.cell.is_some() && !symbol.is_empty();
        self.header.space_group = is_crystal.then(|| symbol.to_string());
    }

    fn remark(&mut self, line: &Line, names: &mut Names) -> Result<()> {
        match line.field(8, 10) {
            "2" => self.resolution(line),
            "465" => self.unobserved(line, names),
            "350" => self.assembly(line, names)?,
            _ => {}
        }
        Ok(())
    }

    fn resolution(&mut self, line: &Line) {
        if line.columns(12, 22) != "RESOLUTION." {
            return;
        }
        let word = line.field(23, 38).split_whitespace().next();
        self.header.resolution_angstrom = word.and_then(positive_number);
    }

    /// Reads a line `REMARK 465   [model] residue chain number[code]`, after a heading that names
    /// these columns.
    fn unobserved(&mut self, line: &Line, names: &mut Names) {
        let text = line.field(12, 80);
        if text.ends_with("SSSEQI") {
            self.in_unobserved_list = true;
            return;
        }
        let words: Vec<&str> = text.split_whitespace().collect();
        let (name, chain, number) = match words.as_slice() {
            _ if !self.in_unobserved_list => return,
            [name, chain, number] | [_, name, chain, number] => (*name, *chain, *number),
            [name, number] => (*name, "", *number),
            _ => return,
        };
        let digits = number.trim_end_matches(char::is_alphabetic);
        if let Ok(value) = digits.parse() {
            let key = ResidueKey {
                chain: names.share(chain),
                number: value,
                insertion_code: names.share(&number[digits.len()..]),
            };
            let name = names.share(name);
            self.header.unobserved.push(UnobservedResidue { key, name });
        }
    }

    fn assembly(&mut self, line: &Line, names: &mut Names) -> Result<()> {
        let text = line.field(12, 80);
        if let Some(id) = text.strip_prefix("BIOMOLECULE:") {
            let id = id.split(',').next().unwrap_or(id).trim();
            self.begin_assembly(id);
        } else if text.starts_with("AUTHOR DETERMINED BIOLOGICAL UNIT:")
            || text.starts_with("SOFTWARE DETERMINED")
        {
            if let (Some(assembly), Some((_, unit))) =
                (self.assemblies.last_mut(), text.split_once(':'))
            {
                assembly.details = unit.trim().to_string();
            }
        } else if let Some((_, chains)) = text.split_once("CHAINS:") {
            self.chains(chains, names);
        } else if text.starts_with("BIOMT") {
            self.operator_row(text, line)?;
        }
        Ok(())
    }

    fn begin_assembly(&mut self, id: &str) {
        self.assemblies.push(BiologicalAssembly {
            id: id.to_string(),
            details: String::new(),
            parts: Vec::new(),
        });
        self.part_has_operators = true;
    }

    /// Reads a list of chains; lists that follow each other without operators between belong
    /// together. `NULL`, of entries whose chains have no name, and no list at all stand for all
    /// chains.
    fn chains(&mut self, list: &str, names: &mut Names) {
        let begins = self.part_has_operators;
        let Some(part) = self.part(begins) else {
            return;
        };
        for chain in list.split([',', ' ']).map(str::trim) {
            if !(chain.is_empty() || chain == "NULL") {
                part.chains.push(names.share(chain));
            }
        }
        self.part_has_operators = false;
    }

    /// The part of the assembly to which lines belong: a new one if it `begins`, or there is none yet.
    fn part(&mut self, begins: bool) -> Option<&mut AssemblyPart> {
        if self.assemblies.is_empty() {
            self.begin_assembly("1");
        }
        let parts = &mut self.assemblies.last_mut()?.parts;
        if begins || parts.is_empty() {
            parts.push(AssemblyPart {
                chains: Vec::new(),
                operators: Vec::new(),
            });
        }
        parts.last_mut()
    }

    /// Reads a row `BIOMTn  serial  r1 r2 r3  t` of an operator, n = 1, 2, 3.
    fn operator_row(&mut self, text: &str, line: &Line) -> Result<()> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let (Some(&row), Some(numbers)) = (words.first(), row_numbers(&words)) else {
            let cause = format!("assembly operator {} lacks numbers", quoted(text));
            return Err(line.error(cause, "correct the REMARK 350 line or delete that remark"));
        };
        if row == "BIOMT1" {
            self.rows.clear();
        }
        self.rows.push(numbers);
        let name = words.get(1).unwrap_or(&"");
        if row == "BIOMT3" {
            self.end_operator(name);
        }
        Ok(())
    }

    /// Adds the operator of three rows to the current part of the current assembly.
    fn end_operator(&mut self, name: &str) {
        let rows = std::mem::take(&mut self.rows);
        if let ([r1, r2, r3], Some(part)) = (rows.as_slice(), self.part(false)) {
            part.operators.push(Operator {
                name: name.to_string(),
                rotation: Matrix3::from_fn(|i, j| [r1, r2, r3][i][j]),
                translation: Vec3::new(r1[3], r2[3], r3[3]),
            });
            self.part_has_operators = true;
        }
    }
}

/// A number in these columns; NaN where there is none.
fn number(line: &Line, (first, last): (usize, usize)) -> f64 {
    line.field(first, last).parse().unwrap_or(f64::NAN)
}

fn positive_number(word: &str) -> Option<f64> {
    let value: f64 = word.parse().ok()?;
    (value.is_finite() && value > 0.0).then_some(value)
}

/// The four numbers of a row of an operator: words beyond the first two, as many as are numbers.
fn row_numbers(words: &[&str]) -> Option<[f64; 4]> {
    let mut numbers = Vec::new();
    for word in words.iter().skip(2) {
        if let Ok(number) = word.parse::<f64>() {
            numbers.push(number);
        }
    }
    numbers.try_into().ok()
}

/// Disulfide bond of a line `SSBOND serial CYS chain number code  CYS chain number code  operator
/// operator length`. A line without two residue numbers records nothing.
fn disulfide(line: &Line, names: &mut Names) -> Option<RecordedDisulfide> {
    let mut cysteine = |chain: (usize, usize), number: (usize, usize), code: usize| {
        Some(ResidueKey {
            chain: names.share(line.field(chain.0, chain.1)),
            number: whole_number(line.field(number.0, number.1))?,
            insertion_code: names.share(line.field(code, code)),
        })
    };
    let first = cysteine((15, 16), (18, 21), 22)?;
    let second = cysteine((29, 30), (32, 35), 36)?;
    Some(RecordedDisulfide {
        residues: [first, second],
        symmetry: [
            names.share(line.field(60, 65)),
            names.share(line.field(67, 72)),
        ],
    })
}

fn append(text: &mut String, more: &str) {
    if !text.is_empty() {
        text.push(' ');
    }
    text.push_str(more);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bond(text: &str) -> Option<RecordedDisulfide> {
        let line = Line::new("x.pdb", 1, text);
        disulfide(&line, &mut Names::default())
    }

    #[test]
    fn an_ssbond_record_names_two_residues_and_their_operators() {
        let found =
            bond("SSBOND   2 CYS A   22    CYS B   27A                         1555   2655  2.79")
                .unwrap();
        let names = found.residues.each_ref().map(ResidueKey::to_string);
        assert_eq!(names, ["A:22", "B:27A"]);
        assert!(found.is_between_symmetry_copies());
        let short = bond("SSBOND   1 CYS A   22    CYS A   27").unwrap();
        assert!(!short.is_between_symmetry_copies());
        assert_eq!(bond("SSBOND   1 CYS A   22    CYS A"), None);
    }
}
