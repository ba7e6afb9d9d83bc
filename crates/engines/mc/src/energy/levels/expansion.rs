//! The energy of far charges as a quadratic function of how a pair has moved.
//!
//! A charge q at ξ from the centre of its group moves by u = ΔR ξ + d, and its energy changes by
//! q (g·u + u·H u / 2), where g and H are the gradient and the second derivatives of the first body's
//! potential where the charge was. Summed over the charges, this is a quadratic form of the nine
//! elements of ΔR and the three of d: its cost does not depend on how many charges there are.

use super::derivatives::Derivatives;
use super::field::{Field, Spots};
use super::lanes::{BLOCK, sum_of_lanes};
use super::motion::{Block, Motion, length};
use protomer_kernel::vectorised;

/// The displacement at which the error is judged, Å: about as far as close pairs drift.
const TEST_ANGSTROM: f32 = 1.5;
/// The rotation at which the error is judged, rad.
const TEST_RADIAN: f32 = 0.03;
/// Axes along which and about which the test motions are made.
const AXES: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The pairs of coordinates of [`Derivatives::second`], and how often each counts in u·H u / 2.
const PAIRS: [(usize, usize, f32); 6] = [
    (0, 0, 0.5),
    (1, 1, 0.5),
    (2, 2, 0.5),
    (0, 1, 1.0),
    (0, 2, 1.0),
    (1, 2, 1.0),
];

/// A quadratic form of a pair's motion from a reference pose. Row a of the motion has the elements
/// of row a of ΔR and then that of d; ξ has a fourth component of one.
#[derive(Debug, Clone)]
pub(super) struct Expansion {
    centre: [f32; 3],
    constant_kt: f32,
    /// Σ q g_a ξ_m in lane 4 a + m.
    linear: [f32; BLOCK],
    /// For each pair of coordinates Σ q H_ab ξ_m ξ_n in lane 4 m + n.
    quadratic: [[f32; BLOCK]; 6],
    /// The likely square of the error after the test motions, kT².
    test_variance: f64,
}

impl Expansion {
    /// The form of points (Å in the second body's frame, charges in e) in the coarse field of the first
    /// body about a pose; `None` where the table ends before them. `centre`: of the points, Å.
    /// `length_angstrom`: the distance over which the potential varies.
    pub fn new(
        field: &Field,
        reference: &Motion,
        centre: [f32; 3],
        blocks: &[Block],
        length_angstrom: f32,
    ) -> Option<Self> {
        let mut form = Self {
            centre,
            constant_kt: 0.0,
            linear: [0.0; BLOCK],
            quadratic: [[0.0; BLOCK]; 6],
            test_variance: 0.0,
        };
        form.add(field, reference, blocks)?;
        form.test_variance = form.likely_square(reference, length_angstrom);
        Some(form)
    }

    vectorised! {
        fused
        fn add[add_avx512, add_avx2, add_all](
            self: &mut Self,
            field: &Field,
            reference: &Motion,
            blocks: &[Block]
        ) -> Option<()>
    }

    #[inline(always)]
    fn add_all<const FUSED: bool>(
        &mut self,
        field: &Field,
        reference: &Motion,
        blocks: &[Block],
    ) -> Option<()> {
        let mut waiting: Option<(Spots, &Block)> = None;
        for block in blocks.iter().map(Some).chain([None]) {
            let mut next = None;
            if let Some(block) = block {
                let spots = field.locate(&reference.apply_block(block))?;
                field.prefetch_coarse(&spots);
                next = Some((spots, block));
            }
            // While the series of the next points come, those before are added.
            if let Some((spots, [x, y, z, charge])) = std::mem::replace(&mut waiting, next) {
                let derivatives = field.derivatives::<FUSED>(&spots)?;
                for lane in 0..BLOCK {
                    let place = [x[lane], y[lane], z[lane]];
                    self.add_point(place, charge[lane], &derivatives[lane]);
                }
            }
        }
        Some(())
    }

