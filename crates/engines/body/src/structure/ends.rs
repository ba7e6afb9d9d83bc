//! Which residues carry a free amine or carboxylate.
//!
//! The first and the last protein residue of each strand do ([`super::strands`]), and so does every
//! residue with an OXT,
//! unless
//!
//! * the file lists unobserved residues beyond them;
//! * the two are bonded to each other, which makes the chain a ring;
//! * the residue is a cap, or its nitrogen is acylated (pyroglutamate, N-formylmethionine);
//! * the nitrogen or the carbonyl carbon is bonded to another residue, whether that residue is
//!   selected or not. For example, a peptide has no amine if it begins with an acyl group that the
//!   file lists as a ligand;
//! * the residue is in no table and has no OXT: its last carbon may be that of an alcohol.

use super::classes::ResidueClass;
use super::completeness::peptide_distance;
use super::contents::{Atom, UnobservedResidue};
use super::corrections::describe;
use super::report::ListedResidue;
use super::residues::is_of;
use super::selected::SelectedResidue;
use crate::chemistry::residue_names::{has_blocked_amine, is_water};
use protomer_kernel::Vec3;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// Atoms other than metals that are closer than this are bonded: the longest such bond of a
/// nitrogen or a carbonyl carbon is C-S, 1.8 Å.
const BONDED_ANGSTROM: f64 = 1.9;

/// Elements that make covalent bonds with the nitrogen or carbon of a chain's end.
const COVALENT: [&str; 8] = ["B", "C", "N", "O", "P", "S", "SE", "SI"];

/// Marks the residues that carry a free amine or carboxylate, and lists the ends that are bonded to
/// another residue. `atoms` are all atoms of the model, selected or not.
pub(crate) fn mark_chain_ends(
    residues: &mut [SelectedResidue],
    unobserved: &[UnobservedResidue],
    atoms: &[&Atom],
) -> Vec<ListedResidue> {
    let hidden = HiddenEnds::from_unobserved(unobserved);
    for chain in protein_chains(residues) {
        mark_first_and_last(residues, &chain, &hidden);
        mark_oxt(residues, &chain);
    }
    let partners = bonded_partners(residues, atoms);
    let mut blocked = Vec::new();
    for (end, partner) in partners {
        let residue = &mut residues[end.residue];
        let (group, atom) = if end.is_amine {
            residue.n_terminus = false;
            ("amine", "N")
        } else {
            residue.c_terminus = false;
            ("carboxylate", "C")
        };
        blocked.push(ListedResidue {
            residue: residue.key.clone(),
            name: residue.name.clone(),
            note: format!("no free {group}: {atom} is bonded to {partner}"),
            charge_e: None,
        });
    }
    blocked
}

/// Indices of the protein residues of each strand, in their order.
fn protein_chains(residues: &[SelectedResidue]) -> Vec<Vec<usize>> {
    let mut chains: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (index, residue) in residues.iter().enumerate() {
        if let (Some(strand), true) = (residue.strand, residue.class.is_protein()) {
            chains.entry(strand).or_default().push(index);
        }
    }
    chains.into_values().collect()
}

fn mark_first_and_last(residues: &mut [SelectedResidue], chain: &[usize], hidden: &HiddenEnds) {
    let (Some(&first), Some(&last)) = (chain.first(), chain.last()) else {
        return;
    };
    if first != last && are_bonded(&residues[last], &residues[first]) {
        return;
    }
    let (begin, end) = (&residues[first], &residues[last]);
    let has_amine = !hidden.before(begin) && may_be_amine(begin);
    let has_carboxylate = !hidden.after(end) && may_be_carboxylate(end);
    residues[first].n_terminus = has_amine;
    residues[last].c_terminus = has_carboxylate;
}

fn are_bonded(before: &SelectedResidue, after: &SelectedResidue) -> bool {
    const BOND_ANGSTROM: f64 = 2.0;
    peptide_distance(before, after).is_some_and(|distance| distance < BOND_ANGSTROM)
}

/// A residue with an OXT ends a chain, and the next one begins another.
fn mark_oxt(residues: &mut [SelectedResidue], chain: &[usize]) {
    for (position, &index) in chain.iter().enumerate() {
        if residues[index].atom("OXT").is_none() || !may_be_carboxylate(&residues[index]) {
            continue;
        }
        residues[index].c_terminus = true;
        if let Some(&next) = chain.get(position + 1) {
            residues[next].n_terminus = may_be_amine(&residues[next]);
        }
    }
}

fn may_be_amine(residue: &SelectedResidue) -> bool {
    residue.class != ResidueClass::Cap
        && residue.atom("N").is_some()
        && !has_blocked_amine(&residue.name)
        && !is_acylated(residue)
}

fn may_be_carboxylate(residue: &SelectedResidue) -> bool {
    let is_in_table = matches!(
        residue.class,
        ResidueClass::AminoAcid(_) | ResidueClass::Modified(_)
    );
    residue.class != ResidueClass::Cap
        && residue.atom("C").is_some()
        && (is_in_table || residue.atom("OXT").is_some())
}

