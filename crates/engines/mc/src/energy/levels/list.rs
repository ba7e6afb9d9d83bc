//! What stands for the second body of a pair while the pair has not moved far.
//!
//! The points are chosen once, at a reference pose, and kept: energies before and after a move come
//! from the same points, so that most of their errors cancel in the difference.

use super::expansion::Expansion;
use super::field::Spots;
use super::lanes::BLOCK;
use super::motion::{Block, Motion};
use super::near::NearPairs;
use super::table::Table;
use crate::prefetch::prefetch;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::vectorised;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// Number of uses of a list before its expansion is made. An expansion costs as much as half a
/// dozen energies of all points. Where cluster moves are made, many lists are used only once or
/// twice.
const USES_OF_ALL_POINTS: u32 = 2;

/// The potential beyond the reach varies over some such distance.
const EXPANSION_LENGTH_ANGSTROM: f32 = 4.0;

/// The variance of the errors' change at small moves, in units of that at large ones.
const CROSSINGS: f64 = 0.3;
/// Number of lengths over which errors vary in a turn of 1 rad: near a node, errors of equivalent
/// charges are of the third order of spherical harmonics and above.
const ERRORS_PER_RADIAN: f32 = 3.0;

/// The points of one pair.
#[derive(Debug)]
pub(super) struct List {
    pub reference: RelativePose,
    /// Points in the coarse table at every move.
    pub(super) points: Vec<Block>,
    /// Points farther away, at most moves replaced by their [`Expansion`].
    pub(super) far_points: Vec<Block>,
    pub(super) far_centre: [f32; 3],
    /// Expansion of the far points, made when the pair has moved a few times; `None` where the
    /// table ends before.
    pub(super) expansion: OnceLock<Option<Expansion>>,
    /// Number of energies found at poses other than the reference.
    pub(super) uses: AtomicU32,
    pub(super) near: NearPairs,
    /// All parts of the second body.
    pub(super) parts: Vec<Parts>,
    /// Radius of the sphere around the second body's origin that holds its charges, Å.
    pub(super) radius: f32,
    /// The least [length](Part::length) of a part, Å.
    pub(super) least_length: f32,
    /// Variance of the energy of all points by the error model, kT².
    pub variance: f64,
    /// Whether some of the points are near the first body.
    pub is_contact: bool,
}

/// A part of the second body: how far (Å) it may move, and over which distance (Å) the error of its
/// energy varies.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    pub centre: [f32; 3],
    pub radius: f32,
    pub limit: f32,
    pub length: f32,
}

/// Sixteen parts.
#[derive(Debug, Clone)]
pub(super) struct Parts {
    centre: [[f32; BLOCK]; 3],
    radius: [f32; BLOCK],
    limit: [f32; BLOCK],
    length: [f32; BLOCK],
}

impl Parts {
    /// Arranges these parts in lanes; empty lanes repeat the last.
    pub fn new(parts: &[Part]) -> Vec<Self> {
        let lanes = |parts: &[Part]| {
            let part = |lane: usize| parts[lane.min(parts.len() - 1)];
            let values = |value: fn(&Part) -> f32| std::array::from_fn(|lane| value(&part(lane)));
            Self {
                centre: [0, 1, 2].map(|axis| std::array::from_fn(|lane| part(lane).centre[axis])),
                radius: values(|part| part.radius),
                limit: values(|part| part.limit),
                length: values(|part| part.length),
            }
        };
        parts.chunks(BLOCK).map(lanes).collect()
    }

    /// Bounds on how far the parts move by a displacement, Å.
    #[inline(always)]
    fn distances(&self, displacement: &Motion) -> [f32; BLOCK] {
        let [x, y, z] = &self.centre;
        let [dx, dy, dz] = displacement.apply_lanes([x, y, z]);
        let turn = displacement.turn();
        let mut distances = [0.0; BLOCK];
        for lane in 0..BLOCK {
            let square = dx[lane] * dx[lane] + dy[lane] * dy[lane] + dz[lane] * dz[lane];
            // A part moves by its centre's displacement and at most by turn times radius.
            distances[lane] = square.sqrt() + turn * self.radius[lane];
        }
        distances
    }
}

/// The energy of a list at a pose, kT.
#[derive(Debug, Clone, Copy)]
pub(super) struct ListEnergy {
    /// Energy with the expansion in place of the far points.
    pub expanded_kt: f64,
    /// Energy without the far points.
    pub close_kt: f64,
    /// Variance of the expansion by the error model, kT².
    pub expansion_variance: f64,
}

impl List {
    /// Asks for what the energy of a pair that moves a little needs.
    pub fn prefetch(&self) {
        // The first of each: the processor's own prefetch follows an array once it has begun.
        self.parts.first().into_iter().for_each(prefetch);
        self.points.first().into_iter().for_each(prefetch);
    }

