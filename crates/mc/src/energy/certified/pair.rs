//! The energy of two bodies as an interval.

use super::field::SmoothField;
use super::leaves::{LEAF, Leaves};
use super::near::NearKernel;
use super::split::Split;
use super::window::{Bounded, LARGEST_RADIUS, Lists, Sources, Target, moments, sum_target};
use crate::charges::ChargeCloud;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::potential::Yukawa;

/// Edge of the field's cubes, Å, while the cut-off is at most [`REACH_OF_EDGE`]; beyond, in
/// proportion.
const EDGE: f64 = 4.0;
const REACH_OF_EDGE: f64 = 60.0;
/// The short distance R of the split over the edge of a cube.
const NEAR_PER_EDGE: f64 = 2.5;
/// Likely errors are this many times the root of the sum of squared bounds.
const DEVIATIONS: f64 = 6.0;
/// A cut-off below this many R is left to the direct sum, which is short then.
const LEAST_CUTOFF: f64 = 2.4;

/// An energy between two bounds, kT.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EnergyInterval {
    /// The best estimate, kT.
    pub middle_kt: f64,
    /// Half the width of the interval, kT.
    pub error_kt: f64,
    /// Six times the square root of the sum of the parts' squared bounds, kT: what the error is
    /// within if the errors of charges in different places are independent, as those of polynomials
    /// and roundings are in practice.
    pub likely_error_kt: f64,
}

impl EnergyInterval {
    /// Lower bound, kT.
    pub fn low_kt(&self) -> f64 {
        self.middle_kt - self.error_kt
    }

    /// Upper bound, kT.
    pub fn high_kt(&self) -> f64 {
        self.middle_kt + self.error_kt
    }
}

/// What is precomputed about the charges of one body under one potential; immutable, to be shared.
#[derive(Debug, Clone, PartialEq)]
pub struct ChargeTable {
    leaves: Leaves,
    sources: Sources,
    /// The moments of each leaf about its centre.
    moments: Vec<[f64; 14]>,
    magnitude: f64,
    split: Split,
    near: NearKernel,
    pub(super) field: Option<SmoothField>,
}

impl ChargeTable {
    /// The tables of these charges.
    pub fn new(charges: &ChargeCloud, yukawa: &Yukawa) -> Self {
        Self::with_field(charges, yukawa, SmoothField::new)
    }

    /// The same with the field, which takes long to make, from elsewhere.
    pub(super) fn with_field(
        charges: &ChargeCloud,
        yukawa: &Yukawa,
        field: impl FnOnce(&Leaves, &Split, f64, f64) -> SmoothField,
    ) -> Self {
        let leaves = Leaves::new(charges, LARGEST_RADIUS);
        let (split, edge, reach) = Self::scales(yukawa);
        let field = (yukawa.cutoff_angstrom >= LEAST_CUTOFF * split.near_radius
            && leaves.len() > 0)
            .then(|| field(&leaves, &split, edge, reach));
        Self::assemble(leaves, split, field)
    }

    /// The kernel's parts, the edge of the field's cubes and the field's reach, Å.
    pub(super) fn scales(yukawa: &Yukawa) -> (Split, f64, f64) {
        let reach = if yukawa.cutoff_angstrom.is_finite() {
            yukawa.cutoff_angstrom
        } else {
            REACH_OF_EDGE
        };
        let edge = EDGE * (reach / REACH_OF_EDGE).max(1.0);
        (Split::new(yukawa, NEAR_PER_EDGE * edge), edge, reach)
    }

    fn assemble(leaves: Leaves, split: Split, field: Option<SmoothField>) -> Self {
        let sources = Sources::new(&leaves);
        let moments = (0..leaves.len())
            .map(|leaf| {
                let [cx, cy, cz, _] = leaves.spheres[leaf];
                let (x, y, z) = (
                    leaves.x[leaf].map(|x| x - cx),
                    leaves.y[leaf].map(|y| y - cy),
                    leaves.z[leaf].map(|z| z - cz),
                );
                moments([&x, &y, &z], &leaves.charge[leaf])
            })
            .collect();
        let magnitude = leaves.magnitude.iter().sum();
        let near = NearKernel::new(&split);
        Self {
            leaves,
            sources,
            moments,
            magnitude,
            split,
            near,
            field,
        }
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        let leaf = 4 * 8 * LEAF + 4 * 8 + 8 + 14 * 8;
        self.field.as_ref().map_or(0, SmoothField::memory_bytes)
            + self.sources.memory_bytes()
            + leaf * self.leaves.len()
    }

