//! The residues of one kind of body with their charges and atoms.

use super::places::ResiduePlaces;
use crate::BodyType;
use protomer_body::Body;
use protomer_kernel::Vec3;
use protomer_kernel::pose::RelativePose;

/// The residues of one kind of body.
#[derive(Debug)]
pub struct ResiduesOfKind {
    /// Residues by their places.
    pub places: ResiduePlaces,
    /// The charges that interact, in the body's frame.
    pub(super) charges: OwnedCharges,
    /// The heavy atoms of each residue, in the body's frame.
    pub(super) atoms: Vec<AtomsOfResidue>,
}

/// Charges, each with its residue.
#[derive(Debug, Clone, Default)]
pub(super) struct OwnedCharges {
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
    pub(super) z: Vec<f64>,
    pub(super) charge_e: Vec<f64>,
    pub(super) residue: Vec<usize>,
}

/// The heavy atoms of a residue in their bounding sphere.
#[derive(Debug, Clone)]
pub(super) struct AtomsOfResidue {
    pub(super) centre: Vec3,
    pub(super) radius_angstrom: f64,
    pub(super) atoms: Vec<Vec3>,
}

impl ResiduesOfKind {
    /// The residues of a body with the charges of its type, which may be effective ones; a charge
    /// belongs to the residue of the nearest atom. `None` for a body without residues.
    pub fn new(body: &Body, kind: &BodyType) -> Option<Self> {
        let places = ResiduePlaces::from_body(body);
        let mut charges = OwnedCharges::default();
        for (place, charge_e) in kind.charges.iter() {
            let residue = places.nearest(&place)?;
            charges.push(place, charge_e, residue);
        }
        let mut atoms = vec![Vec::new(); places.len()];
        for site in &body.sites {
            let of_residue = site.residue.and_then(|index| atoms.get_mut(index as usize));
            if let (Some(of_residue), false) = (of_residue, site.is_hydrogen()) {
                of_residue.push(site.position);
            }
        }
        Some(Self {
            places,
            charges,
            atoms: atoms.into_iter().map(AtomsOfResidue::new).collect(),
        })
        .filter(|kind| !kind.places.is_empty())
    }

    /// Number of residues.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Always false: a kind has at least one residue.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// The sum of the charges of each residue, e.
    pub fn charges_of_residues(&self) -> Vec<f64> {
        let mut charges = vec![0.0; self.len()];
        for (residue, charge_e) in self.charges.residue.iter().zip(&self.charges.charge_e) {
            charges[*residue] += charge_e;
        }
        charges
    }

    /// The residues of the first and of the second body that touch: heavy atoms of them are closer
    /// than `distance_angstrom`.
    pub(super) fn touching(
        &self,
        second: &Self,
        relative: &RelativePose,
        distance_angstrom: f64,
        mut take: impl FnMut(usize, usize),
    ) {
        let square = distance_angstrom * distance_angstrom;
        for (of_second, theirs) in second.atoms.iter().enumerate() {
            let theirs = theirs.moved(relative);
            for (of_first, ours) in self.atoms.iter().enumerate() {
                let reach = ours.radius_angstrom + theirs.radius_angstrom + distance_angstrom;
                if (ours.centre - theirs.centre).norm_squared() < reach * reach
                    && ours.comes_within(&theirs, square)
                {
                    take(of_first, of_second);
                }
            }
        }
    }
}

impl OwnedCharges {
    fn push(&mut self, place: Vec3, charge_e: f64, residue: usize) {
        self.x.push(place.x);
        self.y.push(place.y);
        self.z.push(place.z);
        self.charge_e.push(charge_e);
        self.residue.push(residue);
    }

    pub(super) fn len(&self) -> usize {
        self.charge_e.len()
    }

    pub(super) fn place(&self, index: usize) -> Vec3 {
        Vec3::new(self.x[index], self.y[index], self.z[index])
    }

    /// The charges in the frame of another body.
    pub(super) fn moved(&self, relative: &RelativePose) -> Self {
        let mut charges = self.clone();
        for index in 0..self.len() {
            let place = relative.transform_point(&self.place(index));
            (charges.x[index], charges.y[index], charges.z[index]) = (place.x, place.y, place.z);
        }
        charges
    }
}

impl AtomsOfResidue {
    fn new(atoms: Vec<Vec3>) -> Self {
        let centre = atoms.iter().sum::<Vec3>() / atoms.len().max(1) as f64;
        let farthest = atoms.iter().map(|atom| (atom - centre).norm_squared());
        Self {
            centre,
            radius_angstrom: farthest.fold(0.0, f64::max).sqrt(),
            atoms,
        }
    }

    fn moved(&self, relative: &RelativePose) -> Self {
        let atoms = self.atoms.iter();
        Self {
            centre: relative.transform_point(&self.centre),
            radius_angstrom: self.radius_angstrom,
            atoms: atoms.map(|atom| relative.transform_point(atom)).collect(),
        }
    }

    fn comes_within(&self, other: &Self, square_angstrom2: f64) -> bool {
        let is_near = |atom: &Vec3| {
            let mut others = other.atoms.iter();
            others.any(|of_other| (atom - of_other).norm_squared() < square_angstrom2)
        };
        self.atoms.iter().any(is_near)
    }
}

/// Sites for the charge of another side chain at this residue: its heavy atoms that are farthest
/// from the backbone by the letter of their names, as `ingest --mutate` has it.
pub fn charge_sites(body: &Body, residue: usize) -> Vec<Vec3> {
    let (mut farthest, mut places) = (0, Vec::new());
    for site in &body.sites {
        if site.residue != Some(residue as u32) || site.is_hydrogen() {
            continue;
        }
        let remoteness = remoteness(&site.atom_name);
        if remoteness > farthest {
            farthest = remoteness;
            places.clear();
        }
        if remoteness == farthest {
            places.push(site.position);
        }
    }
    places
}

fn remoteness(atom_name: &str) -> usize {
    let is_backbone = ["N", "CA", "C", "O", "OXT"].contains(&atom_name);
    let letter = atom_name.chars().nth(1).unwrap_or(' ');
    match "BGDEZH".find(letter) {
        Some(rank) if !is_backbone => 2 + rank,
        _ if atom_name == "CA" => 1,
        _ => 0,
    }
}
