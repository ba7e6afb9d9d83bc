//! The selected residues.

use super::classes::ResidueClass;
use super::contents::Atom;
use super::report::SelectionReport;
use super::residue_key::ResidueKey;
use crate::chemistry::amino_acid::AminoAcid;
use std::sync::Arc;

/// The selected residues in file order; [`Structure::select`](super::Structure::select) makes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Selection {
    /// Residues, each with at least one atom.
    pub residues: Vec<SelectedResidue>,
    /// Report of what was selected, what was left out, and how residues were treated.
    pub report: SelectionReport,
}

impl Selection {
    /// The residues of one chain, with the report of the whole selection.
    pub fn only_chain(&self, chain: &str) -> Selection {
        self.only_chains(&[chain])
    }

    /// The residues of some chains in the order of the file, with the report of the whole selection.
    ///
    /// ```
    /// use protomer_body::structure::{SelectionSettings, Structure};
    /// let text = "\
    /// ATOM      1  CA  GLY A   7      11.639   6.071  -5.147  1.00 10.00           C
    /// ATOM      2  CA  ALA B   7      31.639   6.071  -5.147  1.00 10.00           C
    /// ATOM      3  CA  SER C   7      51.639   6.071  -5.147  1.00 10.00           C
    /// ";
    /// let selection = Structure::read("three.pdb", text.as_bytes())?.select(&SelectionSettings::default())?;
    /// let part = selection.only_chains(&["C", "A"]);
    /// let names: Vec<&str> = part.residues.iter().map(|residue| &*residue.name).collect();
    /// assert_eq!((names, part.report.atoms), (vec!["GLY", "SER"], 2));
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn only_chains(&self, chains: &[impl AsRef<str>]) -> Selection {
        let mut residues = Vec::new();
        for residue in &self.residues {
            let name = &*residue.key.chain;
            if chains.iter().any(|chain| chain.as_ref() == name) {
                residues.push(residue.clone());
            }
        }
        let mut report = self.report.clone();
        report.atoms = atom_count(&residues);
        Selection { residues, report }
    }
}

/// One residue in one conformer.
#[derive(Debug, Clone, PartialEq)]
pub struct SelectedResidue {
    /// Chain, number, insertion code. The second copy of chain A in an assembly is chain `A-2`. Chains
    /// to which the file gives no name, or the same, have names that tell them apart.
    pub key: ResidueKey,
    /// Residue name; after a mutation that of the new residue. Where the file has a name that the atoms
    /// contradict, that of the amino acid whose atoms they are.
    pub name: Arc<str>,
    /// Class of the residue; after a mutation that of the new residue.
    pub class: ResidueClass,
    /// Atoms of the residue.
    pub atoms: Vec<Atom>,
    /// Author's chain in the file, which may give several chains the same name or none.
    pub source_chain: Arc<str>,
    /// Residue number in the file, which may give all residues the same.
    pub source_number: i32,
    /// The separate polymer to which the residue belongs, counted from zero; `None` outside
    /// polymers.
    pub strand: Option<usize>,
    /// Whether the residue has a free amine as the beginning of a chain.
    pub n_terminus: bool,
    /// Whether the residue has a free carboxylate as the end of a chain.
    pub c_terminus: bool,
    /// Whether the residue is a cysteine in a disulfide bond.
    pub in_disulfide: bool,
    /// The amino acid before a mutation.
    pub mutated_from: Option<AminoAcid>,
}

impl SelectedResidue {
    /// The atom of a name.
    ///
    /// ```
    /// use protomer_body::structure::{SelectionSettings, Structure};
    /// let text = "ATOM      1  CA  GLY A   7      11.639   6.071  -5.147  1.00 10.00           C";
    /// let selection = Structure::read("one.pdb", text.as_bytes())?.select(&SelectionSettings::default())?;
    /// let glycine = &selection.residues[0];
    /// assert_eq!(glycine.atom("CA").map(|atom| atom.position.x), Some(11.639));
    /// assert!(glycine.atom("CB").is_none());
    /// # Ok::<(), protomer_body::BodyError>(())
    /// ```
    pub fn atom(&self, name: &str) -> Option<&Atom> {
        self.atoms.iter().find(|atom| &*atom.name == name)
    }

    /// The key of the residue in the file.
    pub(crate) fn source_key(&self) -> ResidueKey {
        ResidueKey {
            chain: self.source_chain.clone(),
            number: self.source_number,
            ..self.key.clone()
        }
    }
}

/// Number of atoms of these residues.
pub(crate) fn atom_count(residues: &[SelectedResidue]) -> usize {
    let mut atoms = 0;
    for residue in residues {
        atoms += residue.atoms.len();
    }
    atoms
}