    /// Whether the points still serve at this pose.
    pub fn serves(&self, pose: &RelativePose) -> bool {
        self.slack_angstrom(pose) >= 0.0
    }

    /// Distance that every charge of the second body may move from this pose while the points
    /// serve, Å; negative where they do not.
    pub fn slack_angstrom(&self, pose: &RelativePose) -> f32 {
        self.least_slack(&Motion::between(&self.reference, pose))
    }

    /// Whether a list made where the pair is would serve where it goes.
    pub fn spans(&self, from: &RelativePose, to: &RelativePose) -> bool {
        self.least_slack(&Motion::between(from, to)) >= 0.0
    }

    vectorised! {
        fused
        fn least_slack[slack_avx512, slack_avx2, slack](self: &Self, displacement: &Motion) -> f32
    }

    #[inline(always)]
    fn slack<const FUSED: bool>(&self, displacement: &Motion) -> f32 {
        let mut least = [f32::INFINITY; BLOCK];
        for parts in &self.parts {
            let distances = parts.distances(displacement);
            for lane in 0..BLOCK {
                least[lane] = least[lane].min(parts.limit[lane] - distances[lane]);
            }
        }
        // The part with the least room decides for the whole list.
        least.into_iter().fold(f32::INFINITY, f32::min)
    }

    /// Variance of the change of the energy of all points from one pose to another by the error
    /// model, kT².
    pub fn change_variance(&self, from: &RelativePose, to: &RelativePose) -> f64 {
        self.variance * self.shift(from, to).powi(2)
    }

    /// Distance that the second body moves between two poses, in units of the lengths over which
    /// the errors of its points vary: 1 Å near the other body, more farther away; 1/3 rad
    /// everywhere.
    fn shift(&self, from: &RelativePose, to: &RelativePose) -> f64 {
        let motion = Motion::between(from, to);
        let farthest = match self.is_contact {
            true => self.farthest_in_lengths(&motion),
            // Parts that are all far away have similar lengths, and need not be looked at.
            false => motion.distance([0.0; 3], self.radius) / self.least_length,
        };
        // Whichever varies faster: the turn, or the farthest part in units of its length.
        let extent = f64::from((ERRORS_PER_RADIAN * motion.turn()).max(farthest));
        // In proportion to small moves, points cross into cells with other errors.
        // Between √x for small moves, where cells are crossed, and x for large ones.
        (extent * (extent + CROSSINGS)).sqrt()
    }

    vectorised! {
        fused
        /// Largest distance that a part moves, in units of its length.
        fn farthest_in_lengths[farthest_avx512, farthest_avx2, farthest](
            self: &Self,
            displacement: &Motion
        ) -> f32
    }

    #[inline(always)]
    fn farthest<const FUSED: bool>(&self, displacement: &Motion) -> f32 {
        let mut most = [0.0_f32; BLOCK];
        for parts in &self.parts {
            let distances = parts.distances(displacement);
            for lane in 0..BLOCK {
                most[lane] = most[lane].max(distances[lane] / parts.length[lane]);
            }
        }
        most.into_iter().fold(0.0, f32::max)
    }

    /// Relative change of the expansion's error from one pose to another.
    pub fn expansion_shift(&self, from: &RelativePose, to: &RelativePose) -> f64 {
        let step = Motion::between(from, to);
        let from_reference = [from, to].map(|pose| Motion::between(&self.reference, pose));
        let expansion = self.expansion.get().and_then(Option::as_ref);
        expansion.map_or(0.0, |expansion| {
            expansion.shift(from_reference.each_ref(), &step)
        })
    }

    /// The energy of all points at this pose; `None` where the table of the first body ends before.
    pub fn energy_of_points(&self, first: &Table, pose: &RelativePose) -> Option<ListEnergy> {
        let close_kt = self.close_energy(first, pose)?;
        Some(ListEnergy {
            expanded_kt: close_kt + self.far_energy(first, pose)?,
            close_kt,
            expansion_variance: 0.0,
        })
    }

    /// The energy at this pose, with the expansion in place of the far points once the list has
    /// been used a few times.
    pub fn energy(&self, first: &Table, pose: &RelativePose) -> Option<ListEnergy> {
        // Relaxed: it counts, and orders nothing. Who
        // makes the expansion does not change its value.
        let uses = self.uses.fetch_add(1, Ordering::Relaxed);
        match self.far_points.is_empty() || uses < USES_OF_ALL_POINTS {
            true => self.energy_of_points(first, pose),
            false => self.expanded_energy(first, pose),
        }
    }

