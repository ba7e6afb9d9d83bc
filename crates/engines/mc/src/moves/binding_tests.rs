//! Every move that forms and dissolves contacts leaves known distributions unchanged, and a fault in
//! each acceptance rule is noticed.

use super::BindingMove;
use super::contact_turn;
use crate::energy::{DirectSum, EnergyModel};
use crate::hard::overlapping_pairs;
use crate::observables::{contacts, r_g_angstrom};
use crate::system::System;
use crate::test_support::octahedron;
use crate::{BodyType, Interaction, Settings, Simulation};
use protomer_kernel::potential::Yukawa;
use protomer_kernel::random::{CounterRng, Purpose};
use protomer_kernel::statistics::RunningMoments;
use protomer_kernel::{Boundary, Pose, Rotation, TriangleMesh, Vec3};
use std::ops::ControlFlow;
use std::sync::Arc;

const GAP_ANGSTROM: f64 = 3.0;

fn yukawa() -> Yukawa {
    Yukawa::new(7.0, 0.1, 12.0).unwrap()
}

/// A lopsided octahedron with charges off its centre.
fn body(name: &str, sign: f64, length_angstrom: f64) -> Arc<BodyType> {
    let mut mesh = octahedron(4.0);
    mesh.vertices[0] *= length_angstrom / 4.0;
    let mesh = with_middles(mesh);
    // Not the same for both signs, or a swap would leave the energy as it is.
    let place = match sign > 0.0 {
        true => 3.0 * Vec3::x(),
        false => 0.5 * Vec3::z(),
    };
    let charges = [(place, 2.4 * sign), (-Vec3::y(), -0.6 * sign)];
    Arc::new(BodyType::new(name, &mesh, &charges).unwrap())
}

