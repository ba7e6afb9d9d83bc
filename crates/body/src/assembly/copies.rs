//! Identical chains become one body and its poses.
//!
//! Two chains are identical if no residue number that both have bears different names, and the
//! shared residues make up most of both; crystal copies differ in what is disordered. The copy with
//! the most atoms is the reference: its atoms make the body, in a frame about their centroid, and
//! each copy's pose is the superposition of the atoms common to both.

use super::superposition::superpose;
use crate::structure::{SelectedResidue, Selection};
use crate::{BodyError, Result};
use protomer_kernel::{Pose, Vec3};
use std::collections::HashMap;

/// A body type found in a structure.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyType {
    /// The chain that serves as the reference.
    pub reference: String,
    /// The reference chain alone, from which the body is made.
    pub selection: Selection,
    /// Copies in the order of the structure, the reference among them.
    pub copies: Vec<ChainCopy>,
}

/// One copy of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct ChainCopy {
    /// Chain of the copy.
    pub chain: String,
    /// Pose of the body whose frame has its origin at the centroid of the reference's atoms.
    pub pose: Pose,
    /// Root mean square distance of the common atoms, Å.
    pub rmsd_angstrom: f64,
    /// Atoms common to the copy and the reference.
    pub common_atoms: usize,
}

/// The least share of the residues of the longer chain that two identical chains have in common.
const LEAST_SHARED: f64 = 0.5;

/// Every chain is compared with one of each family before it.
const MOST_CHAINS: usize = 10_000;

/// Sorts the chains of a selection into body types with their copies.
///
/// # Errors
/// [`BodyError::Invalid`] for more than ten thousand chains, and those of [`superpose`].
pub fn body_types(selection: &Selection) -> Result<Vec<BodyType>> {
    let chains = by_chain(selection);
    if chains.len() > MOST_CHAINS {
        return Err(BodyError::Invalid {
            cause: format!("{} chains", chains.len()),
            remedy: "select some of them or a smaller assembly".into(),
        });
    }
    let mut largest_first: Vec<usize> = (0..chains.len()).collect();
    largest_first.sort_by_key(|index| std::cmp::Reverse(chains[*index].atoms()));
    // Each family begins with its reference.
    let mut families: Vec<Vec<usize>> = Vec::new();
    for index in largest_first {
        match families
            .iter_mut()
            .find(|family| are_identical(&chains[family[0]], &chains[index]))
        {
            Some(family) => family.push(index),
            None => families.push(vec![index]),
        }
    }
    families.sort_by_key(|family| family.iter().min().copied());
    families
        .iter()
        .map(|family| body_type(selection, &chains, family))
        .collect()
}

struct Chain<'a> {
    name: &'a str,
    residues: Vec<&'a SelectedResidue>,
    by_number: HashMap<(i32, &'a str), usize>,
}

impl Chain<'_> {
    fn atoms(&self) -> usize {
        self.residues
            .iter()
            .map(|residue| residue.atoms.len())
            .sum()
    }
}

fn by_chain(selection: &Selection) -> Vec<Chain<'_>> {
    let mut index_of: HashMap<&str, usize> = HashMap::new();
    let mut chains: Vec<Chain> = Vec::new();
    for residue in &selection.residues {
        let name = &*residue.key.chain;
        let index = *index_of.entry(name).or_insert_with(|| {
            chains.push(Chain {
                name,
                residues: Vec::new(),
                by_number: HashMap::new(),
            });
            chains.len() - 1
        });
        let chain = &mut chains[index];
        let number = (residue.key.number, &*residue.key.insertion_code);
        chain
            .by_number
            .entry(number)
            .or_insert(chain.residues.len());
        chain.residues.push(residue);
    }
    chains
}

/// The residues of both chains that bear the same number, in the order of the first.
fn shared<'a>(a: &Chain<'a>, b: &Chain<'a>) -> Vec<(&'a SelectedResidue, &'a SelectedResidue)> {
    let partner = |residue: &&'a SelectedResidue| {
        let number = (residue.key.number, &*residue.key.insertion_code);
        Some((*residue, b.residues[*b.by_number.get(&number)?]))
    };
    a.residues.iter().filter_map(partner).collect()
}

fn are_identical(a: &Chain, b: &Chain) -> bool {
    let longer = a.residues.len().max(b.residues.len());
    let shared = shared(a, b);
    shared.len() as f64 >= LEAST_SHARED * longer as f64
        && shared.iter().all(|(a, b)| a.name == b.name)
        && !common_atoms(&shared).is_empty()
}

/// Positions of the atoms that both residues of a pair have, Å.
fn common_atoms(pairs: &[(&SelectedResidue, &SelectedResidue)]) -> Vec<(Vec3, Vec3)> {
    let mut common = Vec::new();
    for (a, b) in pairs {
        let positions: HashMap<&str, Vec3> = b
            .atoms
            .iter()
            .map(|atom| (&*atom.name, atom.position))
            .collect();
        let both = |(name, position): (&str, Vec3)| Some((position, *positions.get(name)?));
        common.extend(
            a.atoms
                .iter()
                .filter_map(|atom| both((&atom.name, atom.position))),
        );
    }
    common
}

fn body_type(selection: &Selection, chains: &[Chain], family: &[usize]) -> Result<BodyType> {
    let reference = &chains[family[0]];
    let positions: Vec<Vec3> = reference
        .residues
        .iter()
        .flat_map(|residue| &residue.atoms)
        .map(|atom| atom.position)
        .collect();
    let origin = positions.iter().sum::<Vec3>() / positions.len().max(1) as f64;
    let mut in_order = family.to_vec();
    in_order.sort_unstable();
    let copies = in_order
        .iter()
        .map(|&index| chain_copy(reference, &chains[index], &origin));
    Ok(BodyType {
        reference: reference.name.to_string(),
        selection: selection.only_chain(reference.name),
        copies: copies.collect::<Result<_>>()?,
    })
}

fn chain_copy(reference: &Chain, copy: &Chain, origin: &Vec3) -> Result<ChainCopy> {
    let common = common_atoms(&shared(reference, copy));
    let (body_points, copy_points): (Vec<Vec3>, Vec<Vec3>) =
        common.iter().map(|(a, b)| (a - origin, *b)).unzip();
    let best = superpose(&body_points, &copy_points)?;
    Ok(ChainCopy {
        chain: copy.name.to_string(),
        pose: best.pose,
        rmsd_angstrom: best.rmsd_angstrom,
        common_atoms: common.len(),
    })
}
