//! Certified intervals hold the direct sum at every pose, for any charges and any salt.

use crate::common::{bench_folder, bench_system};
use protomer_kernel::pose::RelativePose;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Pose, Vec3};
use protomer_mc::charges::ChargeCloud;
use protomer_mc::energy::certified::{Cells, Certified};
use protomer_mc::energy::{DirectSum, EnergyModel, pair_energy_kt};

/// Charges up to this distance from the origin, Å.
struct Kind {
    charges: ChargeCloud,
    radius: f64,
}

/// All partial charges of a small protein, a few formal ones, and a neutral body with a large dipole.
fn kinds() -> [Kind; 3] {
    let mut rng = CounterRng::new(91, 0, 0);
    let mut kind = |count: usize, radius: f64, charge: &dyn Fn(&Vec3, f64) -> f64| {
        let mut placed: Vec<(Vec3, f64)> = Vec::new();
        for _ in 0..count {
            let place = rng.vector_in_ball(radius);
            placed.push((place, charge(&place, rng.uniform_in(-1.0, 1.0))));
        }
        let charges = ChargeCloud::new(&placed);
        Kind { charges, radius }
    };
    [
        kind(250, 13.0, &|_, random| 0.04 + 0.5 * random),
        kind(30, 11.0, &|_, random| if random > 0.3 { -1.0 } else { 1.0 }),
        kind(120, 16.0, &|place, _| 0.05 * place.z),
    ]
}

/// Half of the poses are near contact: charges lie in balls that touch, or miss each other by up to 2 Å.
fn pose(kinds: [&Kind; 2], rng: &mut CounterRng) -> RelativePose {
    let touching = kinds[0].radius + kinds[1].radius;
    let gap = match rng.uniform() < 0.5 {
        true => rng.uniform_in(0.0, 2.0),
        false => rng.uniform_in(2.0, 80.0),
    };
    let position = rng.unit_vector() * (touching + gap);
    let rotation = rng.rotation();
    RelativePose::new(&Pose::identity(), &Pose { position, rotation }, &position)
}

#[test]
fn intervals_hold_the_direct_sum_at_ten_thousand_poses() {
    let kinds = kinds();
    let mut rng = CounterRng::new(92, 0, 0);
    let (mut poses, mut nearest_to_the_bound, mut widest) = (0, 0.0_f64, 0.0_f64);
    // The last is without salt.
    for inverse_debye in [1.0 / 3.0, 1.0 / 9.6, 1.0 / 30.0, 0.0] {
        let yukawa = Yukawa::uncut(7.0, inverse_debye).unwrap();
        for first in &kinds {
            let cells = Cells::new(&first.charges, &yukawa, 130.0);
            for second in &kinds {
                for _ in 0..280 {
                    let pose = pose([first, second], &mut rng);
                    let direct_kt = pair_energy_kt(&yukawa, &first.charges, &second.charges, &pose);
                    let interval = cells.energy_with(&second.charges, &pose).unwrap();
                    let error = (interval.energy_kt - direct_kt).abs();
                    assert!(error <= interval.error_kt, "{interval:?} {direct_kt}");
                    nearest_to_the_bound = nearest_to_the_bound.max(error / interval.error_kt);
                    widest = widest.max(interval.error_kt);
                    poses += 1;
                }
            }
        }
    }
    assert!(poses >= 10_000);
    // Narrow enough to decide by, and not a thousand times too wide.
    assert!(widest < 0.05, "{widest}");
    assert!(nearest_to_the_bound > 1e-3, "{nearest_to_the_bound}");
}

#[test]
fn the_octree_ends_where_it_was_asked_to() {
    let [kind, ..] = kinds();
    let yukawa = Yukawa::uncut(7.0, 0.1).unwrap();
    let cells = Cells::new(&kind.charges, &yukawa, 60.0);
    let energies = |x: f64| {
        let position = Vec3::new(x, 0.0, 0.0);
        let pose = Pose {
            position,
            ..Pose::identity()
        };
        let pose = RelativePose::new(&Pose::identity(), &pose, &position);
        cells.energy_with(&kind.charges, &pose)
    };
    assert!(energies(45.0).is_some() && energies(80.0).is_none() && energies(f64::NAN).is_none());
    assert!(cells.memory_bytes() > 0);
}

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: bench/data"]
fn the_energy_of_the_benchmark_state_is_within_its_bound() {
    let folder = bench_folder();
    let system = bench_system(&folder, "bumpy_1620.off");
    let yukawa = Yukawa::uncut(7.0, 1.0 / 9.6).unwrap();
    let mut certified = Certified::for_system(yukawa, &system);
    certified.reset(&system).unwrap();
    let bound = certified.error_bound_kt(&system);
    assert!(bound > 0.0 && bound < 5e-3, "{bound}");
    assert!((certified.total_kt(&system) - -27.093_464_773_453).abs() < 120.0 * bound);
    let mut direct = DirectSum::new(yukawa);
    direct.reset(&system).unwrap();
    for (sum, middle) in direct.pairs(&system).iter().zip(certified.pairs(&system)) {
        assert!((sum.energy_kt - middle.energy_kt).abs() <= bound);
    }
}
