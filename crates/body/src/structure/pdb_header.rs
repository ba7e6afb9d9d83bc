//! PDB title records and remarks: entry, method, resolution, cell, unobserved residues, assemblies.

use super::biological_assembly::{AssemblyPart, BiologicalAssembly, Operator};
use super::columns::Line;
use super::{Header, Names, ResidueKey, UnitCell, UnobservedResidue, quoted};
use crate::Result;
use nalgebra::Matrix3;
use protomer_kernel::Vec3;

/// Collects what stands outside the coordinate records.
#[derive(Default)]
pub(crate) struct HeaderReader {
    header: Header,
    assemblies: Vec<BiologicalAssembly>,
    /// Whether the list of REMARK 465 has begun (its own heading comes first).
    in_unobserved_list: bool,
    /// Rows of the operator being read.
    rows: Vec<[f64; 4]>,
    /// The next list of chains begins a new part of the assembly.
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
            "REMARK" => self.remark(line, names)?,
            _ => {}
        }
        Ok(())
    }

    /// What was collected.
    pub(crate) fn finish(self) -> (Header, Vec<BiologicalAssembly>) {
        let mut assemblies = self.assemblies;
        for assembly in &mut assemblies {
            assembly.parts.retain(|part| !part.operators.is_empty());
        }
        assemblies.retain(|assembly| !assembly.parts.is_empty());
        (self.header, assemblies)
    }

    fn crystal(&mut self, line: &Line) {
        let number = |first, last| line.field(first, last).parse::<f64>().unwrap_or(f64::NAN);
        let lengths = [number(7, 15), number(16, 24), number(25, 33)];
        let angles = [number(34, 40), number(41, 47), number(48, 54)];
        self.header.cell = UnitCell::of_crystal(lengths, angles);
        let symbol = line.field(56, 66);
        self.header.space_group =
            (self.header.cell.is_some() && !symbol.is_empty()).then(|| symbol.to_string());
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
        if line.columns(12, 22) == "RESOLUTION." {
            let value = line
                .field(23, 38)
                .split_whitespace()
                .next()
                .and_then(|word| word.parse::<f64>().ok());
            self.header.resolution_angstrom =
                value.filter(|value| value.is_finite() && *value > 0.0);
        }
    }

    /// `REMARK 465   [model] residue chain number[code]`, after a heading that names these columns.
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
        let digits = number.trim_end_matches(|c: char| c.is_ascii_alphabetic());
        if let Ok(number_value) = digits.parse() {
            let key = ResidueKey {
                chain: names.share(chain),
                number: number_value,
                insertion_code: names.share(&number[digits.len()..]),
            };
            self.header.unobserved.push(UnobservedResidue {
                key,
                name: names.share(name),
            });
        }
    }

    fn assembly(&mut self, line: &Line, names: &mut Names) -> Result<()> {
        let text = line.field(12, 80);
        if let Some(id) = text.strip_prefix("BIOMOLECULE:") {
            let id = id.split(',').next().unwrap_or(id).trim().to_string();
            self.assemblies.push(BiologicalAssembly {
                id,
                details: String::new(),
                parts: Vec::new(),
            });
            self.part_has_operators = true;
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

    /// A list of chains; lists that follow each other without operators between belong together.
    fn chains(&mut self, list: &str, names: &mut Names) {
        if self.assemblies.is_empty() {
            self.assemblies.push(BiologicalAssembly {
                id: "1".into(),
                details: String::new(),
                parts: Vec::new(),
            });
            self.part_has_operators = true;
        }
        let Some(assembly) = self.assemblies.last_mut() else {
            return;
        };
        if self.part_has_operators || assembly.parts.is_empty() {
            assembly.parts.push(AssemblyPart {
                chains: Vec::new(),
                operators: Vec::new(),
            });
            self.part_has_operators = false;
        }
        if let Some(part) = assembly.parts.last_mut() {
            let chains = list
                .split([',', ' '])
                .map(str::trim)
                .filter(|chain| !chain.is_empty());
            part.chains.extend(chains.map(|chain| names.share(chain)));
        }
    }

    /// `BIOMTn  serial  r1 r2 r3  t`, n = 1, 2, 3.
    fn operator_row(&mut self, text: &str, line: &Line) -> Result<()> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let numbers: Vec<f64> = words
            .iter()
            .skip(2)
            .filter_map(|word| word.parse().ok())
            .collect();
        let (Some(&row), [a, b, c, t]) = (words.first(), numbers.as_slice()) else {
            let cause = format!("assembly operator {} lacks numbers", quoted(text));
            return Err(line.error(cause, "mend the REMARK 350 line or delete that remark"));
        };
        if row == "BIOMT1" {
            self.rows.clear();
        }
        self.rows.push([*a, *b, *c, *t]);
        let part = self
            .assemblies
            .last_mut()
            .and_then(|assembly| assembly.parts.last_mut());
        if let ("BIOMT3", [r1, r2, r3], Some(part)) = (row, self.rows.as_slice(), part) {
            let rotation = Matrix3::from_fn(|i, j| [r1, r2, r3][i][j]);
            let translation = Vec3::new(r1[3], r2[3], r3[3]);
            let name = words.get(1).unwrap_or(&"").to_string();
            part.operators.push(Operator {
                name,
                rotation,
                translation,
            });
            self.part_has_operators = true;
            self.rows.clear();
        }
        Ok(())
    }
}

fn append(text: &mut String, more: &str) {
    if !text.is_empty() {
        text.push(' ');
    }
    text.push_str(more);
}
