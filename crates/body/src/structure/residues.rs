//! Atoms grouped to residues, and what kind of residue each is.

use super::Atom;
use crate::chemistry::AminoAcid;
use crate::chemistry::residue_names::{self, ModifiedResidue};
use serde::{Deserialize, Serialize};
use std::collections::{HashMap, HashSet};
use std::fmt;
use std::sync::Arc;

/// What identifies a residue: chain, number, insertion code. Written `A:45`, or `A:45B` with
/// insertion code B.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ResidueKey {
    /// Chain identifier (author's).
    pub chain: Arc<str>,
    /// Residue number (author's).
    pub number: i32,
    /// Insertion code; empty for none.
    pub insertion_code: Arc<str>,
}

impl fmt::Display for ResidueKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}{}", self.chain, self.number, self.insertion_code)
    }
}

impl ResidueKey {
    pub(crate) fn of(atom: &Atom) -> Self {
        let insertion_code = atom.insertion_code.clone();
        Self {
            chain: atom.chain.clone(),
            number: atom.residue_number,
            insertion_code,
        }
    }
}

/// What kind of residue it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ResidueClass {
    /// One of the twenty amino acids.
    AminoAcid(AminoAcid),
    /// A known modification of one, or a chromophore.
    Modified(&'static ModifiedResidue),
    /// Part of a protein chain, but in no table.
    UnknownAminoAcid,
    /// A group that closes a chain, such as acetyl.
    Cap,
    /// A nucleotide.
    Nucleotide,
    /// Water.
    Water,
    /// Anything else: ligands, ions, sugars, lipids.
    Ligand,
}

impl ResidueClass {
    /// Whether the residue is part of a protein.
    pub fn is_protein(&self) -> bool {
        use ResidueClass::{AminoAcid, Cap, Modified, UnknownAminoAcid};
        matches!(self, AminoAcid(_) | Modified(_) | UnknownAminoAcid | Cap)
    }

    /// The amino acid it is or was made from.
    pub fn amino_acid(&self) -> Option<AminoAcid> {
        match self {
            ResidueClass::AminoAcid(amino_acid) => Some(*amino_acid),
            ResidueClass::Modified(modified) => modified.parent,
            _ => None,
        }
    }

    /// The class by the residue's name and atoms; an unknown residue is held for part of a chain
    /// only if `is_in_chain`.
    pub(crate) fn of(name: &str, atoms: &[&Atom], is_in_chain: bool) -> Self {
        let has = |atom_name: &str| atoms.iter().any(|atom| &*atom.name == atom_name);
        let outside = atoms.iter().all(|atom| atom.outside_polymer);
        if residue_names::is_water(name) {
            ResidueClass::Water
        } else if outside && !is_in_chain {
            ResidueClass::Ligand
        } else if let Some(amino_acid) = AminoAcid::of_residue(name) {
            ResidueClass::AminoAcid(amino_acid)
        } else if let Some(modified) = residue_names::modified_residue(name) {
            ResidueClass::Modified(modified)
        } else if residue_names::is_cap(name) {
            ResidueClass::Cap
        } else if residue_names::is_nucleotide(name) || (is_in_chain && has("C1'")) {
            ResidueClass::Nucleotide
        } else if is_in_chain && has("N") && has("CA") && has("C") {
            ResidueClass::UnknownAminoAcid
        } else {
            ResidueClass::Ligand
        }
    }
}

/// The atom records of one residue.
pub(crate) struct AtomGroup<'a> {
    pub(crate) key: ResidueKey,
    pub(crate) atoms: Vec<&'a Atom>,
    /// Whether an earlier residue bears the same chain and number.
    pub(crate) is_repeated: bool,
}

/// Groups atoms by residue, in order of first appearance; the atoms of a residue need not stand
/// together (some files list conformers one after the other). Waters and what stands outside of
/// polymers never share a group with a polymer's residue of the same number. Where a residue's
/// number comes again and so do its atoms, a new residue begins: files without chain identifiers
/// number each chain from one, and large ones begin again after 9999.
pub(crate) fn group(atoms: &[Atom]) -> Vec<AtomGroup<'_>> {
    let mut groups: Vec<AtomGroup> = Vec::new();
    let mut index_of: HashMap<(ResidueKey, bool), usize> = HashMap::new();
    let mut seen: HashSet<(usize, &str, Option<char>)> = HashSet::with_capacity(atoms.len());
    let mut last: Option<(usize, bool)> = None;
    for atom in atoms {
        let outside = atom.outside_polymer || residue_names::is_water(&atom.residue_name);
        let continues = last.filter(|(index, last_outside)| {
            let key = &groups[*index].key;
            *last_outside == outside
                && key.number == atom.residue_number
                && key.chain == atom.chain
                && key.insertion_code == atom.insertion_code
        });
        let index = match continues {
            Some((index, _)) => index,
            None => {
                let key = ResidueKey::of(atom);
                let earlier = index_of.get(&(key.clone(), outside)).copied();
                let is_new = |index: &usize| !seen.contains(&(*index, &*atom.name, atom.alternate));
                earlier.filter(is_new).unwrap_or_else(|| {
                    index_of.insert((key.clone(), outside), groups.len());
                    groups.push(AtomGroup {
                        key,
                        atoms: Vec::new(),
                        is_repeated: earlier.is_some(),
                    });
                    groups.len() - 1
                })
            }
        };
        groups[index].atoms.push(atom);
        seen.insert((index, &atom.name, atom.alternate));
        last = Some((index, outside));
    }
    groups
}
