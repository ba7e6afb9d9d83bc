//! Energies by levels, calibrated or certified, make the decisions of the direct sum.

use crate::common::{bench_folder, bench_system, icosphere};
use protomer_kernel::potential::Yukawa;
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Boundary, Pose, Vec3};
use protomer_mc::energy::certified::Certified;
use protomer_mc::energy::levels::{Calibration, Levels, Table};
use protomer_mc::energy::{DirectSum, Effort, EnergyModel, Pairs};
use protomer_mc::scatter::scattered;
use protomer_mc::system::Trial;
use protomer_mc::{BodyType, Interaction, McError, Settings, Simulation, System};
use std::ops::ControlFlow;
use std::sync::Arc;

const RADIUS: f64 = 10.0;

fn cube(edge_angstrom: f64) -> Boundary {
    Boundary::periodic(Vec3::repeat(edge_angstrom)).unwrap()
}

/// Eight bodies of two kinds with opposite net charge, near contact.
fn eight_bodies(
    charges: usize,
    mean_charge: f64,
    boundary: Boundary,
    rng: &mut CounterRng,
) -> System {
    let mesh = icosphere(RADIUS, 1);
    let mut kind = |sign: f64| {
        let mut charge = |_| {
            let place = rng.vector_in_ball(RADIUS - 1.0);
            (place, sign * mean_charge + rng.uniform_in(-0.6, 0.6))
        };
        let charges: Vec<(Vec3, f64)> = (0..charges).map(&mut charge).collect();
        Arc::new(BodyType::new("ball", &mesh, &charges).unwrap())
    };
    let kinds = vec![kind(1.0), kind(-1.0)];
    let mut body = |i: usize| {
        let corner = |bit: usize| 22.0 * f64::from(u8::from(i >> bit & 1 == 1)) - 11.0;
        let position = Vec3::new(corner(0), corner(1), corner(2));
        let rotation = rng.rotation();
        (i % 2, Pose { position, rotation })
    };
    let bodies: Vec<(usize, Pose)> = (0..8).map(&mut body).collect();
    System::new(kinds, &bodies, boundary).unwrap()
}

/// The poses after some sweeps, cluster moves among them, and how many moves were accepted.
fn trajectory(system: &System, model: Box<dyn EnergyModel>, sweeps: u64) -> (Vec<Pose>, u64) {
    let settings = Settings {
        translation_step_angstrom: 2.0,
        rotation_step_rad: 0.3,
        equilibration_sweeps: 0,
        cluster_moves_per_sweep: 1,
        ..Settings::new(Interaction::HardOnly)
    };
    let mut simulation = Simulation::with_model(system.clone(), settings, model, 5, 0).unwrap();
    let mut go_on = |_: &Simulation| ControlFlow::Continue(());
    simulation.run_until(sweeps, &mut go_on).unwrap();
    let statistics = simulation.statistics();
    let kinds = statistics.translation.iter().chain(&statistics.rotation);
    let accepted = kinds.map(|kind| kind.accepted).sum();
    (simulation.system().poses().to_vec(), accepted)
}

fn assert_same_decisions(system: &System, yukawa: Yukawa, sweeps: u64) {
    let (direct, accepted) = trajectory(system, Box::new(DirectSum::new(yukawa)), sweeps);
    let models: [Box<dyn EnergyModel>; 2] = [
        Box::new(Levels::for_system(yukawa, system)),
        Box::new(Certified::for_system(yukawa, system)),
    ];
    for model in models {
        let (by_levels, also) = trajectory(system, model, sweeps);
        assert_eq!(direct, by_levels, "every pose to the last bit");
        assert_eq!(accepted, also);
    }
    let moves = 8 * sweeps;
    assert!(accepted > moves / 20 && accepted < moves * 19 / 20);
}

#[test]
fn decisions_are_those_of_the_direct_sum() {
    let mut rng = CounterRng::new(33, 0, 0);
    // In the third box images beyond the nearest count; the last is wide enough for cells.
    for (debye, charge, edge) in [
        (9.6, 0.3, 300.0),
        (3.0, 1.0, 120.0),
        (9.6, 0.2, 90.0),
        (3.0, 1.0, 400.0),
    ] {
        let yukawa = Yukawa::uncut(7.0, 1.0 / debye).unwrap();
        let system = eight_bodies(50, charge, cube(edge), &mut rng);
        assert_same_decisions(&system, yukawa, 60);
    }
    let wall = Boundary::SphereWall {
        radius_angstrom: 45.0,
    };
    let without_salt = Yukawa::uncut(7.0, 0.0).unwrap();
    let system = eight_bodies(50, 0.05, wall, &mut rng);
    assert_same_decisions(&system, without_salt, 60);
}

