//! The residues of a body as beads, laid out for vector units.

use crate::charges::{LANES, near_neighbours};
use protomer_body::chemistry::AminoAcid;
use protomer_body::residue_contacts::Bead;
use protomer_kernel::Vec3;

/// Kind of the empty lanes of a group, which interacts with nothing.
pub const EMPTY_LANE: u8 = 20;

/// Beads in the body's frame, in groups of [`LANES`] near neighbours.
///
/// ```
/// use protomer_body::chemistry::AminoAcid;
/// use protomer_body::residue_contacts::Bead;
/// use protomer_kernel::Vec3;
/// use protomer_mc::beads::BeadCloud;
/// let position = Vec3::new(3.0, 4.0, 0.0);
/// let alanine = Bead { position, amino_acid: AminoAcid::Ala, residue: 0 };
/// let cloud = BeadCloud::new(&[alanine]);
/// assert_eq!((cloud.len(), cloud.radius_angstrom()), (1, 5.0));
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BeadCloud {
    groups: Vec<BeadGroup>,
    count: usize,
    radius_angstrom: f64,
}

/// [`LANES`] neighbouring beads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeadGroup {
    /// Coordinates, Å.
    pub x: [f64; LANES],
    /// Coordinates, Å.
    pub y: [f64; LANES],
    /// Coordinates, Å.
    pub z: [f64; LANES],
    /// The amino acids, as numbers; [`EMPTY_LANE`] from the first lane that is empty.
    pub kind: [u8; LANES],
    /// Centre of the bounding sphere, Å.
    pub centre: Vec3,
    /// Radius of the bounding sphere, Å.
    pub radius_angstrom: f64,
}

impl BeadCloud {
    /// Groups the beads.
    pub fn new(beads: &[Bead]) -> Self {
        let mut sites = Vec::with_capacity(beads.len());
        let mut radius_angstrom: f64 = 0.0;
        for bead in beads {
            radius_angstrom = radius_angstrom.max(bead.position.norm());
            sites.push((bead.position, *bead));
        }
        let mut groups = Vec::with_capacity(beads.len().div_ceil(LANES));
        near_neighbours(&mut sites, &mut |near| groups.push(BeadGroup::new(near)));
        Self {
            groups,
            count: beads.len(),
            radius_angstrom,
        }
    }

    /// The groups.
    pub fn groups(&self) -> &[BeadGroup] {
        &self.groups
    }

    /// Number of beads.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are no beads.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Radius of the sphere around the body's origin that encloses all beads, Å.
    pub fn radius_angstrom(&self) -> f64 {
        self.radius_angstrom
    }
}

impl BeadGroup {
    /// A group of one to [`LANES`] beads; empty lanes repeat the first position.
    fn new(beads: &[(Vec3, Bead)]) -> Self {
        let place = |lane: usize| {
            beads
                .get(lane)
                .map_or(beads[0].0, |(position, _)| *position)
        };
        let mut kind = [EMPTY_LANE; LANES];
        let mut centre = Vec3::zeros();
        for (lane, (position, bead)) in beads.iter().enumerate() {
            kind[lane] = number(bead.amino_acid);
            centre += position / beads.len() as f64;
        }
        let mut radius_angstrom: f64 = 0.0;
        for (position, _) in beads {
            radius_angstrom = radius_angstrom.max((position - centre).norm());
        }
        Self {
            x: std::array::from_fn(|lane| place(lane).x),
            y: std::array::from_fn(|lane| place(lane).y),
            z: std::array::from_fn(|lane| place(lane).z),
            kind,
            centre,
            radius_angstrom,
        }
    }

    /// Position of the bead of a lane, Å.
    pub fn place(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }
}

fn number(amino_acid: AminoAcid) -> u8 {
    amino_acid as u8
}