/// Whether the nitrogen is bonded to a carbon of its own residue that carries an oxygen, CA apart:
/// an amide is no base.
fn is_acylated(residue: &SelectedResidue) -> bool {
    const BOND_ANGSTROM: f64 = 1.7;
    const CARBONYL_ANGSTROM: f64 = 1.35;
    let Some(nitrogen) = residue.atom("N") else {
        return false;
    };
    let has_oxygen = |carbon: &Atom| {
        residue
            .atoms
            .iter()
            .any(|atom| &*atom.element == "O" && distance(atom, carbon) < CARBONYL_ANGSTROM)
    };
    residue.atoms.iter().any(|atom| {
        let is_other_carbon = &*atom.element == "C" && &*atom.name != "CA";
        is_other_carbon && distance(atom, nitrogen) < BOND_ANGSTROM && has_oxygen(atom)
    })
}

fn distance(a: &Atom, b: &Atom) -> f64 {
    (a.position - b.position).norm()
}

/// The smallest and largest number of the unobserved residues of each chain.
struct HiddenEnds {
    range: HashMap<Arc<str>, (i32, i32)>,
}

impl HiddenEnds {
    fn from_unobserved(unobserved: &[UnobservedResidue]) -> Self {
        let mut range: HashMap<Arc<str>, (i32, i32)> = HashMap::new();
        for residue in unobserved {
            let number = residue.key.number;
            let chain = residue.key.chain.clone();
            let (low, high) = range.entry(chain).or_insert((number, number));
            (*low, *high) = ((*low).min(number), (*high).max(number));
        }
        Self { range }
    }

    fn before(&self, residue: &SelectedResidue) -> bool {
        match self.range.get(&residue.source_chain) {
            Some((low, _)) => *low < residue.key.number,
            None => false,
        }
    }

    fn after(&self, residue: &SelectedResidue) -> bool {
        match self.range.get(&residue.source_chain) {
            Some((_, high)) => *high > residue.key.number,
            None => false,
        }
    }
}

/// The nitrogen of a free amine or the carbon of a carboxylate.
#[derive(Clone, Copy)]
struct End {
    residue: usize,
    is_amine: bool,
    position: Vec3,
}

/// The ends bonded to an atom of another residue, each with that atom. A carboxylate with an OXT is
/// free and is not searched.
fn bonded_partners(residues: &[SelectedResidue], atoms: &[&Atom]) -> Vec<(End, String)> {
    let ends = ends(residues);
    let cells = cells_around(&ends);
    let mut partners: Vec<Option<String>> = vec![None; ends.len()];
    for &atom in atoms {
        let Some(near) = cells.get(&cell_of(&atom.position)) else {
            continue;
        };
        if !COVALENT.contains(&&*atom.element) || is_water(&atom.residue_name) {
            continue;
        }
        for &index in near {
            let end = &ends[index];
            let residue = &residues[end.residue];
            let is_own = is_of(atom, &residue.source_key()) || has_place(residue, atom);
            let is_bonded = (atom.position - end.position).norm() < BONDED_ANGSTROM;
            if !is_own && is_bonded && partners[index].is_none() {
                partners[index] = Some(describe(atom));
            }
        }
    }
    let mut bonded = Vec::new();
    for (end, partner) in ends.into_iter().zip(partners) {
        if let Some(partner) = partner {
            bonded.push((end, partner));
        }
    }
    bonded
}

/// Whether one of the residue's atoms is exactly where the atom is.
fn has_place(residue: &SelectedResidue, atom: &Atom) -> bool {
    residue
        .atoms
        .iter()
        .any(|member| member.position == atom.position)
}

fn ends(residues: &[SelectedResidue]) -> Vec<End> {
    let mut ends = Vec::new();
    for (index, residue) in residues.iter().enumerate() {
        let mut add = |is_amine: bool, name: &str| {
            if let Some(atom) = residue.atom(name) {
                ends.push(End {
                    residue: index,
                    is_amine,
                    position: atom.position,
                });
            }
        };
        if residue.n_terminus {
            add(true, "N");
        }
        if residue.c_terminus && residue.atom("OXT").is_none() {
            add(false, "C");
        }
    }
    ends
}

/// Ends by the cells that can contain an atom bonded to them.
fn cells_around(ends: &[End]) -> HashMap<[i64; 3], Vec<usize>> {
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    for (index, end) in ends.iter().enumerate() {
        let [x, y, z] = cell_of(&end.position);
        for neighbour in 0..27 {
            let cell = [
                x + neighbour / 9 - 1,
                y + neighbour / 3 % 3 - 1,
                z + neighbour % 3 - 1,
            ];
            cells.entry(cell).or_default().push(index);
        }
    }
    cells
}

fn cell_of(position: &Vec3) -> [i64; 3] {
    [position.x, position.y, position.z].map(|x| (x / BONDED_ANGSTROM).floor() as i64)
}
