//! Missing atoms and chain breaks.

use super::classes::ResidueClass;
use super::report::{ChainBreak, IncompleteResidue};
use super::selected::SelectedResidue;
use crate::chemistry::amino_acid::BACKBONE;

/// The largest distance of a peptide bond, which is 1.33 Å long.
const BROKEN_ANGSTROM: f64 = 2.5;

/// The residues that lack heavy atoms.
pub(crate) fn incomplete_residues(residues: &[SelectedResidue]) -> Vec<IncompleteResidue> {
    let mut incomplete = Vec::new();
    for residue in residues {
        let missing_atoms = missing_atoms(residue);
        if !missing_atoms.is_empty() {
            incomplete.push(IncompleteResidue {
                residue: residue.key.clone(),
                name: residue.name.clone(),
                missing_atoms,
            });
        }
    }
    incomplete
}

/// Heavy atoms that the residue lacks. Only the backbone is known for a residue that is not one of
/// the twenty, and nothing for a chromophore.
pub(crate) fn missing_atoms(residue: &SelectedResidue) -> Vec<&'static str> {
    let side_chain = match residue.class {
        ResidueClass::AminoAcid(amino_acid) => amino_acid.side_chain(),
        ResidueClass::Modified(modified) if modified.parent.is_none() => return Vec::new(),
        ResidueClass::Modified(_) => &[],
        ResidueClass::LikeAminoAcid(_) | ResidueClass::UnknownAminoAcid => &[],
        _ => return Vec::new(),
    };
    let mut missing = Vec::new();
    for &name in BACKBONE.iter().chain(side_chain) {
        if residue.atom(name).is_none() {
            missing.push(name);
        }
    }
    missing
}

/// Breaks between consecutive protein residues of a strand.
pub(crate) fn chain_breaks(residues: &[SelectedResidue]) -> Vec<ChainBreak> {
    let mut breaks = Vec::new();
    let mut last: Option<&SelectedResidue> = None;
    for residue in residues {
        if !residue.class.is_protein() {
            continue;
        }
        if let Some(before) = last
            && before.key.chain == residue.key.chain
            && before.strand == residue.strand
        {
            breaks.extend(chain_break(before, residue));
        }
        last = Some(residue);
    }
    breaks
}

fn chain_break(before: &SelectedResidue, after: &SelectedResidue) -> Option<ChainBreak> {
    let distance_angstrom = peptide_distance(before, after);
    let step = after.key.number.saturating_sub(before.key.number);
    let missing_numbers = step.saturating_sub(1).max(0);
    // Without the atoms of the bond, the numbers decide.
    let is_broken = match distance_angstrom {
        Some(distance) => distance > BROKEN_ANGSTROM,
        None => missing_numbers > 0,
    };
    is_broken.then(|| ChainBreak {
        before: before.key.clone(),
        after: after.key.clone(),
        distance_angstrom,
        missing_numbers,
    })
}

/// Distance from the carbonyl carbon to the next nitrogen, Å. Chromophores call them C3 and N1.
pub(crate) fn peptide_distance(before: &SelectedResidue, after: &SelectedResidue) -> Option<f64> {
    let carbon = before.atom("C").or(before.atom("C3"))?;
    let nitrogen = after.atom("N").or(after.atom("N1"))?;
    Some((carbon.position - nitrogen.position).norm())
}
