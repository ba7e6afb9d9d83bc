//! One conformer per residue.
//!
//! The letter with the highest mean occupancy holds for the whole residue (ties: the first letter),
//! or a letter the user states where the residue has it. Atoms without a letter belong to every
//! conformer. An atom that the chosen conformer lacks is taken from the conformer that has it with
//! the highest occupancy, so that no atom is lost. With the letter goes the residue name, where a
//! crystal holds two residues in one place (microheterogeneity).

use super::Atom;
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

/// Chooses the conformer; `atoms` belong to one residue and are not empty.
pub(crate) fn choose<'a>(atoms: &[&'a Atom], wanted: Option<char>) -> Conformer<'a> {
    let letter = chosen_letter(atoms, wanted);
    let of_letter = atoms
        .iter()
        .find(|atom| letter.is_some() && atom.alternate == letter);
    let name = of_letter
        .or(atoms.first())
        .map_or_else(|| Arc::from(""), |atom| atom.residue_name.clone());
    let mut conformer = Conformer {
        name,
        atoms: Vec::new(),
        alternates: 0,
        duplicates: 0,
        other_names: BTreeSet::new(),
    };
    let mut chosen: HashMap<&str, usize> = HashMap::with_capacity(atoms.len());
    for atom in atoms {
        if atom.residue_name != conformer.name {
            conformer.other_names.insert(atom.residue_name.clone());
            conformer.alternates += 1;
            continue;
        }
        match chosen.get(&*atom.name) {
            None => {
                chosen.insert(&atom.name, conformer.atoms.len());
                conformer.atoms.push(atom);
            }
            Some(&index) => {
                let rival = conformer.atoms[index];
                let is_repeat = rival.alternate == atom.alternate;
                *(if is_repeat {
                    &mut conformer.duplicates
                } else {
                    &mut conformer.alternates
                }) += 1;
                if rank(atom, letter, rival) == Ordering::Greater {
                    conformer.atoms[index] = atom;
                }
            }
        }
    }
    conformer
}

/// Which of two records of one atom is better: chosen letter before no letter before another
/// letter, then occupancy, then the first in the file.
fn rank(atom: &Atom, letter: Option<char>, rival: &Atom) -> Ordering {
    let preference = |atom: &Atom| match atom.alternate {
        alternate if alternate == letter => 2,
        None => 1,
        Some(_) => 0,
    };
    preference(atom)
        .cmp(&preference(rival))
        .then(atom.occupancy.total_cmp(&rival.occupancy))
}

fn chosen_letter(atoms: &[&Atom], wanted: Option<char>) -> Option<char> {
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
    /// Means that differ by less are equal: occupancies have two digits.
    const TIE: f64 = 1e-6;
    let mut best: Option<(char, f64)> = None;
    for (letter, (sum, count)) in occupancies {
        let mean = sum / count;
        if best.is_none_or(|(_, highest)| mean > highest + TIE) {
            best = Some((letter, mean));
        }
    }
    best.map(|(letter, _)| letter)
}
