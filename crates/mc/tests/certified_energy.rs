//! The certified energies contain the direct sum, and the certified decisions are the direct sum's.

#![allow(clippy::unwrap_used)]

mod common;

use common::icosphere;
use protomer_kernel::pose::RelativePose;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Boundary, Pose, Vec3};
use protomer_mc::charges::ChargeCloud;
use protomer_mc::energy::certified::{CertifiedSum, ChargeTable};
use protomer_mc::energy::{DirectSum, EnergyModel, pair_energy_kt};
use protomer_mc::{BodyType, Interaction, Settings, Simulation, System};
use std::ops::ControlFlow;
use std::sync::Arc;

const RADIUS: f64 = 10.0;

fn random_charges(count: usize, rng: &mut CounterRng) -> Vec<(Vec3, f64)> {
    (0..count)
        .map(|_| (rng.vector_in_ball(RADIUS - 1.0), rng.uniform_in(-0.6, 0.6)))
        .collect()
}

#[test]
fn intervals_contain_the_direct_sum_from_contact_to_beyond_the_cutoff() {
    let mut rng = CounterRng::new(31, 0, 0);
    let (mut returned, mut narrow) = (0, 0);
    for (debye, cutoff) in [
        (3.0, 15.0),
        (9.6, 48.0),
        (30.0, 60.0),
        (9.6, f64::INFINITY),
        (9.6, 1000.0),
    ] {
        let yukawa = Yukawa::new(7.0, 1.0 / debye, cutoff).unwrap();
        let mut bodies: Vec<Vec<(Vec3, f64)>> = [0, 1, 2, 40, 120]
            .iter()
            .map(|count| random_charges(*count, &mut rng))
            .collect();
        // Charges that coincide.
        let again = bodies[3][7];
        bodies[3].push(again);
        bodies[3].push((again.0, -0.2));
        let clouds: Vec<ChargeCloud> = bodies
            .iter()
            .map(|charges| ChargeCloud::new(charges))
            .collect();
        let tables: Vec<ChargeTable> = clouds
            .iter()
            .map(|cloud| ChargeTable::new(cloud, &yukawa))
            .collect();
        let farthest = cutoff.min(60.0) + 2.0 * RADIUS + 3.0;
        for case in 0..400 {
            let (a, b) = (case % 5, case / 5 % 5);
            let position = rng.unit_vector() * rng.uniform_in(2.0 * RADIUS, farthest);
            let pose = Pose {
                position,
                rotation: rng.rotation(),
            };
            let relative = RelativePose::new(&Pose::identity(), &pose, &pose.position);
            let direct = pair_energy_kt(&yukawa, &clouds[a], &clouds[b], &relative);
            let Some(interval) = tables[a].energy_interval(&tables[b], &relative) else {
                assert!(
                    cutoff < 30.0,
                    "only cut-offs of the body's size are refused"
                );
                continue;
            };
            assert!(
                interval.low_kt() <= direct && direct <= interval.high_kt(),
                "{debye} {cutoff} {a} {b}: {direct} {interval:?}"
            );
            returned += 1;
            narrow += usize::from(interval.error_kt < 0.02);
        }
    }
    // Of 2000 cases those of charged bodies with the shortest cut-off are refused.
    assert!(
        returned > 1700 && narrow > returned * 9 / 10,
        "bounds are narrow enough to be of use: {narrow} of {returned}"
    );
}

/// Poses that put one pair of charges within rounding of the cut-off, on either side.
#[test]
fn a_pair_at_the_very_cutoff_is_inside_the_interval() {
    let mut rng = CounterRng::new(32, 0, 0);
    let yukawa = Yukawa::new(7.0, 1.0 / 9.6, 48.0).unwrap();
    let charges = random_charges(60, &mut rng);
    let cloud = ChargeCloud::new(&charges);
    let table = ChargeTable::new(&cloud, &yukawa);
    for case in 0..300 {
        let offset = [0.0, 1e-14, 1e-12, 1e-9, 1e-7, 1e-5, 1e-4][case % 7]
            * if case % 2 == 0 { 1.0 } else { -1.0 };
        let pose = Pose {
            position: Vec3::zeros(),
            rotation: rng.rotation(),
        };
        let mut relative = RelativePose::new(&Pose::identity(), &pose, &Vec3::zeros());
        let (first, second) = (charges[rng.index(60)].0, charges[rng.index(60)].0);
        relative.translation =
            first + rng.unit_vector() * (48.0 + offset) - relative.rotation * second;
        if relative.translation.norm() < 2.0 * RADIUS {
            continue;
        }
        let direct = pair_energy_kt(&yukawa, &cloud, &cloud, &relative);
        let interval = table.energy_interval(&table, &relative).unwrap();
        assert!(
            interval.low_kt() <= direct && direct <= interval.high_kt(),
            "{offset} {direct} {interval:?}"
        );
    }
}

