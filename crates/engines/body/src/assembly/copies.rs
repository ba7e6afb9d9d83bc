//! Identical units become one body and its poses.
//!
//! Two chains are identical if residues with the same number have the same name, and the shared
//! residues make up at least half of both chains: copies in a crystal differ in which residues are
//! disordered. Units of several chains are identical if their chains are, one by one. The copy with
//! the most atoms is the reference. Its atoms make the body, in a frame about their centroid. The pose
//! of each copy is the superposition of the atoms common to both.
//!
//! Copies that differ from the reference can be asked to keep their own shape. Copies of one
//! chain by the operators of a biological assembly are equal, and share it.

use super::superposition::superpose;
use super::units::{Unit, units_of_chains};
use crate::structure::{ResidueKey, SelectedResidue, Selection, SelectionReport};
use crate::{BodyError, Result};
use protomer_kernel::{Pose, Vec3};
use std::collections::{BTreeSet, HashMap};

/// A body type found in a structure.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyType {
    /// The unit that serves as the reference, by its name.
    pub reference: String,
    /// Number of the reference unit.
    pub unit: usize,
    /// The reference alone, from which the body is made.
    pub selection: Selection,
    /// Copies in the order of the structure, the reference among them.
    pub copies: Vec<ChainCopy>,
}

/// One copy of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct ChainCopy {
    /// Name of the copied unit: its chain, or its chains.
    pub chain: String,
    /// Number of the copied unit.
    pub unit: usize,
    /// Pose of the body whose frame has its origin at the centroid of the reference's atoms.
    pub pose: Pose,
    /// Root mean square distance of the common atoms, Å.
    pub rmsd_angstrom: f64,
    /// Atoms common to the copy and the reference.
    pub common_atoms: usize,
}

/// The least share of the residues of the longer chain that two identical chains have in common.
const LEAST_SHARED: f64 = 0.5;

/// The largest number of units: every unit is compared with the reference of each family.
const MOST_CHAINS: usize = 10_000;

/// Copies whose atoms all lie within this distance (root mean square, Å) are the same: the digits of
/// the operators of a file.
const SAME_SHAPE_ANGSTROM: f64 = 0.02;

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
    let units = units_of_chains(selection);
    body_types_of_units(&units, &selection.report, &BTreeSet::new())
}

/// Variant of [`body_types`] for units. Those in `with_own_shape` (numbers) do not take the shape
/// of a reference that differs from theirs; nor do the units that are equal to them.
///
/// # Errors
/// As [`body_types`].
pub fn body_types_of_units(
    units: &[Unit],
    report: &SelectionReport,
    with_own_shape: &BTreeSet<usize>,
) -> Result<Vec<BodyType>> {
    if units.len() > MOST_CHAINS {
        return Err(BodyError::Invalid {
            cause: format!("{} chains", units.len()),
            remedy: "select some of them or a smaller assembly".into(),
        });
    }
    let chains: Vec<Chain> = units.iter().map(Chain::from_unit).collect();
    let mut types = Vec::new();
    for family in families(&chains) {
        for part in by_shape(&chains, &family, with_own_shape)? {
            types.push(body_type(units, report, &chains, &part)?);
        }
    }
    Ok(types)
}

/// A family, and those of its members that keep their own shape, each group of equal ones with its
/// reference first.
fn by_shape(
    chains: &[Chain],
    family: &[usize],
    with_own_shape: &BTreeSet<usize>,
) -> Result<Vec<Vec<usize>>> {
    // Nobody asked: the groups would all share one shape anyway.
    if !family.iter().any(|member| with_own_shape.contains(member)) {
        return Ok(vec![family.to_vec()]);
    }
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for &member in family {
        let mut equal_group = None;
        for (number, group) in groups.iter().enumerate() {
            // Compared with the first of each group: equal means equal up to the digits of a file.
            if are_equal(&chains[group[0]], &chains[member])? {
                equal_group = Some(number);
                break;
            }
        }
        match equal_group {
            Some(number) => groups[number].push(member),
            None => groups.push(vec![member]),
        }
    }
    // The first group is that of the family's reference, whose shape the others share.
    let (mut sharing, mut parts) = (Vec::new(), Vec::new());
    for (number, group) in groups.into_iter().enumerate() {
        let keeps_own = number > 0 && group.iter().any(|member| with_own_shape.contains(member));
        if keeps_own {
            parts.push(group);
        } else {
            sharing.extend(group);
        }
    }
    parts.insert(0, sharing);
    Ok(parts)
}

