//! The chains of bodies, and new identifiers for those of every copy.

use super::super::classes::is_sugar;
use super::PlacedBody;
use super::symbol::{NamedAtom, symbol};
use crate::body::Body;
use crate::chemistry::AminoAcid;
use crate::chemistry::residue_names::{is_nucleotide, is_polymer, is_water};
use crate::{BodyError, Result};
use serde::Serialize;
use std::collections::HashMap;

/// A chain in a file, and where it comes from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct WrittenChain {
    /// Identifier of the chain in the file: `auth_asym_id` in mmCIF.
    pub chain: String,
    /// The copy of a body that the chain belongs to, counted from zero.
    pub copy: usize,
    /// The name of the body.
    pub body: String,
    /// The chain in the body's source; empty if it has none.
    pub source_chain: String,
}

/// Chains that are written, in order.
pub(super) struct Layout<'a> {
    pub(super) chains: Vec<Chain<'a>>,
    /// The parts of each body that occurs.
    parts: Vec<(&'a Body, BodyParts)>,
}

/// A chain of a copy.
pub(super) struct Chain<'a> {
    pub(super) id: String,
    pub(super) copy: usize,
    pub(super) placed: &'a PlacedBody<'a>,
    body: usize,
    part: usize,
}

/// The residues of a body by chain.
struct BodyParts {
    chains: Vec<ChainPart>,
    /// The atoms of each residue, as indices of sites.
    atoms: Vec<Vec<usize>>,
    /// The element of each site.
    symbols: Vec<&'static str>,
}

/// One chain of a body: indices of residues.
pub(super) struct ChainPart {
    pub(super) name: String,
    /// Residues of the polymer, each with its number in the sequence.
    pub(super) polymer: Vec<(usize, i64)>,
    /// Ligands, ions and waters.
    pub(super) others: Vec<usize>,
}

impl<'a> Layout<'a> {
    /// Layout with identifiers of one character.
    pub(super) fn for_pdb(copies: &'a [PlacedBody<'a>]) -> Result<Self> {
        let mut layout = Self::new(copies);
        let needed = layout.chains.len();
        if needed > CHARACTERS.len() {
            return Err(BodyError::Invalid {
                cause: format!(
                    "{needed} chains, and a PDB file has identifiers for {}",
                    CHARACTERS.len()
                ),
                remedy: "write mmCIF instead".into(),
            });
        }
        for (chain, letter) in layout.chains.iter_mut().zip(CHARACTERS.chars()) {
            chain.id = letter.to_string();
        }
        Ok(layout)
    }

    /// Layout with the identifiers A, B, ..., Z, AA, AB, ...
    pub(super) fn for_mmcif(copies: &'a [PlacedBody<'a>]) -> Self {
        let mut layout = Self::new(copies);
        for (number, chain) in layout.chains.iter_mut().enumerate() {
            chain.id = letters(number);
        }
        layout
    }

    fn new(copies: &'a [PlacedBody<'a>]) -> Self {
        let mut parts: Vec<(&Body, BodyParts)> = Vec::new();
        let mut chains = Vec::new();
        for (copy, placed) in copies.iter().enumerate() {
            let index = parts
                .iter()
                .position(|(body, _)| std::ptr::eq(*body, placed.body));
            let body = index.unwrap_or(parts.len());
            if index.is_none() {
                parts.push((placed.body, BodyParts::from_body(placed.body)));
            }
            for part in 0..parts[body].1.chains.len() {
                chains.push(Chain {
                    id: String::new(),
                    copy,
                    placed,
                    body,
                    part,
                });
            }
        }
        Self { chains, parts }
    }

    /// The residues of a chain.
    pub(super) fn part(&self, chain: &Chain) -> &ChainPart {
        &self.parts[chain.body].1.chains[chain.part]
    }

    /// The atoms of a residue of a chain's body: indices of sites and elements.
    pub(super) fn atoms(
        &self,
        chain: &Chain,
        residue: usize,
    ) -> impl Iterator<Item = (usize, &'static str)> {
        let parts = &self.parts[chain.body].1;
        let sites = parts.atoms[residue].iter();
        sites.map(|site| (*site, parts.symbols[*site]))
    }

    pub(super) fn table(&self) -> Vec<WrittenChain> {
        let mut table = Vec::with_capacity(self.chains.len());
        for chain in &self.chains {
            table.push(WrittenChain {
                chain: chain.id.clone(),
                copy: chain.copy,
                body: chain.placed.body.name.clone(),
                source_chain: self.part(chain).name.clone(),
            });
        }
        table
    }
}