fn trajectory(
    system: &System,
    yukawa: Yukawa,
    model: Box<dyn EnergyModel>,
    sweeps: u64,
) -> (Vec<Pose>, u64) {
    let settings = Settings {
        translation_step_angstrom: 2.0,
        rotation_step_rad: 0.3,
        equilibration_sweeps: 0,
        cluster_moves_per_sweep: 1,
        ..Settings::new(Interaction::YukawaDirect(yukawa))
    };
    let mut simulation = Simulation::with_model(system.clone(), settings, model, 5, 0).unwrap();
    simulation
        .run_until(sweeps, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    let statistics = simulation.statistics();
    let accepted = statistics
        .translation
        .iter()
        .chain(&statistics.rotation)
        .map(|kind| kind.accepted)
        .sum();
    (simulation.system().poses().to_vec(), accepted)
}

/// Eight bodies of two kinds with opposite net charge, near contact.
fn eight_bodies(charges: usize, mean_charge: f64, rng: &mut CounterRng) -> System {
    let mesh = icosphere(RADIUS, 1);
    let kinds: Vec<Arc<BodyType>> = [1.0, -1.0]
        .iter()
        .map(|sign| {
            let charges: Vec<(Vec3, f64)> = random_charges(charges, rng)
                .iter()
                .map(|(x, q)| (*x, q + sign * mean_charge))
                .collect();
            Arc::new(BodyType::new("ball", &mesh, &charges).unwrap())
        })
        .collect();
    let bodies: Vec<(usize, Pose)> = (0..8)
        .map(|i| {
            let corner = |bit: usize| 22.0 * f64::from(u8::from(i >> bit & 1 == 1)) - 11.0;
            (
                i % 2,
                Pose {
                    position: Vec3::new(corner(0), corner(1), corner(2)),
                    rotation: rng.rotation(),
                },
            )
        })
        .collect();
    System::new(
        kinds,
        &bodies,
        Boundary::periodic(Vec3::repeat(200.0)).unwrap(),
    )
    .unwrap()
}

#[test]
fn decisions_are_those_of_the_direct_sum() {
    let mut rng = CounterRng::new(33, 0, 0);
    for (debye, cutoff, charge) in [(9.6, 48.0, 0.3), (3.0, 15.0, 1.0), (20.0, 40.0, 0.2)] {
        let yukawa = Yukawa::new(7.0, 1.0 / debye, cutoff).unwrap();
        let system = eight_bodies(50, charge, &mut rng);
        let (direct, accepted) = trajectory(&system, yukawa, Box::new(DirectSum::new(yukawa)), 100);
        let (certified, also) =
            trajectory(&system, yukawa, Box::new(CertifiedSum::new(yukawa)), 100);
        assert_eq!(direct, certified, "every pose to the last bit");
        assert!(
            accepted == also && accepted > 80 && accepted < 750,
            "both answers occur: {accepted}"
        );
    }
}

/// `cargo test --release -p protomer-mc --test certified_energy -- --ignored`
#[test]
#[ignore = "a hundred thousand decisions; run by name"]
fn a_hundred_thousand_decisions_are_those_of_the_direct_sum() {
    let yukawa = Yukawa::new(7.0, 1.0 / 9.6, 48.0).unwrap();
    let system = eight_bodies(150, 0.1, &mut CounterRng::new(34, 0, 0));
    let (direct, accepted) = trajectory(&system, yukawa, Box::new(DirectSum::new(yukawa)), 12_500);
    let (certified, also) =
        trajectory(&system, yukawa, Box::new(CertifiedSum::new(yukawa)), 12_500);
    assert_eq!(direct, certified, "every pose to the last bit");
    assert!(
        accepted == also && accepted > 5_000 && accepted < 95_000,
        "both answers occur: {accepted}"
    );
}

/// As above; bodies as large as those for which certified energies are made.
#[test]
#[ignore = "tables of 3000 charges; run by name"]
fn intervals_of_large_bodies_contain_the_direct_sum() {
    let mut rng = CounterRng::new(35, 0, 0);
    let yukawa = Yukawa::new(7.0, 1.0 / 9.6, 48.0).unwrap();
    let cloud = |rng: &mut CounterRng| {
        let charges: Vec<(Vec3, f64)> = (0..3000)
            .map(|_| (rng.vector_in_ball(15.0), rng.uniform_in(-0.6, 0.6)))
            .collect();
        ChargeCloud::new(&charges)
    };
    let clouds = [cloud(&mut rng), cloud(&mut rng)];
    let tables = [0, 1].map(|i: usize| ChargeTable::new(&clouds[i], &yukawa));
    let mut largest = 0.0_f64;
    for _ in 0..100 {
        let position = rng.unit_vector() * rng.uniform_in(32.0, 80.0);
        let relative = RelativePose::new(
            &Pose::identity(),
            &Pose {
                position,
                rotation: rng.rotation(),
            },
            &position,
        );
        let direct = pair_energy_kt(&yukawa, &clouds[0], &clouds[1], &relative);
        let interval = tables[0].energy_interval(&tables[1], &relative).unwrap();
        assert!(
            interval.low_kt() <= direct && direct <= interval.high_kt(),
            "{direct} {interval:?}"
        );
        let error = (interval.middle_kt - direct).abs();
        assert!(
            error <= 0.25 * interval.likely_error_kt && interval.likely_error_kt < 1e-3,
            "{error} {interval:?}"
        );
        largest = largest.max(error / interval.error_kt);
    }
    // Far above what is found, far below what would be needed to break a bound.
    assert!(largest < 0.1, "an error of {largest} of its bound");
}

#[test]
fn approximate_energies_are_within_their_tolerance() {
    let tolerance_kt = 1e-3;
    let yukawa = Yukawa::new(7.0, 1.0 / 9.6, 48.0).unwrap();
    let system = eight_bodies(50, 0.3, &mut CounterRng::new(36, 0, 0));
    let mut direct = DirectSum::new(yukawa);
    let mut approximate = Interaction::YukawaApproximate {
        yukawa,
        tolerance_kt,
    }
    .model();
    direct.reset(&system).unwrap();
    approximate.reset(&system).unwrap();
    let bound = approximate.error_bound_kt();
    assert!(bound > 0.0 && bound <= tolerance_kt, "{bound}");
    for (exact, near) in direct.pairs().iter().zip(approximate.pairs()) {
        assert_eq!((exact.first, exact.second), (near.first, near.second));
        assert!(
            (exact.energy_kt - near.energy_kt).abs() <= bound,
            "{exact:?} {near:?}"
        );
    }
}
