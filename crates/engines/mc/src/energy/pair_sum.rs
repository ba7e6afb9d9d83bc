//! The sum over all pairs of charges of two bodies, vectorised.

use super::potential::SitePotential;
use crate::charges::{ChargeCloud, ChargeGroup, LANES};
use protomer_kernel::pose::RelativePose;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::vectorised;

vectorised!(
    /// Energy of two bodies, kT: Σ q_k q_l v(r_kl) over all sites k of the first and l of the second.
    ///
    /// `relative` is the pose of the second body in the frame of the first. Groups of sites that a
    /// cut-off leaves out as a whole are passed over; every other pair is summed in double precision,
    /// in one order and without fused operations, so that every processor gives the same bits.
    pub fn pair_energy_kt[sum_avx512, sum_avx2, sum](
        potential: &Yukawa,
        first: &ChargeCloud,
        second: &ChargeCloud,
        relative: &RelativePose,
    ) -> f64
);

/// The sum itself; compiled once per instruction set by inlining.
#[inline(always)]
fn sum(
    potential: &Yukawa,
    first: &ChargeCloud,
    second: &ChargeCloud,
    relative: &RelativePose,
) -> f64 {
    // Rounding may not lose a pair just inside the cut-off.
    let reach = potential.cutoff_angstrom().unwrap_or(f64::INFINITY) + 1e-9;
    // One sum per lane, added up once at the end: the
    // order of additions is the same for all vectors.
    let mut total = [0.0; LANES];
    // The second body outside: each of its groups is
    // turned once and used for all groups of the first.
    for group in second.groups() {
        let image = transform(group, relative);
        for other in first.groups() {
            let limit = reach + image.radius_angstrom + other.radius_angstrom;
            // Squares: the spheres of most pairs of groups
            // are far from the limit, and no root is needed.
            if (image.centre - other.centre).norm_squared() < limit * limit {
                add_group_pair(potential, other, &image, &mut total);
            }
        }
    }
    total.iter().sum()
}

#[inline(always)]
fn transform(group: &ChargeGroup, relative: &RelativePose) -> ChargeGroup {
    let (r, t) = (&relative.rotation, &relative.translation);
    // Charges and radius are taken along as they are; only places change.
    let mut image = ChargeGroup {
        centre: relative.transform_point(&group.centre),
        ..*group
    };
    for lane in 0..LANES {
        let (x, y, z) = (group.x[lane], group.y[lane], group.z[lane]);
        image.x[lane] = r.m11 * x + r.m12 * y + r.m13 * z + t.x;
        image.y[lane] = r.m21 * x + r.m22 * y + r.m23 * z + t.y;
        image.z[lane] = r.m31 * x + r.m32 * y + r.m33 * z + t.z;
    }
    image
}

#[inline(always)]
fn add_group_pair(potential: &Yukawa, a: &ChargeGroup, b: &ChargeGroup, total: &mut [f64; LANES]) {
    for k in 0..LANES {
        let (x, y, z, charge) = (a.x[k], a.y[k], a.z[k], a.charge_e[k]);
        if charge == 0.0 {
            // From here on lanes are empty and would add zero.
            break;
        }
        // One charge against a whole group: eight distances, roots and exponentials side by side.
        for (lane, total) in total.iter_mut().enumerate() {
            let (dx, dy, dz) = (b.x[lane] - x, b.y[lane] - y, b.z[lane] - z);
            let energy = potential.at_square(dx * dx + dy * dy + dz * dz);
            // Lanes without a charge lie somewhere and add zero.
            *total += charge * b.charge_e[lane] * energy;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::potential::Yukawa;
    use protomer_kernel::random::CounterRng;
    use protomer_kernel::{Pose, Vec3};

    /// The slow, obvious twin.
    fn double_loop(
        yukawa: &Yukawa,
        a: &[(Vec3, f64)],
        b: &[(Vec3, f64)],
        relative: &RelativePose,
    ) -> f64 {
        let mut energy = 0.0;
        for (place, charge) in a {
            for (other_place, other_charge) in b {
                let distance = (relative.transform_point(other_place) - place).norm();
                energy += charge * other_charge * yukawa.energy_kt(distance);
            }
        }
        energy
    }

    #[test]
    fn every_instruction_set_gives_the_double_loop() {
        let mut rng = CounterRng::new(17, 0, 0);
        for case in 0..40 {
            let mut cloud = |count: usize| -> Vec<(Vec3, f64)> {
                (0..count)
                    .map(|_| (rng.vector_in_ball(15.0), rng.uniform_in(-1.0, 1.0)))
                    .collect()
            };
            let (a, b) = (cloud(1 + 37 * case % 211), cloud(1 + 53 * case % 173));
            let kappa = [0.0, 0.1, 1.0][case % 3];
            let yukawa =
                Yukawa::new(7.0, kappa, [12.0, 48.0, f64::INFINITY][case / 3 % 3]).unwrap();
            let pose = Pose {
                position: rng.unit_vector() * (25.0 + case as f64),
                rotation: rng.rotation(),
            };
            let relative = RelativePose::from(&pose);
            let expected = double_loop(&yukawa, &a, &b, &relative);
            let scale = double_loop(
                &yukawa,
                &a.iter()
                    .map(|(place, charge)| (*place, charge.abs()))
                    .collect::<Vec<_>>(),
                &b.iter()
                    .map(|(place, charge)| (*place, charge.abs()))
                    .collect::<Vec<_>>(),
                &relative,
            );
            let (a, b) = (ChargeCloud::new(&a), ChargeCloud::new(&b));
            let portable = sum(&yukawa, &a, &b, &relative);
            assert!(
                (portable - expected).abs() <= 1e-13 * scale,
                "case {case}: {portable} {expected}"
            );
            assert_eq!(
                portable.to_bits(),
                pair_energy_kt(&yukawa, &a, &b, &relative).to_bits()
            );
        }
    }
}
