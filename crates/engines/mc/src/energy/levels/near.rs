//! Pairs of charges of two bodies that are near each other, or may come near while a list serves.
//!
//! Most of them are beyond the near part's range R at most poses. Pairs are in groups by their
//! distance at the list's reference pose: one that was D apart is at least D - m apart after its
//! charge has moved by m, so that groups with D ≥ R + m add nothing.

use super::lanes::BLOCK;
use super::motion::{Motion, length};
use super::split::Split;
use protomer_kernel::pose::RelativePose;

/// Groups of pairs that are out of range at the reference pose.
const GROUPS: usize = 4;

/// Room for so many pairs of each group is made at once.
const EXPECTED: usize = 256;

/// Sixteen pairs: places in the second body (x, y, z) and in the first, each in its own frame, Å;
/// products of the charges, e².
type Pairs = [[f32; BLOCK]; PARTS];
const PARTS: usize = 7;

/// The near pairs of a list.
#[derive(Debug, Clone, Default)]
pub(super) struct NearPairs {
    /// Blocks of pairs, ascending by their least distance (Å) at the reference pose.
    blocks: Vec<(f32, Pairs)>,
    /// A sphere around all charges of the second body among them.
    centre: [f32; 3],
    radius: f32,
}

/// Collects the pairs of a list.
#[derive(Debug)]
pub(super) struct NearMaker {
    /// R², by how much (Å²) squared distances of the next groups are larger, and its inverse.
    near_square: f32,
    width_square: f32,
    inverse_width: f32,
    groups: [Vec<[f32; PARTS]>; GROUPS + 1],
    low: [f32; 3],
    high: [f32; 3],
}

impl NearMaker {
    /// A maker for pairs that are less than `skin` (Å) out of the near part's range.
    pub fn new(near_radius: f32, skin: f32) -> Self {
        let near_square = near_radius * near_radius;
        let width_square = ((near_radius + skin).powi(2) - near_square) / GROUPS as f32;
        Self {
            near_square,
            width_square,
            inverse_width: width_square.recip(),
            groups: std::array::from_fn(|_| Vec::with_capacity(EXPECTED)),
            low: [f32::INFINITY; 3],
            high: [f32::NEG_INFINITY; 3],
        }
    }

    /// Adds a pair of charges (Å, e), each in its body's frame, with the square of their distance;
    /// the second must be [included](Self::include).
    #[inline(always)]
    pub fn add(&mut self, first: [f32; 4], second: [f32; 4], square: f32) {
        let [x, y, z, charge] = second;
        let [sx, sy, sz, source] = first;
        // In squared distances, so no root is taken per pair.
        let beyond = (square - self.near_square) * self.inverse_width;
        // Those in range are below zero.
        let group = ((beyond + 1.0).max(0.0) as usize).min(GROUPS);
        // Group 0 is within range now; group g > 0 begins at R² + (g - 1) w.
        self.groups[group].push([x, y, z, sx, sy, sz, charge * source]);
    }

    /// Includes a charge of the second body that is among the pairs.
    #[inline(always)]
    pub fn include(&mut self, [x, y, z, _]: [f32; 4]) {
        for (axis, place) in [x, y, z].into_iter().enumerate() {
            self.low[axis] = self.low[axis].min(place);
            self.high[axis] = self.high[axis].max(place);
        }
    }

    pub fn finish(self) -> NearPairs {
        let mut pairs = NearPairs::default();
        if self.groups.iter().all(Vec::is_empty) {
            return pairs;
        }
        for (group, members) in self.groups.iter().enumerate() {
            let distance = match group {
                0 => 0.0,
                // The least distance that a member of this group has: its lower border.
                _ => (self.near_square + (group - 1) as f32 * self.width_square).sqrt(),
            };
            let blocks = members.chunks(BLOCK);
            pairs
                .blocks
                .extend(blocks.map(|block| (distance, lanes(block))));
        }
        // A box, then its sphere: cheaper than the smallest sphere, and always a bound.
        pairs.centre = [0, 1, 2].map(|axis: usize| (self.low[axis] + self.high[axis]) / 2.0);
        let diagonal = [0, 1, 2].map(|axis: usize| self.high[axis] - self.low[axis]);
        pairs.radius = length(diagonal) / 2.0;
        pairs
    }
}

/// Pairs in lanes; empty ones repeat the last pair without charges.
fn lanes(pairs: &[[f32; PARTS]]) -> Pairs {
    let mut block = [[0.0; BLOCK]; PARTS];
    for lane in 0..BLOCK {
        for (part, value) in pairs[lane.min(pairs.len() - 1)].into_iter().enumerate() {
            block[part][lane] = value;
        }
        if lane >= pairs.len() {
            block[PARTS - 1][lane] = 0.0;
        }
    }
    block
}

