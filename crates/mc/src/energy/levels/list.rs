//! What stands for the second body of a pair while the pair has not moved far.
//!
//! The points are chosen once, at a reference pose, and kept: energies before and after a move come
//! from the same points, so that most of their errors cancel in the difference.

use super::expansion::Expansion;
use super::field::Spots;
use super::lanes::{BLOCK, vectorised};
use super::motion::{Block, Motion};
use super::near::NearPairs;
use super::table::Table;
use crate::energy::SitePotential;
use protomer_kernel::pose::RelativePose;

/// The variance of the errors' change at small moves, in units of that at large ones.
const CROSSINGS: f64 = 0.3;
/// Errors of equivalent charges are of the third order of spherical harmonics and above.
const ERRORS_PER_RADIAN: f32 = 3.0;

/// The points of one pair.
#[derive(Debug, Clone)]
pub(super) struct List {
    pub reference: RelativePose,
    /// Points in the coarse table at every move.
    pub(super) points: Vec<Block>,
    /// Points farther away, at most moves replaced by their [`Expansion`].
    pub(super) far_points: Vec<Block>,
    pub(super) expansion: Option<Expansion>,
    pub(super) near: NearPairs,
    /// All parts of the second body.
    pub(super) parts: Vec<Part>,
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

/// The energy of a list at a pose, kT.
#[derive(Debug, Clone, Copy)]
pub(super) struct ListEnergy {
    /// With the expansion in place of the far points.
    pub expanded_kt: f64,
    /// Without the far points.
    pub close_kt: f64,
    /// Variance of the expansion by the error model, kT².
    pub expansion_variance: f64,
}

impl List {
    /// Whether the points still serve at this pose.
    pub fn serves(&self, pose: &RelativePose) -> bool {
        let motion = Motion::between(&self.reference, pose);
        self.parts
            .iter()
            .all(|part| motion.distance(part.centre, part.radius) <= part.limit)
    }

    /// Variance of the change of the energy of all points from one pose to another by the error
    /// model, kT².
    pub fn change_variance(&self, from: &RelativePose, to: &RelativePose) -> f64 {
        self.variance * self.shift(from, to).powi(2)
    }

    /// How far the second body moves between two poses, in units of the lengths over which the
    /// errors of its points vary: 1 Å near the other body, more farther away; 1/3 rad everywhere.
    fn shift(&self, from: &RelativePose, to: &RelativePose) -> f64 {
        let motion = Motion::between(from, to);
        let lengths = self
            .parts
            .iter()
            .map(|part| motion.distance(part.centre, part.radius) / part.length);
        let moved = f64::from(lengths.fold(ERRORS_PER_RADIAN * motion.turn(), f32::max));
        // In proportion to small moves, points cross into cells with other errors.
        (moved * (moved + CROSSINGS)).sqrt()
    }

    /// How much of the expansion's error changes from one pose to another.
    pub fn expansion_shift(&self, from: &RelativePose, to: &RelativePose) -> f64 {
        let step = Motion::between(from, to);
        let from_reference = [from, to].map(|pose| Motion::between(&self.reference, pose));
        let expansion = self.expansion.as_ref();
        expansion.map_or(0.0, |expansion| {
            expansion.shift(from_reference.each_ref(), &step)
        })
    }

    /// The energy at this pose; `None` where the table of the first body ends before.
    pub fn energy<P: SitePotential>(
        &self,
        first: &Table<P>,
        pose: &RelativePose,
    ) -> Option<ListEnergy> {
        let close_kt = self.points_energy(first, &self.points, Some(&self.near), pose)?;
        let mut energy = ListEnergy {
            expanded_kt: close_kt,
            close_kt,
            expansion_variance: 0.0,
        };
        if let Some(expansion) = &self.expansion {
            let motion = Motion::between(&self.reference, pose);
            energy.expanded_kt += f64::from(expansion.energy_kt(&motion));
            energy.expansion_variance = expansion.variance(&motion);
        }
        Some(energy)
    }

    /// The energy of the far points at this pose, kT; `None` where the table of the first body ends
    /// before.
    pub fn far_energy<P: SitePotential>(
        &self,
        first: &Table<P>,
        pose: &RelativePose,
    ) -> Option<f64> {
        self.points_energy(first, &self.far_points, None, pose)
    }

    fn points_energy<P: SitePotential>(
        &self,
        first: &Table<P>,
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
        fn sum_of_points[sum_avx512, sum_avx2, sum]<P: SitePotential>(
            self: &Self,
            first: &Table<P>,
            points: &[Block],
            near: Option<&NearPairs>,
            pose: &RelativePose
        ) -> Option<f64>
    }

    /// The points' energy in the coarse table, and that of the near pairs.
    #[inline(always)]
    fn sum<P: SitePotential, const FUSED: bool>(
        &self,
        first: &Table<P>,
        points: &[Block],
        near: Option<&NearPairs>,
        pose: &RelativePose,
    ) -> Option<f64> {
        let motion = Motion::new(pose);
        let mut sum = [0.0_f32; BLOCK];
        let mut waiting: Option<(Spots, &[f32; BLOCK])> = None;
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
            near.add::<P, FUSED>(&first.split, &motion, &from_reference, &mut sum);
        }
        Some(sum.iter().map(|part| f64::from(*part)).sum())
    }
}