    #[inline(always)]
    fn add_point(&mut self, [x, y, z]: [f32; 3], charge: f32, derivatives: &Derivatives) {
        let [cx, cy, cz] = self.centre;
        // A fourth component of one takes the translation into the same products.
        let arm = [x - cx, y - cy, z - cz, 1.0];
        let (mut arms, mut gradient) = ([0.0; BLOCK], [0.0; BLOCK]);
        for lane in 0..BLOCK {
            // ξ_m ξ_n in lane 4 m + n, computed once for all six second derivatives.
            arms[lane] = arm[lane / 4] * arm[lane % 4];
        }
        for lane in 0..12 {
            gradient[lane] = derivatives.gradient[lane / 4] * arm[lane % 4];
        }
        // The energy at the reference pose.
        self.constant_kt += charge * derivatives.value;
        for lane in 0..BLOCK {
            self.linear[lane] += charge * gradient[lane];
        }
        for (sum, second) in self.quadratic.iter_mut().zip(derivatives.second) {
            let weight = charge * second;
            for lane in 0..BLOCK {
                sum[lane] += weight * arms[lane];
            }
        }
    }

    /// The likely square of the error, kT²: what the third order adds is to the quadratic part as the
    /// motion is to three times the distance L over which the potential varies, and to the linear
    /// part as its square is to 6 L². Either part may be small by chance.
    fn likely_square(&self, reference: &Motion, length_angstrom: f32) -> f64 {
        let mut squares = 0.0;
        let of_quadratic = TEST_ANGSTROM / (3.0 * length_angstrom);
        // Third order of exp(-x/L) over its second, x/3L, and over its first, x²/6L².
        let of_linear = 1.5 * of_quadratic.powi(2);
        for axis in AXES {
            let step = axis.map(|x| TEST_ANGSTROM * x);
            let translation = reference.displacement(self.centre, step, axis, 0.0);
            // About the centre of the points, which a turn then leaves in its place.
            let rotation = reference.displacement(self.centre, [0.0; 3], axis, TEST_RADIAN);
            for motion in [translation, rotation] {
                let elements = motion.elements(self.centre);
                squares += f64::from(of_quadratic * self.quadratic_kt(&elements)).powi(2)
                    + f64::from(of_linear * self.linear_kt(&elements)).powi(2);
            }
        }
        squares / (2 * AXES.len()) as f64
    }

    vectorised! {
        fused
        /// The energy after a motion from the reference pose, kT.
        pub fn energy_kt[energy_avx512, energy_avx2, energy](
            self: &Self,
            from_reference: &Motion
        ) -> f32
    }

    #[inline(always)]
    fn energy<const FUSED: bool>(&self, from_reference: &Motion) -> f32 {
        let elements = from_reference.elements(self.centre);
        self.constant_kt + self.linear_kt(&elements) + self.quadratic_kt(&elements)
    }

    #[inline(always)]
    fn linear_kt(&self, elements: &[[f32; 4]; 3]) -> f32 {
        let products = self.linear.iter().zip(elements.as_flattened());
        products.map(|(sum, element)| sum * element).sum()
    }

    /// The likely square of the error after a motion from the reference pose, kT². The error grows
    /// with the third power of the motion, the first order that is left out.
    pub fn variance(&self, from_reference: &Motion) -> f64 {
        // At least one test motion: near the reference the model would promise too much.
        self.test_variance * self.extent(from_reference).max(1.0).powi(6)
    }

    /// Relative change of the error when the pair, after one motion from the reference pose or
    /// another, moves by `step`.
    pub fn shift(&self, from_reference: [&Motion; 2], step: &Motion) -> f64 {
        let extents = from_reference.map(|motion| self.extent(motion));
        // d(x³)/x³ = 3 dx/x.
        3.0 * self.extent(step) / extents[0].max(extents[1]).max(1.0)
    }

    /// A displacement in units of the test motions.
    fn extent(&self, displacement: &Motion) -> f64 {
        let translation = length(displacement.apply(self.centre)) / TEST_ANGSTROM;
        let rotation = displacement.turn() / TEST_RADIAN;
        f64::from((translation * translation + rotation * rotation).sqrt())
    }

