//! Chooses the points of a list.

use super::expansion::centre;
use super::fit::FIT_DISTANCE;
use super::lanes::BLOCK;
use super::list::{List, Part, Parts};
use super::motion::{Block, Motion, blocks};
use super::near::NearMaker;
use super::neighbours::{SKIN_ANGSTROM, squares};
use super::table::Table;
use super::tree::Node;
use crate::energy::SitePotential;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::vectorised;
use std::sync::OnceLock;
use std::sync::atomic::AtomicU32;

/// Radii of a node at which its equivalent charges stand for it.
pub(super) const COARSE_OPENING: f32 = 1.0;

/// Points farther away may move by this part of their distance.
pub(super) const PART_OF_DISTANCE: f32 = 0.3;

/// Variance of an energy by the rounding of single precision, kT².
const ROUNDING_VARIANCE: f64 = 1e-9;

/// A node stands for its charges where that costs less than this variance, kT².
const NODE_VARIANCE: f32 = 3e-6;

/// Errors of a table at points of one cell add up: so much more variance than if they did not.
const TABLE_WEIGHT: f32 = 10.0;

/// Charges farther than this behind the nearest ones hardly see a node's error, Å.
const SEEN_ANGSTROM: f32 = 8.0;

impl List {
    /// The points of the second body for this pose, nodes standing for charges where they are
    /// farther than `opening` of their radii from the charges of the first and their error is small.
    pub fn new(first: &Table, second: &Table, reference: &RelativePose, opening: f32) -> Self {
        let motion = Motion::new(reference);
        let reach = first.split.radius_angstrom as f32 + SKIN_ANGSTROM;
        let mut maker = Maker {
            first,
            second,
            motion,
            reach,
            opening,
            points: Vec::new(),
            far_points: Vec::new(),
            near: NearMaker::new(first.split.radius_angstrom as f32, SKIN_ANGSTROM),
            taken: Vec::new(),
            variance: 0.0,
        };
        maker.choose();
        maker.finish(reference)
    }
}

struct Maker<'a> {
    first: &'a Table,
    second: &'a Table,
    motion: Motion,
    /// Charges farther apart than this, Å, stay beyond the near part's range.
    reach: f32,
    opening: f32,
    /// Points nearer than the reach, and those farther away.
    points: Vec<[f32; 4]>,
    far_points: Vec<[f32; 4]>,
    near: NearMaker,
    /// Nodes with the distance of their centres from the first body.
    taken: Vec<(Node, f32)>,
    variance: f32,
}