impl BodyParts {
    fn from_body(body: &Body) -> Self {
        let mut atoms = vec![Vec::new(); body.residues.len()];
        for (index, site) in body.sites.iter().enumerate() {
            if let Some(residue) = residue_of_atom(body, index)
                && !site.atom_name.is_empty()
            {
                atoms[residue].push(index);
            }
        }
        let mut symbols = vec!["X"; body.sites.len()];
        let mut chains: Vec<ChainPart> = Vec::new();
        let mut index_of = HashMap::new();
        for (index, residue) in body.residues.iter().enumerate() {
            let sites = &atoms[index];
            if sites.is_empty() {
                continue;
            }
            let names = |site: &usize| body.sites[*site].atom_name.as_str();
            let is_in_polymer = is_in_polymer(&residue.name, sites.iter().map(names));
            for site in sites {
                symbols[*site] = symbol(&NamedAtom {
                    name: &body.sites[*site].atom_name,
                    residue_name: &residue.name,
                    radius_angstrom: body.sites[*site].radius_angstrom,
                    is_common: is_in_polymer || is_water(&residue.name),
                    is_alone: sites.len() == 1,
                });
            }
            let chain = *index_of.entry(&residue.chain).or_insert_with(|| {
                chains.push(ChainPart::named(&residue.chain));
                chains.len() - 1
            });
            match is_in_polymer {
                true => chains[chain].add_to_polymer(body, index),
                false => chains[chain].others.push(index),
            }
        }
        Self {
            chains,
            atoms,
            symbols,
        }
    }
}

impl ChainPart {
    fn named(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            polymer: Vec::new(),
            others: Vec::new(),
        }
    }

    /// A gap in the residue numbers is one in the sequence too, so that no viewer bonds its ends.
    fn add_to_polymer(&mut self, body: &Body, index: usize) {
        let number = match self.polymer.last() {
            None => 1,
            Some((before, last)) => {
                let number_of = |index: usize| i64::from(body.residues[index].number);
                last + (number_of(index) - number_of(*before)).max(1)
            }
        };
        self.polymer.push((index, number));
    }
}

/// The number of atoms of a body.
pub(super) fn atoms_of(body: &Body) -> usize {
    let atoms = body.sites.iter().enumerate().filter(|(index, site)| {
        !site.atom_name.is_empty() && residue_of_atom(body, *index).is_some()
    });
    atoms.count()
}

fn residue_of_atom(body: &Body, site: usize) -> Option<usize> {
    let residue = usize::try_from(body.sites[site].residue?).ok()?;
    (residue < body.residues.len()).then_some(residue)
}

/// Whether a residue is an amino acid or a nucleotide, whose records are `ATOM`.
pub(super) fn is_standard(name: &str) -> bool {
    AminoAcid::of_residue(name).is_some() || is_nucleotide(name)
}

/// Whether a residue is part of a polymer by its name; one of an unknown name by its atoms: those of
/// a backbone or of a sugar.
fn is_in_polymer<'a>(name: &str, atoms: impl Iterator<Item = &'a str>) -> bool {
    if is_polymer(name) {
        return true;
    }
    if is_water(name) {
        return false;
    }
    let atoms: Vec<&str> = atoms.collect();
    let has_backbone = ["N", "CA", "C"].iter().all(|name| atoms.contains(name));
    has_backbone || is_sugar(|name| atoms.contains(&name))
}

/// Identifiers of chains in a PDB file, in the order in which they are used.
const CHARACTERS: &str = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789";

/// Letters of a number: A for 0, Z for 25, AA for 26.
pub(super) fn letters(mut number: usize) -> String {
    let mut letters = Vec::new();
    loop {
        letters.push(char::from(b'A' + (number % 26) as u8));
        match (number / 26).checked_sub(1) {
            Some(quotient) => number = quotient,
            None => break,
        }
    }
    letters.iter().rev().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_go_on_after_z() {
        let cases = [
            (0, "A"),
            (25, "Z"),
            (26, "AA"),
            (27, "AB"),
            (701, "ZZ"),
            (702, "AAA"),
        ];
        for (number, id) in cases {
            assert_eq!(letters(number), id);
        }
    }

    #[test]
    fn a_polymer_is_known_by_name_or_by_its_atoms() {
        let polymer = |name: &str, atoms: &[&str]| is_in_polymer(name, atoms.iter().copied());
        assert!(polymer("MSE", &["SE"]) && polymer("ACE", &["C"]) && polymer("DA", &["P"]));
        assert!(polymer("XYZ", &["N", "CA", "C", "Q1"]));
        assert!(polymer("XYZ", &["C1'", "C2'", "C3'", "C4'", "O4'"]));
        assert!(
            !polymer("HOH", &["O"]) && !polymer("CA", &["CA"]) && !polymer("ATP", &["PA", "C1'"])
        );
        assert!(is_standard("LYS") && is_standard("DG") && !is_standard("MSE"));
    }
}
