//! Atoms grouped into residues.
//!
//! A residue is what has one chain, segment, number and insertion code, with four exceptions:
//!
//! * After TER, and outside polymers, numbers begin again: an ion, a water or a ligand never shares a
//!   group with a polymer's residue of the same number.
//! * Names that differ are different residues, unless letters of alternate locations show two
//!   residues in one place. A fragment of an amino acid under a second name is not another residue:
//!   CHARMM patches name the side chain alone (GLU and GLUP, CYS and DISU), and the two have one N,
//!   CA, C, O together.
//! * Where the atom with which the residue began comes again, another residue begins: several ions,
//!   waters or ligands of one number, files that number nothing, and numbers that start again after
//!   9999. With occupancies that add up to one, it is an alternate location without a letter.
//! * The atoms of a residue need not be contiguous: some files list conformers one after the other.

use super::contents::Atom;
use super::element;
use super::names::Names;
use super::residue_key::ResidueKey;
use crate::chemistry::amino_acid::{AminoAcid, BACKBONE};
use crate::chemistry::residue_names::{self, parent_amino_acid};
use protomer_kernel::{PointRecord, Vec3};
use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap, HashSet};
use std::sync::Arc;

/// The atom records of one residue.
#[derive(Clone)]
pub(crate) struct AtomGroup<'a> {
    pub(crate) key: ResidueKey,
    pub(crate) atoms: Vec<&'a Atom>,
    /// Further names under which the file gives a part of the residue's atoms.
    pub(crate) fragments: BTreeSet<Arc<str>>,
}

impl AtomGroup<'_> {
    /// Position of the first atom with one of two names.
    pub(crate) fn position(&self, names: [&str; 2]) -> Option<Vec3> {
        for atom in &self.atoms {
            if names.contains(&&*atom.name) {
                return Some(atom.position);
            }
        }
        None
    }

    /// Whether all atoms of the residue are outside any polymer according to the file.
    pub(crate) fn is_outside(&self) -> bool {
        self.atoms.iter().all(|atom| atom.outside_polymer)
    }

    pub(crate) fn is_hetero(&self) -> bool {
        self.atoms.iter().all(|atom| atom.hetero)
    }
}

/// The name of an atom by which it is the same as another: a deuterium takes the place of the
/// hydrogen of its name.
pub(crate) fn place_name(atom: &Atom) -> Cow<'_, str> {
    match atom.name.strip_prefix('D') {
        Some(suffix) if &*atom.element == "D" => Cow::Owned(format!("H{suffix}")),
        _ => Cow::Borrowed(&atom.name),
    }
}

/// Properties that the residues of one place in a file have in common.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Place {
    key: ResidueKey,
    segment: Arc<str>,
    label_chain: Arc<str>,
    is_outside: bool,
}

impl Place {
    fn from_atom(atom: &Atom) -> Self {
        Self {
            key: ResidueKey {
                chain: atom.chain.clone(),
                number: atom.residue_number,
                insertion_code: atom.insertion_code.clone(),
            },
            segment: atom.segment.clone(),
            label_chain: atom.label_chain.clone(),
            is_outside: atom.outside_polymer || residue_names::is_water(&atom.residue_name),
        }
    }

    fn has(&self, atom: &Atom) -> bool {
        is_of(atom, &self.key)
            && self.segment == atom.segment
            && self.label_chain == atom.label_chain
            && self.is_outside
                == (atom.outside_polymer || residue_names::is_water(&atom.residue_name))
    }
}

/// Whether an atom belongs to the residue of this key.
pub(crate) fn is_of(atom: &Atom, key: &ResidueKey) -> bool {
    key.number == atom.residue_number
        && key.chain == atom.chain
        && key.insertion_code == atom.insertion_code
}

/// Groups atoms by residue, in order of first appearance.
pub(crate) fn group<'a>(atoms: &[&'a Atom]) -> Vec<AtomGroup<'a>> {
    let mut grouping = Grouping {
        groups: Vec::new(),
        latest: HashMap::new(),
        named: HashMap::new(),
        members: HashSet::with_capacity(atoms.len()),
    };
    let mut last: Option<(usize, Place)> = None;
    for &atom in atoms {
        last = Some(match last {
            Some((index, place)) if place.has(atom) => {
                let joined = grouping.belongs(atom, index).then_some(index);
                (grouping.add(atom, &place, joined), place)
            }
            _ => {
                let place = Place::from_atom(atom);
                let latest = grouping.latest.get(&place).copied();
                // Where a residue is interrupted, only what it lacks continues it.
                let joined = latest
                    .filter(|&index| grouping.belongs(atom, index) && !grouping.has(atom, index));
                (grouping.add(atom, &place, joined), place)
            }
        });
    }
    grouping.groups
}

/// Indices of the points of each residue, by the same rules as the atoms of a structure. Points without
/// the name of a residue are in none.
pub(crate) fn residues_of_points(points: &[PointRecord]) -> Vec<Vec<usize>> {
    let mut names = Names::default();
    let mut atoms = Vec::with_capacity(points.len());
    for (index, point) in points.iter().enumerate() {
        if !point.residue_name.is_empty() {
            atoms.push(atom_of_point(index, point, &mut names));
        }
    }
    let groups = group(&atoms.iter().collect::<Vec<_>>());
    let index_of = |atom: &&Atom| usize::try_from(atom.serial).ok();
    let indices = |group: AtomGroup| group.atoms.iter().filter_map(index_of).collect();
    groups.into_iter().map(indices).collect()
}

