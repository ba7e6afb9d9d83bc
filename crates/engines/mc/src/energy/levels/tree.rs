//! A body's charges at every resolution: a tree of nodes, each with a few equivalent charges that
//! stand for those inside it.

use super::fit::{Equivalent, fit};
use crate::charges::ChargeCloud;
use protomer_kernel::Vec3;
use protomer_kernel::potential::Yukawa;

/// Largest number of charges of a leaf, which has no equivalent ones.
const LEAF: usize = 12;
/// Number of equivalent charges of a node.
const EQUIVALENT: usize = 16;
/// Nodes of fewer charges than this have [`FEW_EQUIVALENT`].
const SMALL: usize = 24;
/// Number of equivalent charges of a small node.
const FEW_EQUIVALENT: usize = 12;

/// The charges of one body type.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tree {
    pub nodes: Vec<Node>,
    /// Position (Å) and charge (e): those of each node in turn.
    pub points: Vec<[f32; 4]>,
    /// Sum of all charges, e.
    pub net_charge: f32,
    /// Half the diagonal of the charges' bounding box, Å.
    pub radius: f32,
    /// Sum of the squared charges over the volume they fill, e²/Å³.
    pub density: f32,
}

/// A part of the charges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Node {
    pub centre: [f32; 3],
    pub radius: f32,
    /// First of the node's points: true charges in a leaf, equivalent ones elsewhere.
    pub first: u32,
    pub count: u32,
    /// The second child; the first follows the node. Zero for a leaf.
    pub second: u32,
    /// Root mean square error of the equivalent charges' potential at [`FIT_DISTANCE`](super::fit::FIT_DISTANCE) radii, kT/e.
    pub error: f32,
}

impl Tree {
    pub fn new(charges: &ChargeCloud, potential: &Yukawa) -> Self {
        let mut tree = Self::without_nodes(charges);
        let mut charges: Vec<(Vec3, f64)> = charges.iter().collect();
        if !charges.is_empty() {
            tree.grow(&mut charges, potential);
        }
        tree
    }

    pub fn without_nodes(charges: &ChargeCloud) -> Self {
        let charges: Vec<(Vec3, f64)> = charges.iter().collect();
        let (low, high) = bounds(&charges);
        Self {
            nodes: Vec::new(),
            points: Vec::new(),
            net_charge: charges.iter().map(|(_, charge)| *charge).sum::<f64>() as f32,
            radius: ((high - low).norm() / 2.0) as f32,
            density: density(&charges),
        }
    }

    /// Adds a node of these charges and its children, and returns its number.
    fn grow(&mut self, charges: &mut [(Vec3, f64)], potential: &Yukawa) -> u32 {
        let (low, high) = bounds(charges);
        let centre = (low + high) / 2.0;
        let farthest = charges
            .iter()
            .map(|(x, _)| (x - centre).norm())
            .fold(0.0, f64::max);
        let is_leaf = charges.len() <= LEAF;
        let wanted = if charges.len() < SMALL {
            FEW_EQUIVALENT
        } else {
            EQUIVALENT
        };
        let equivalent = match is_leaf {
            true => Equivalent {
                charges: charges.to_vec(),
                error: 0.0,
            },
            false => fit(charges, &centre, farthest, wanted, potential),
        };
        // Pushed before its children, so the first child has the next number.
        let number = self.nodes.len();
        self.nodes.push(Node {
            centre: centre.map(|x| x as f32).into(),
            radius: farthest as f32,
            first: self.points.len() as u32,
            count: equivalent.charges.len() as u32,
            second: 0,
            error: equivalent.error as f32,
        });
        let rows = equivalent.charges.iter();
        self.points
            .extend(rows.map(|(x, q)| [x.x as f32, x.y as f32, x.z as f32, *q as f32]));
        if !is_leaf {
            // Cut at the median along the longest side:
            // nodes stay compact and the tree is balanced.
            let axis = (high - low).imax();
            let middle = charges.len() / 2;
            charges.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]));
            let (left, right) = charges.split_at_mut(middle);
            self.grow(left, potential);
            // Known only now, after the whole first subtree has been added.
            self.nodes[number].second = self.grow(right, potential);
        }
        number as u32
    }

    /// The charges, those of a leaf together.
    pub fn charges(&self) -> Vec<[f32; 4]> {
        let leaves = self.nodes.iter().filter(|node| node.second == 0);
        let points = leaves.flat_map(|leaf| {
            let first = leaf.first as usize;
            &self.points[first..first + leaf.count as usize]
        });
        points.copied().collect()
    }

    pub fn memory_bytes(&self) -> usize {
        std::mem::size_of_val(&*self.nodes) + std::mem::size_of_val(&*self.points)
    }
}

fn bounds(charges: &[(Vec3, f64)]) -> (Vec3, Vec3) {
    let none = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    charges
        .iter()
        .fold(none, |(low, high), (x, _)| (low.inf(x), high.sup(x)))
}

fn density(charges: &[(Vec3, f64)]) -> f32 {
    let (low, high) = bounds(charges);
    let squares: f64 = charges.iter().map(|(_, q)| q * q).sum();
    // The ellipsoid in the bounding box; a single charge gets a volume too.
    (squares / (0.52 * (high - low).add_scalar(2.0).product())) as f32
}