/// Most pairs are so far apart that a decision does without them, unless the budget is close to the
/// rise of the energy.
#[test]
fn images_far_away_are_looked_at_where_they_decide() {
    let mut rng = CounterRng::new(37, 0, 0);
    let yukawa = Yukawa::uncut(7.0, 1.0 / 9.6).unwrap();
    for edge in [150.0, 450.0] {
        let dense = eight_bodies(80, 0.3, cube(edge), &mut rng);
        let system = scattered(&dense, 6, 0).unwrap();
        let mut direct = DirectSum::new(yukawa);
        let mut levels = Levels::for_system(yukawa, &system);
        direct.reset(&system).unwrap();
        levels.reset(&system).unwrap();
        for body in 0..system.len() {
            let mut poses = system.poses().to_vec();
            poses[body] = Pose {
                position: poses[body].position + rng.vector_in_ball(15.0),
                rotation: rng.rotation(),
            };
            let bodies = poses.iter().enumerate();
            let bodies: Vec<_> = bodies
                .map(|(at, pose)| (system.type_index(at), *pose))
                .collect();
            let moved = System::new(system.types().to_vec(), &bodies, *system.boundary()).unwrap();
            let energy_kt = |system: &System| {
                let pairs = Pairs::With(std::slice::from_ref(&body));
                direct
                    .energy_elsewhere_kt(system, pairs, Effort::Full)
                    .unwrap()
            };
            let rise_kt = energy_kt(&moved) - energy_kt(&system);
            let trial = Trial {
                system: &system,
                body,
                pose: *moved.pose(body),
            };
            let partners: Vec<usize> = (0..system.len()).filter(|other| *other != body).collect();
            for margin_kt in [-0.1, -1e-6, 1e-6, 0.1] {
                let budget_kt = rise_kt + margin_kt;
                let accepted = levels.accept(&trial, &partners, budget_kt).unwrap();
                assert_eq!(accepted, margin_kt > 0.0, "{edge}: {body} {margin_kt}");
                levels.reject();
            }
        }
    }
}

/// `cargo test --release -p protomer-mc --test integration levels:: -- --ignored`
#[test]
#[ignore = "a hundred thousand decisions at each of three Debye lengths; run by name"]
fn a_hundred_thousand_decisions_are_those_of_the_direct_sum() {
    // A wall keeps the bodies close to each other.
    let wall = Boundary::SphereWall {
        radius_angstrom: 25.0,
    };
    for debye in [3.0, 9.6, 30.0] {
        let system = eight_bodies(500, 0.03, wall, &mut CounterRng::new(34, 0, 0));
        let yukawa = Yukawa::uncut(7.0, 1.0 / debye).unwrap();
        assert_same_decisions(&system, yukawa, 11_200);
    }
}

/// As above.
#[test]
#[ignore = "slow, five thousand decisions at 3000 charges; needs PROTOMER_TEST_DATA: bench/data"]
fn decisions_on_the_benchmark_state_are_those_of_the_direct_sum() {
    let folder = bench_folder();
    let system = bench_system(&folder, "bumpy_1620.off");
    let yukawa = Yukawa::uncut(7.0, 1.0 / 9.6).unwrap();
    let decisions = |model: Box<dyn EnergyModel>| {
        let settings = Settings {
            translation_step_angstrom: 0.3,
            rotation_step_rad: 0.04,
            equilibration_sweeps: 0,
            ..Settings::new(Interaction::HardOnly)
        };
        let mut simulation = Simulation::with_model(system.clone(), settings, model, 7, 0).unwrap();
        let mut decisions = Vec::new();
        let mut note = |accepted| decisions.push(accepted);
        simulation.trial_moves(5000, &mut note).unwrap();
        decisions
    };
    let direct = decisions(Box::new(DirectSum::new(yukawa)));
    assert_eq!(
        decisions(Box::new(Levels::for_system(yukawa, &system))),
        direct
    );
    assert_eq!(
        decisions(Box::new(Certified::for_system(yukawa, &system))),
        direct
    );
}

#[test]
fn energies_are_the_sums_within_their_bounds() {
    let mut rng = CounterRng::new(36, 0, 0);
    let yukawa = Yukawa::uncut(7.0, 1.0 / 9.6).unwrap();
    let system = eight_bodies(80, 0.3, cube(300.0), &mut rng);
    let mut direct = DirectSum::new(yukawa);
    direct.reset(&system).unwrap();
    for tolerance_kt in [None, Some(1e-1), Some(1e-3), Some(1e-9)] {
        let mut levels = Levels::for_system(yukawa, &system);
        if let Some(tolerance_kt) = tolerance_kt {
            levels = levels.with_tolerance(tolerance_kt);
        }
        levels.reset(&system).unwrap();
        let bound = levels.error_bound_kt(&system);
        assert!(
            bound <= tolerance_kt.unwrap_or(0.1),
            "{bound} {tolerance_kt:?}"
        );
        for (sum, near) in direct.pairs(&system).iter().zip(levels.pairs(&system)) {
            assert_eq!((sum.first, sum.second), (near.first, near.second));
            let difference = (sum.energy_kt - near.energy_kt).abs();
            assert!(
                difference <= bound + 1e-12,
                "{difference} {bound} {tolerance_kt:?}"
            );
        }
    }
}

