//! Depletants: exact results for two spheres, and all kinds of moves with the same averages.

use crate::common;

use common::*;
use protomer_kernel::{Boundary, Pose, Vec3};
use protomer_mc::{BodyType, Depletants, Interaction, Settings, Simulation, System};
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Volume that two balls share.
fn lens(radius: f64, apart: f64) -> f64 {
    let height = (radius - 0.5 * apart).max(0.0);
    2.0 * PI / 3.0 * height * height * (3.0 * radius - height)
}

/// Part of the time for which two spheres among depletants touch a common one, in a box of this volume (Asakura and
/// Oosawa).
fn bonded(radius: f64, depletants: &Depletants, volume: f64) -> f64 {
    let range = 2.0 * (radius + depletants.radius_angstrom);
    let (contact, steps) = (2.0 * radius, 20_000);
    let width = (range - contact) / f64::from(steps);
    let mut inside = 0.0;
    for step in 0..steps {
        let r = contact + (f64::from(step) + 0.5) * width;
        let shared = lens(radius + depletants.radius_angstrom, r);
        inside += (depletants.fugacity_per_angstrom3() * shared).exp() * 4.0 * PI * r * r * width;
    }
    inside / (inside + volume - 4.0 / 3.0 * PI * range.powi(3))
}

/// An icosphere with the volume of a sphere.
fn sphere(radius: f64, level: usize) -> Arc<BodyType> {
    let mesh = icosphere(radius, level);
    let wanted = 4.0 / 3.0 * PI * radius.powi(3);
    let factor = (wanted / mesh.volume_angstrom3()).cbrt();
    let mesh = icosphere(factor * radius, level);
    Arc::new(BodyType::new("sphere", &mesh, &[]).unwrap())
}

fn row(kinds: &[Arc<BodyType>], bodies: &[usize], spacing: f64, boundary: Boundary) -> System {
    let pose = |place: usize| Pose {
        position: Vec3::new(spacing * place as f64, 0.0, 0.0),
        ..Pose::identity()
    };
    let placed: Vec<(usize, Pose)> = bodies
        .iter()
        .enumerate()
        .map(|(place, kind)| (*kind, pose(place)))
        .collect();
    System::new(kinds.to_vec(), &placed, boundary).unwrap()
}

#[test]
fn two_spheres_among_depletants_are_those_of_asakura_and_oosawa() {
    let (radius, edge) = (10.0, 70.0);
    let kind = sphere(radius, 3);
    let system = row(
        &[kind],
        &[0, 0],
        30.0,
        Boundary::periodic(Vec3::repeat(edge)).unwrap(),
    );
    for (radius_angstrom, reservoir_fraction) in [(4.0, 0.3), (7.0, 0.4)] {
        let depletants = Depletants {
            radius_angstrom,
            reservoir_fraction,
        };
        let range = 2.0 * (radius + radius_angstrom);
        for cluster_moves in [0, 2] {
            let settings = Settings {
                depletants: Some(depletants),
                ..settings(Interaction::HardOnly, cluster_moves)
            };
            let [near] = simulate(&system, settings, 8, 40_000, |state| {
                [f64::from(u8::from(distance(state.system()) < range))]
            });
            let exact = bonded(radius, &depletants, edge.powi(3));
            let case = format!("{depletants:?}, {cluster_moves} cluster moves");
            assert_agree(&case, near, Estimate::exact(exact), 0.05 * exact);
        }
    }
}

/// Three bodies that are not convex, of two kinds: half turns of one or several, moves next to others, groups and swaps have the averages
/// of single moves.
#[test]
fn all_kinds_of_moves_have_the_same_averages() {
    let kinds = [6.0, 7.5]
        .map(|radius| Arc::new(BodyType::new("bump", &chiral_bump(radius), &[]).unwrap()));
    let boundary = Boundary::periodic(Vec3::new(46.0, 50.0, 54.0)).unwrap();
    let system = row(&kinds, &[0, 1, 0], 16.0, boundary);
    let averages = |cluster_moves: u32, binding_moves: u32| {
        let settings = Settings {
            depletants: Some(Depletants {
                radius_angstrom: 4.0,
                reservoir_fraction: 0.5,
            }),
            binding_moves_per_sweep: binding_moves,
            ..settings(Interaction::HardOnly, cluster_moves)
        };
        simulate(&system, settings, 8, 30_000, |state| {
            let apart = |one, other| state.system().pair(one, other).displacement.norm();
            let pairs = [apart(0, 1), apart(0, 2), apart(1, 2)];
            let near = pairs.iter().filter(|distance| **distance < 15.0).count();
            [near as f64, f64::from(u8::from(near >= 2))]
        })
    };
    let single = averages(0, 0);
    for (cluster_moves, binding_moves) in [(3, 0), (0, 3)] {
        let others = averages(cluster_moves, binding_moves);
        for (number, what) in ["pairs", "clusters"].into_iter().enumerate() {
            let case = format!("{what}, {cluster_moves} cluster and {binding_moves} binding moves");
            assert_agree(
                &case,
                others[number],
                single[number],
                0.05 * single[number].mean,
            );
        }
    }
    let without = simulate(
        &system,
        settings(Interaction::HardOnly, 1),
        2,
        10_000,
        |state| {
            [f64::from(u8::from(
                state.system().pair(0, 1).displacement.norm() < 15.0,
            ))]
        },
    );
    assert!(3.0 * without[0].mean < single[0].mean, "depletants attract");
}

#[test]
fn a_run_among_depletants_continues_bit_for_bit() {
    let kind = sphere(8.0, 1);
    let boundary = Boundary::periodic(Vec3::repeat(60.0)).unwrap();
    let system = row(&[kind], &[0, 0, 0], 18.0, boundary);
    let settings = Settings {
        depletants: Some(Depletants {
            radius_angstrom: 3.0,
            reservoir_fraction: 0.4,
        }),
        binding_moves_per_sweep: 1,
        ..settings(Interaction::HardOnly, 1)
    };
    let mut whole = Simulation::new(system.clone(), settings, 3, 1).unwrap();
    let run = |simulation: &mut Simulation, sweep| {
        simulation
            .run_until(sweep, &mut |_| ControlFlow::Continue(()))
            .unwrap();
    };
    run(&mut whole, 150);
    let mut continued = Simulation::resume(system, whole.checkpoint()).unwrap();
    run(&mut whole, 400);
    run(&mut continued, 400);
    assert_eq!(whole.checkpoint(), continued.checkpoint());
}
