//! Identical chains become one body and its poses.
//!
//! Two chains are identical if residues with the same number have the same name, and the shared
//! residues make up at least half of both chains: copies in a crystal differ in which residues are
//! disordered. The copy with the most atoms is the reference. Its atoms make the body, in a frame
//! about their centroid. The pose of each copy is the superposition of the atoms common to both.

use super::superposition::superpose;
use crate::structure::{ResidueKey, SelectedResidue, Selection};
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

/// The largest number of chains: every chain is compared with the reference of each family.
const MOST_CHAINS: usize = 10_000;

/// Sorts the chains of a selection into body types with their copies.
///
/// ```
/// use protomer_body::assembly::body_types;
/// use protomer_body::structure::{SelectionSettings, Structure};
/// let text = "\
/// ATOM      1  N   GLY A   7      11.104   6.134  -6.504  1.00 10.00           N
/// ATOM      2  CA  GLY A   7      11.639   6.071  -5.147  1.00 10.00           C
/// ATOM      3  N   GLY B   7      31.104   6.134  -6.504  1.00 10.00           N
/// ATOM      4  CA  GLY B   7      31.639   6.071  -5.147  1.00 10.00           C";
/// let structure = Structure::read("pair.pdb", text.as_bytes())?;
/// let types = body_types(&structure.select(&SelectionSettings::default())?)?;
/// assert_eq!((types.len(), types[0].copies.len()), (1, 2));
/// let [first, second] = [0, 1].map(|copy| types[0].copies[copy].pose.position);
/// assert!(((second - first).x - 20.0).abs() < 1e-9);
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
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
    let families = families(&chains);
    let mut types = Vec::with_capacity(families.len());
    for family in &families {
        types.push(body_type(selection, &chains, family)?);
    }
    Ok(types)
}

/// Identical chains by their indices, in the order of the structure. Each family begins with its
/// reference, the chain with the most atoms.
fn families(chains: &[Chain]) -> Vec<Vec<usize>> {
    let mut largest_first: Vec<usize> = (0..chains.len()).collect();
    largest_first.sort_by_key(|index| std::cmp::Reverse(chains[*index].atoms()));
    let mut families: Vec<Vec<usize>> = Vec::new();
    for index in largest_first {
        let is_own = |family: &&mut Vec<usize>| are_identical(&chains[family[0]], &chains[index]);
        match families.iter_mut().find(is_own) {
            Some(family) => family.push(index),
            None => families.push(vec![index]),
        }
    }
    families.sort_by_key(|family| family.iter().min().copied());
    families
}

struct Chain<'a> {
    name: &'a str,
    residues: Vec<&'a SelectedResidue>,
    /// The place of each residue by number, insertion code, and how many before it have the same:
    /// waters and ions may.
    by_number: HashMap<Number<'a>, usize>,
    /// The number of each residue.
    numbers: Vec<Number<'a>>,
}

/// Number, insertion code, and how many residues before have the same.
type Number<'a> = (i32, &'a str, usize);

impl<'a> Chain<'a> {
    fn add(&mut self, residue: &'a SelectedResidue, earlier: usize) {
        let key = &residue.key;
        let number = (key.number, &*key.insertion_code, earlier);
        self.by_number.insert(number, self.residues.len());
        self.numbers.push(number);
        self.residues.push(residue);
    }

    fn atoms(&self) -> usize {
        let mut atoms = 0;
        for residue in &self.residues {
            atoms += residue.atoms.len();
        }
        atoms
    }

    /// The residue of a number.
    fn residue(&self, number: &Number<'a>) -> Option<&'a SelectedResidue> {
        Some(self.residues[*self.by_number.get(number)?])
    }
}

fn by_chain(selection: &Selection) -> Vec<Chain<'_>> {
    let mut index_of: HashMap<&str, usize> = HashMap::new();
    let mut chains: Vec<Chain> = Vec::new();
    let mut earlier: HashMap<&ResidueKey, usize> = HashMap::new();
    for residue in &selection.residues {
        let name = &*residue.key.chain;
        let index = *index_of.entry(name).or_insert_with(|| {
            chains.push(Chain {
                name,
                residues: Vec::new(),
                by_number: HashMap::new(),
                numbers: Vec::new(),
            });
            chains.len() - 1
        });
        let earlier = earlier.entry(&residue.key).or_default();
        chains[index].add(residue, *earlier);
        *earlier += 1;
    }
    chains
}

/// The residues of both chains that have the same number, in the order of the first.
fn shared<'a>(a: &Chain<'a>, b: &Chain<'a>) -> Vec<(&'a SelectedResidue, &'a SelectedResidue)> {
    let mut shared = Vec::new();
    for (residue, number) in a.residues.iter().zip(&a.numbers) {
        if let Some(partner) = b.residue(number) {
            shared.push((*residue, partner));
        }
    }
    shared
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
        // The last atom of a name counts.
        let mut positions: HashMap<&str, Vec3> = HashMap::new();
        for atom in &b.atoms {
            positions.insert(&atom.name, atom.position);
        }
        for atom in &a.atoms {
            if let Some(position) = positions.get(&*atom.name) {
                common.push((atom.position, *position));
            }
        }
    }
    common
}

fn body_type(selection: &Selection, chains: &[Chain], family: &[usize]) -> Result<BodyType> {
    let reference = &chains[family[0]];
    let mut origin = Vec3::zeros();
    for residue in &reference.residues {
        for atom in &residue.atoms {
            origin += atom.position;
        }
    }
    origin /= reference.atoms().max(1) as f64;
    let mut in_order = family.to_vec();
    in_order.sort_unstable();
    let mut copies = Vec::with_capacity(in_order.len());
    for index in in_order {
        copies.push(chain_copy(reference, &chains[index], &origin)?);
    }
    Ok(BodyType {
        reference: reference.name.to_string(),
        selection: selection.only_chain(reference.name),
        copies,
    })
}

fn chain_copy(reference: &Chain, copy: &Chain, origin: &Vec3) -> Result<ChainCopy> {
    let common = common_atoms(&shared(reference, copy));
    let (mut body_points, mut copy_points) = (Vec::new(), Vec::new());
    for (in_reference, in_copy) in &common {
        body_points.push(in_reference - origin);
        copy_points.push(*in_copy);
    }
    let best = superpose(&body_points, &copy_points)?;
    Ok(ChainCopy {
        chain: copy.name.to_string(),
        pose: best.pose,
        rmsd_angstrom: best.rmsd_angstrom,
        common_atoms: common.len(),
    })
}
