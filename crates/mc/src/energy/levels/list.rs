//! What stands for the second body of a pair while the pair has not moved far.
//!
//! The points are chosen once, at a reference pose, and kept: energies before and after a move come
//! from the same points, so that most of their errors cancel in the difference.

use super::field::BLOCK;
use super::table::Table;
use super::tree::{FIT_DISTANCE, Node};
use crate::energy::SitePotential;
use protomer_kernel::Vec3;
use protomer_kernel::pose::RelativePose;

/// How far (Å) points near the other body may have moved before new ones are chosen; charges that
/// can come within the near part's range until then are listed.
pub(super) const SKIN_ANGSTROM: f32 = 1.9;
/// Points farther away may move by this part of their distance.
const PART_OF_DISTANCE: f32 = 0.4;

/// A node stands for its charges where that costs less than this variance, kT².
const NODE_VARIANCE: f32 = 3e-5;

/// Errors of a table at points of one cell add up: so much more variance than if they did not.
const TABLE_WEIGHT: f32 = 10.0;

/// Charges farther than this behind the nearest ones hardly see a node's error, Å.
const SEEN_ANGSTROM: f32 = 8.0;

/// Points in arrays of 16: x, y, z (Å) and charge (e).
pub(super) type Block = [[f32; BLOCK]; 4];
const EMPTY: Block = [[0.0; BLOCK]; 4];

/// The points of one pair.
#[derive(Debug, Clone)]
pub(super) struct List {
    pub reference: RelativePose,
    points: Vec<Block>,
    near: Vec<Near>,
    sources: Vec<Block>,
    /// The part of the second body that must not move far: centre, radius and how far, Å.
    guard: Guard,
    /// Variance of the energy by the error model, kT².
    pub variance: f64,
}

/// A charge of the second body with the charges of the first that are near it.
#[derive(Debug, Clone, Copy)]
struct Near {
    at: [f32; 4],
    first: u32,
    count: u32,
}

#[derive(Debug, Clone, Copy)]
struct Guard {
    centre: [f32; 3],
    radius: f32,
    limit: f32,
    length: f32,
}

/// A relative pose in single precision.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion {
    r: [[f32; 3]; 3],
    t: [f32; 3],
}

impl Motion {
    pub fn new(pose: &RelativePose) -> Self {
        let r = [0, 1, 2].map(|i| [0, 1, 2].map(|j| pose.rotation[(i, j)] as f32));
        let t = [0, 1, 2].map(|i| pose.translation[i] as f32);
        Self { r, t }
    }

    #[inline(always)]
    pub fn apply(&self, x: [f32; 3]) -> [f32; 3] {
        let [a, b, c] = self.r;
        let along = |row: [f32; 3], t: f32| row[0] * x[0] + row[1] * x[1] + row[2] * x[2] + t;
        [
            along(a, self.t[0]),
            along(b, self.t[1]),
            along(c, self.t[2]),
        ]
    }

    #[inline(always)]
    pub fn apply_block(&self, block: &Block) -> [[f32; BLOCK]; 3] {
        let [x, y, z, _] = block;
        let along = |[a, b, c]: [f32; 3], t: f32| {
            let mut moved = [t; BLOCK];
            for lane in 0..BLOCK {
                moved[lane] += a * x[lane];
            }
            for lane in 0..BLOCK {
                moved[lane] += b * y[lane];
            }
            for lane in 0..BLOCK {
                moved[lane] += c * z[lane];
            }
            moved
        };
        [
            along(self.r[0], self.t[0]),
            along(self.r[1], self.t[1]),
            along(self.r[2], self.t[2]),
        ]
    }
}

impl List {
    /// The points of the second body for this pose, nodes standing for charges where they are
    /// farther than `opening` of their radii from the charges of the first and their error is small.
    pub fn new<P: SitePotential>(
        first: &Table<P>,
        second: &Table<P>,
        reference: &RelativePose,
        opening: f32,
    ) -> Self {
        let motion = Motion::new(reference);
        let reach = first.split.radius_angstrom as f32 + SKIN_ANGSTROM;
        let mut maker = Maker {
            first,
            second,
            motion,
            reach,
            opening,
            points: Vec::new(),
            near: Vec::new(),
            sources: Vec::new(),
            least_distance: f32::INFINITY,
            variance: 0.0,
        };
        maker.choose();
        maker.finish(reference)
    }

