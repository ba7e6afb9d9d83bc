//! Chains that hold together by more than their surfaces: by covalent bonds, or as the strands of a
//! duplex of nucleic acid. As separate rigid bodies they would be torn apart, or overlap.

use super::cells::Cells;
use super::units::Unit;
use crate::structure::{ResidueClass, SelectedResidue};
use protomer_kernel::Vec3;
use protomer_kernel::disjoint_sets::DisjointSets;
use std::collections::BTreeMap;
use std::fmt;

/// Sulfurs of cysteines at this distance or less are bonded; the bond is 2.05 Å long.
const DISULFIDE_ANGSTROM: f64 = 2.5;
/// Any two heavy atoms at this distance or less are bonded; a bond between C and N is 1.33 to 1.47 Å
/// long.
const BOND_ANGSTROM: f64 = 1.7;
/// N1 of a purine and N3 of the pyrimidine that pairs with it are 2.9 Å apart.
const BASE_PAIR_ANGSTROM: (f64, f64) = (2.5, 3.3);
/// Fewest base pairs of a duplex.
const FEWEST_PAIRS: usize = 4;

/// A bond or duplex that joins two units.
///
/// ```
/// use protomer_body::assembly::JoinedBy;
/// assert_eq!(JoinedBy::Duplex(12).to_string(), "12 base pairs");
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum JoinedBy {
    /// A disulfide bond between two residues.
    Disulfide(String, String),
    /// Another covalent bond between two atoms, and their distance, Å.
    Bond(String, String, f64),
    /// Base pairs, with their number.
    Duplex(usize),
}

impl fmt::Display for JoinedBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Disulfide(one, other) => write!(f, "the disulfide bond {one} - {other}"),
            Self::Bond(one, other, distance) => {
                write!(f, "a bond of {distance:.2} Å, {one} - {other}")
            }
            Self::Duplex(pairs) => write!(f, "{pairs} base pairs"),
        }
    }
}

/// Two units, by their numbers, and what joins them.
#[derive(Debug, Clone, PartialEq)]
pub struct Joined {
    /// The two units, the smaller number first.
    pub units: (usize, usize),
    /// The bond or duplex between them.
    pub by: JoinedBy,
}

/// The pairs of units that are joined, each once.
///
/// ```
/// use protomer_body::assembly::{joined_units, units_of_chains};
/// use protomer_body::structure::{SelectionSettings, Structure};
/// let text = "\
/// ATOM      1  SG  CYS H   7      11.104   6.134  -6.504  1.00 10.00           S
/// ATOM      2  SG  CYS L   9      13.154   6.134  -6.504  1.00 10.00           S";
/// let structure = Structure::read("two.pdb", text.as_bytes())?;
/// let units = units_of_chains(&structure.select(&SelectionSettings::default())?);
/// let joined = joined_units(&units);
/// assert_eq!(joined[0].by.to_string(), "the disulfide bond H:7 - L:9");
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
pub fn joined_units(units: &[Unit]) -> Vec<Joined> {
    let mut links: BTreeMap<(usize, usize), JoinedBy> = BTreeMap::new();
    let mut base_pairs: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    let atoms = Atoms::from_units(units);
    atoms
        .cells
        .for_each_pair(BASE_PAIR_ANGSTROM.1, |one, other| {
            let (a, b) = (&atoms.list[one], &atoms.list[other]);
            if a.unit == b.unit {
                return;
            }
            let (a, b) = if a.unit < b.unit { (a, b) } else { (b, a) };
            let distance = (a.position - b.position).norm();
            let pair = (a.unit, b.unit);
            if a.pairs_with(b) && distance >= BASE_PAIR_ANGSTROM.0 {
                *base_pairs.entry(pair).or_default() += 1;
            }
            if a.is_sulfur && b.is_sulfur && distance <= DISULFIDE_ANGSTROM {
                let (one, other) = (a.residue.key.to_string(), b.residue.key.to_string());
                links.entry(pair).or_insert(JoinedBy::Disulfide(one, other));
            } else if distance <= BOND_ANGSTROM {
                let bond = JoinedBy::Bond(a.to_string(), b.to_string(), distance);
                links.entry(pair).or_insert(bond);
            }
        });
    for (pair, count) in base_pairs {
        if count >= FEWEST_PAIRS {
            links.entry(pair).or_insert(JoinedBy::Duplex(count));
        }
    }
    let joined = links.into_iter();
    joined
        .map(|(units, link)| Joined { units, by: link })
        .collect()
}

