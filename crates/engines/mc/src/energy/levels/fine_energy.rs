//! The energy of two bodies from fine tables: with the near pairs of a list, or without a list, for
//! poses that have nothing to do with each other.

use super::field::Spots;
use super::lanes::{BLOCK, sum_of_lanes};
use super::list::List;
use super::motion::{Block, Motion};
use super::neighbours::squares;
use super::table::{Estimate, Table};
use protomer_kernel::pose::RelativePose;
use protomer_kernel::vectorised;

impl Table {
    /// The energy with another body at this pose: its charges in the fine table, and the near pairs
    /// of a list that serves here one by one. `None` where the table ends before.
    pub(super) fn fine_energy(
        &self,
        other: &Self,
        list: &List,
        pose: &RelativePose,
    ) -> Option<Estimate> {
        let mut estimate = self.fine_table_energy(other.blocks(), pose)?;
        estimate.energy_kt += self.near_energy_kt(list, pose);
        Some(estimate)
    }

    vectorised! {
        fused
        /// The energy of charges in the fine table.
        pub(super) fn fine_table_energy[fine_avx512, fine_avx2, fine_sum](
            self: &Self,
            blocks: &[Block],
            pose: &RelativePose
        ) -> Option<Estimate>
    }

    #[inline(always)]
    fn fine_sum<const FUSED: bool>(
        &self,
        blocks: &[Block],
        pose: &RelativePose,
    ) -> Option<Estimate> {
        let motion = Motion::new(pose);
        let (mut energy_kt, mut variance) = (0.0, 0.0);
        let mut waiting: Option<(Spots, &[f32; BLOCK])> = None;
        // One turn more than there are blocks: the last turn only adds what is waiting.
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
        Some(Estimate {
            energy_kt,
            variance,
        })
    }

    vectorised! {
        fused
        /// The near pairs of a list, kT.
        fn near_energy_kt[near_avx512, near_avx2, near_sum](
            self: &Self,
            list: &List,
            pose: &RelativePose
        ) -> f64
    }

    #[inline(always)]
    fn near_sum<const FUSED: bool>(&self, list: &List, pose: &RelativePose) -> f64 {
        let from_reference = Motion::between(&list.reference, pose);
        list.near.energy_kt(&self.split, pose, &from_reference)
    }

    vectorised! {
        fused
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
        // No list, so near charges are looked up for each charge.
        let motion = Motion::new(pose);
        let mut energy_kt = 0.0;
        for block in other.blocks() {
            let places = motion.apply_block(block);
            let spots = self.field.locate(&places)?;
            energy_kt += self.field.fine::<FUSED>(&spots, &block[3]);
            for lane in 0..BLOCK {
                let place = [places[0][lane], places[1][lane], places[2][lane]];
                // An empty lane has the charge zero and a place like its neighbour's.
                energy_kt += f64::from(block[3][lane] * self.near_potential::<FUSED>(place));
            }
        }
        Some(energy_kt)
    }

    /// The near part of the potential at a place, kT/e.
    #[inline(always)]
    fn near_potential<const FUSED: bool>(&self, place: [f32; 3]) -> f32 {
        let mut potential = [0.0; BLOCK];
        for block in self.neighbours.blocks(place) {
            let squares = squares(block, place);
            for lane in 0..BLOCK {
                potential[lane] += block[3][lane] * self.split.near_f32::<FUSED>(squares[lane]);
            }
        }
        sum_of_lanes(&potential)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::maker::COARSE_OPENING;
    use super::*;
    use crate::charges::ChargeCloud;
    use crate::energy::pair_energy_kt;
    use protomer_kernel::potential::Yukawa;
    use protomer_kernel::random::CounterRng;
    use protomer_kernel::{Pose, Vec3};

    /// The tables of two bodies at poses from touching, where charges are 1.5 Å apart, to 90 Å, with
    /// their direct sum, kT.
    pub fn for_each_pose(mut check: impl FnMut([&Table; 2], &RelativePose, f64, String)) {
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
            let [first, second] = clouds
                .each_ref()
                .map(|charge_cloud| Table::new(charge_cloud, &yukawa, 120.0));
            for case in 0..60 {
                let distance = 27.5 + 1e-4 * f64::from(case).powi(3) * 2.9;
                let position = rng.unit_vector() * distance;
                let rotation = rng.rotation();
                let pose = Pose { position, rotation };
                let pose = RelativePose::new(&Pose::identity(), &pose, &position);
                let direct_kt = pair_energy_kt(&yukawa, &clouds[0], &clouds[1], &pose);
                check(
                    [&first, &second],
                    &pose,
                    direct_kt,
                    format!("{debye} {distance}"),
                );
            }
        }
    }

    #[test]
    fn it_is_the_direct_sum_near_and_far() {
        for_each_pose(|[first, second], pose, direct_kt, case| {
            let list = List::new(first, second, pose, COARSE_OPENING);
            let fine = first.fine_energy(second, &list, pose).unwrap();
            let error = (fine.energy_kt - direct_kt).abs();
            assert!(error < 3e-4, "{case} {error}");
            let alone = first.energy_alone_kt(second, pose).unwrap();
            assert!(
                (alone - direct_kt).abs() < 1e-3,
                "{case} {alone} {direct_kt}"
            );
        });
    }
}
