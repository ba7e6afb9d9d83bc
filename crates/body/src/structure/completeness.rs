//! Missing atoms, chain breaks, real chain ends, disulfides.

use super::selection::SelectedResidue;
use super::{ResidueClass, ResidueKey, UnobservedResidue};
use crate::chemistry::AminoAcid;
use crate::chemistry::amino_acid::BACKBONE;
use crate::chemistry::residue_names::has_blocked_amine;
use protomer_kernel::Vec3;
use serde::Serialize;
use std::collections::HashMap;
use std::sync::Arc;

/// A residue without some of its heavy atoms.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct IncompleteResidue {
    /// Which residue.
    pub residue: ResidueKey,
    /// Its name.
    pub name: Arc<str>,
    /// Names of the atoms it lacks.
    pub missing_atoms: Vec<&'static str>,
}

/// Two residues that follow each other in the file but are not bonded.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChainBreak {
    /// The residue before the break.
    pub before: ResidueKey,
    /// The residue after it.
    pub after: ResidueKey,
    /// Distance from C to N, Å; `None` if one of them is missing.
    pub distance_angstrom: Option<f64>,
    /// Residue numbers left out between the two.
    pub missing_numbers: i32,
}

/// A peptide bond is 1.33 Å; beyond this distance there is none.
const BROKEN_ANGSTROM: f64 = 2.5;

/// Heavy atoms that the residue should have and lacks. Of a modified residue only the backbone is
/// known; of a chromophore nothing.
pub(crate) fn missing_atoms(residue: &SelectedResidue) -> Vec<&'static str> {
    let side_chain = match residue.class {
        ResidueClass::AminoAcid(amino_acid) => amino_acid.side_chain(),
        ResidueClass::Modified(modified) if modified.parent.is_some() => &[],
        ResidueClass::UnknownAminoAcid => &[],
        _ => return Vec::new(),
    };
    let expected = BACKBONE.iter().chain(side_chain).copied();
    expected
        .filter(|name| residue.atom(name).is_none())
        .collect()
}

/// Breaks between consecutive protein residues of a chain.
pub(crate) fn chain_breaks(residues: &[SelectedResidue]) -> Vec<ChainBreak> {
    consecutive(residues)
        .filter_map(|(before, after)| chain_break(before, after))
        .collect()
}

fn consecutive(
    residues: &[SelectedResidue],
) -> impl Iterator<Item = (&SelectedResidue, &SelectedResidue)> {
    let protein = || residues.iter().filter(|residue| residue.class.is_protein());
    protein()
        .zip(protein().skip(1))
        .filter(|(before, after)| before.key.chain == after.key.chain)
}

fn chain_break(before: &SelectedResidue, after: &SelectedResidue) -> Option<ChainBreak> {
    let distance_angstrom = peptide_distance(before, after);
    let missing_numbers = after
        .key
        .number
        .saturating_sub(before.key.number)
        .saturating_sub(1)
        .max(0);
    let is_broken =
        distance_angstrom.map_or(missing_numbers > 0, |distance| distance > BROKEN_ANGSTROM);
    is_broken.then(|| ChainBreak {
        before: before.key.clone(),
        after: after.key.clone(),
        distance_angstrom,
        missing_numbers,
    })
}

/// Distance from the carbonyl carbon to the next nitrogen, Å. Chromophores call them C3 and N1.
fn peptide_distance(before: &SelectedResidue, after: &SelectedResidue) -> Option<f64> {
    let carbon = before.atom("C").or_else(|| before.atom("C3"))?;
    let nitrogen = after.atom("N").or_else(|| after.atom("N1"))?;
    Some((carbon.position - nitrogen.position).norm())
}