    /// The energy at this pose with the expansion in place of the far points.
    pub fn expanded_energy(&self, first: &Table, pose: &RelativePose) -> Option<ListEnergy> {
        let Some(expansion) = self.expansion.get_or_init(|| self.expand(first)) else {
            return self.energy_of_points(first, pose);
        };
        let motion = Motion::between(&self.reference, pose);
        let close_kt = self.close_energy(first, pose)?;
        // Near points stay exact: a quadratic form serves only what varies slowly.
        Some(ListEnergy {
            expanded_kt: close_kt + f64::from(expansion.energy_kt(&motion)),
            close_kt,
            expansion_variance: expansion.variance(&motion),
        })
    }

    fn expand(&self, first: &Table) -> Option<Expansion> {
        let reference = Motion::new(&self.reference);
        let (centre, points) = (self.far_centre, &self.far_points);
        match points[..] {
            [] => None,
            _ => Expansion::new(
                &first.field,
                &reference,
                centre,
                points,
                EXPANSION_LENGTH_ANGSTROM,
            ),
        }
    }

    fn close_energy(&self, first: &Table, pose: &RelativePose) -> Option<f64> {
        self.points_energy(first, &self.points, Some(&self.near), pose)
    }

    /// The energy of the far points at this pose, kT; `None` where the table of the first body ends
    /// before.
    pub fn far_energy(&self, first: &Table, pose: &RelativePose) -> Option<f64> {
        self.points_energy(first, &self.far_points, None, pose)
    }

    fn points_energy(
        &self,
        first: &Table,
        points: &[Block],
        near: Option<&NearPairs>,
        pose: &RelativePose,
    ) -> Option<f64> {
        match points {
            [] => Some(0.0),
            _ => self.sum_of_points(first, points, near, pose),
        }
    }

    vectorised! {
        fused
        fn sum_of_points[sum_avx512, sum_avx2, sum](
            self: &Self,
            first: &Table,
            points: &[Block],
            near: Option<&NearPairs>,
            pose: &RelativePose
        ) -> Option<f64>
    }

    /// The points' energy in the coarse table, and that of the near pairs.
    #[inline(always)]
    fn sum<const FUSED: bool>(
        &self,
        first: &Table,
        points: &[Block],
        near: Option<&NearPairs>,
        pose: &RelativePose,
    ) -> Option<f64> {
        let motion = Motion::new(pose);
        let mut sum = [0.0_f32; BLOCK];
        let mut waiting: Option<(Spots, &[f32; BLOCK])> = None;
        // One turn more than there are blocks: the last turn only adds what is waiting.
        for block in points.iter().map(Some).chain([None]) {
            let mut next = None;
            if let Some(block) = block {
                let spots = first.field.locate(&motion.apply_block(block))?;
                first.field.prefetch_coarse(&spots);
                next = Some((spots, &block[3]));
            }
            // While the series of the next points come, those before are added.
            if let Some((spots, charge)) = std::mem::replace(&mut waiting, next) {
                first.field.add_coarse::<FUSED>(&spots, charge, &mut sum);
            }
        }
        if let Some(near) = near {
            let from_reference = Motion::between(&self.reference, pose);
            near.add::<FUSED>(&first.split, &motion, &from_reference, &mut sum);
        }
        // Sixteen sums in single precision, joined in double.
        Some(sum.iter().map(|part| f64::from(*part)).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;
    use protomer_kernel::{Pose, Vec3};

    #[test]
    fn sixteen_parts_move_as_each_alone() {
        let mut rng = CounterRng::new(41, 0, 0);
        let part = |rng: &mut CounterRng| {
            let centre: Vec3 = rng.vector_in_ball(30.0);
            Part {
                centre: centre.map(|x| x as f32).into(),
                radius: rng.uniform_in(0.0, 9.0) as f32,
                limit: rng.uniform_in(0.5, 4.0) as f32,
                length: rng.uniform_in(1.0, 8.0) as f32,
            }
        };
        let parts: Vec<Part> = (0..37).map(|_| part(&mut rng)).collect();
        let lanes = Parts::new(&parts);
        let relative = |pose: Pose| RelativePose::from(&pose);
        for _ in 0..50 {
            let rotation = rng.rotation();
            let from = Pose {
                position: rng.vector_in_ball(40.0),
                rotation,
            };
            let to = Pose {
                position: from.position + rng.vector_in_ball(1.0),
                rotation: rng.small_rotation(0.1) * rotation,
            };
            let displacement = Motion::between(&relative(from), &relative(to));
            for (number, parts) in parts.chunks(BLOCK).enumerate() {
                let distances = lanes[number].distances(&displacement);
                for lane in 0..BLOCK {
                    let part = parts[lane.min(parts.len() - 1)];
                    let alone = displacement.distance(part.centre, part.radius);
                    assert!((distances[lane] - alone).abs() < 1e-5, "{lane} {alone}");
                    assert_eq!(lanes[number].limit[lane], part.limit);
                    assert_eq!(lanes[number].length[lane], part.length);
                }
            }
        }
    }
}
