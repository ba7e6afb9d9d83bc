//! Contacts between residues of different units: pairs with heavy atoms within 4.5 Å.

use super::cells::Cells;
use super::copies::{BodyType, Chain};
use super::placement::Placement;
use super::units::Unit;
use protomer_kernel::Vec3;
use std::collections::BTreeSet;

/// Residues with heavy atoms at most this far apart are in contact, Å.
pub const CONTACT_ANGSTROM: f64 = 4.5;

/// A residue by the number of its unit and its place there.
type ResidueOfUnit = (usize, usize);

/// Pairs of residues of different units that are in contact.
///
/// ```
/// use protomer_body::assembly::{ResidueContacts, units_of_chains};
/// use protomer_body::structure::{SelectionSettings, Structure};
/// let text = "\
/// ATOM      1  CA  GLY A   7       0.000   0.000   0.000  1.00 10.00           C
/// ATOM      2  CA  GLY B   7       4.000   0.000   0.000  1.00 10.00           C
/// ATOM      3  CA  GLY C   7      20.000   0.000   0.000  1.00 10.00           C";
/// let structure = Structure::read("three.pdb", text.as_bytes())?;
/// let contacts = ResidueContacts::native(&units_of_chains(&structure.select(&SelectionSettings::default())?));
/// assert_eq!(contacts.len(), 1);
/// assert!(contacts.partners(0).contains(&1) && contacts.partners(2).is_empty());
/// assert_eq!(contacts.share_in(&ResidueContacts::default()), Some(0.0));
/// # Ok::<(), protomer_body::BodyError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ResidueContacts(BTreeSet<(ResidueOfUnit, ResidueOfUnit)>);

impl ResidueContacts {
    /// The contacts in the coordinates of the structure.
    pub fn native(units: &[Unit]) -> Self {
        let mut atoms = Vec::new();
        for (number, unit) in units.iter().enumerate() {
            for (place, residue) in unit.residues.iter().enumerate() {
                let heavy = residue.atoms.iter().filter(|atom| !atom.is_hydrogen());
                atoms.extend(heavy.map(|atom| (atom.position, (number, place))));
            }
        }
        Self::between(atoms)
    }

    /// The contacts between placed bodies, whose residues are those of the unit that each is a copy
    /// of. `placements` has the copies of the first type, then those of the second, and so on.
    pub fn of_placements(units: &[Unit], types: &[BodyType], placements: &[Placement]) -> Self {
        let mut atoms = Vec::new();
        let mut placed = placements.iter();
        for of_type in types {
            let reference = Chain::from_unit(&units[of_type.unit]);
            let origin = centroid(&units[of_type.unit]);
            for (copy, (_, pose)) in of_type.copies.iter().zip(&mut placed) {
                let places = reference.places_in(&Chain::from_unit(&units[copy.unit]));
                for (residue, place) in units[of_type.unit].residues.iter().zip(places) {
                    let Some(place) = place else {
                        continue;
                    };
                    for atom in residue.atoms.iter().filter(|atom| !atom.is_hydrogen()) {
                        let position = pose.transform_point(&(atom.position - origin));
                        atoms.push((position, (copy.unit, place)));
                    }
                }
            }
        }
        Self::between(atoms)
    }

    fn between(atoms: Vec<(Vec3, ResidueOfUnit)>) -> Self {
        let (positions, residues): (Vec<Vec3>, Vec<ResidueOfUnit>) = atoms.into_iter().unzip();
        let mut pairs = BTreeSet::new();
        Cells::new(positions, CONTACT_ANGSTROM).for_each_pair(CONTACT_ANGSTROM, |one, other| {
            let (a, b) = (residues[one], residues[other]);
            if a.0 != b.0 {
                pairs.insert((a.min(b), a.max(b)));
            }
        });
        Self(pairs)
    }

    /// Number of pairs.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are no contacts.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The share of these contacts that others have too; `None` if there are no contacts.
    pub fn share_in(&self, others: &Self) -> Option<f64> {
        let common = self.0.intersection(&others.0).count();
        (!self.is_empty()).then(|| common as f64 / self.len() as f64)
    }

    /// Number of these contacts that each unit has, and number of those that others have too.
    pub fn kept_by_unit(&self, others: &Self, units: usize) -> Vec<(usize, usize)> {
        let mut counts = vec![(0, 0); units];
        for contact in &self.0 {
            let is_kept = usize::from(others.0.contains(contact));
            for (unit, _) in [contact.0, contact.1] {
                counts[unit].0 += 1;
                counts[unit].1 += is_kept;
            }
        }
        counts
    }

    /// The units with a contact to this one.
    pub fn partners(&self, unit: usize) -> BTreeSet<usize> {
        let mut partners = BTreeSet::new();
        for (a, b) in &self.0 {
            if a.0 == unit {
                partners.insert(b.0);
            } else if b.0 == unit {
                partners.insert(a.0);
            }
        }
        partners
    }

    /// The residues that have a contact.
    pub fn residues(&self) -> BTreeSet<(usize, usize)> {
        self.0.iter().flat_map(|(a, b)| [*a, *b]).collect()
    }
}

/// The origin of the body that is made of a unit: the centroid of its atoms, Å.
pub fn centroid(unit: &Unit) -> Vec3 {
    let atoms = unit.residues.iter().flat_map(|residue| &residue.atoms);
    let mut sum = Vec3::zeros();
    for atom in atoms {
        sum += atom.position;
    }
    sum / unit.atoms().max(1) as f64
}
