//! Bonds between residues: which residues are part of a chain, and which follows which.
//!
//! A file lists a chain in its order, with one exception: modified residues may come after the TER of
//! their chain, as ligands do. They are in the chain if the bonds C-N or O3'-P connect them with it,
//! and take their place there.

use super::residues::AtomGroup;
use protomer_kernel::Vec3;
use std::collections::HashMap;

/// The longest bond between residues of a chain, Å.
const BOND_ANGSTROM: f64 = 2.0;

/// Names of the atoms of a peptide bond; chromophores call them C3 and N1.
const PEPTIDE: [[&str; 2]; 2] = [["C", "C3"], ["N", "N1"]];
/// Names of the atoms of the bond between nucleotides.
const PHOSPHODIESTER: [[&str; 2]; 2] = [["O3'", "O3*"], ["P", "P"]];

/// The residues of a model in the order of their chains.
pub(crate) struct Links {
    /// Indices of the groups: the order of the file, with residues listed after their chain in their
    /// place.
    pub(crate) order: Vec<usize>,
    /// Whether each group is part of a chain.
    pub(crate) in_chain: Vec<bool>,
    /// Group inside to which each group that was listed after its chain is bonded.
    pub(crate) host: Vec<Option<usize>>,
}

impl Links {
    pub(crate) fn from_groups(groups: &[AtomGroup]) -> Self {
        let mut in_chain = in_chain(groups);
        let (next, previous) = late_bonds(groups, &in_chain);
        let host = hosts(groups, &in_chain, &next, &previous);
        for (in_chain, host) in in_chain.iter_mut().zip(&host) {
            *in_chain |= host.is_some();
        }
        Self {
            order: order(&host, &next, &previous),
            in_chain,
            host,
        }
    }
}

/// Whether each group is part of a chain: an ordinary ATOM, or bonded to its neighbour in the file
/// by a bond between residues of a chain. A group outside any polymer counts only if such bonds
/// connect it to a group inside: two bonded parts of a ligand are not a chain.
fn in_chain(groups: &[AtomGroup]) -> Vec<bool> {
    let mut bonded_to_next = Vec::with_capacity(groups.len());
    for pair in groups.windows(2) {
        bonded_to_next.push(are_bonded(&pair[0], &pair[1]));
    }
    bonded_to_next.push(false);
    let mut in_chain = vec![false; groups.len()];
    // From each side: whether a series of bonds connects a group inside to this one.
    // Two sweeps instead of a search: a series of bonds comes from before or from behind.
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

pub(crate) fn are_bonded(before: &AtomGroup, after: &AtomGroup) -> bool {
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

type Neighbours = Vec<Option<usize>>;

/// The next and the previous group of each, where one of the two is an amino acid that the file lists
/// outside its chain.
fn late_bonds(groups: &[AtomGroup], in_chain: &[bool]) -> (Neighbours, Neighbours) {
    let mut next = vec![None; groups.len()];
    let mut previous = vec![None; groups.len()];
    let is_late: Vec<bool> = groups
        .iter()
        .zip(in_chain)
        .map(|(group, in_chain)| !in_chain && is_amino_acid(group))
        .collect();
    // Nearly all files; the cells below are only built where something must be sought.
    if !is_late.contains(&true) {
        return (next, previous);
    }
    let mut starts: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    for (index, group) in groups.iter().enumerate() {
        if let (true, Some(start)) = (
            in_chain[index] || is_late[index],
            group.position(PEPTIDE[1]),
        ) {
            starts.entry(cell_of(&start)).or_default().push(index);
        }
    }
    for (index, group) in groups.iter().enumerate() {
        let Some(end) = group.position(PEPTIDE[0]) else {
            continue;
        };
        if !(in_chain[index] || is_late[index]) {
            continue;
        }
        for after in near(&starts, &end) {
            let is_new = next[index].is_none() && previous[after].is_none() && after != index;
            let involves_late = is_late[index] || is_late[after];
            if involves_late && is_new && are_bonded(group, &groups[after]) {
                next[index] = Some(after);
                previous[after] = Some(index);
            }
        }
    }
    (next, previous)
}

/// Whether the group has the backbone of an amino acid.
fn is_amino_acid(group: &AtomGroup) -> bool {
    ["N", "CA", "C"]
        .iter()
        .all(|name| group.position([name, name]).is_some())
}

fn cell_of(position: &Vec3) -> [i64; 3] {
    [position.x, position.y, position.z].map(|x| (x / BOND_ANGSTROM).floor() as i64)
}

/// Largest number of groups of a cell that are compared, which bounds the time for files with many
/// atoms in one place.
const MOST_PER_CELL: usize = 32;

fn near(cells: &HashMap<[i64; 3], Vec<usize>>, position: &Vec3) -> Vec<usize> {
    let [x, y, z] = cell_of(position);
    let mut near = Vec::new();
    // A bond is no longer than a cell: the 27 cells around hold all partners.
    for neighbour in 0..27 {
        let cell = [
            x + neighbour / 9 - 1,
            y + neighbour / 3 % 3 - 1,
            z + neighbour % 3 - 1,
        ];
        let groups = cells.get(&cell).into_iter().flatten();
        near.extend(groups.take(MOST_PER_CELL).copied());
    }
    near
}

/// Group of a chain that a series of bonds leads to, for each late group.
fn hosts(
    groups: &[AtomGroup],
    in_chain: &[bool],
    next: &Neighbours,
    previous: &Neighbours,
) -> Neighbours {
    let mut host = vec![None; groups.len()];
    // Both ways along the bonds, outwards from what is surely inside.
    for ways in [previous, next] {
        for (index, inside) in in_chain.iter().enumerate() {
            if !inside || groups[index].is_outside() {
                continue;
            }
            // From each group inside, outwards along the bonds that lead to it.
            let mut current = index;
            while let Some(late) = ways[current].filter(|late| !in_chain[*late]) {
                // Another series reached it first; going on would run in circles.
                if host[late].is_some() {
                    break;
                }
                host[late] = Some(index);
                current = late;
            }
        }
    }
    host
}

/// The order of the file, with each hosted group after the one before it or before the one after it.
fn order(host: &Neighbours, next: &Neighbours, previous: &Neighbours) -> Vec<usize> {
    let mut order = Vec::with_capacity(host.len());
    for index in 0..host.len() {
        if host[index].is_some() {
            continue;
        }
        let before: Vec<usize> = series(index, previous, host).collect();
        // Those that follow a group of the file's order are placed after that one.
        let follows_another = before.last().is_some_and(|last| previous[*last].is_some());
        if !follows_another {
            order.extend(before.iter().rev());
        }
        order.push(index);
        order.extend(series(index, next, host));
    }
    order
}

/// The hosted groups that follow a group along the bonds.
fn series<'n>(
    group: usize,
    bonds: &'n Neighbours,
    host: &'n Neighbours,
) -> impl Iterator<Item = usize> + 'n {
    let step = move |current: &usize| bonds[*current].filter(|late| host[*late].is_some());
    // A ring of hosted groups would never end.
    std::iter::successors(step(&group), step).take(host.len())
}
