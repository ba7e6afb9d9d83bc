//! What the reader takes otherwise than the file says, counted by kind.
//!
//! A file with one oddity usually has it in thousands of lines. Each kind gives one warning, with
//! the number of its cases and the first of them.

use super::contents::Atom;
use std::collections::BTreeMap;

/// A kind of correction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Correction {
    /// The element column says another element than the name of the atom.
    Element,
    /// Columns are shifted after a long number.
    ShiftedColumns,
    /// The residue number is missing, or did not fit into its columns.
    NoResidueNumber,
    /// The residue name is not in capitals.
    LowerCase,
    /// Column 21 belongs to the name of the residue.
    FourLetterName,
}

/// The corrections of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Corrections {
    /// Number of cases of each kind, and the first.
    cases: BTreeMap<Correction, (usize, String)>,
}

impl Corrections {
    /// Counts a case; `describe` tells what the first one is.
    pub(crate) fn add(
        &mut self,
        correction: Correction,
        line: usize,
        describe: impl FnOnce() -> String,
    ) {
        let first = || (0, format!("line {line}: {}", describe()));
        self.cases.entry(correction).or_insert_with(first).0 += 1;
    }

    /// One warning for each kind.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::with_capacity(self.cases.len());
        for (correction, (count, first)) in &self.cases {
            warnings.push(correction.warning(*count, first));
        }
        warnings
    }
}

impl Correction {
    fn warning(self, count: usize, first: &str) -> String {
        let atoms = if count == 1 { "atom" } else { "atoms" };
        let description = match self {
            Correction::Element => "state another element than their names, which decide",
            Correction::ShiftedColumns => {
                "have columns shifted by a long number, and are read in the shifted columns"
            }
            Correction::NoResidueNumber => {
                "have no readable residue number: residues are told apart by names and atoms"
            }
            Correction::LowerCase => "have residue names in small letters, read as capitals",
            Correction::FourLetterName => {
                "have a residue name of four letters: column 21 is read as its last, not as the \
                 first letter of the chain"
            }
        };
        format!("{count} {atoms} {description} (first in {first})")
    }
}

/// Atom in words, such as `CA of ALA A:7`.
pub(crate) fn describe(atom: &Atom) -> String {
    format!(
        "{} of {} {}:{}{}",
        atom.name, atom.residue_name, atom.chain, atom.residue_number, atom.insertion_code
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_is_one_warning_with_its_number_and_first_case() {
        let mut corrections = Corrections::default();
        for line in 3..10 {
            corrections.add(Correction::LowerCase, line, || format!("case {line}"));
        }
        let [warning] = corrections.warnings().try_into().unwrap();
        assert!(
            warning.starts_with("7 atoms") && warning.ends_with("(first in line 3: case 3)"),
            "{warning}"
        );
    }
}