/// Marks the residues that carry a free amine or carboxylate: the first and last residue of each
/// chain unless the file lists unobserved residues beyond them or the two are bonded to a ring, and
/// every residue with an OXT.
pub(crate) fn mark_chain_ends(residues: &mut [SelectedResidue], unobserved: &[UnobservedResidue]) {
    let hidden = HiddenEnds::of(unobserved);
    let protein: Vec<usize> = (0..residues.len())
        .filter(|i| residues[*i].class.is_protein())
        .collect();
    let is_one_chain = |a: &usize, b: &usize| residues[*a].key.chain == residues[*b].key.chain;
    let chains: Vec<Vec<usize>> = protein
        .chunk_by(is_one_chain)
        .map(<[usize]>::to_vec)
        .collect();
    for chain in chains {
        let (Some(&first), Some(&last)) = (chain.first(), chain.last()) else {
            continue;
        };
        let is_ring = first != last
            && peptide_distance(&residues[last], &residues[first])
                .is_some_and(|distance| distance < 2.0);
        if !is_ring {
            residues[first].n_terminus =
                !hidden.before(&residues[first]) && may_be_amine(&residues[first]);
            residues[last].c_terminus =
                !hidden.after(&residues[last]) && may_be_carboxylate(&residues[last]);
        }
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
}

fn may_be_amine(residue: &SelectedResidue) -> bool {
    residue.class != ResidueClass::Cap
        && !has_blocked_amine(&residue.name)
        && residue.atom("N").is_some()
}

fn may_be_carboxylate(residue: &SelectedResidue) -> bool {
    residue.class != ResidueClass::Cap && residue.atom("C").is_some()
}

/// The smallest and largest number of the unobserved residues of each chain.
struct HiddenEnds {
    range: HashMap<Arc<str>, (i32, i32)>,
}

impl HiddenEnds {
    fn of(unobserved: &[UnobservedResidue]) -> Self {
        let mut range: HashMap<Arc<str>, (i32, i32)> = HashMap::new();
        for residue in unobserved {
            let number = residue.key.number;
            let (low, high) = range
                .entry(residue.key.chain.clone())
                .or_insert((number, number));
            (*low, *high) = ((*low).min(number), (*high).max(number));
        }
        Self { range }
    }

    fn before(&self, residue: &SelectedResidue) -> bool {
        self.range
            .get(&residue.source_chain)
            .is_some_and(|(low, _)| *low < residue.key.number)
    }

    fn after(&self, residue: &SelectedResidue) -> bool {
        self.range
            .get(&residue.source_chain)
            .is_some_and(|(_, high)| *high > residue.key.number)
    }
}

/// Marks the cysteines whose SG lies within 2.5 Å of another's (the bond is 2.05 Å long).
pub(crate) fn mark_disulfides(residues: &mut [SelectedResidue]) {
    const BOND_ANGSTROM: f64 = 2.5;
    /// Two points in one cell are always within the distance, so that a crowd in one place costs no
    /// more than a pair.
    const CELL_ANGSTROM: f64 = BOND_ANGSTROM * 0.577;
    let sulfurs: Vec<(usize, Vec3)> = residues
        .iter()
        .enumerate()
        .filter(|(_, residue)| {
            residue.class == ResidueClass::AminoAcid(AminoAcid::Cys) || &*residue.name == "CYX"
        })
        .filter_map(|(index, residue)| Some((index, residue.atom("SG")?.position)))
        .collect();
    residues
        .iter_mut()
        .for_each(|residue| residue.in_disulfide = false);
    let cell_of = |p: &Vec3| [p.x, p.y, p.z].map(|x| (x / CELL_ANGSTROM).floor() as i64);
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    for (i, (_, position)) in sulfurs.iter().enumerate() {
        cells.entry(cell_of(position)).or_default().push(i);
    }
    let neighbours =
        || (-2..=2).flat_map(|x| (-2..=2).flat_map(move |y| (-2..=2).map(move |z| [x, y, z])));
    for (i, (residue, position)) in sulfurs.iter().enumerate() {
        let centre = cell_of(position);
        let shares_cell = cells.get(&centre).is_some_and(|members| members.len() > 1);
        let is_near = |j: &usize| *j != i && (sulfurs[*j].1 - position).norm() < BOND_ANGSTROM;
        residues[*residue].in_disulfide = shares_cell
            || neighbours().any(|offset| {
                let cell = [0, 1, 2].map(|k| centre[k] + offset[k]);
                cells
                    .get(&cell)
                    .is_some_and(|members| members.iter().any(is_near))
            });
    }
}