/// The same surface with the middles of its edges as further vertices.
fn with_middles(mesh: TriangleMesh) -> TriangleMesh {
    let mut vertices = mesh.vertices.clone();
    let mut triangles = Vec::new();
    for [a, b, c] in mesh.triangles {
        let mut middle = |i: u32, j: u32| {
            let point = 0.5 * (vertices[i as usize] + vertices[j as usize]);
            let index = vertices.iter().position(|vertex| *vertex == point);
            index.unwrap_or_else(|| {
                vertices.push(point);
                vertices.len() - 1
            }) as u32
        };
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        triangles.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    TriangleMesh {
        vertices,
        triangles,
    }
}

/// Bodies of two kinds in turn, in a row.
fn row(bodies: usize, space: Boundary) -> System {
    let kinds = vec![body("plus", 1.0, 6.0), body("minus", -1.0, 4.0)];
    let middle = 0.5 * (bodies - 1) as f64;
    let place = |k: usize| {
        let position = Vec3::new(0.0, 9.5 * (k as f64 - middle), 0.0);
        let rotation = Rotation::identity();
        (k % 2, Pose { position, rotation })
    };
    let places: Vec<(usize, Pose)> = (0..bodies).map(place).collect();
    System::new(kinds, &places, space).unwrap()
}

fn spaces() -> [Boundary; 2] {
    [
        Boundary::periodic(Vec3::new(37.0, 40.0, 44.0)).unwrap(),
        Boundary::SphereWall {
            radius_angstrom: 20.0,
        },
    ]
}

/// Energy, contacts, and the radius of gyration.
fn measured(system: &System, energy_kt: f64) -> [f64; 3] {
    let touching = contacts(system, GAP_ANGSTROM).len() as f64;
    [energy_kt, touching, r_g_angstrom(system, |_| 1.0)]
}

#[derive(Debug, Clone, Copy)]
struct Estimate {
    mean: f64,
    error: f64,
}

fn estimates(batches: &[[f64; 3]]) -> [Estimate; 3] {
    std::array::from_fn(|k| {
        let moments: RunningMoments = batches.iter().map(|batch| batch[k]).collect();
        Estimate {
            mean: moments.mean(),
            error: moments.independent_standard_error(),
        }
    })
}

/// Boltzmann averages over two bodies anywhere in the space: the direct integral.
fn integrated(space: Boundary) -> [Estimate; 3] {
    const BATCHES: u32 = 16;
    const STATES: u64 = 12_000;
    let system = row(2, space);
    let mut model = DirectSum::new(yukawa());
    let mut batches = Vec::new();
    for batch in 0..BATCHES {
        let (mut sums, mut weights) = ([0.0; 3], 0.0);
        for state in 0..STATES {
            let mut rng = CounterRng::new(11, batch, state);
            let mut pose = || Pose {
                position: match space {
                    Boundary::Periodic { lengths_angstrom } => {
                        lengths_angstrom.map(|edge| edge * rng.uniform_in(-0.5, 0.5))
                    }
                    Boundary::SphereWall { radius_angstrom } => rng.vector_in_ball(radius_angstrom),
                    Boundary::Open => Vec3::zeros(),
                },
                rotation: rng.rotation(),
            };
            let system = system.with_poses(&[pose(), pose()]);
            if !overlapping_pairs(&system).is_empty() {
                continue;
            }
            model.reset(&system).unwrap();
            let energy_kt = model.total_kt(&system);
            let weight = (-energy_kt).exp();
            weights += weight;
            for (sum, value) in sums.iter_mut().zip(measured(&system, energy_kt)) {
                *sum += weight * value;
            }
        }
        batches.push(sums.map(|sum| sum / weights));
    }
    estimates(&batches)
}

/// Averages of sweeps of plain moves, with moves of this kind by a rule after each.
fn simulated(
    system: &System,
    kind: Option<BindingMove>,
    (moves, sweeps): (u64, u64),
    rule: impl Fn(f64) -> f64,
) -> [Estimate; 3] {
    const REPLICAS: u32 = 8;
    let mut batches = Vec::new();
    for replica in 0..REPLICAS {
        let settings = Settings {
            translation_step_angstrom: 4.0,
            rotation_step_rad: 1.0,
            equilibration_sweeps: 0,
            cluster_moves_per_sweep: 0,
            contact_gap_angstrom: GAP_ANGSTROM,
            ..Settings::new(Interaction::YukawaDirect(yukawa()))
        };
        let mut simulation = Simulation::new(system.clone(), settings, 5, replica).unwrap();
        let mut sums = [0.0; 3];
        for sweep in 0..sweeps {
            let mut go_on = |_: &Simulation| ControlFlow::Continue(());
            simulation.run_until(sweep + 1, &mut go_on).unwrap();
            for step in moves * sweep..moves * (sweep + 1) {
                let mut rng = CounterRng::for_purpose(5, replica, step, Purpose::BindingMove);
                if let Some(kind) = kind {
                    simulation.binding_move_by(kind, &mut rng, &rule).unwrap();
                }
            }
            let energy_kt = simulation.observables().energy_kt;
            let now = measured(simulation.system(), energy_kt);
            for (sum, value) in sums.iter_mut().zip(now) {
                *sum += value / sweeps as f64;
            }
        }
        assert_eq!(overlapping_pairs(simulation.system()), []);
        batches.push(sums);
    }
    estimates(&batches)
}

/// The largest deviation, in standard errors.
fn apart(averages: &[Estimate; 3], wanted: &[Estimate; 3]) -> f64 {
    let pairs = averages.iter().zip(wanted);
    let sigmas = pairs.map(|(a, b)| (a.mean - b.mean).abs() / a.error.hypot(b.error));
    sigmas.fold(0.0, f64::max)
}

#[test]
fn two_bodies_have_the_averages_of_the_direct_integral() {
    for space in spaces() {
        let wanted = integrated(space);
        for &kind in BindingMove::ALL {
            let averages = simulated(&row(2, space), Some(kind), (6, 3_000), |allowance_kt| {
                allowance_kt
            });
            let sigmas = apart(&averages, &wanted);
            assert!(
                sigmas < 4.0,
                "{kind:?}, {space:?}: {sigmas}\n{averages:?}\n{wanted:?}"
            );
            assert!(
                averages[1].error < 0.03 && averages[0].error < 0.08,
                "{averages:?}"
            );
        }
    }
}

#[test]
fn a_mixture_has_the_averages_of_plain_moves() {
    let [space, _] = spaces();
    let system = row(4, space);
    let wanted = simulated(&system, None, (0, 10_000), |allowance_kt| allowance_kt);
    for &kind in BindingMove::ALL {
        let averages = simulated(&system, Some(kind), (8, 2_000), |allowance_kt| allowance_kt);
        let sigmas = apart(&averages, &wanted);
        assert!(sigmas < 4.0, "{kind:?}: {sigmas}\n{averages:?}\n{wanted:?}");
    }
}

#[test]
fn a_fault_in_each_rule_is_noticed() {
    // So narrow that the bodies are often in contact.
    let space = Boundary::SphereWall {
        radius_angstrom: 11.0,
    };
    let wanted = integrated(space);
    let forgotten = |_: f64| 0.0;
    for kind in [
        BindingMove::Relocation,
        BindingMove::ContactTurn,
        BindingMove::Group,
    ] {
        let averages = simulated(&row(2, space), Some(kind), (8, 5_000), forgotten);
        let sigmas = apart(&averages, &wanted);
        assert!(sigmas > 8.0, "{kind:?}: {sigmas}\n{averages:?}\n{wanted:?}");
    }
    // A swap has no allowance; this one forgets the energy. Two of them cancel, so their number is odd.
    let always = |_: f64| f64::INFINITY;
    let averages = simulated(&row(2, space), Some(BindingMove::Swap), (5, 5_000), always);
    let sigmas = apart(&averages, &wanted);
    assert!(sigmas > 8.0, "{sigmas}\n{averages:?}\n{wanted:?}");
}

#[test]
fn a_turn_about_a_contact_keeps_it() {
    let system = row(3, spaces()[0]);
    for step in 0..200 {
        let mut rng = CounterRng::new(3, 0, step);
        let Some(proposal) = contact_turn::propose(&system, 5.0, &mut rng) else {
            continue;
        };
        let (body, pose) = proposal.poses[0];
        let old = system.pose(body);
        // A point of the body has stayed, and it is a vertex that touches another body.
        let is_fixed = |vertex: &Vec3| {
            (old.transform_point(vertex) - pose.transform_point(vertex)).norm() < 1e-9
        };
        let corners: Vec<Vec3> = (0..18)
            .map(|mark| system.body_type(body).surface_points.of_mark(mark))
            .collect();
        assert!(corners.iter().any(is_fixed), "{step}");
        let trial_system = system.with_moved(&proposal.poses);
        assert!(
            contacts(&trial_system, 5.0)
                .iter()
                .any(|(i, j)| *i == body || *j == body)
        );
    }
}