/// The units that are joined, directly or through others, as lists of their numbers.
///
/// ```
/// use protomer_body::assembly::{Joined, JoinedBy, joined_groups};
/// let pair = |first, second| Joined { units: (first, second), by: JoinedBy::Duplex(12) };
/// assert_eq!(joined_groups(5, &[pair(0, 3), pair(1, 3)]), [[0, 1, 3]]);
/// ```
pub fn joined_groups(units: usize, joined: &[Joined]) -> Vec<Vec<usize>> {
    let mut sets = DisjointSets::new(units);
    for Joined { units: (a, b), .. } in joined {
        sets.join(*a as u32, *b as u32);
    }
    let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (unit, root) in sets.into_roots().into_iter().enumerate() {
        members.entry(root).or_default().push(unit);
    }
    members
        .into_values()
        .filter(|group| group.len() > 1)
        .collect()
}

/// The ring nitrogen of a base in the middle hydrogen bond of a Watson-Crick pair.
#[derive(Clone, Copy, PartialEq)]
enum PairingNitrogen {
    None,
    OfPurine,
    OfPyrimidine,
}

struct Atom<'a> {
    unit: usize,
    residue: &'a SelectedResidue,
    name: &'a str,
    position: Vec3,
    is_sulfur: bool,
    pairing: PairingNitrogen,
}

impl Atom<'_> {
    fn pairs_with(&self, other: &Self) -> bool {
        use PairingNitrogen::{OfPurine, OfPyrimidine};
        matches!(
            (self.pairing, other.pairing),
            (OfPurine, OfPyrimidine) | (OfPyrimidine, OfPurine)
        )
    }
}

impl fmt::Display for Atom<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} {} {}",
            self.name, self.residue.name, self.residue.key
        )
    }
}

struct Atoms<'a> {
    list: Vec<Atom<'a>>,
    cells: Cells,
}

impl<'a> Atoms<'a> {
    fn from_units(units: &'a [Unit]) -> Self {
        let mut list = Vec::new();
        for (unit, of_unit) in units.iter().enumerate() {
            for residue in &of_unit.residues {
                let pairing = pairing_nitrogen(residue);
                for atom in &residue.atoms {
                    if atom.is_hydrogen() {
                        continue;
                    }
                    let is_pairing = pairing.is_some_and(|(name, _)| *atom.name == *name);
                    list.push(Atom {
                        unit,
                        residue,
                        name: &atom.name,
                        position: atom.position,
                        is_sulfur: &*atom.name == "SG",
                        pairing: match pairing {
                            Some((_, kind)) if is_pairing => kind,
                            _ => PairingNitrogen::None,
                        },
                    });
                }
            }
        }
        let positions: Vec<Vec3> = list.iter().map(|atom| atom.position).collect();
        Self {
            cells: Cells::new(positions, BASE_PAIR_ANGSTROM.1),
            list,
        }
    }
}

/// Name and kind of a nucleotide; purines have an atom N9.
fn pairing_nitrogen(residue: &SelectedResidue) -> Option<(&'static str, PairingNitrogen)> {
    if residue.class != ResidueClass::Nucleotide {
        return None;
    }
    Some(match residue.atom("N9") {
        Some(_) => ("N1", PairingNitrogen::OfPurine),
        None => ("N3", PairingNitrogen::OfPyrimidine),
    })
}