    /// The energy of the body of this table and another whose pose in this one's frame is
    /// `relative`; `None` where the tables do not serve: a cut-off so short that the direct sum is,
    /// or charges that all but coincide.
    pub fn energy_interval(
        &self,
        other: &ChargeTable,
        relative: &RelativePose,
    ) -> Option<EnergyInterval> {
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("fma")
                && is_x86_feature_detected!("popcnt")
                && is_x86_feature_detected!("bmi1")
            {
                // SAFETY: the processor has the features the function is compiled for.
                return unsafe { self.interval_avx512(other, relative) };
            }
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                // SAFETY: the processor has the features the function is compiled for.
                return unsafe { self.interval_avx2(other, relative) };
            }
        }
        self.interval::<false>(other, relative)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,fma,popcnt,bmi1")]
    fn interval_avx512(
        &self,
        other: &ChargeTable,
        relative: &RelativePose,
    ) -> Option<EnergyInterval> {
        self.interval::<true>(other, relative)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn interval_avx2(
        &self,
        other: &ChargeTable,
        relative: &RelativePose,
    ) -> Option<EnergyInterval> {
        self.interval::<false>(other, relative)
    }

    #[inline(always)]
    fn interval<const WIDE: bool>(
        &self,
        other: &ChargeTable,
        relative: &RelativePose,
    ) -> Option<EnergyInterval> {
        if self.leaves.len() == 0 || other.leaves.len() == 0 {
            return Some(EnergyInterval::default());
        }
        let field = self.field.as_ref()?;
        let mut lists = Lists::new(&self.sources);
        let mut sum = Bounded::default();
        let r = [0, 1, 2].map(|i| [0, 1, 2].map(|j| relative.rotation[(i, j)]));
        let middle: [f64; 3] = std::array::from_fn(|i| {
            let at = |j: usize| r[i][j] * other.leaves.middle[j];
            at(0) + at(1) + at(2) + relative.translation[i] - self.leaves.middle[i]
        });
        for leaf in 0..other.leaves.len() {
            let (places, target) = other.place(leaf, &r, &middle);
            if self.beyond(&target) {
                continue;
            }
            let outside =
                |i: usize| self.smooth_exactly([places[0][i], places[1][i], places[2][i]]);
            // The cubes come from memory while the rest is summed.
            let spots = field.locate([&places[0], &places[1], &places[2]], &target.charge);
            let rest =
                sum_target::<WIDE>(&self.sources, &target, &self.split, &self.near, &mut lists);
            let smooth = field.sum::<WIDE>(&spots, &target.charge, outside);
            sum.add(smooth);
            sum.add(rest);
        }
        // What double precision rounds, here and in the direct sum: its terms are at most a few
        // kT/e².
        let rounding = 1e-12 * self.magnitude * other.magnitude;
        let error_kt = sum.error + rounding;
        let likely_error_kt = (DEVIATIONS * sum.square.sqrt() + rounding).min(error_kt);
        let interval = EnergyInterval {
            middle_kt: sum.value,
            error_kt,
            likely_error_kt,
        };
        (interval.low_kt().is_finite() && interval.high_kt().is_finite()).then_some(interval)
    }

    /// Whether no charge of this body comes within the cut-off of the target leaf.
    #[inline(always)]
    fn beyond(&self, target: &Target) -> bool {
        let outside =
            |axis: usize| (target.centre[axis].abs() - self.leaves.half_extents[axis]).max(0.0);
        let reach = self.split.cutoff + target.radius + 1e-6;
        outside(0).powi(2) + outside(1).powi(2) + outside(2).powi(2) > reach * reach
    }

    /// A leaf of this body turned and moved.
    #[inline(always)]
    fn place(
        &self,
        leaf: usize,
        r: &[[f64; 3]; 3],
        middle: &[f64; 3],
    ) -> ([[f64; LEAF]; 3], Target) {
        let leaves = &self.leaves;
        let [cx, cy, cz, radius] = leaves.spheres[leaf];
        let turn = |v: [f64; 3], i: usize| r[i][0] * v[0] + r[i][1] * v[1] + r[i][2] * v[2];
        let centre: [f64; 3] = std::array::from_fn(|i| turn([cx, cy, cz], i) + middle[i]);
        let mut places = [[0.0; LEAF]; 3];
        let mut exact_offset = [[0.0; LEAF]; 3];
        for axis in 0..3 {
            for lane in 0..LEAF {
                let local = [
                    leaves.x[leaf][lane] - cx,
                    leaves.y[leaf][lane] - cy,
                    leaves.z[leaf][lane] - cz,
                ];
                exact_offset[axis][lane] = turn(local, axis);
                places[axis][lane] = exact_offset[axis][lane] + centre[axis];
            }
        }
        let mut square = [0.0; LEAF];
        for lane in 0..LEAF {
            let d = [
                exact_offset[0][lane],
                exact_offset[1][lane],
                exact_offset[2][lane],
            ];
            square[lane] = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        }
        let target = Target {
            centre,
            radius,
            offset: exact_offset.map(|axis| axis.map(|d| d as f32)),
            exact_offset,
            square,
            charge: leaves.charge[leaf],
            magnitude: leaves.magnitude[leaf],
            moments: turn_moments(&self.moments[leaf], r),
        };
        (places, target)
    }

    /// The smooth part at a point without a cube: none is needed beyond a finite cut-off.
    #[cold]
    fn smooth_exactly(&self, x: [f64; 3]) -> f64 {
        let leaves = &self.leaves;
        let outside = |axis: usize| (x[axis].abs() - leaves.half_extents[axis]).max(0.0);
        if outside(0).powi(2) + outside(1).powi(2) + outside(2).powi(2) > self.split.cutoff.powi(2)
        {
            return 0.0;
        }
        let mut sum = 0.0;
        for leaf in 0..leaves.len() {
            for i in 0..LEAF {
                let d = [
                    x[0] - leaves.x[leaf][i],
                    x[1] - leaves.y[leaf][i],
                    x[2] - leaves.z[leaf][i],
                ];
                let t = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                sum += leaves.charge[leaf][i] * self.split.smooth(t);
            }
        }
        sum
    }
}

