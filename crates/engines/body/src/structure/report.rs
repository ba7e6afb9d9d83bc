//! The report of a selection.

use super::confidence::LowConfidence;
use super::contents::Atom;
use super::residue_key::ResidueKey;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Report of what was selected, what was left out and why, and how residues were treated.
///
/// ```
/// use protomer_body::structure::{SelectionSettings, Structure};
/// let text = "\
/// ATOM      1  CA  GLY A   7      11.639   6.071  -5.147  1.00 10.00           C
/// HETATM    2  O   HOH A 201      20.639   6.071  -5.147  1.00 10.00           O
/// ";
/// let structure = Structure::read("wet.pdb", text.as_bytes())?;
/// let report = structure.select(&SelectionSettings::default())?.report;
/// assert_eq!((report.records, report.atoms), (2, 1));
/// assert_eq!(report.skipped_in_words(), Some("1 water".to_owned()));
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct SelectionReport {
    /// Model used.
    pub model: i32,
    /// Models in the file.
    pub models: usize,
    /// Whether the user chose the model.
    #[serde(skip)]
    pub is_model_chosen: bool,
    /// Biological assembly used.
    pub assembly: Option<String>,
    /// Atom records of the model.
    pub records: usize,
    /// Atoms selected, over all copies of an assembly.
    pub atoms: usize,
    /// Atom records left out, by reason. With `atoms` they add up to `records` unless an assembly
    /// is applied.
    pub skipped: BTreeMap<&'static str, usize>,
    /// Names of the records that are no atoms, or no separate atoms, by reason.
    pub left_out: BTreeMap<&'static str, BTreeMap<String, usize>>,
    /// Names and numbers of chains and residues that were read otherwise than the file says.
    pub corrections: Vec<String>,
    /// Residues left out, by reason.
    pub skipped_residues: BTreeMap<&'static str, SkippedResidues>,
    /// Modified residues: what each is and what it counts as.
    pub modified: Vec<ListedResidue>,
    /// Residues of a chain that are in no table, and what each counts as.
    pub unknown: Vec<ListedResidue>,
    /// Ligands kept, and where the charge of each comes from.
    pub ligands: Vec<ListedResidue>,
    /// Residues with other residues in the same place.
    pub microheterogeneous: Vec<ListedResidue>,
    /// First and last residues of chains whose amine or carboxyl group has no charge because it is
    /// bonded to another residue.
    pub blocked_ends: Vec<ListedResidue>,
    /// Disulfide bonds.
    pub disulfides: Vec<Disulfide>,
    /// Residues that lack heavy atoms.
    pub incomplete: Vec<IncompleteResidue>,
    /// Breaks of chains.
    pub chain_breaks: Vec<ChainBreak>,
    /// Residues of the selected chains that the file lists as not observed.
    pub unobserved: usize,
    /// Selected residues that have the chain and number of an earlier one, as in files without
    /// chain identifiers.
    pub repeated_numbers: usize,
    /// Selected atoms with zero occupancy.
    pub zero_occupancy: usize,
    /// Residues of low confidence, of a predicted model.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub low_confidence: Vec<LowConfidence>,
}

impl SelectionReport {
    /// Counts atoms that are left out.
    pub(crate) fn skip(&mut self, why: &'static str, atoms: usize) {
        if atoms > 0 {
            *self.skipped.entry(why).or_default() += atoms;
        }
    }

    /// Counts a residue that is left out with this many atoms.
    pub(crate) fn skip_residue(
        &mut self,
        why: &'static str,
        name: &str,
        chain: &str,
        atoms: usize,
    ) {
        self.skip(why, atoms);
        let residues = self.skipped_residues.entry(why).or_default();
        *residues.names.entry(name.to_owned()).or_default() += 1;
        residues.chains.insert(chain.to_owned());
    }

    /// Atoms left out, by reason, such as `6 ligand, 221 water`; `None` if none were.
    pub fn skipped_in_words(&self) -> Option<String> {
        let counts = self.skipped.iter();
        let words: Vec<String> = counts
            .map(|(reason, count)| format!("{count} {reason}"))
            .collect();
        (!words.is_empty()).then(|| words.join(", "))
    }

