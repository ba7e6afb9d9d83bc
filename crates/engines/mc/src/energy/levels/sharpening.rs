//! Fine energies on their way to the direct sum.
//!
//! A few charges in cells near the other body's make most of the error of a fine energy. Each step
//! takes some more of them out of the table, the least certain first, and sums the smooth potential
//! there over the other body's charges:
//!
//! E_s = E_{s-1} + Σ_k q_k (φ(x_k) - φ_table(x_k)), k over the charges of step s.

use super::lanes::BLOCK;
use super::motion::{Block, Motion, blocks};
use super::table::Table;
use crate::charges::LANES;
use protomer_kernel::Vec3;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::vectorised;

/// The part of the charges that is summed directly after each step.
const SUMMED: [f64; STEPS] = [0.01, 0.03, 0.1, 0.25, 0.6];
/// The number of steps.
pub(super) const STEPS: usize = 5;

/// The charges of the second body of a pair in the order in which they leave the table.
#[derive(Debug)]
pub(super) struct Ranking {
    /// Places in the blocks of the second body. Within a step they have no order.
    places: Vec<u32>,
    /// End of each step among the places.
    ends: [usize; STEPS],
    /// Variance of the charges in the table after each step, kT².
    remaining_variances: [f64; STEPS],
}

impl Ranking {
    /// Variance of the energy after a step, kT².
    pub fn variance(&self, step: usize) -> f64 {
        self.remaining_variances[step]
    }

    /// The charges that leave the table at a step.
    fn of_step(&self, step: usize) -> &[u32] {
        let start = step.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.places[start..self.ends[step]]
    }

    /// The ranking from the variance that each charge in blocks brings, kT².
    fn new(variances: &[[f32; BLOCK]], charges: usize) -> Self {
        let variances = variances.as_flattened();
        let mut places: Vec<u32> = (0..variances.len() as u32).collect();
        let variance = |place: &u32| variances[*place as usize];
        let ends = SUMMED.map(|part| (part * charges as f64).ceil() as usize);
        // From the last step to the first, so that each looks only at the charges of the one after it.
        let mut taken = places.as_mut_slice();
        for end in ends.into_iter().rev() {
            // Selection, not sorting: only the borders between steps matter.
            if end < taken.len() {
                taken.select_nth_unstable_by(end, |a, b| {
                    // Ties by place, so that the order is unique.
                    variance(b).total_cmp(&variance(a)).then(a.cmp(b))
                });
            }
            taken = &mut taken[..end];
        }
        let sum = |places: &[u32]| {
            places
                .iter()
                .map(|place| f64::from(variance(place)))
                .sum::<f64>()
        };
        let remaining_variances = ends.map(|end| sum(&places[end..]));
        Self {
            places,
            ends,
            remaining_variances,
        }
    }
}

impl Table {
    /// The order in which the charges of another body at this pose leave the table; `None` where the
    /// table ends before.
    pub(super) fn ranking(&self, other: &Self, pose: &RelativePose) -> Option<Ranking> {
        let variances = self.variances(other.blocks(), pose)?;
        Some(Ranking::new(&variances, other.charges.len()))
    }

    /// Energy that a step adds, kT; `None` where the table ends before the other body.
    pub(super) fn correction_kt(
        &self,
        other: &Self,
        pose: &RelativePose,
        ranking: &Ranking,
        step: usize,
    ) -> Option<f64> {
        let charge = |place: &u32| {
            let (block, lane) = (*place as usize / BLOCK, *place as usize % BLOCK);
            other.blocks()[block].map(|row| row[lane])
        };
        let charges: Vec<[f32; 4]> = ranking.of_step(step).iter().map(charge).collect();
        let placed = |charge: &[f32; 4]| {
            let [x, y, z, charge] = charge.map(f64::from);
            (pose.transform_point(&Vec3::new(x, y, z)), charge)
        };
        let placed: Vec<(Vec3, f64)> = charges.iter().map(placed).collect();
        let from_table = self.fine_table_energy(&blocks(&charges), pose)?;
        // Adds the smooth potential summed directly and takes out what the table gave.
        Some(self.smooth_energy_kt(&placed) - from_table.energy_kt)
    }

    vectorised! {
        fused
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
        let block_variances = |block: &Block| {
            let spots = self.field.locate(&motion.apply_block(block))?;
            Some(self.field.fine_variances(&spots, &block[3]))
        };
        blocks.iter().map(block_variances).collect()
    }

    vectorised! {
        fused
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
        // Groups outside: each is loaded once for all charges.
        for group in self.charges.groups() {
            for (place, charge) in charges {
                let (mut squares, mut potential) = ([0.0_f32; LANES], [0.0_f32; LANES]);
                for lane in 0..LANES {
                    let (dx, dy, dz) = (
                        place.x - group.x[lane],
                        place.y - group.y[lane],
                        place.z - group.z[lane],
                    );
                    squares[lane] = (dx * dx + dy * dy + dz * dz) as f32;
                }
                // A vector of single precision has twice the lanes, hence a separate loop.
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
}

#[cfg(test)]
mod tests {
    use super::super::fine_energy::tests::for_each_pose;
    use super::super::list::List;
    use super::super::maker::COARSE_OPENING;
    use super::*;
    use protomer_kernel::random::CounterRng;

    #[test]
    fn each_step_takes_the_least_certain_of_those_left() {
        let mut rng = CounterRng::new(31, 0, 0);
        for charges in [1, 2, 15, 16, 17, 300] {
            let mut variances = vec![[0.0_f32; BLOCK]; usize::div_ceil(charges, BLOCK)];
            let each = variances.as_flattened_mut().iter_mut();
            each.take(charges)
                .for_each(|variance| *variance = rng.uniform() as f32);
            let ranking = Ranking::new(&variances, charges);
            let variance = |place: &u32| variances.as_flattened()[*place as usize];
            let mut sorted = variances.as_flattened().to_vec();
            sorted.sort_by(|a, b| b.total_cmp(a));
            let mut taken = Vec::new();
            for step in 0..STEPS {
                taken.extend(ranking.of_step(step).iter().map(variance));
                taken.sort_by(|a, b| b.total_cmp(a));
                assert_eq!(taken, sorted[..ranking.ends[step]]);
                let left: f64 = sorted[taken.len()..].iter().copied().map(f64::from).sum();
                assert!((ranking.variance(step) - left).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn energies_come_closer_to_the_direct_sum_with_each_step() {
        for_each_pose(|[first, second], pose, direct_kt, case| {
            let list = List::new(first, second, pose, COARSE_OPENING);
            let mut energy_kt = first.fine_energy(second, &list, pose).unwrap().energy_kt;
            let ranking = first.ranking(second, pose).unwrap();
            let most = [2e-4, 1e-4, 5e-5, 3e-5, 2e-5];
            for (step, most) in most.into_iter().enumerate() {
                let correction = first.correction_kt(second, pose, &ranking, step);
                energy_kt += correction.unwrap();
                let error = (energy_kt - direct_kt).abs();
                assert!(error < most, "{case} {step} {error}");
            }
        });
    }
}