impl Maker<'_> {
    vectorised! {
        fused
        fn choose[choose_avx512, choose_avx2, choose_points](self: &mut Self)
    }

    #[inline(always)]
    fn choose_points<const FUSED: bool>(&mut self) {
        let mut open = vec![0_u32];
        while let Some(number) = open.pop() {
            // No charges, no nodes.
            let Some(node) = self.second.tree.nodes.get(number as usize).copied() else {
                return;
            };
            let distance = self
                .first
                .field
                .distance_bound(self.motion.apply(node.centre));
            // The pair may come nearer by the skin while the list serves.
            let nearest = distance - SKIN_ANGSTROM;
            // Far for the fit, beyond the near part, and certain enough: else look at its children.
            let is_far = nearest > self.opening * node.radius
                && nearest > node.radius + self.first.split.radius_angstrom as f32
                && self.node_variance(&node, distance) < NODE_VARIANCE;
            if node.second == 0 || is_far {
                self.take(&node, distance);
            } else {
                open.extend([node.second, number + 1]);
            }
        }
    }

    #[inline(always)]
    fn take(&mut self, node: &Node, distance: f32) {
        self.taken.push((*node, distance));
        self.variance += self.node_variance(node, distance);
        let range = node.first as usize..(node.first + node.count) as usize;
        let points = &self.second.tree.points[range];
        // Out of the near part's reach for as long as the list serves.
        if distance > node.radius + self.reach {
            self.far_points.extend_from_slice(points);
            return;
        }
        self.points.extend_from_slice(points);
        // Only leaves come so near: a node that stands for its charges is beyond the reach.
        if node.second == 0 {
            for point in points {
                self.list_neighbours(*point);
            }
        }
    }

    /// Variance of the energy of a node's equivalent charges, kT².
    ///
    /// Their error is of the third order of spherical harmonics: it falls with the fourth power of the
    /// distance, three of them in addition to the 1/r of the potential, and is screened with it. For
    /// random charges this is right within a factor of 2.5 up to three radii of the node. Farther out
    /// remains of the lower orders are larger, ten times at six radii, where some thousandths of it are
    /// left; the comparison of the levels scales the model. The charges of the first body that are nearest
    /// see the error with random signs; from far away, all of them see it alike.
    #[inline(always)]
    fn node_variance(&self, node: &Node, distance: f32) -> f32 {
        if node.second == 0 {
            return 0.0;
        }
        // The error was found at this distance and falls from there.
        let fitted_at = FIT_DISTANCE * node.radius;
        let potential = &self.first.split.potential;
        let screened = potential.at_square_f32::<false>(distance * distance)
            / potential.at_square_f32::<false>(fitted_at * fitted_at);
        let decay = (fitted_at / distance).powi(3) * screened;
        let tree = &self.first.tree;
        let random = tree.density * distance.min(SEEN_ANGSTROM).powi(3) / 16.0;
        let together = tree.net_charge * (distance / (distance + tree.radius)).powi(3);
        let squares = 0.12 + random + together * together;
        (node.error * decay).powi(2) * squares
    }

    #[inline(always)]
    fn list_neighbours(&mut self, point: [f32; 4]) {
        let [x, y, z, _] = point;
        let place = self.motion.apply([x, y, z]);
        let reach_square = self.reach * self.reach;
        let mut is_near = false;
        for block in self.first.neighbours.blocks(place) {
            let squares = squares(block, place);
            // A margin for the skin is in the reach, so squares are compared with it as it is.
            for lane in 0..BLOCK {
                if squares[lane] < reach_square {
                    let site = [0, 1, 2, 3].map(|row: usize| block[row][lane]);
                    self.near.add(site, point, squares[lane]);
                    is_near = true;
                }
            }
        }
        if is_near {
            self.near.include(point);
        }
    }

    fn finish(mut self, reference: &RelativePose) -> List {
        let parts = self.parts();
        let lengths = parts.iter().map(|part| part.length);
        let is_contact = !self.points.is_empty();
        let (points, far_points) = (blocks(&self.points), blocks(&self.far_points));
        self.variance += TABLE_WEIGHT * self.table_variance(&points);
        self.variance += TABLE_WEIGHT * self.table_variance(&far_points);
        List {
            reference: *reference,
            points,
            far_points,
            far_centre: centre(&self.far_points),
            expansion: OnceLock::new(),
            uses: AtomicU32::new(0),
            near: self.near.finish(),
            radius: self.second.charges.radius_angstrom() as f32,
            least_length: lengths.fold(f32::INFINITY, f32::min),
            parts: Parts::new(&parts),
            variance: f64::from(self.variance) + ROUNDING_VARIANCE,
            is_contact,
        }
    }

    fn parts(&self) -> Vec<Part> {
        let near_radius = self.first.split.radius_angstrom as f32;
        let part = |(node, distance): &(Node, f32)| {
            let gap = distance - node.radius;
            // Charges of a leaf that is not expanded hold everywhere, but those that are not listed
            // must not come near.
            let to_near = gap - near_radius;
            let room = match node.second {
                0 if gap <= self.reach => to_near,
                _ => to_near.min(PART_OF_DISTANCE * gap),
            };
            Part {
                centre: node.centre,
                radius: node.radius,
                // Even where there is hardly any room, a list
                // serves for the skin: its neighbours hold so long.
                limit: room.max(SKIN_ANGSTROM),
                length: (gap / 3.0).max(1.0),
            }
        };
        self.taken.iter().map(part).collect()
    }

    vectorised! {
        fused
        /// Variance of the energy of these points from the coarse table, kT².
        fn table_variance[variance_avx512, variance_avx2, sum_of_variances](
            self: &Self,
            blocks: &[Block]
        ) -> f32
    }

    #[inline(always)]
    fn sum_of_variances<const FUSED: bool>(&self, blocks: &[Block]) -> f32 {
        let mut variance = 0.0;
        for block in blocks {
            if let Some(spots) = self.first.field.locate(&self.motion.apply_block(block)) {
                variance += self.first.field.coarse_variance(&spots, &block[3]);
            }
        }
        variance
    }
}