/// A point as an atom whose serial number is the index of the point.
fn atom_of_point(index: usize, point: &PointRecord, names: &mut Names) -> Atom {
    let chain = names.share(&point.chain);
    Atom {
        serial: i64::try_from(index).unwrap_or(i64::MAX),
        name: names.share(&point.atom_name),
        alternate: None,
        residue_name: names.share(&point.residue_name),
        label_chain: chain.clone(),
        chain,
        segment: names.share(""),
        polymer: 0,
        residue_number: point.residue_number,
        insertion_code: names.share(&point.insertion_code),
        element: names.share(element::from_name(&point.atom_name)),
        occupancy: 1.0,
        b_factor_angstrom2: 0.0,
        formal_charge_e: None,
        position: point.position,
        hetero: false,
        outside_polymer: false,
    }
}

/// The residues found so far.
struct Grouping<'a> {
    groups: Vec<AtomGroup<'a>>,
    /// The last residue of each place.
    latest: HashMap<Place, usize>,
    /// The last residue of each place and name.
    named: HashMap<(Place, Arc<str>), usize>,
    /// The atoms of each residue: name, alternate location.
    members: HashSet<(usize, Cow<'a, str>, Option<char>)>,
}

impl<'a> Grouping<'a> {
    /// Adds an atom to a residue, to an earlier one of its place and name that lacks it, or to a new
    /// one.
    fn add(&mut self, atom: &'a Atom, place: &Place, joined: Option<usize>) -> usize {
        let index = joined
            .or_else(|| self.earlier(atom, place))
            .unwrap_or_else(|| self.begin(atom, place));
        let group = &mut self.groups[index];
        let name = &atom.residue_name;
        let has_other_name = group
            .atoms
            .first()
            .is_some_and(|first| first.residue_name != *name);
        if has_other_name && atom.alternate.is_none() {
            group.fragments.insert(name.clone());
        }
        group.atoms.push(atom);
        self.members
            .insert((index, place_name(atom), atom.alternate));
        index
    }

    /// An earlier residue of the place and name of the atom, which lacks the atom.
    fn earlier(&self, atom: &Atom, place: &Place) -> Option<usize> {
        let named = (place.clone(), atom.residue_name.clone());
        let earlier = self.named.get(&named).copied();
        earlier.filter(|&index| !self.begins_again(atom, index) && !self.has(atom, index))
    }

    fn begin(&mut self, atom: &'a Atom, place: &Place) -> usize {
        let index = self.groups.len();
        self.groups.push(AtomGroup {
            key: place.key.clone(),
            atoms: Vec::new(),
            fragments: BTreeSet::new(),
        });
        self.latest.insert(place.clone(), index);
        let named = (place.clone(), atom.residue_name.clone());
        self.named.insert(named, index);
        index
    }

    /// Whether an atom belongs to the last residue of its place.
    fn belongs(&self, atom: &Atom, index: usize) -> bool {
        let group = &self.groups[index];
        let Some(first) = group.atoms.first() else {
            return true;
        };
        let has_name = |other: &&Atom| other.residue_name == atom.residue_name;
        if first.residue_name == atom.residue_name || group.atoms.last().is_some_and(has_name) {
            return !self.begins_again(atom, index);
        }
        let is_alternate =
            atom.alternate.is_some() && group.atoms.iter().any(|other| other.alternate.is_some());
        is_alternate || self.is_fragment(atom, index)
    }

    /// Whether the atom shows that another residue of the same place begins: the one with which the
    /// residue began comes again, or a TER lies between them.
    fn begins_again(&self, atom: &Atom, index: usize) -> bool {
        let group = &self.groups[index];
        let Some(first) = group.atoms.first() else {
            return false;
        };
        let is_conformer = atom.alternate.is_some() && !self.has(atom, index);
        if first.polymer != atom.polymer && !atom.outside_polymer && !is_conformer {
            return true;
        }
        let is_first = place_name(first) == place_name(atom) && first.alternate == atom.alternate;
        // A residue of a polymer has more than the atom that comes again at once.
        let is_whole = group.atoms.len() > 1 || !residue_names::is_polymer(&atom.residue_name);
        is_first && is_whole && !share_occupancy(first, atom)
    }

    /// Whether a residue has an atom of this name and alternate location.
    fn has(&self, atom: &Atom, index: usize) -> bool {
        let name: Cow<'a, str> = Cow::Owned(place_name(atom).into_owned());
        self.members.contains(&(index, name, atom.alternate))
    }

    /// Whether the atom is one that the amino acid of the residue still lacks, under a second name
    /// for the same residue.
    fn is_fragment(&self, atom: &Atom, index: usize) -> bool {
        let Some(first) = self.groups[index].atoms.first() else {
            return false;
        };
        let parents = [&first.residue_name, &atom.residue_name].map(|name| parent_amino_acid(name));
        let (amino_acid, is_one) = match parents {
            [Some(one), Some(other)] => (one, one == other),
            [Some(one), None] | [None, Some(one)] => (one, true),
            [None, None] => return false,
        };
        is_one && is_atom_of(amino_acid, atom) && !self.has(atom, index)
    }
}

/// Whether the occupancies of two records of an atom add up to one: alternate locations.
fn share_occupancy(first: &Atom, second: &Atom) -> bool {
    /// Occupancies have two digits.
    const ONE: f64 = 1.01;
    first.occupancy > 0.0 && second.occupancy > 0.0 && first.occupancy + second.occupancy <= ONE
}

fn is_atom_of(amino_acid: AminoAcid, atom: &Atom) -> bool {
    let name = &*atom.name;
    BACKBONE.contains(&name)
        || amino_acid.side_chain().contains(&name)
        || ["OXT", "OT1", "OT2"].contains(&name)
        || atom.is_hydrogen()
}
