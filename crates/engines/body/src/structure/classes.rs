//! What kind of residue a group of atoms is.

use super::contents::Atom;
use crate::chemistry::amino_acid::{AminoAcid, BACKBONE};
use crate::chemistry::residue_names::{self, ModifiedResidue};

/// Kind of a residue.
///
/// ```
/// use protomer_body::chemistry::AminoAcid;
/// use protomer_body::structure::ResidueClass;
/// let class = ResidueClass::AminoAcid(AminoAcid::Ser);
/// assert!(class.is_protein());
/// assert_eq!(ResidueClass::Ligand.amino_acid(), None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ResidueClass {
    /// One of the twenty amino acids.
    AminoAcid(AminoAcid),
    /// A residue in the table of modified residues: a modified amino acid, a D-amino acid or a
    /// chromophore.
    Modified(&'static ModifiedResidue),
    /// A residue in no table, but with exactly the heavy atoms of an amino acid, OXT apart.
    LikeAminoAcid(AminoAcid),
    /// A residue in no table that is part of a protein chain.
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
        use ResidueClass::{AminoAcid, Cap, LikeAminoAcid, Modified, UnknownAminoAcid};
        matches!(
            self,
            AminoAcid(_) | Modified(_) | LikeAminoAcid(_) | UnknownAminoAcid | Cap
        )
    }

    /// The amino acid that the residue is, derives from, or has the atoms of.
    pub fn amino_acid(&self) -> Option<AminoAcid> {
        match self {
            ResidueClass::AminoAcid(amino_acid) | ResidueClass::LikeAminoAcid(amino_acid) => {
                Some(*amino_acid)
            }
            ResidueClass::Modified(modified) => modified.parent,
            _ => None,
        }
    }

    /// The class by the residue's name and atoms. `is_in_chain` says whether it is in a polymer or
    /// bonded to one ([`super::residues::in_chain`]). Anything outside is a ligand, even an amino
    /// acid; an unknown name is taken for an amino acid only inside.
    pub(crate) fn classify(name: &str, atoms: &[&Atom], is_in_chain: bool) -> Self {
        if residue_names::is_water(name) {
            return ResidueClass::Water;
        }
        let is_outside = atoms.iter().all(|atom| atom.outside_polymer);
        if is_outside && !is_in_chain {
            return ResidueClass::Ligand;
        }
        if let Some(amino_acid) = AminoAcid::of_residue(name) {
            ResidueClass::AminoAcid(amino_acid)
        } else if let Some(amino_acid) = amino_acid_of_force_field(name, atoms) {
            ResidueClass::AminoAcid(amino_acid)
        } else if let Some(class) = contradicted(name, atoms) {
            class
        } else if let Some(modified) = residue_names::modified_residue(name) {
            ResidueClass::Modified(modified)
        } else if residue_names::is_cap(name) {
            ResidueClass::Cap
        } else if residue_names::is_nucleotide(name) {
            ResidueClass::Nucleotide
        } else if is_in_chain {
            Self::by_atoms(atoms)
        } else {
            ResidueClass::Ligand
        }
    }

    /// The class of a residue of a chain whose name is in no table. A nucleotide is recognised by
    /// its whole sugar; `C1'` alone is not enough (2-ethylpiperidine has one).
    fn by_atoms(atoms: &[&Atom]) -> Self {
        if is_sugar(|name| has(atoms, name)) {
            ResidueClass::Nucleotide
        } else if !["N", "CA", "C"].iter().all(|name| has(atoms, name)) {
            ResidueClass::Ligand
        } else if let Some(amino_acid) = amino_acid_of_atoms(atoms) {
            ResidueClass::LikeAminoAcid(amino_acid)
        } else {
            ResidueClass::UnknownAminoAcid
        }
    }
}

/// The amino acid of a name of a force field, if the residue is one: glycerol is GLYC in CHARMM.
fn amino_acid_of_force_field(name: &str, atoms: &[&Atom]) -> Option<AminoAcid> {
    let amino_acid = residue_names::force_field_amino_acid(name)?;
    (has(atoms, "CA") && (has(atoms, "N") || has(atoms, "C"))).then_some(amino_acid)
}

/// The class of a residue whose name means a cap or a modified residue, but whose atoms are those of
/// an amino acid: AMBER calls the first Met of a chain NMET, of which three columns hold NME.
fn contradicted(name: &str, atoms: &[&Atom]) -> Option<ResidueClass> {
    let modified = residue_names::modified_residue(name);
    if modified.is_none() && !residue_names::is_cap(name) {
        return None;
    }
    let amino_acid = amino_acid_of_atoms(atoms)?;
    let is_parent = modified.is_some_and(|modified| modified.parent == Some(amino_acid));
    (!is_parent).then_some(ResidueClass::LikeAminoAcid(amino_acid))
}

/// The furanose ring of a nucleotide, in both spellings.
const SUGAR: [[&str; 2]; 5] = [
    ["C1'", "C1*"],
    ["C2'", "C2*"],
    ["C3'", "C3*"],
    ["C4'", "C4*"],
    ["O4'", "O4*"],
];

fn has(atoms: &[&Atom], name: &str) -> bool {
    atoms.iter().any(|atom| &*atom.name == name)
}

/// Whether a residue that has some names of atoms has a furanose ring.
pub(crate) fn is_sugar(has: impl Fn(&str) -> bool) -> bool {
    SUGAR.iter().all(|names| names.iter().any(|name| has(name)))
}

/// The amino acid with exactly these heavy atoms, with or without OXT. Glycine and alanine are
/// excluded: any residue without its side chain has their atoms.
fn amino_acid_of_atoms(atoms: &[&Atom]) -> Option<AminoAcid> {
    let mut names = Vec::new();
    for atom in atoms {
        if atom.is_hydrogen() || &*atom.name == "OXT" {
            continue;
        }
        // SD of methionine is a sulfur; with a selenium of that name it is another residue.
        if !atom.name.starts_with(&*atom.element) {
            return None;
        }
        names.push(&*atom.name);
    }
    names.sort_unstable();
    for amino_acid in AminoAcid::all() {
        let mut expected = [&BACKBONE[..], amino_acid.side_chain()].concat();
        expected.sort_unstable();
        let is_excluded = matches!(amino_acid, AminoAcid::Gly | AminoAcid::Ala);
        if !is_excluded && names == expected {
            return Some(amino_acid);
        }
    }
    None
}
