//! The energy of two bodies from fine tables: with the near pairs of a list, or without a list, for
//! poses that have nothing to do with each other.
//!
//! A few charges in cells near the other body's make most of the error. A sharpened energy has the
//! smooth potential itself there, summed over the other body's charges.

use super::field::Spots;
use super::lanes::{BLOCK, sum_of_lanes, vectorised};
use super::list::List;
use super::motion::{Block, Motion};
use super::neighbours::squares;
use super::table::{Estimate, Table};
use crate::charges::LANES;
use crate::energy::SitePotential;
use protomer_kernel::Vec3;
use protomer_kernel::pose::RelativePose;

/// The steps of sharpening: the parts of the charges that are summed directly.
pub(super) const SHARPENED: [f64; 4] = [0.0, 0.02, 0.1, 0.5];

impl<P: SitePotential> Table<P> {
    /// The energy with another body at this pose after this step of sharpening: its charges in the
    /// fine table, and the near pairs of a list that serves here one by one. `None` where the table
    /// ends before.
    pub(super) fn fine_energy(
        &self,
        other: &Self,
        list: &List,
        pose: &RelativePose,
        step: usize,
    ) -> Option<Estimate> {
        let summed = (SHARPENED[step] * other.charges.len() as f64).ceil() as usize;
        match summed {
            0 => self.fine_energy_of(other.blocks(), list, pose),
            _ => self.sharpened_energy(other, list, pose, summed),
        }
    }

    /// The same without the table for this many of the charges, those that bring most of its
    /// variance.
    fn sharpened_energy(
        &self,
        other: &Self,
        list: &List,
        pose: &RelativePose,
        without_table: usize,
    ) -> Option<Estimate> {
        let mut blocks = other.blocks().to_vec();
        let variances = self.variances(&blocks, pose)?;
        let variance = |place: usize| variances[place / BLOCK][place % BLOCK];
        let mut places: Vec<usize> = (0..BLOCK * blocks.len()).collect();
        places.sort_unstable_by(|a, b| variance(*b).total_cmp(&variance(*a)).then(a.cmp(b)));
        places.truncate(without_table);
        let mut taken = Vec::with_capacity(places.len());
        for place in places {
            let (block, lane) = (&mut blocks[place / BLOCK], place % BLOCK);
            let [x, y, z, charge] = [0, 1, 2, 3].map(|row: usize| f64::from(block[row][lane]));
            taken.push((pose.transform_point(&Vec3::new(x, y, z)), charge));
            block[3][lane] = 0.0;
        }
        let mut estimate = self.fine_energy_of(&blocks, list, pose)?;
        estimate.energy_kt += self.smooth_energy_kt(&taken);
        Some(estimate)
    }

    vectorised! {
        /// The variance that each of these charges brings, kT².
        fn variances[variances_avx512, variances_avx2, variances_each](
            self: &Self,
            blocks: &[Block],
            pose: &RelativePose
        ) -> Option<Vec<[f32; BLOCK]>>
    }

    #[inline(always)]
    fn variances_each<const FUSED: bool>(
        &self,
        blocks: &[Block],
        pose: &RelativePose,
    ) -> Option<Vec<[f32; BLOCK]>> {
        let motion = Motion::new(pose);
        let of = |block: &Block| {
            let spots = self.field.locate(&motion.apply_block(block))?;
            Some(self.field.fine_variances(&spots, &block[3]))
        };
        blocks.iter().map(of).collect()
    }

    vectorised! {
        /// The energy of charges (Å, e) in the smooth potential of this body, summed charge by
        /// charge, kT. Distances and sums are in double precision; the potential is in single
        /// precision, whose errors of 10⁻⁷ of each term have random signs.
        fn smooth_energy_kt[smooth_avx512, smooth_avx2, smooth_sum](
            self: &Self,
            charges: &[(Vec3, f64)]
        ) -> f64
    }

    #[inline(always)]
    fn smooth_sum<const FUSED: bool>(&self, charges: &[(Vec3, f64)]) -> f64 {
        let mut sum = [0.0; LANES];
        for group in self.charges.groups() {
            for (at, charge) in charges {
                let (mut squares, mut potential) = ([0.0_f32; LANES], [0.0_f32; LANES]);
                for lane in 0..LANES {
                    let (dx, dy, dz) = (
                        at.x - group.x[lane],
                        at.y - group.y[lane],
                        at.z - group.z[lane],
                    );
                    squares[lane] = (dx * dx + dy * dy + dz * dz) as f32;
                }
                // A vector of single precision has twice the lanes: a loop of its own.
                for lane in 0..LANES {
                    potential[lane] = self.split.smooth_f32::<FUSED>(squares[lane]);
                }
                for lane in 0..LANES {
                    sum[lane] += charge * group.charge_e[lane] * f64::from(potential[lane]);
                }
            }
        }
        sum.iter().sum()
    }

    vectorised! {
        fn fine_energy_of[fine_avx512, fine_avx2, fine_sum](
            self: &Self,
            blocks: &[Block],
            list: &List,
            pose: &RelativePose
        ) -> Option<Estimate>
    }