/// Whether two units have the same atoms in the same places, up to a motion.
fn are_equal(a: &Chain, b: &Chain) -> Result<bool> {
    let common = common_atoms(&shared(a, b));
    // Another number of atoms: another shape, whatever the distance.
    if common.len() != a.atoms() || common.len() != b.atoms() {
        return Ok(false);
    }
    let (first, second): (Vec<Vec3>, Vec<Vec3>) = common.into_iter().unzip();
    Ok(superpose(&first, &second)?.rmsd_angstrom < SAME_SHAPE_ANGSTROM)
}

/// Identical chains by their indices, in the order of the structure. Each family begins with its
/// reference, the chain with the most atoms.
fn families(chains: &[Chain]) -> Vec<Vec<usize>> {
    let mut largest_first: Vec<usize> = (0..chains.len()).collect();
    // Stable, so of equally large chains the first of the structure is the reference.
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

/// A unit with its residues by number.
pub(super) struct Chain<'a> {
    name: &'a str,
    /// Number of its chains.
    chains: usize,
    residues: Vec<&'a SelectedResidue>,
    /// The place of each residue.
    by_number: HashMap<Number<'a>, usize>,
    /// The number of each residue.
    numbers: Vec<Number<'a>>,
}

/// The place of the chain in its unit, number, insertion code, and how many residues before have the
/// same: waters and ions may.
type Number<'a> = (usize, i32, &'a str, usize);

impl<'a> Chain<'a> {
    pub(super) fn from_unit(unit: &'a Unit) -> Self {
        let mut chain = Self {
            name: &unit.name,
            chains: unit.chains.len(),
            residues: Vec::new(),
            by_number: HashMap::new(),
            numbers: Vec::new(),
        };
        let places = unit.chains.iter().enumerate();
        let place_of: HashMap<&str, usize> = places.map(|(index, name)| (&**name, index)).collect();
        let mut earlier: HashMap<&ResidueKey, usize> = HashMap::new();
        for residue in &unit.residues {
            let earlier = earlier.entry(&residue.key).or_default();
            let place = place_of.get(&*residue.key.chain).copied();
            chain.add(residue, place.unwrap_or(unit.chains.len()), *earlier);
            *earlier += 1;
        }
        chain
    }

    fn add(&mut self, residue: &'a SelectedResidue, place: usize, earlier: usize) {
        let key = &residue.key;
        let number = (place, key.number, &*key.insertion_code, earlier);
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

    /// The place in another unit of each residue that has the same number there.
    pub(super) fn places_in(&self, other: &Chain<'a>) -> Vec<Option<usize>> {
        let numbers = self.numbers.iter();
        numbers
            .map(|number| other.by_number.get(number).copied())
            .collect()
    }
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
    // The cheap conditions first; names only where enough residues are shared.
    a.chains == b.chains
        && shared.len() as f64 >= LEAST_SHARED * longer as f64
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

fn body_type(
    units: &[Unit],
    report: &SelectionReport,
    chains: &[Chain],
    family: &[usize],
) -> Result<BodyType> {
    let reference = &chains[family[0]];
    let mut origin = Vec3::zeros();
    for residue in &reference.residues {
        for atom in &residue.atoms {
            origin += atom.position;
        }
    }
    origin /= reference.atoms().max(1) as f64;
    let mut in_order = family.to_vec();
    // The reference comes first in the family; copies come in the order of the structure.
    in_order.sort_unstable();
    let mut copies = Vec::with_capacity(in_order.len());
    for index in in_order {
        copies.push(chain_copy(reference, (index, &chains[index]), &origin)?);
    }
    Ok(BodyType {
        reference: reference.name.to_string(),
        unit: family[0],
        selection: units[family[0]].to_selection(report),
        copies,
    })
}

fn chain_copy(
    reference: &Chain,
    (unit, copy): (usize, &Chain),
    origin: &Vec3,
) -> Result<ChainCopy> {
    let common = common_atoms(&shared(reference, copy));
    let (mut body_points, mut copy_points) = (Vec::new(), Vec::new());
    for (in_reference, in_copy) in &common {
        // The body's frame has its origin at the centroid, so that a pose's position is its middle.
        body_points.push(in_reference - origin);
        copy_points.push(*in_copy);
    }
    let best = superpose(&body_points, &copy_points)?;
    Ok(ChainCopy {
        chain: copy.name.to_string(),
        unit,
        pose: best.pose,
        rmsd_angstrom: best.rmsd_angstrom,
        common_atoms: common.len(),
    })
}
