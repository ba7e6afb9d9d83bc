//! Disulfide bonds: from the records of the file first, by distance second.
//!
//! A cysteine that the file records as bonded has no thiol, however long the bond is in the model:
//! recorded bonds of 2.6 to 2.8 Å occur at low resolution (2FZZ has eight). The same applies if the
//! partner is not selected, because it is in another chain or in a symmetry copy of the deposited
//! coordinates: the cysteine keeps the state that it has in the file.
//!
//! Cysteines without a record are bonded if their sulfurs lie within 2.5 Å of each other.

use super::classes::ResidueClass;
use super::contents::RecordedDisulfide;
use super::report::{Disulfide, DisulfideEvidence};
use super::residue_key::ResidueKey;
use super::selected::SelectedResidue;
use crate::chemistry::AminoAcid;
use protomer_kernel::Vec3;
use std::collections::HashMap;

/// Sulfurs at this distance or less are bonded without a record; the bond is 2.05 Å long.
pub(crate) const BOND_ANGSTROM: f64 = 2.5;

/// An assembly copies recorded partners; a copy at this distance or less is the bonded one.
const LONGEST_RECORDED_ANGSTROM: f64 = 3.5;

/// Marks the cysteines in disulfide bonds and lists the bonds in the order of their residues.
pub(crate) fn mark_disulfides(
    residues: &mut [SelectedResidue],
    records: &[RecordedDisulfide],
) -> Vec<Disulfide> {
    let cysteines = Cysteines::from_residues(residues);
    let mut bonds = Bonds {
        is_bonded: vec![false; cysteines.list.len()],
        list: Vec::new(),
    };
    for record in records {
        cysteines.add_recorded(record, &mut bonds);
    }
    cysteines.add_close_pairs(&mut bonds);
    bonds.list.sort_by_key(|bond| bond.cysteine);
    for (cysteine, is_bonded) in cysteines.list.iter().zip(&bonds.is_bonded) {
        residues[cysteine.residue].in_disulfide = *is_bonded;
    }
    let mut disulfides = Vec::with_capacity(bonds.list.len());
    for bond in bonds.list {
        let key = |cysteine: usize| residues[cysteines.list[cysteine].residue].key.clone();
        disulfides.push(Disulfide {
            residue: key(bond.cysteine),
            partner: bond.partner.map_or(bond.recorded_partner, key),
            evidence: bond.evidence,
            distance_angstrom: bond.distance_angstrom,
            partner_is_selected: bond.partner.is_some(),
        });
    }
    disulfides
}

/// A selected cysteine.
struct Cysteine {
    /// Index of its residue.
    residue: usize,
    key: ResidueKey,
    /// Key of the residue in the file.
    source: ResidueKey,
    sulfur: Option<Vec3>,
}

/// A bond of a cysteine, each by its index in [`Cysteines`].
struct Bond {
    cysteine: usize,
    /// Partner of the cysteine; `None` if it is not selected.
    partner: Option<usize>,
    recorded_partner: ResidueKey,
    evidence: DisulfideEvidence,
    distance_angstrom: Option<f64>,
}

struct Bonds {
    is_bonded: Vec<bool>,
    list: Vec<Bond>,
}

impl Bonds {
    fn add(&mut self, bond: Bond) {
        self.is_bonded[bond.cysteine] = true;
        if let Some(partner) = bond.partner {
            self.is_bonded[partner] = true;
        }
        self.list.push(bond);
    }
}

/// The selected cysteines, by their keys and by the cells of their sulfurs.
struct Cysteines {
    list: Vec<Cysteine>,
    by_source: HashMap<ResidueKey, Vec<usize>>,
    cells: HashMap<[i64; 3], Vec<usize>>,
}

impl Cysteines {
    /// Largest number of sulfurs of a cell that are compared, which bounds the time for files with
    /// many sulfurs in one place.
    const MOST_PER_CELL: usize = 32;

    fn from_residues(residues: &[SelectedResidue]) -> Self {
        let mut cysteines = Self {
            list: Vec::new(),
            by_source: HashMap::new(),
            cells: HashMap::new(),
        };
        for (index, residue) in residues.iter().enumerate() {
            if is_cysteine(residue) {
                cysteines.add(index, residue);
            }
        }
        cysteines
    }

    fn add(&mut self, residue_index: usize, residue: &SelectedResidue) {
        let number = self.list.len();
        let source = residue.source_key();
        let sulfur = residue.atom("SG").map(|atom| atom.position);
        self.by_source
            .entry(source.clone())
            .or_default()
            .push(number);
        if let Some(position) = sulfur {
            self.cells
                .entry(cell_of(&position))
                .or_default()
                .push(number);
        }
        self.list.push(Cysteine {
            residue: residue_index,
            key: residue.key.clone(),
            source,
            sulfur,
        });
    }