    /// The charges in the fine table, and the near pairs of the list.
    #[inline(always)]
    fn fine_sum<const FUSED: bool>(
        &self,
        blocks: &[Block],
        list: &List,
        pose: &RelativePose,
    ) -> Option<Estimate> {
        let motion = Motion::new(pose);
        let (mut energy_kt, mut variance) = (0.0, 0.0);
        let mut waiting: Option<(Spots, &[f32; BLOCK])> = None;
        for block in blocks.iter().map(Some).chain([None]) {
            let mut next = None;
            if let Some(block) = block {
                let spots = self.field.locate(&motion.apply_block(block))?;
                self.field.prefetch_fine(&spots);
                next = Some((spots, &block[3]));
            }
            // While the series of the next points come, those before are added.
            if let Some((spots, charge)) = std::mem::replace(&mut waiting, next) {
                energy_kt += self.field.fine::<FUSED>(&spots, charge);
                variance += f64::from(self.field.fine_variance(&spots, charge));
            }
        }
        let from_reference = Motion::between(&list.reference, pose);
        energy_kt += list.near.energy_kt(&self.split, pose, &from_reference);
        Some(Estimate {
            energy_kt,
            variance,
        })
    }

    vectorised! {
        /// The energy with another body at a pose in the frame of this one, from the fine table and
        /// the near pairs, kT; `None` where the table ends before the other body does.
        ///
        /// The error is that of the fine series, some 10⁻⁴ kT for two proteins in contact.
        pub fn energy_alone_kt[alone_avx512, alone_avx2, sum_alone](
            self: &Self,
            other: &Self,
            pose: &RelativePose
        ) -> Option<f64>
    }

    #[inline(always)]
    fn sum_alone<const FUSED: bool>(&self, other: &Self, pose: &RelativePose) -> Option<f64> {
        let motion = Motion::new(pose);
        let mut energy_kt = 0.0;
        for block in other.blocks() {
            let places = motion.apply_block(block);
            let spots = self.field.locate(&places)?;
            energy_kt += self.field.fine::<FUSED>(&spots, &block[3]);
            for lane in 0..BLOCK {
                let at = [places[0][lane], places[1][lane], places[2][lane]];
                energy_kt += f64::from(block[3][lane] * self.near_potential::<FUSED>(at));
            }
        }
        Some(energy_kt)
    }

    /// The near part of the potential at a place, kT/e.
    #[inline(always)]
    fn near_potential<const FUSED: bool>(&self, place: [f32; 3]) -> f32 {
        let mut potential = [0.0; BLOCK];
        for block in self.neighbours.of(place) {
            let squares = squares(block, place);
            for lane in 0..BLOCK {
                potential[lane] += block[3][lane] * self.split.near_f32::<FUSED>(squares[lane]);
            }
        }
        sum_of_lanes(&potential)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::maker::COARSE_OPENING;
    use super::*;
    use crate::charges::ChargeCloud;
    use crate::energy::pair_energy_kt;
    use protomer_kernel::Pose;
    use protomer_kernel::potential::Yukawa;
    use protomer_kernel::random::CounterRng;

    #[test]
    fn it_is_the_direct_sum_near_and_far() {
        let mut rng = CounterRng::new(71, 0, 0);
        let mut cloud = |radius: f64| {
            let mut charges: Vec<(Vec3, f64)> = Vec::new();
            for _ in 0..300 {
                charges.push((rng.vector_in_ball(radius), rng.uniform_in(-0.6, 0.7)));
            }
            ChargeCloud::new(&charges)
        };
        let clouds = [cloud(15.0), cloud(11.0)];
        let mut rng = CounterRng::new(72, 0, 0);
        for debye in [3.04, 9.6, 30.0] {
            let yukawa = Yukawa::uncut(7.0, 1.0 / debye).unwrap();
            let tables = clouds.each_ref().map(|of| Table::new(of, &yukawa, 120.0));
            for case in 0..60 {
                // From touching, where charges are 1.5 Å apart, to 90 Å.
                let distance = 27.5 + 1e-4 * f64::from(case).powi(3) * 2.9;
                let position = rng.unit_vector() * distance;
                let pose = Pose {
                    position,
                    rotation: rng.rotation(),
                };
                let relative = RelativePose::new(&Pose::identity(), &pose, &position);
                let expected = pair_energy_kt(&yukawa, &clouds[0], &clouds[1], &relative);
                let list = List::new(&tables[0], &tables[1], &relative, COARSE_OPENING);
                for (without_table, most) in [(0, 3e-4), (12, 1e-4), (100, 5e-5), (400, 2e-5)] {
                    let [first, second] = &tables;
                    let sharpened = first.sharpened_energy(second, &list, &relative, without_table);
                    let found = sharpened.unwrap();
                    let error = (found.energy_kt - expected).abs();
                    assert!(error < most, "{debye} {distance} {without_table} {error}");
                    assert_eq!(found.variance > 0.0, without_table < 300);
                }
                let found = tables[0].energy_alone_kt(&tables[1], &relative).unwrap();
                assert!(
                    (found - expected).abs() < 1e-3,
                    "{debye} {distance} {found} {expected}"
                );
            }
        }
    }
}
