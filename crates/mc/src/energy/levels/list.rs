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

/// How far (Å) points may have moved before new ones are chosen; charges that can come within the
/// near part's range until then are listed, and nodes hold until then.
pub(super) const SKIN_ANGSTROM: f32 = 2.2;
/// Points farther away may move by this part of their distance.
const PART_OF_DISTANCE: f32 = 0.3;

/// Of single precision, kT².
const ROUNDING_VARIANCE: f64 = 1e-9;

/// The variance of the errors' change at small moves, in units of that at large ones.
const CROSSINGS: f64 = 0.3;

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
    /// All parts of the second body.
    parts: Vec<Part>,
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

/// A part of the second body: how far (Å) it may move, and over which distance (Å) the error of its
/// energy varies.
#[derive(Debug, Clone, Copy)]
struct Part {
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

    /// The displacement of every point from one pose to another.
    fn between(from: &RelativePose, to: &RelativePose) -> Self {
        Self::new(&RelativePose {
            rotation: to.rotation - from.rotation,
            translation: to.translation - from.translation,
        })
    }

    /// A bound on how far a part moves by a [displacement](Self::between), Å.
    #[inline(always)]
    fn distance(&self, part: &Part) -> f32 {
        let length = |[x, y, z]: [f32; 3]| (x * x + y * y + z * z).sqrt();
        let turn = self
            .r
            .iter()
            .map(|row| row[0] * row[0] + row[1] * row[1] + row[2] * row[2]);
        // A turn by φ has Frobenius norm 2√2 sin(φ/2) and moves points by 2 sin(φ/2) of their distance.
        let turned = (turn.sum::<f32>() / 2.0).sqrt() * part.radius;
        length(self.apply(part.centre)) + turned
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
            taken: Vec::new(),
            variance: 0.0,
        };
        maker.choose();
        maker.finish(reference)
    }

    /// Whether the points still serve at this pose.
    pub fn serves(&self, pose: &RelativePose) -> bool {
        let motion = Motion::between(&self.reference, pose);
        self.parts
            .iter()
            .all(|part| motion.distance(part) <= part.limit)
    }

    /// How far the second body moves between two poses, in units of the lengths over which the
    /// errors of its points vary: 1 Å near the other body, more farther away.
    pub fn shift(&self, from: &RelativePose, to: &RelativePose) -> f64 {
        let motion = Motion::between(from, to);
        let lengths = self
            .parts
            .iter()
            .map(|part| motion.distance(part) / part.length);
        let moved = f64::from(lengths.fold(0.0, f32::max));
        // In proportion to small moves, points cross into cells with other errors.
        (moved * (moved + CROSSINGS)).sqrt()
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
    /// Nodes with the distance of their centres from the first body.
    taken: Vec<(Node, f32)>,
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
            let nearest = distance - SKIN_ANGSTROM;
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

    fn take(&mut self, node: &Node, distance: f32) {
        self.taken.push((*node, distance));
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

    /// The error of a node's potential falls with a high power of the distance. The charges of the
    /// first body that are nearest see it with random signs; from far away, all of them see it alike.
    fn node_variance(&self, node: &Node, distance: f32) -> f32 {
        if node.second == 0 {
            return 0.0;
        }
        let fitted_at = FIT_DISTANCE * node.radius;
        let potential = &self.first.split.potential;
        let screened = potential.at_square_f32(distance * distance)
            / potential.at_square_f32(fitted_at * fitted_at);
        let decay = (fitted_at / distance).powi(3) * screened;
        let seen = &self.first.tree;
        let random = seen.density * distance.min(SEEN_ANGSTROM).powi(3) / 16.0;
        let together = seen.net_charge * (distance / (distance + seen.radius)).powi(3);
        let squares = 0.12 + random + together * together;
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
        let parts = self.parts();
        let blocks = blocks(&self.points);
        self.variance += TABLE_WEIGHT * self.table_variance(&blocks);
        List {
            reference: *reference,
            points: blocks,
            near: self.near,
            sources: self.sources,
            parts,
            variance: f64::from(self.variance) + ROUNDING_VARIANCE,
        }
    }

    fn parts(&self) -> Vec<Part> {
        let near_radius = self.first.split.radius_angstrom as f32;
        let part = |(node, distance): &(Node, f32)| {
            let gap = distance - node.radius;
            // Charges of a leaf hold everywhere, but those that are not listed must not come near.
            let to_near = gap - near_radius;
            let room = match node.second {
                0 => to_near,
                _ => to_near.min(PART_OF_DISTANCE * gap),
            };
            Part {
                centre: node.centre,
                radius: node.radius,
                limit: room.max(SKIN_ANGSTROM),
                length: (gap / 3.0).max(1.0),
            }
        };
        self.taken.iter().map(part).collect()
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