    /// Whether the points still serve at this pose.
    pub fn serves(&self, pose: &RelativePose) -> bool {
        let (was, is) = (&self.reference, pose);
        let turn = is.rotation - was.rotation;
        let centre = nalgebra::Vector3::from(self.guard.centre.map(f64::from));
        let shift = turn * centre + is.translation - was.translation;
        // A turn by φ has Frobenius norm 2√2 sin(φ/2) and moves points by 2 sin(φ/2) of their distance.
        let turned = turn.norm() * std::f64::consts::FRAC_1_SQRT_2 * f64::from(self.guard.radius);
        shift.norm() + turned <= f64::from(self.guard.limit)
    }

    /// How far the part near the other body moves between two poses, in units of the length over
    /// which the errors of its points vary: 1 Å near the other body, more farther away.
    pub fn shift(&self, from: &RelativePose, to: &RelativePose) -> f64 {
        let turn = to.rotation - from.rotation;
        let centre = nalgebra::Vector3::from(self.guard.centre.map(f64::from));
        let shift = turn * centre + to.translation - from.translation;
        let turned = turn.norm() * std::f64::consts::FRAC_1_SQRT_2 * f64::from(self.guard.radius);
        (shift.norm() + turned) / f64::from(self.guard.length)
    }

    /// The energy at this pose, kT; `None` where the table of the first body ends before.
    pub fn energy<P: SitePotential>(&self, first: &Table<P>, pose: &RelativePose) -> Option<f64> {
        #[cfg(target_arch = "x86_64")]
        if has_wide_vectors() {
            // SAFETY: the processor has the features the function is compiled for.
            return unsafe { self.energy_avx512(first, pose) };
        }
        self.sum::<P, false>(first, pose)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,fma")]
    fn energy_avx512<P: SitePotential>(
        &self,
        first: &Table<P>,
        pose: &RelativePose,
    ) -> Option<f64> {
        self.sum::<P, true>(first, pose)
    }

    #[inline(always)]
    fn sum<P: SitePotential, const FUSED: bool>(
        &self,
        first: &Table<P>,
        pose: &RelativePose,
    ) -> Option<f64> {
        let motion = Motion::new(pose);
        let mut sum = [0.0_f32; BLOCK];
        for block in &self.points {
            let spots = first.field.locate(&motion.apply_block(block))?;
            first.field.add_coarse::<FUSED>(&spots, &block[3], &mut sum);
        }
        for near in &self.near {
            let [x, y, z, charge] = near.at;
            let [x, y, z] = motion.apply([x, y, z]);
            let range = near.first as usize..(near.first + near.count) as usize;
            for [sx, sy, sz, source] in &self.sources[range] {
                for lane in 0..BLOCK {
                    let (dx, dy, dz) = (x - sx[lane], y - sy[lane], z - sz[lane]);
                    let near = first.split.near_f32(dx * dx + dy * dy + dz * dz);
                    sum[lane] += charge * source[lane] * near;
                }
            }
        }
        Some(sum.iter().map(|part| f64::from(*part)).sum())
    }
}

impl List {
    /// The near part of the energy at this pose in double precision, kT.
    #[inline(always)]
    pub fn near_energy<P: SitePotential>(&self, first: &Table<P>, pose: &RelativePose) -> f64 {
        let mut sum = [0.0_f64; BLOCK];
        for near in &self.near {
            let [x, y, z, charge] = near.at.map(f64::from);
            let at = pose.transform_point(&Vec3::new(x, y, z));
            let range = near.first as usize..(near.first + near.count) as usize;
            for [sx, sy, sz, source] in &self.sources[range] {
                for lane in 0..BLOCK {
                    let dx = at.x - f64::from(sx[lane]);
                    let dy = at.y - f64::from(sy[lane]);
                    let dz = at.z - f64::from(sz[lane]);
                    let near = first.split.near(dx * dx + dy * dy + dz * dz);
                    sum[lane] += charge * f64::from(source[lane]) * near;
                }
            }
        }
        sum.iter().sum()
    }
}

/// Whether the processor has the vectors that the fast paths of tables are compiled for.
#[cfg(target_arch = "x86_64")]
pub(super) fn has_wide_vectors() -> bool {
    is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("fma")
}

/// Points in arrays; empty lanes repeat the last place without a charge.
pub(super) fn blocks(points: &[[f32; 4]]) -> Vec<Block> {
    let block = |points: &[[f32; 4]]| {
        let mut block = EMPTY;
        for lane in 0..BLOCK {
            let [x, y, z, charge] = points[lane.min(points.len() - 1)];
            let charge = if lane < points.len() { charge } else { 0.0 };
            (block[0][lane], block[1][lane], block[2][lane]) = (x, y, z);
            block[3][lane] = charge;
        }
        block
    };
    points.chunks(BLOCK).map(block).collect()
}

/// Chooses the points of a list.
struct Maker<'a, P> {
    first: &'a Table<P>,
    second: &'a Table<P>,
    motion: Motion,
    reach: f32,
    opening: f32,
    points: Vec<[f32; 4]>,
    near: Vec<Near>,
    sources: Vec<Block>,
    least_distance: f32,
    variance: f32,
}