/// The moments of a leaf after a rotation about its centre.
#[inline(always)]
fn turn_moments(m: &[f64; 14], r: &[[f64; 3]; 3]) -> [f64; 14] {
    let turn = |v: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|i| r[i][0] * v[0] + r[i][1] * v[1] + r[i][2] * v[2])
    };
    let d = turn([m[1], m[2], m[3]]);
    let o = turn([m[10], m[11], m[12]]);
    // R Q Rᵀ: the columns of R Q, turned again.
    let columns = [
        turn([m[4], m[7], m[8]]),
        turn([m[7], m[5], m[9]]),
        turn([m[8], m[9], m[6]]),
    ];
    let rows = [0, 1, 2].map(|i| turn([columns[0][i], columns[1][i], columns[2][i]]));
    [
        m[0], d[0], d[1], d[2], rows[0][0], rows[1][1], rows[2][2], rows[0][1], rows[0][2],
        rows[1][2], o[0], o[1], o[2], m[13],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::random::CounterRng;
    use protomer_kernel::{Pose, Vec3};

    /// The portable path is the twin of the one that the processor's vectors make fast.
    #[test]
    fn the_vector_path_gives_the_intervals_of_the_portable_one() {
        let mut rng = CounterRng::new(41, 0, 0);
        for cutoff in [48.0, f64::INFINITY] {
            let Ok(yukawa) = Yukawa::new(7.0, 1.0 / 9.6, cutoff) else {
                continue;
            };
            let table = |rng: &mut CounterRng| {
                let charges: Vec<(Vec3, f64)> = (0..150)
                    .map(|_| (rng.vector_in_ball(12.0), rng.uniform_in(-0.6, 0.6)))
                    .collect();
                ChargeTable::new(&ChargeCloud::new(&charges), &yukawa)
            };
            let (a, b) = (table(&mut rng), table(&mut rng));
            for _ in 0..200 {
                let position = rng.unit_vector() * rng.uniform_in(25.0, 75.0);
                let relative = RelativePose::new(
                    &Pose::identity(),
                    &Pose {
                        position,
                        rotation: rng.rotation(),
                    },
                    &position,
                );
                let (fast, slow) = (
                    a.energy_interval(&b, &relative),
                    a.interval::<false>(&b, &relative),
                );
                let (Some(fast), Some(slow)) = (fast, slow) else {
                    assert_eq!(fast, slow);
                    continue;
                };
                let apart = (fast.middle_kt - slow.middle_kt).abs();
                assert!(apart <= 1e-3 * slow.error_kt, "{fast:?} {slow:?}");
                assert!(
                    (fast.error_kt / slow.error_kt - 1.0).abs() < 1e-5,
                    "{fast:?} {slow:?}"
                );
            }
        }
    }
}
