//! One conformer per residue.
//!
//! One letter is chosen for the whole residue: the user's where the residue has it, otherwise the
//! one with the highest mean occupancy (ties: the first). Atoms without a letter belong to every
//! conformer. An atom that the chosen conformer lacks comes from the conformer in which it has the
//! highest occupancy, so that no atom is lost. The letter also decides the residue name where a
//! crystal holds two residues in one place (microheterogeneity).

use super::contents::Atom;
use super::residues::{AtomGroup, place_name};
use crate::chemistry::amino_acid::AminoAcid;
use crate::chemistry::residue_names::parent_amino_acid;
use std::borrow::Cow;
use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

/// One conformer and what was left out.
pub(crate) struct Conformer<'a> {
    pub(crate) name: Arc<str>,
    pub(crate) atoms: Vec<&'a Atom>,
    /// Atoms of other conformers.
    pub(crate) alternates: usize,
    /// Records that repeat an atom.
    pub(crate) duplicates: usize,
    /// Other residue names at this place.
    pub(crate) other_names: BTreeSet<Arc<str>>,
}

/// Chooses the conformer of a residue, which is not empty.
pub(crate) fn choose<'a>(group: &AtomGroup<'a>, wanted: Option<char>) -> Conformer<'a> {
    let atoms = &group.atoms;
    let letter = chosen_letter(atoms, wanted);
    let mut conformer = Conformer {
        name: name_of(group, letter),
        atoms: Vec::new(),
        alternates: 0,
        duplicates: 0,
        other_names: BTreeSet::new(),
    };
    let mut chosen: HashMap<Cow<str>, usize> = HashMap::with_capacity(atoms.len());
    let is_whole = group.fragments.is_empty();
    for &atom in atoms {
        if is_whole && atom.residue_name != conformer.name {
            conformer.other_names.insert(atom.residue_name.clone());
            conformer.alternates += 1;
            continue;
        }
        let Some(&index) = chosen.get(&place_name(atom)) else {
            chosen.insert(place_name(atom), conformer.atoms.len());
            conformer.atoms.push(atom);
            continue;
        };
        let rival = conformer.atoms[index];
        if rival.alternate == atom.alternate {
            conformer.duplicates += 1;
        } else {
            conformer.alternates += 1;
        }
        if rank(atom, letter, rival) == Ordering::Greater {
            conformer.atoms[index] = atom;
        }
    }
    conformer
}

/// The residue name of the chosen letter, or of the first atom. Of several names for the fragments of
/// one residue, that of an amino acid.
fn name_of(group: &AtomGroup, letter: Option<char>) -> Arc<str> {
    let mut names = group.atoms.iter().map(|atom| &atom.residue_name);
    if !group.fragments.is_empty() {
        let name = names
            .clone()
            .find(|name| AminoAcid::of_residue(name).is_some());
        let name = name.or_else(|| names.clone().find(|name| parent_amino_acid(name).is_some()));
        return name.or_else(|| names.next()).cloned().unwrap_or_default();
    }
    for atom in &group.atoms {
        if letter.is_some() && atom.alternate == letter {
            return atom.residue_name.clone();
        }
    }
    names.next().cloned().unwrap_or_default()
}

/// Whether one record of an atom is preferred to another: chosen letter before no letter before another
/// letter, then the higher occupancy; of equals the first in the file stays.
fn rank(atom: &Atom, letter: Option<char>, rival: &Atom) -> Ordering {
    preference(atom, letter)
        .cmp(&preference(rival, letter))
        .then(atom.occupancy.total_cmp(&rival.occupancy))
}

fn preference(atom: &Atom, letter: Option<char>) -> u8 {
    match atom.alternate {
        alternate if alternate == letter => 2,
        None => 1,
        Some(_) => 0,
    }
}

fn chosen_letter(atoms: &[&Atom], wanted: Option<char>) -> Option<char> {
    /// Means that differ by less are equal: occupancies have two digits.
    const TIE: f64 = 1e-6;
    // Sum and number of the occupancies of each letter.
    let mut occupancies: BTreeMap<char, (f64, f64)> = BTreeMap::new();
    for atom in atoms {
        if let Some(letter) = atom.alternate {
            let (sum, count) = occupancies.entry(letter).or_default();
            *sum += atom.occupancy;
            *count += 1.0;
        }
    }
    if wanted.is_some_and(|letter| occupancies.contains_key(&letter)) {
        return wanted;
    }
    let mut best = None;
    let mut highest = f64::NEG_INFINITY;
    for (letter, (sum, count)) in occupancies {
        let mean = sum / count;
        if best.is_none() || mean > highest + TIE {
            (best, highest) = (Some(letter), mean);
        }
    }
    best
}