impl<P: SitePotential> Maker<'_, P> {
    fn choose(&mut self) {
        let mut open = vec![0_u32];
        while let Some(number) = open.pop() {
            let Some(node) = self.second.tree.nodes.get(number as usize).copied() else {
                return;
            };
            let distance = self
                .first
                .field
                .distance_bound(self.motion.apply(node.centre));
            let is_far = distance > self.opening * node.radius
                && distance > node.radius + 0.7 * self.first.split.radius_angstrom as f32
                && self.node_variance(&node, distance) < NODE_VARIANCE;
            if node.second == 0 || is_far {
                self.take(&node, distance);
            } else {
                open.extend([node.second, number + 1]);
            }
        }
    }

    fn take(&mut self, node: &Node, distance: f32) {
        self.least_distance = self.least_distance.min(distance - node.radius);
        self.variance += self.node_variance(node, distance);
        let range = node.first as usize..(node.first + node.count) as usize;
        let points = &self.second.tree.points[range];
        self.points.extend_from_slice(points);
        if node.second == 0 && distance < node.radius + self.reach {
            for point in points {
                self.list_neighbours(*point);
            }
        }
    }

    /// The error of a node's potential falls with a high power of the distance, and the charges of
    /// the first body that are nearest see it with random signs.
    fn node_variance(&self, node: &Node, distance: f32) -> f32 {
        if node.second == 0 {
            return 0.0;
        }
        let decay = (FIT_DISTANCE * node.radius / distance).powi(4);
        let squares = 0.12 + self.first.tree.density * distance.min(SEEN_ANGSTROM).powi(3) / 16.0;
        (node.error * decay).powi(2) * squares
    }

    fn list_neighbours(&mut self, point: [f32; 4]) {
        let [x, y, z, _] = point;
        let at = self.motion.apply([x, y, z]);
        let first = self.sources.len();
        let mut filled = BLOCK;
        for site in self.first.neighbours.of(at) {
            let d = [site[0] - at[0], site[1] - at[1], site[2] - at[2]];
            if d[0] * d[0] + d[1] * d[1] + d[2] * d[2] < self.reach * self.reach {
                if filled == BLOCK {
                    self.sources.push(EMPTY);
                    filled = 0;
                }
                if let Some(block) = self.sources.last_mut() {
                    (0..4).for_each(|part| block[part][filled] = site[part]);
                }
                filled += 1;
            }
        }
        let count = self.sources.len() - first;
        if count > 0 {
            self.near.push(Near {
                at: point,
                first: first as u32,
                count: count as u32,
            });
        }
    }

    fn finish(mut self, reference: &RelativePose) -> List {
        let guard = self.guard();
        let blocks = blocks(&self.points);
        self.variance += TABLE_WEIGHT * self.table_variance(&blocks);
        List {
            reference: *reference,
            points: blocks,
            near: self.near,
            sources: self.sources,
            guard,
            variance: f64::from(self.variance),
        }
    }

    /// What must not move far: the charges near the first body; where there are none, everything.
    fn guard(&self) -> Guard {
        let near = self
            .near
            .iter()
            .map(|near| [near.at[0], near.at[1], near.at[2]]);
        let mut low = [f32::INFINITY; 3];
        let mut high = [f32::NEG_INFINITY; 3];
        for at in near {
            for axis in 0..3 {
                (low[axis], high[axis]) = (low[axis].min(at[axis]), high[axis].max(at[axis]));
            }
        }
        if self.near.is_empty() {
            let root = self.second.tree.nodes.first();
            return Guard {
                centre: root.map_or([0.0; 3], |root| root.centre),
                radius: root.map_or(0.0, |root| root.radius),
                limit: SKIN_ANGSTROM.max(PART_OF_DISTANCE * self.least_distance),
                length: (self.least_distance / 3.0).max(1.0),
            };
        }
        let half = [0, 1, 2].map(|axis| (high[axis] - low[axis]) / 2.0);
        Guard {
            centre: [0, 1, 2].map(|axis| (low[axis] + high[axis]) / 2.0),
            radius: (half[0] * half[0] + half[1] * half[1] + half[2] * half[2]).sqrt(),
            limit: SKIN_ANGSTROM,
            length: 1.0,
        }
    }

    fn table_variance(&self, blocks: &[Block]) -> f32 {
        let mut variance = 0.0;
        for block in blocks {
            if let Some(spots) = self.first.field.locate(&self.motion.apply_block(block)) {
                variance += self.first.field.coarse_variance(&spots, &block[3]);
            }
        }
        variance
    }
}
