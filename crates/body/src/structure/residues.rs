//! Atoms grouped into residues, and which groups form a chain.

use super::contents::Atom;
use super::residue_key::ResidueKey;
use crate::chemistry::residue_names;
use protomer_kernel::Vec3;
use std::collections::{HashMap, HashSet};

/// The atom records of one residue.
pub(crate) struct AtomGroup<'a> {
    pub(crate) key: ResidueKey,
    pub(crate) atoms: Vec<&'a Atom>,
    /// Whether an earlier residue has the same chain and number.
    pub(crate) is_repeated: bool,
}

impl AtomGroup<'_> {
    /// Position of the first atom with one of two names.
    fn position(&self, names: [&str; 2]) -> Option<Vec3> {
        for atom in &self.atoms {
            if names.contains(&&*atom.name) {
                return Some(atom.position);
            }
        }
        None
    }

    /// Whether all its atoms are outside any polymer according to the file.
    fn is_outside(&self) -> bool {
        self.atoms.iter().all(|atom| atom.outside_polymer)
    }

    fn is_hetero(&self) -> bool {
        self.atoms.iter().all(|atom| atom.hetero)
    }
}

/// Groups atoms by residue, in order of first appearance. The atoms of a residue need not be
/// contiguous: some files list conformers one after the other. Waters and atoms outside polymers
/// never share a group with a polymer's residue of the same number.
///
/// A new residue begins where both a residue's number and its atoms recur: files without chain
/// identifiers number each chain from one, and large files start again after 9999.
pub(crate) fn group(atoms: &[Atom]) -> Vec<AtomGroup<'_>> {
    let mut groups: Vec<AtomGroup> = Vec::new();
    let mut index_of: HashMap<(ResidueKey, bool), usize> = HashMap::new();
    let mut seen: HashSet<(usize, &str, Option<char>)> = HashSet::with_capacity(atoms.len());
    // The group of the previous atom, and whether it is outside.
    let mut last: Option<(usize, bool)> = None;
    for atom in atoms {
        let outside = atom.outside_polymer || residue_names::is_water(&atom.residue_name);
        let index = match last {
            Some((index, was_outside))
                if was_outside == outside && is_of(atom, &groups[index].key) =>
            {
                index
            }
            _ => {
                let key = key_of(atom);
                let earlier = index_of.get(&(key.clone(), outside)).copied();
                match earlier {
                    Some(index) if !seen.contains(&(index, &*atom.name, atom.alternate)) => index,
                    _ => {
                        index_of.insert((key.clone(), outside), groups.len());
                        groups.push(AtomGroup {
                            key,
                            atoms: Vec::new(),
                            is_repeated: earlier.is_some(),
                        });
                        groups.len() - 1
                    }
                }
            }
        };
        groups[index].atoms.push(atom);
        seen.insert((index, &atom.name, atom.alternate));
        last = Some((index, outside));
    }
    groups
}

fn key_of(atom: &Atom) -> ResidueKey {
    ResidueKey {
        chain: atom.chain.clone(),
        number: atom.residue_number,
        insertion_code: atom.insertion_code.clone(),
    }
}

/// Whether an atom belongs to the residue of this key.
pub(crate) fn is_of(atom: &Atom, key: &ResidueKey) -> bool {
    key.number == atom.residue_number
        && key.chain == atom.chain
        && key.insertion_code == atom.insertion_code
}

/// For each group, whether it is part of a chain: an ordinary ATOM, or bonded to its neighbour in
/// the file by a bond between residues of a chain (C-N or O3'-P). A group outside any polymer
/// counts only if such bonds connect it to a group inside: two bonded parts of a ligand are not a
/// chain.
pub(crate) fn in_chain(groups: &[AtomGroup]) -> Vec<bool> {
    let mut bonded_to_next = Vec::with_capacity(groups.len());
    for pair in groups.windows(2) {
        bonded_to_next.push(are_bonded(&pair[0], &pair[1]));
    }
    bonded_to_next.push(false);
    let mut in_chain = vec![false; groups.len()];
    // From each side: whether a series of bonds connects a group inside to this one.
    let mut reaches = false;
    for (index, group) in groups.iter().enumerate() {
        in_chain[index] = !group.is_hetero() || reaches;
        reaches = bonded_to_next[index] && (reaches || !group.is_outside());
    }
    reaches = false;
    for (index, group) in groups.iter().enumerate().rev() {
        in_chain[index] |= reaches;
        let is_bonded = index > 0 && bonded_to_next[index - 1];
        reaches = is_bonded && (reaches || !group.is_outside());
    }
    in_chain
}

fn are_bonded(before: &AtomGroup, after: &AtomGroup) -> bool {
    const BOND_ANGSTROM: f64 = 2.0;
    // Chromophores call the atoms of their peptide bonds C3 and N1.
    const PEPTIDE: [[&str; 2]; 2] = [["C", "C3"], ["N", "N1"]];
    const PHOSPHODIESTER: [[&str; 2]; 2] = [["O3'", "O3*"], ["P", "P"]];
    if before.key.chain != after.key.chain {
        return false;
    }
    for [end, start] in [PEPTIDE, PHOSPHODIESTER] {
        if let (Some(end), Some(start)) = (before.position(end), after.position(start))
            && (end - start).norm() < BOND_ANGSTROM
        {
            return true;
        }
    }
    false
}
