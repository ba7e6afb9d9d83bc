//! Names of residues and chains in columns 18-22 of PDB lines.
//!
//! The standard has the residue name in columns 18-20 and the chain in column 22. Two extensions use
//! column 21: a two-letter chain (large complexes), and a four-letter residue name (programs for
//! molecular dynamics: `LYSH`, `TIP3`). A line alone does not tell them apart, `LYSHA  15` may be
//! either; the file does:
//!
//! 1. A residue between two of the chain that column 22 names, with the number in between, has a
//!    four-letter name.
//! 2. Otherwise three letters that name a residue make the other column a part of the chain, unless
//!    every residue of that chain has a name of four letters that means something.
//! 3. Three letters that name nothing belong to a four-letter name.

use super::columns::{Line, whole_number};
use crate::chemistry::residue_names;
use std::collections::{HashMap, HashSet};

/// Columns 21 and 22.
type Pair = [u8; 2];

/// The use of column 21 in a file.
#[derive(Debug, Default)]
pub(super) struct ResidueNames {
    /// Columns 21-22 that are a chain of two letters.
    two_letter_chains: HashSet<Pair>,
}

/// Evidence about the residues with one pair of letters in columns 21-22.
#[derive(Default)]
struct Evidence {
    /// Whether one of the residues continues the chain of column 22.
    continues: bool,
    /// Whether one of the residues has three letters that name a residue, and four that do not.
    needs_three: bool,
}

/// The residue of the line before.
#[derive(Clone, Copy, PartialEq)]
struct Place {
    pair: Pair,
    number: i32,
}

impl Place {
    fn from_line(line: &Line) -> Option<Self> {
        let [first, second] = [21, 22].map(|column| {
            let letter = line.columns(column, column).bytes().next();
            letter.unwrap_or(b' ')
        });
        Some(Self {
            pair: [first, second],
            number: whole_number(line.residue_number_field())?,
        })
    }

    /// Whether two successive residues are neighbours in the chain that column 22 names, one of them
    /// with a letter in column 21.
    fn continues(&self, other: &Self) -> bool {
        let is_next = other.number.checked_sub(self.number) == Some(1);
        let is_blank = |place: &Self| place.pair[0] == b' ';
        is_next && self.pair[1] == other.pair[1] && is_blank(self) != is_blank(other)
    }
}

impl ResidueNames {
    /// Looks through all atoms of a file.
    pub(super) fn of_file(text: &str) -> Self {
        let mut evidence: HashMap<Pair, Evidence> = HashMap::new();
        let mut last: Option<Place> = None;
        for text in text.lines() {
            if !(text.starts_with("ATOM") || text.starts_with("HETATM")) {
                continue;
            }
            let line = Line::of_atom("", 0, text);
            let Some(place) = Place::from_line(&line) else {
                continue;
            };
            if last == Some(place) {
                continue;
            }
            if let Some(last) = last.filter(|last| last.continues(&place)) {
                for pair in [last.pair, place.pair] {
                    evidence.entry(pair).or_default().continues = true;
                }
            }
            if place.pair[0] != b' ' {
                let (three, four) = (line.field(18, 20), line.field(18, 21));
                let of_pair = evidence.entry(place.pair).or_default();
                let is_meant = residue_names::is_name_of_four_letters(four);
                of_pair.needs_three |= is_residue_name(three) && !is_meant;
            }
            last = Some(place);
        }
        let is_chain = |(_, signs): &(Pair, Evidence)| signs.needs_three && !signs.continues;
        let chains = evidence.into_iter().filter(is_chain);
        Self {
            two_letter_chains: chains.map(|(pair, _)| pair).collect(),
        }
    }

    /// Residue name and chain of a line, and whether column 21 belongs to a name whose first three
    /// letters would be a residue as well.
    pub(super) fn of_line<'a>(&self, line: &Line<'a>) -> (&'a str, &'a str, bool) {
        let three = line.field(18, 20);
        if line.character(21).is_none() {
            return (three, line.field(22, 22), false);
        }
        let is_blank = line.character(22).is_none();
        let letters = line.columns(21, 22).as_bytes();
        let is_two_letters = match letters {
            [first, second] => self.two_letter_chains.contains(&[*first, *second]),
            _ => false,
        };
        let is_name = is_residue_name(three);
        if is_two_letters && is_name && !is_blank {
            (three, line.field(21, 22), false)
        } else {
            let is_ambiguous = is_name && !residue_names::is_water(line.field(18, 21));
            (line.field(18, 21), line.field(22, 22), is_ambiguous)
        }
    }
}

fn is_residue_name(name: &str) -> bool {
    residue_names::is_polymer(name) || residue_names::is_water(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(places: &[&str]) -> Vec<(String, String)> {
        let lines: Vec<String> = places
            .iter()
            .map(|place| format!("ATOM      1  CA  {place}      11.104   6.134  -6.504"))
            .collect();
        let names = ResidueNames::of_file(&lines.join("\n"));
        let read = |text: &String| {
            let (name, chain, _) = names.of_line(&Line::of_atom("", 0, text));
            (name.to_owned(), chain.to_owned())
        };
        lines.iter().map(read).collect()
    }

    #[test]
    fn the_file_tells_chains_of_two_letters_from_names_of_four() {
        let named = |name: &str, chain: &str| (name.to_owned(), chain.to_owned());
        // Molecular dynamics: single residues in the middle of chain A.
        assert_eq!(
            names(&["CYS A  14", "LYSHA  15", "ALA A  16"]),
            [named("CYS", "A"), named("LYSH", "A"), named("ALA", "A")]
        );
        assert_eq!(names(&["ALA A  14", "TYRXA  15"])[1], named("TYRX", "A"));
        // Chain HA, although LYSH and ASPH would be names.
        assert_eq!(
            names(&["ALA A 120", "ALAHA   1", "LYSHA   2", "ASPHA   3"])[1..],
            [named("ALA", "HA"), named("LYS", "HA"), named("ASP", "HA")]
        );
        assert_eq!(names(&["GLUBb4016"]), [named("GLU", "Bb")]);
        // Only names that mean something, and none in a chain of two letters.
        assert_eq!(names(&["LYSHA   1", "ASPHA   2"])[1], named("ASPH", "A"));
        assert_eq!(names(&["TIP3W1234"]), [named("TIP3", "W")]);
        assert_eq!(names(&["NALAA   1"]), [named("NALA", "A")]);
    }
}