    /// Counts a record that is no atom, or no separate atom.
    pub(crate) fn leave_out(&mut self, why: &'static str, atom: &Atom) {
        self.skip(why, 1);
        let names = self.left_out.entry(why).or_default();
        *names.entry(atom.name.to_string()).or_default() += 1;
    }
}

/// Residues left out for one reason.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct SkippedResidues {
    /// Number of residues of each name.
    pub names: BTreeMap<String, usize>,
    /// Chains that they are in.
    pub chains: BTreeSet<String>,
}

/// Reasons in [`SelectionReport::skipped`].
pub mod reason {
    /// Another chain.
    pub const CHAIN: &str = "other chain";
    /// A residue outside the ranges that were named.
    pub const RANGE: &str = "outside the range";
    /// Another conformer of the residue.
    pub const ALTERNATE: &str = "alternate location";
    /// The same atom of the residue again, elsewhere.
    pub const DUPLICATE: &str = "duplicate atom";
    /// The same atom again, in the same place.
    pub const REPEATED: &str = "repeated atom";
    /// An atom exactly where another one is.
    pub const COINCIDENT: &str = "atom in the place of another";
    /// An atom without a position: nines, or several at the origin.
    pub const UNBUILT: &str = "unbuilt atom";
    /// A pseudoatom, a lone pair or a virtual site.
    pub const PSEUDOATOM: &str = "pseudoatom";
    /// Water.
    pub const WATER: &str = "water";
    /// Ligands, ions, sugars.
    pub const LIGAND: &str = "ligand";
    /// Nucleic acids.
    pub const NUCLEIC_ACID: &str = "nucleic acid";
    /// Hydrogen and deuterium.
    pub const HYDROGEN: &str = "hydrogen";
    /// Residues that lack atoms, where they are to be skipped.
    pub const INCOMPLETE: &str = "incomplete residue";
    /// Chains that are not part of the biological assembly.
    pub const ASSEMBLY: &str = "not in the assembly";
}

/// A residue and how it was treated.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ListedResidue {
    /// Key of the residue.
    pub residue: ResidueKey,
    /// Name of the residue.
    pub name: Arc<str>,
    /// Treatment of the residue, in words.
    pub note: String,
    /// Net charge of the residue, e; `None` before the pH is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub charge_e: Option<f64>,
}

/// A residue without some of its heavy atoms.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct IncompleteResidue {
    /// Key of the residue.
    pub residue: ResidueKey,
    /// Name of the residue.
    pub name: Arc<str>,
    /// Names of the atoms it lacks.
    pub missing_atoms: Vec<&'static str>,
}

/// Two residues that follow each other in the file but are not bonded.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChainBreak {
    /// The residue before the break.
    pub before: ResidueKey,
    /// The residue after the break.
    pub after: ResidueKey,
    /// Distance from C to N, Å; `None` if one of them is missing.
    pub distance_angstrom: Option<f64>,
    /// Residue numbers left out between the two.
    pub missing_numbers: i32,
}

/// A disulfide bond of a selected cysteine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Disulfide {
    /// The selected cysteine.
    pub residue: ResidueKey,
    /// The cysteine it is bonded to.
    pub partner: ResidueKey,
    /// The evidence of the bond.
    pub evidence: DisulfideEvidence,
    /// Distance between the sulfurs, Å; `None` where one of them is missing or the partner is not
    /// selected.
    pub distance_angstrom: Option<f64>,
    /// Whether the partner is selected too. If not, it is in another chain, or in a symmetry copy
    /// of the deposited coordinates.
    pub partner_is_selected: bool,
}

/// The evidence of a disulfide bond.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DisulfideEvidence {
    /// A record of the file, and sulfurs within bonding distance.
    RecordAndDistance,
    /// A record of the file; the sulfurs are farther apart, or one of them is missing.
    Record,
    /// The distance alone.
    Distance,
}