    /// Adds the bonds of a record: one for each copy of the two cysteines in an assembly.
    fn add_recorded(&self, record: &RecordedDisulfide, bonds: &mut Bonds) {
        let [first, second] = &record.residues;
        for (residue, recorded_partner) in [(first, second), (second, first)] {
            let copies = self.by_source.get(residue).map_or(&[][..], Vec::as_slice);
            for &cysteine in copies {
                if bonds.is_bonded[cysteine] {
                    continue;
                }
                let partner = self.recorded_partner(cysteine, recorded_partner, record, bonds);
                let distance_angstrom =
                    partner.and_then(|partner| self.distance_angstrom(cysteine, partner));
                let is_close = distance_angstrom.is_some_and(|distance| distance <= BOND_ANGSTROM);
                bonds.add(Bond {
                    cysteine,
                    partner,
                    recorded_partner: recorded_partner.clone(),
                    evidence: if is_close {
                        DisulfideEvidence::RecordAndDistance
                    } else {
                        DisulfideEvidence::Record
                    },
                    distance_angstrom,
                });
            }
        }
    }

    /// The nearby copy of the recorded partner. If there is none, and the record is not between
    /// symmetry copies, the partner in the same copy of the chains at any distance.
    fn recorded_partner(
        &self,
        cysteine: usize,
        partner: &ResidueKey,
        record: &RecordedDisulfide,
        bonds: &Bonds,
    ) -> Option<usize> {
        let is_partner =
            |other: usize| self.list[other].source == *partner && !bonds.is_bonded[other];
        let close = self.nearest(cysteine, LONGEST_RECORDED_ANGSTROM, is_partner);
        if close.is_some() || record.is_between_symmetry_copies() {
            return close;
        }
        let Cysteine { key, source, .. } = &self.list[cysteine];
        let copy = key.chain.strip_prefix(&*source.chain).unwrap_or("");
        let partner_chain = format!("{}{copy}", partner.chain);
        let candidates = self.by_source.get(partner)?;
        candidates.iter().copied().find(|&other| {
            other != cysteine
                && *self.list[other].key.chain == *partner_chain
                && !bonds.is_bonded[other]
        })
    }

    /// Adds bonds between cysteines without a record whose sulfurs are close.
    fn add_close_pairs(&self, bonds: &mut Bonds) {
        for cysteine in 0..self.list.len() {
            if bonds.is_bonded[cysteine] {
                continue;
            }
            let is_free = |other: usize| !bonds.is_bonded[other];
            let Some(partner) = self.nearest(cysteine, BOND_ANGSTROM, is_free) else {
                continue;
            };
            bonds.add(Bond {
                cysteine,
                partner: Some(partner),
                recorded_partner: self.list[partner].key.clone(),
                evidence: DisulfideEvidence::Distance,
                distance_angstrom: self.distance_angstrom(cysteine, partner),
            });
        }
    }

    /// The nearest other cysteine within `reach` that `is_wanted`.
    fn nearest(
        &self,
        cysteine: usize,
        reach_angstrom: f64,
        is_wanted: impl Fn(usize) -> bool,
    ) -> Option<usize> {
        let [x, y, z] = cell_of(self.list[cysteine].sulfur.as_ref()?);
        let (mut nearest, mut least) = (None, reach_angstrom);
        for neighbour in 0..27 {
            let cell = [
                x + neighbour / 9 - 1,
                y + neighbour / 3 % 3 - 1,
                z + neighbour % 3 - 1,
            ];
            let members = self.cells.get(&cell).map_or(&[][..], Vec::as_slice);
            for &other in members.iter().take(Self::MOST_PER_CELL) {
                let Some(distance) = self.distance_angstrom(cysteine, other) else {
                    continue;
                };
                if other != cysteine && distance <= least && is_wanted(other) {
                    (nearest, least) = (Some(other), distance);
                }
            }
        }
        nearest
    }

    fn distance_angstrom(&self, first: usize, second: usize) -> Option<f64> {
        let (first, second) = (self.list[first].sulfur?, self.list[second].sulfur?);
        Some((first - second).norm())
    }
}

/// Whether the residue has the thiol of a cysteine: a modified one has it only if its titratable
/// group is that of cysteine.
fn is_cysteine(residue: &SelectedResidue) -> bool {
    match residue.class {
        ResidueClass::AminoAcid(amino_acid) | ResidueClass::LikeAminoAcid(amino_acid) => {
            amino_acid == AminoAcid::Cys
        }
        ResidueClass::Modified(modified) => {
            modified.parent == Some(AminoAcid::Cys) && modified.groups.is_none()
        }
        _ => false,
    }
}

/// The cell of a position. Cells are as wide as the longest distance searched.
fn cell_of(position: &Vec3) -> [i64; 3] {
    [position.x, position.y, position.z].map(|x| (x / LONGEST_RECORDED_ANGSTROM).floor() as i64)
}