#[test]
fn energies_elsewhere_are_those_of_the_direct_sum() {
    let mut rng = CounterRng::new(36, 0, 0);
    let system = eight_bodies(60, 0.3, cube(120.0), &mut rng);
    let other = scattered(&system, 5, 0).unwrap();
    let yukawa = Yukawa::uncut(7.0, 1.0 / 9.6).unwrap();
    let mut levels = Levels::for_system(yukawa, &system);
    levels.reset(&system).unwrap();
    let mut direct = DirectSum::new(yukawa);
    direct.reset(&other).unwrap();
    let expected_kt = direct.total_kt(&other);
    let found_kt = |effort| {
        levels
            .energy_elsewhere_kt(&other, Pairs::All, effort)
            .unwrap()
    };
    assert!((found_kt(Effort::Quick) - expected_kt).abs() < 1e-3);
    assert!((found_kt(Effort::Full) - expected_kt).abs() < 1e-9);
    direct.reset(&system).unwrap();
    let kept = levels.total_kt(&system);
    assert!(
        (kept - direct.total_kt(&system)).abs() < 1e-3,
        "the state is kept"
    );
    assert!((kept - expected_kt).abs() > 0.1);
}

#[test]
fn stored_tables_come_back_bit_for_bit_and_damage_is_noticed() {
    let mut rng = CounterRng::new(37, 0, 0);
    let yukawa = Yukawa::uncut(7.0, 1.0 / 9.6).unwrap();
    let system = eight_bodies(30, 0.3, cube(300.0), &mut rng);
    let charges = &system.body_type(0).charges;
    let table = Table::new(charges, &yukawa, 40.0);
    let mut bytes = Vec::new();
    let fingerprint = Table::fingerprint(charges, &yukawa, 40.0);
    table.write_to(&mut bytes, &fingerprint).unwrap();
    let read = |bytes: &[u8], reach| Table::read_from(bytes, charges, &yukawa, reach);
    assert_eq!(read(&bytes, 40.0).unwrap(), table);
    let refused =
        |bytes: &[u8], reach| matches!(read(bytes, reach), Err(McError::UnusableTable(_)));
    assert!(refused(&bytes, 41.0), "another reach");
    for place in (0..bytes.len()).step_by(bytes.len() / 40) {
        let mut changed = bytes.clone();
        changed[place] ^= 1;
        assert!(refused(&changed, 40.0), "changed at {place}");
        assert!(refused(&bytes[..place], 40.0), "cut at {place}");
    }
    bytes.push(0);
    assert!(refused(&bytes, 40.0), "too long");
}

#[test]
fn stored_comparisons_come_back_bit_for_bit_and_damage_is_noticed() {
    let mut rng = CounterRng::new(38, 0, 0);
    let yukawa = Yukawa::uncut(7.0, 1.0 / 9.6).unwrap();
    let system = eight_bodies(30, 0.3, cube(300.0), &mut rng);
    let types = system.types().iter();
    let tables: Vec<_> = types
        .clone()
        .map(|kind| Arc::new(Table::new(&kind.charges, &yukawa, 40.0)))
        .collect();
    let calibration = Calibration::of_system(&yukawa, &system, &tables);
    let names: Vec<String> = types
        .map(|kind| Table::fingerprint(&kind.charges, &yukawa, 40.0))
        .collect();
    let fingerprint = Calibration::fingerprint(&names);
    let mut bytes = Vec::new();
    calibration.write_to(&mut bytes, &fingerprint).unwrap();
    assert_eq!(
        Calibration::read_from(&bytes[..], &fingerprint).unwrap(),
        calibration
    );
    let other = Calibration::fingerprint(&names[1..]);
    let refused = |bytes: &[u8], fingerprint: &str| {
        let read = Calibration::read_from(bytes, fingerprint);
        matches!(read, Err(McError::UnusableTable(_)))
    };
    assert!(refused(&bytes, &other), "of other tables");
    for place in 0..bytes.len() {
        let mut changed = bytes.clone();
        changed[place] ^= 1;
        assert!(refused(&changed, &fingerprint), "changed at {place}");
        assert!(refused(&bytes[..place], &fingerprint), "cut at {place}");
    }
    bytes.push(0);
    assert!(refused(&bytes, &fingerprint), "too long");
}
