//! All that is prepared for one body type under one potential.

use super::field::Field;
use super::fine::FINE;
use super::motion::{Block, blocks};
use super::neighbours::{Neighbours, SKIN_ANGSTROM};
use super::sampler::Sites;
use super::split::Split;
use super::tree::Tree;
use crate::charges::ChargeCloud;
use protomer_kernel::Vec3;
use protomer_kernel::potential::Yukawa;

/// The range of the near part, in mean distances of neighbouring charges.
const NEAR_SPACINGS: f64 = 1.9;
/// The least and the largest range of the near part, Å.
const NEAR_BOUNDS_ANGSTROM: (f64, f64) = (3.0, 8.0);

/// Data of one body type under one potential, immutable and to be shared.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    pub(super) split: Split,
    pub(super) tree: Tree,
    pub(super) field: Field,
    pub(super) neighbours: Neighbours,
    pub(super) charges: ChargeCloud,
    blocks: Vec<Block>,
}

/// An energy with its variance by the error model, kT and kT².
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Estimate {
    pub energy_kt: f64,
    pub variance: f64,
}

impl Table {
    /// The table of these charges, which serves partners as far away as `reach_angstrom`.
    pub fn new(charges: &ChargeCloud, potential: &Yukawa, reach_angstrom: f64) -> Self {
        let split = Split::new(*potential, near_radius(charges));
        let tree = Tree::new(charges, potential);
        let field = Field::new(charges, &split, reach_angstrom);
        Self::assemble(charges, potential, tree, field)
    }

    /// Number of potentials of single charges that a new table computes, which takes nearly all of
    /// its time.
    pub fn evaluations(charges: &ChargeCloud, reach_angstrom: f64) -> f64 {
        if charges.is_empty() {
            return 0.0;
        }
        let mut boxes = Field::boxes(charges, near_radius(charges), reach_angstrom);
        let cells = boxes.number_cells(&Sites::new(charges));
        (cells.len() * FINE.pow(3)) as f64 * charges.len() as f64
    }

    /// The table with what takes long to make from elsewhere.
    pub(super) fn assemble(
        charges: &ChargeCloud,
        potential: &Yukawa,
        tree: Tree,
        field: Field,
    ) -> Self {
        let split = Split::new(*potential, near_radius(charges));
        // Charges may move by the skin before neighbours are looked up again.
        let distance = split.radius_angstrom + f64::from(SKIN_ANGSTROM);
        Self {
            blocks: blocks(&tree.charges()),
            tree,
            field,
            neighbours: Neighbours::new(charges, distance),
            charges: charges.clone(),
            split,
        }
    }

    /// The field of a table before its cells are filled.
    pub(super) fn empty_field(charges: &ChargeCloud, reach_angstrom: f64) -> Field {
        Field::boxes(charges, near_radius(charges), reach_angstrom)
    }

    /// The charges, in arrays.
    pub(super) fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// A lower bound on the distance of a point from the nearest charge, Å.
    pub(super) fn distance_bound(&self, x: &Vec3) -> f64 {
        f64::from(self.field.distance_bound(x.map(|x| x as f32).into()))
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        self.tree.memory_bytes() + self.field.memory_bytes() + self.neighbours.memory_bytes()
    }
}

/// The standard deviation of a fine energy with a floor for roundings of single precision, kT.
pub(super) fn fine_deviation(variance: f64) -> f64 {
    // 10⁻⁵ kT: about what single precision rounds off in an energy.
    (variance + 1e-10).sqrt()
}

/// Range of the near part, Å. Near pairs are few if it follows the density of the charges.
fn near_radius(charges: &ChargeCloud) -> f64 {
    let (low, high) = charges.bounds_angstrom();
    // The ellipsoid in the bounding box.
    let volume = 0.52 * (high - low).product().max(1.0);
    let spacing = (volume / charges.len().max(1) as f64).cbrt();
    (NEAR_SPACINGS * spacing).clamp(NEAR_BOUNDS_ANGSTROM.0, NEAR_BOUNDS_ANGSTROM.1)
}