    #[inline(always)]
    fn quadratic_kt(&self, elements: &[[f32; 4]; 3]) -> f32 {
        let mut sum = [0.0; BLOCK];
        for ((a, b, weight), of_pair) in PAIRS.into_iter().zip(&self.quadratic) {
            let (a, b) = (elements[a].map(|element| weight * element), elements[b]);
            for lane in 0..BLOCK {
                sum[lane] += of_pair[lane] * (a[lane / 4] * b[lane % 4]);
            }
        }
        sum_of_lanes(&sum)
    }
}

/// The mean position of points; the origin without any.
pub(super) fn centre(points: &[[f32; 4]]) -> [f32; 3] {
    let number = points.len().max(1) as f32;
    [0, 1, 2].map(|axis: usize| points.iter().map(|point| point[axis]).sum::<f32>() / number)
}

#[cfg(test)]
mod tests {
    use super::super::field::tests::field;
    use super::super::motion::blocks;
    use super::*;
    use protomer_kernel::pose::RelativePose;
    use protomer_kernel::random::CounterRng;
    use protomer_kernel::{Pose, Vec3};

    const LENGTH_ANGSTROM: f32 = 4.0;

    fn points() -> Vec<[f32; 4]> {
        let mut rng = CounterRng::new(9, 0, 0);
        let point = |number: usize| {
            let x: Vec3 = rng.vector_in_ball(12.0);
            let charge = if number.is_multiple_of(4) { -1.0 } else { 1.0 };
            [x.x as f32, x.y as f32, x.z as f32, charge]
        };
        (0..80).map(point).collect()
    }

    fn pose(position: Vec3, rng: &mut CounterRng, turn_rad: f64) -> Pose {
        Pose {
            position,
            rotation: rng.small_rotation(turn_rad),
        }
    }

    /// Each point by itself where the pair is.
    fn sum_over_points(field: &Field, motion: &Motion) -> f64 {
        let energy = |[x, y, z, charge]: [f32; 4]| {
            let place = motion.apply([x, y, z]);
            let spots = field.locate(&place.map(|x| [x; BLOCK])).unwrap();
            let value = field.derivatives::<false>(&spots).unwrap()[0].value;
            f64::from(charge * value)
        };
        points().into_iter().map(energy).sum()
    }

    #[test]
    fn it_is_the_sum_over_the_points_within_its_error() {
        let field = field();
        let mut rng = CounterRng::new(10, 0, 0);
        let reference = pose(Vec3::new(4.0, 30.0, 8.0), &mut rng, 1.0);
        let from = RelativePose::from(&reference);
        let (points, reference_motion) = (points(), Motion::new(&from));
        let blocks = blocks(&points);
        let centre = centre(&points);
        let form = Expansion::new(&field, &reference_motion, centre, &blocks, LENGTH_ANGSTROM);
        let form = form.unwrap();
        let start_kt = sum_over_points(&field, &Motion::new(&from));
        for (times, most) in [(1.0, 3e-3), (3.0, 3e-2)] {
            let (mut squares, mut changes, mut modelled) = (0.0, 0.0, 0.0);
            for _ in 0..200 {
                let step = rng.unit_vector() * f64::from(TEST_ANGSTROM) * times;
                let turn = rng.small_rotation(f64::from(TEST_RADIAN) * times);
                let to = RelativePose::from(&Pose {
                    position: reference.position + step,
                    rotation: turn * reference.rotation,
                });
                let motion = Motion::between(&from, &to);
                let sum_kt = sum_over_points(&field, &Motion::new(&to));
                squares += (f64::from(form.energy_kt(&motion)) - sum_kt).powi(2);
                changes += (sum_kt - start_kt).powi(2);
                modelled += form.variance(&motion);
            }
            assert!(squares < most * changes, "{times}: {squares} of {changes}");
            let ratio = squares / modelled;
            assert!((0.005..3.0).contains(&ratio), "{times}: {ratio}");
        }
    }
}