impl NearPairs {
    /// The blocks that may have a pair in range after this motion from the reference pose.
    #[inline(always)]
    fn in_range(&self, near_radius: f32, from_reference: &Motion) -> impl Iterator<Item = &Pairs> {
        let reach = near_radius + from_reference.distance(self.centre, self.radius);
        // Ascending, so the first group out of range ends the loop.
        let near = self.blocks.iter().take_while(move |block| block.0 < reach);
        near.map(|block| &block.1)
    }

    /// Adds the pairs' near energies at a pose to the lanes of `sum`, kT.
    #[inline(always)]
    pub fn add<const FUSED: bool>(
        &self,
        split: &Split,
        motion: &Motion,
        from_reference: &Motion,
        sum: &mut [f32; BLOCK],
    ) {
        for block in self.in_range(split.radius_angstrom as f32, from_reference) {
            let [x, y, z, sx, sy, sz, product] = block;
            let [mx, my, mz] = motion.apply_lanes([x, y, z]);
            // No test of the distance per pair: `near_f32` is zero beyond R.
            for lane in 0..BLOCK {
                let (dx, dy, dz) = (
                    mx[lane] - sx[lane],
                    my[lane] - sy[lane],
                    mz[lane] - sz[lane],
                );
                sum[lane] += product[lane] * split.near_f32::<FUSED>(dx * dx + dy * dy + dz * dz);
            }
        }
    }

    /// The pairs' near energies at a pose in double precision, kT.
    #[inline(always)]
    pub fn energy_kt(&self, split: &Split, pose: &RelativePose, from_reference: &Motion) -> f64 {
        let mut sum = [0.0_f64; BLOCK];
        let (r, t) = (&pose.rotation, &pose.translation);
        for block in self.in_range(split.radius_angstrom as f32, from_reference) {
            let [x, y, z, sx, sy, sz, product] = block;
            for lane in 0..BLOCK {
                let (x, y, z) = (f64::from(x[lane]), f64::from(y[lane]), f64::from(z[lane]));
                let coordinate =
                    |axis: usize| r[(axis, 0)] * x + r[(axis, 1)] * y + r[(axis, 2)] * z + t[axis];
                let (dx, dy, dz) = (
                    coordinate(0) - f64::from(sx[lane]),
                    coordinate(1) - f64::from(sy[lane]),
                    coordinate(2) - f64::from(sz[lane]),
                );
                let near = split.near(dx * dx + dy * dy + dz * dz);
                sum[lane] += f64::from(product[lane]) * near;
            }
        }
        sum.iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::potential::Yukawa;
    use protomer_kernel::random::CounterRng;
    use protomer_kernel::{Pose, Vec3};

    #[test]
    fn groups_left_out_add_nothing() {
        const SKIN: f32 = 2.0;
        let split = Split::new(Yukawa::uncut(7.0, 1.0 / 9.6).unwrap(), 3.0);
        let mut rng = CounterRng::new(21, 0, 0);
        let reference = Pose {
            position: Vec3::new(4.0, -3.0, 2.0),
            rotation: rng.rotation(),
        };
        let mut maker = NearMaker::new(3.0, SKIN);
        let mut charges = Vec::new();
        for _ in 0..400 {
            let second: Vec3 = rng.vector_in_ball(6.0);
            let moved = reference.transform_point(&second);
            let first = moved + rng.unit_vector() * rng.uniform_in(0.8, 5.0);
            let charges_e = [rng.uniform_in(-1.0, 1.0), rng.uniform_in(-1.0, 1.0)];
            let row = |x: Vec3, charge: f64| [x.x, x.y, x.z, charge].map(|x| x as f32);
            let square = (first - moved).norm_squared() as f32;
            maker.add(row(first, charges_e[0]), row(second, charges_e[1]), square);
            maker.include(row(second, charges_e[1]));
            charges.push((first, second, charges_e[0] * charges_e[1]));
        }
        let pairs = maker.finish();
        let mut left_out = 0;
        for case in 0..60 {
            let step_angstrom = 0.03 * f64::from(case);
            let pose = Pose {
                position: reference.position + rng.unit_vector() * step_angstrom,
                rotation: rng.small_rotation(0.02) * reference.rotation,
            };
            let direct = charges.iter().map(|(first, second, product)| {
                product * split.near((pose.transform_point(second) - first).norm_squared())
            });
            let direct: f64 = direct.sum();
            let (from, to) = (RelativePose::from(&reference), RelativePose::from(&pose));
            let from_reference = Motion::between(&from, &to);
            let fine = pairs.energy_kt(&split, &to, &from_reference);
            let mut sum = [0.0; BLOCK];
            pairs.add::<true>(&split, &Motion::new(&to), &from_reference, &mut sum);
            let single = f64::from(sum.iter().sum::<f32>());
            assert!((fine - direct).abs() < 2e-4, "{case}: {fine} {direct}");
            assert!((single - direct).abs() < 1e-3, "{case}: {single} {direct}");
            left_out += pairs.blocks.len() - pairs.in_range(3.0, &from_reference).count();
        }
        assert!(left_out > 60, "{left_out}");
    }
}
