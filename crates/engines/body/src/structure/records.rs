//! Which records of a model are atoms.
//!
//! Some records stand for something else: pseudoatoms of NMR and united methyl groups, lone pairs and
//! virtual sites of force fields, atoms that were never placed, and the same atom a second time. They
//! are left out and counted, each with its reason.

use super::contents::Atom;
use super::report::{SelectionReport, reason};
use crate::chemistry::residue_names;
use protomer_kernel::Vec3;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// The records of a model that are atoms.
pub(crate) struct Sifted<'a> {
    pub(crate) atoms: Vec<&'a Atom>,
    /// Whether two different atoms have the same position.
    pub(crate) has_coincidences: bool,
}

/// A position that can be compared for equality.
pub(crate) type ExactPosition = [u64; 3];

/// The position by its bits; both zeros are one.
pub(crate) fn exact(position: &Vec3) -> ExactPosition {
    [position.x, position.y, position.z].map(|x| (x + 0.0).to_bits())
}

/// Sorts out the records that are not atoms.
pub(crate) fn sift<'a>(atoms: &'a [Atom], report: &mut SelectionReport) -> Sifted<'a> {
    let origin_is_no_place = share_the_origin(atoms);
    let mut first_at: HashMap<ExactPosition, &Atom> = HashMap::with_capacity(atoms.len());
    let mut sifted = Sifted {
        atoms: Vec::with_capacity(atoms.len()),
        has_coincidences: false,
    };
    for atom in atoms {
        let is_unbuilt = is_placeholder(&atom.position)
            || (origin_is_no_place && atom.position == Vec3::zeros());
        if is_unbuilt {
            report.leave_out(reason::UNBUILT, atom);
            continue;
        }
        if is_dummy(atom) {
            report.leave_out(reason::PSEUDOATOM, atom);
            continue;
        }
        match first_at.entry(exact(&atom.position)) {
            Entry::Vacant(entry) => {
                entry.insert(atom);
            }
            Entry::Occupied(entry) if is_same(entry.get(), atom) => {
                report.leave_out(reason::REPEATED, atom);
                continue;
            }
            Entry::Occupied(_) => sifted.has_coincidences = true,
        }
        sifted.atoms.push(atom);
    }
    sifted
}

/// Whether several atoms are exactly at the origin: programs put there what they could not place.
fn share_the_origin(atoms: &[Atom]) -> bool {
    let mut at_origin = atoms.iter().filter(|atom| atom.position == Vec3::zeros());
    let Some(first) = at_origin.next() else {
        return false;
    };
    at_origin.any(|atom| !is_same(first, atom) && atom.alternate == first.alternate)
}

/// Whether the coordinates are the nines that CNS and X-PLOR write for atoms without a position:
/// 9999.000 9999.000 9999.000.
pub(crate) fn is_placeholder(position: &Vec3) -> bool {
    const PLACEHOLDERS_ANGSTROM: [f64; 5] = [999.9, 999.99, 999.999, 9999.0, 9999.99];
    let coordinate = position.x.abs();
    let are_equal = position.iter().all(|x| x.abs() == coordinate);
    are_equal && PLACEHOLDERS_ANGSTROM.contains(&coordinate)
}

/// Whether the record stands for no atom: a pseudoatom (QB, MG1) or a lone pair (LP1, EP) of an amino
/// acid or a nucleotide, or anything of a water but its oxygen and hydrogens (MW, EPW, IW, OM).
fn is_dummy(atom: &Atom) -> bool {
    let name = atom.name.trim_start_matches(|c: char| c.is_ascii_digit());
    if residue_names::is_water(&atom.residue_name) {
        let is_of_water = matches!(&*atom.element, "O" | "H" | "D");
        return !is_of_water || name == "OM";
    }
    let starts = |letters: &[&str]| letters.iter().any(|letters| name.starts_with(letters));
    let is_unknown = &*atom.element == "X";
    is_unknown && residue_names::is_polymer(&atom.residue_name) && starts(&["Q", "M", "LP", "EP"])
}

/// Whether two records at the same position are the same atom.
fn is_same(first: &Atom, second: &Atom) -> bool {
    first.name == second.name
        && first.residue_number == second.residue_number
        && first.alternate == second.alternate
        && first.residue_name == second.residue_name
        && first.chain == second.chain
        && first.insertion_code == second.insertion_code
        && first.position == second.position
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_nines_in_all_three_coordinates_are_a_placeholder() {
        assert!(is_placeholder(&Vec3::repeat(9999.0)));
        assert!(is_placeholder(&Vec3::new(-9999.0, 9999.0, -9999.0)));
        assert!(is_placeholder(&Vec3::repeat(999.999)));
        assert!(!is_placeholder(&Vec3::new(9999.0, 9999.0, 12.0)));
        assert!(!is_placeholder(&Vec3::repeat(99.0)));
    }
}
