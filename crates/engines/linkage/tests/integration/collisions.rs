//! Collisions against slow twins, and long runs.

use crate::common::brute_force::{corner, cut_squares, smallest_height};
use crate::common::{engine, lattice, loose, random_start};
use protomer_kernel::bisection::halved;
use protomer_kernel::random::CounterRng;
use protomer_linkage::CrystalError;
use protomer_linkage::lattice::collision::detection::Detector;
use protomer_linkage::lattice::collision::lcp;
use protomer_linkage::lattice::collision::replay::first_contact;
use protomer_linkage::lattice::contact::candidates::{Body, Candidates};
use protomer_linkage::lattice::contact::separation::{Rectangle, at_rest, separation};
use protomer_linkage::lattice::{
    CollisionSettings, Contact, Corner, Dynamics, Edges, Engine, Network, Square, State,
};
use std::f64::consts::{FRAC_PI_4, PI, SQRT_2};
use std::sync::Arc;

#[test]
fn separation_has_the_sign_of_the_corner_test() {
    let network = loose(2, None);
    let mut rng = CounterRng::new(1, 0, 0);
    let mut apart = 0;
    for _ in 0..20_000 {
        let positions: Vec<f64> = (0..6)
            .map(|k| rng.uniform_in(-1.0, 1.0) * if k % 3 == 2 { PI } else { 1.1 })
            .collect();
        let [a, b] = [0, 1].map(|p| Rectangle::square(&network, p, at_rest(&positions)));
        let gap = separation(&a, &b);
        let height = smallest_height(&network, &positions);
        // Squares with no corner in each other can still overlap crosswise, when their centres are
        // near.
        if gap > 0.0 {
            apart += 1;
            assert!(height > 0.0, "{positions:?}");
        } else if height > 0.0 {
            let distance = (positions[0] - positions[3]).hypot(positions[1] - positions[4]);
            assert!(distance < 2.0 - SQRT_2, "{positions:?}: {gap} {height}");
        }
    }
    assert!((2_000..18_000).contains(&apart), "{apart}");
}

#[test]
fn candidates_are_all_pairs_within_reach() {
    let mut rng = CounterRng::new(2, 0, 0);
    for (count, edges) in [
        (60, None),
        (60, Some([30.0, 14.0])),
        (12, Some([6.5, 5.2])),
        (3, Some([3.1, 2.9])),
        (1, Some([2.2, 9.0])),
    ] {
        for _ in 0..20 {
            let network = loose(count, edges);
            let [width, height] = edges.unwrap_or([25.0, 18.0]);
            // Positions need not lie in the cell.
            let positions: Vec<f64> = (0..count)
                .flat_map(|_| {
                    [
                        rng.uniform_in(-1.0, 2.0) * width,
                        rng.uniform_in(-1.0, 1.0) * height,
                        rng.uniform_in(-9.0, 9.0),
                    ]
                })
                .collect();
            let skin = 0.4;
            let list = Candidates::new(&network, &positions, skin, true);
            let mut found: Vec<(usize, usize, [i64; 2])> = Vec::new();
            for pair in list.pairs() {
                let Body::Square(q) = pair.second else {
                    panic!()
                };
                found.push((pair.first, q, pair.image.map(i64::from)));
            }
            let mut expected = Vec::new();
            let images = if edges.is_some() { -7..=7 } else { 0..=0 };
            for p in 0..count {
                for q in p..count {
                    for i in images.clone() {
                        for j in images.clone() {
                            let x = positions[3 * q] + i as f64 * width - positions[3 * p];
                            let y = positions[3 * q + 1] + j as f64 * height - positions[3 * p + 1];
                            if x.hypot(y) <= 2.0 + skin && (q > p || i > 0 || (i == 0 && j > 0)) {
                                expected.push((p, q, [i, j]));
                            }
                        }
                    }
                }
            }
            found.sort_unstable();
            expected.sort_unstable();
            assert_eq!(found, expected);
        }
    }
}

#[test]
fn rods_near_squares_are_candidates() {
    let network = lattice(4, 2.0);
    let state = State::coherent(&network, 0.0);
    let list = Candidates::new(&network, &state.positions, 1.5, true);
    let listed: Vec<(usize, usize)> = list
        .pairs()
        .iter()
        .filter_map(|pair| {
            if let Body::Rod(rod) = pair.second {
                Some((rod, pair.first))
            } else {
                None
            }
        })
        .collect();
    let mut expected = 0;
    for (index, rod) in network.rods.iter().enumerate() {
        let (a, b) = (
            corner(&state.positions, rod.from),
            corner(&state.positions, rod.to),
        );
        for p in (0..16).filter(|p| *p != rod.from.square && *p != rod.to.square) {
            let x = 0.5 * (a[0] + b[0]) - state.positions[3 * p];
            let y = 0.5 * (a[1] + b[1]) - state.positions[3 * p + 1];
            let near = x.hypot(y) <= 3.5;
            assert_eq!(near, listed.contains(&(index, p)));
            expected += usize::from(near);
        }
    }
    assert_eq!(expected, listed.len());
    assert!(expected > 10);
}

/// The rate of every kind of gap by central differences.
#[test]
fn rows_are_the_gradients_of_gaps() {
    let mut network = Network::clone(&lattice(3, 1.7));
    network.cell = Some([0.3, 0.2]);
    let mut rng = CounterRng::new(3, 0, 0);
    let vertex = |square, vertex| Corner { square, vertex };
    let (image, shift) = ([1, -1], [0.3, -0.2]);
    for _ in 0..200 {
        let positions: Vec<f64> = (0..27).map(|_| rng.uniform_in(-3.0, 3.0)).collect();
        let velocities: Vec<f64> = (0..27).map(|_| rng.uniform_in(-1.0, 1.0)).collect();
        let moved = |t: f64| -> Vec<f64> {
            positions
                .iter()
                .zip(&velocities)
                .map(|(s, v)| s + t * v)
                .collect()
        };
        let h = 1e-5;
        for side in 0..4 {
            let contacts = [
                Contact::VertexSide {
                    striker: vertex(1, 2),
                    target: 5,
                    side,
                    image,
                },
                // For these the row is the rate only where the bodies touch: see below.
                Contact::RodStop {
                    rod: 4,
                    end: 0,
                    side,
                },
                Contact::RodStop {
                    rod: 4,
                    end: 1,
                    side,
                },
            ];
            for contact in contacts {
                let rate = (contact.gap(&network, &moved(h)) - contact.gap(&network, &moved(-h)))
                    / (2.0 * h);
                let row = contact.row(&network, &positions).dot(&velocities);
                assert!(
                    (rate - row).abs() < 1e-8 * (1.0 + rate.abs()),
                    "{contact:?}: {rate} {row}"
                );
            }
        }
        // A corner on a rod: the row is the rate where the corner lies on the rod's line.
        let (striker, rod) = (vertex(8, 3), 0);
        let mut positions = positions.clone();
        let (a, b) = (
            corner(&positions, network.rods[rod].from),
            corner(&positions, network.rods[rod].to),
        );
        let share = rng.uniform();
        let start = corner(&positions, striker);
        positions[24] += a[0] + share * (b[0] - a[0]) - start[0] + shift[0];
        positions[25] += a[1] + share * (b[1] - a[1]) - start[1] + shift[1];
        let moved = |t: f64| -> Vec<f64> {
            positions
                .iter()
                .zip(&velocities)
                .map(|(s, v)| s + t * v)
                .collect()
        };
        for left in [false, true] {
            let contact = Contact::RodCorner {
                striker,
                rod,
                left,
                image,
            };
            let rate =
                (contact.gap(&network, &moved(h)) - contact.gap(&network, &moved(-h))) / (2.0 * h);
            let row = contact.row(&network, &positions).dot(&velocities);
            assert!(
                (rate - row).abs() < 1e-7 * (1.0 + rate.abs()),
                "{contact:?}: {rate} {row}"
            );
        }
        // Two corners head on: the row is the rate along the bisector as it is.
        let (striker, target) = (vertex(1, 2), vertex(5, 4));
        let (start, to) = (corner(&positions, striker), corner(&positions, target));
        positions[3] += to[0] - start[0];
        positions[4] += to[1] - start[1];
        let contact = Contact::VertexVertex {
            striker,
            target,
            image: [0; 2],
        };
        let moved = |t: f64| -> Vec<f64> {
            positions
                .iter()
                .zip(&velocities)
                .map(|(s, v)| s + t * v)
                .collect()
        };
        assert!(contact.gap(&network, &positions).abs() < 1e-14);
        let rate =
            (contact.gap(&network, &moved(h)) - contact.gap(&network, &moved(-h))) / (2.0 * h);
        let row = contact.row(&network, &positions).dot(&velocities);
        assert!(
            (rate - row).abs() < 1e-7 * (1.0 + rate.abs()),
            "{contact:?}: {rate} {row}"
        );
    }
}

/// The first time two freely flying squares touch, by small steps and bisection.
fn slow_first_contact(network: &Network, state: &State, step: f64) -> Option<f64> {
    let gap = |t: f64| {
        let moved: Vec<f64> = state
            .positions
            .iter()
            .zip(&state.velocities)
            .map(|(s, v)| s + t * v)
            .collect();
        smallest_height(network, &moved)
    };
    const PIECES: usize = 4_000;
    let time = |k: usize| step * k as f64 / PIECES as f64;
    let k = (1..=PIECES).find(|k| gap(time(*k)) < 0.0)?;
    let is_open = |time: f64| gap(time) >= 0.0;
    Some(halved([time(k - 1), time(k)], 60, is_open)[1])
}

#[test]
fn first_contacts_of_free_squares_are_found_however_short() {
    let network = Arc::new(loose(3, None));
    let mut rng = CounterRng::new(4, 0, 0);
    let (mut hits, mut grazes, mut tried) = (0, 0, 0);
    while tried < 400 {
        let positions: Vec<f64> = (0..9)
            .map(|k| rng.uniform_in(-2.5, 2.5) + if k % 3 == 2 { 1.0 } else { 0.0 })
            .collect();
        if (0..3).any(|p| {
            (p + 1..3).any(|q| {
                let [a, b] = [p, q].map(|p| Rectangle::square(&network, p, at_rest(&positions)));
                separation(&a, &b) < 1e-3
            })
        }) {
            continue;
        }
        tried += 1;
        // Fast enough to pass by or through each other within one step.
        let velocities: Vec<f64> = (0..9).map(|_| rng.uniform_in(-12.0, 12.0)).collect();
        let state = State {
            time: 0.0,
            positions,
            velocities,
        };
        let step = 0.05;
        let expected = slow_first_contact(&network, &state, step);
        let mut dynamics = Dynamics::new(network.clone(), Vec::new(), &state).unwrap();
        let mut detector = Detector::new(&network, &state.positions, false);
        let mut end = state.positions.clone();
        let found = detector
            .first_meeting(&mut dynamics, &state, step, &mut end)
            .unwrap()
            .map(|meeting| meeting.time);
        match (expected, found) {
            (Some(expected), Some(found)) => {
                hits += 1;
                // The slow twin can miss a graze between its samples, but never finds one that is
                // not there.
                assert!(found <= expected + 1e-10, "{state:?}: {found} {expected}");
                if found < expected - 1e-10 {
                    grazes += 1;
                    assert!(smallest_height(&network, &end).abs() < 1e-10);
                }
            }
            (None, Some(_)) => {
                grazes += 1;
                assert!(smallest_height(&network, &end).abs() < 1e-10, "{state:?}");
            }
            (Some(expected), None) => panic!("missed the contact at {expected}: {state:?}"),
            (None, None) => {}
        }
    }
    eprintln!("{hits} contacts, {grazes} grazes the slow twin missed, of {tried}");
    assert!(hits > 50 && grazes < 5);
}

#[test]
fn two_free_squares_keep_energy_and_momenta() {
    let network = Arc::new(loose(2, None));
    let mut rng = CounterRng::new(5, 0, 0);
    let mut bounces = 0;
    for _ in 0..200 {
        let aim = rng.uniform_in(-1.5, 1.5);
        let mut state = State {
            time: 0.0,
            positions: vec![
                -2.2,
                0.0,
                rng.uniform_in(-3.0, 3.0),
                2.2,
                aim,
                rng.uniform_in(-3.0, 3.0),
            ],
            velocities: vec![
                1.0,
                0.0,
                rng.uniform_in(-2.0, 2.0),
                -1.0,
                0.1,
                rng.uniform_in(-2.0, 2.0),
            ],
        };
        let before = (
            state.kinetic_energy(&network),
            state.momentum(&network),
            state.angular_momentum(&network),
        );
        let mut engine = engine(&network, &state);
        for _ in 0..300 {
            engine.step(&mut state, 0.02).unwrap();
        }
        bounces += engine.statistics().impacts;
        let after = (
            state.kinetic_energy(&network),
            state.momentum(&network),
            state.angular_momentum(&network),
        );
        assert!((after.0 / before.0 - 1.0).abs() < 1e-13);
        assert!(
            (after.1[0] - before.1[0]).abs() < 1e-13 && (after.1[1] - before.1[1]).abs() < 1e-13
        );
        assert!((after.2 - before.2).abs() < 1e-12);
        assert!(smallest_height(&network, &state.positions) > -1e-9);
    }
    eprintln!("{bounces} bounces");
    assert!(bounces > 120);
}

#[test]
fn squares_in_a_periodic_cell_collide_with_images() {
    let cell = [4.6, 5.0];
    let network = Arc::new(Network {
        rows: 2,
        columns: 2,
        ..loose(4, Some(cell))
    });
    let mut rng = CounterRng::new(6, 0, 0);
    let mut state = State {
        time: 0.0,
        positions: vec![0.0, 0.0, 0.0, 2.3, 0.1, 0.2, 0.1, 2.5, 0.1, 2.4, 2.4, 0.3],
        velocities: (0..12).map(|_| rng.uniform_in(-1.0, 1.0)).collect(),
    };
    let energy = state.kinetic_energy(&network);
    let mut engine = engine(&network, &state);
    for step in 0..8000 {
        engine.step(&mut state, 0.01).unwrap();
        if step % 50 == 0 {
            // All squares with all their images around, as a network without a cell.
            let mut everything = Vec::new();
            for (i, j) in (-2..=2).flat_map(|i| (-2..=2).map(move |j| (i, j))) {
                for s in state.positions.chunks_exact(3) {
                    let wrapped = |x: f64, edge: f64| x - (x / edge).floor() * edge;
                    everything.extend([
                        wrapped(s[0], cell[0]) + f64::from(i) * cell[0],
                        wrapped(s[1], cell[1]) + f64::from(j) * cell[1],
                        s[2],
                    ]);
                }
            }
            assert!(
                smallest_height(&loose(100, None), &everything) > -1e-9,
                "step {step}"
            );
        }
    }
    assert!((state.kinetic_energy(&network) / energy - 1.0).abs() < 1e-11);
    let farthest = state
        .positions
        .chunks_exact(3)
        .map(|s| s[0].abs())
        .fold(0.0, f64::max);
    eprintln!(
        "{} impacts, {farthest} travelled",
        engine.statistics().impacts
    );
    assert!(engine.statistics().impacts > 100);
}

/// p ≥ 0, w ≥ 0, p·w = 0 by trying every active set.
fn enumerate(w: &[f64], q: &[f64]) -> Option<Vec<f64>> {
    use nalgebra::{DMatrix, DVector};
    let n = q.len();
    for set in 0_u32..1 << n {
        let inside: Vec<usize> = (0..n).filter(|j| set >> j & 1 == 1).collect();
        let block = DMatrix::from_fn(inside.len(), inside.len(), |i, j| {
            w[inside[i] * n + inside[j]]
        });
        let right = DVector::from_fn(inside.len(), |i, _| -q[inside[i]]);
        let Some(z) = (if inside.is_empty() {
            Some(right)
        } else {
            block.lu().solve(&right)
        }) else {
            continue;
        };
        let mut p = vec![0.0; n];
        for (j, z) in inside.iter().zip(z.iter()) {
            p[*j] = *z;
        }
        let left = |i: usize| q[i] + (0..n).map(|j| w[i * n + j] * p[j]).sum::<f64>();
        if p.iter().all(|p| *p >= -1e-12) && (0..n).all(|i| left(i) >= -1e-9) {
            return Some(p);
        }
    }
    None
}

#[test]
fn complementarity_against_enumeration() {
    let mut rng = CounterRng::new(7, 0, 0);
    let mut singular = 0;
    for trial in 0..3000 {
        let n = 1 + rng.index(7);
        // More contacts than degrees of freedom make W singular; q is then in its range, as N v is.
        let rank = 1 + rng.index(n + 2);
        let g: Vec<f64> = (0..n * rank).map(|_| rng.uniform_in(-1.0, 1.0)).collect();
        let x: Vec<f64> = (0..rank).map(|_| rng.uniform_in(-1.0, 1.0)).collect();
        let row = |i: usize| &g[i * rank..(i + 1) * rank];
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let w: Vec<f64> = (0..n * n).map(|k| dot(row(k / n), row(k % n))).collect();
        let q: Vec<f64> = (0..n).map(|i| dot(row(i), &x)).collect();
        let solution = lcp::solve(&w, &q);
        assert!(solution.exact, "{trial}");
        for (p, rate) in solution.impulses.iter().zip(&solution.rates) {
            assert!(
                *p >= 0.0 && *rate > -1e-11 && p * rate < 1e-9 * (1.0 + p),
                "{trial}: {solution:?}"
            );
        }
        if rank < n {
            singular += 1;
            continue;
        }
        let expected = enumerate(&w, &q).unwrap();
        // W p is unique, p where W is well conditioned.
        for i in 0..n {
            let rate = q[i] + (0..n).map(|j| w[i * n + j] * expected[j]).sum::<f64>();
            assert!(
                (rate - solution.rates[i]).abs() < 1e-8,
                "{trial}: {expected:?} {solution:?}"
            );
        }
    }
    assert!(singular > 500);
}

#[test]
fn impacts_conserve_energy_and_lossy_ones_lose_it() {
    for (restitution, seed) in [(1.0, 1), (0.5, 2), (0.0, 3)] {
        let network = lattice(4, 3.0 / 22.0);
        let mut state = random_start(&network, seed);
        let settings = CollisionSettings {
            restitution,
            ..CollisionSettings::default()
        };
        let mut engine = Engine::new(network.clone(), Vec::new(), &state, settings).unwrap();
        let momentum = state.momentum(&network);
        for _ in 0..4000 {
            engine.step(&mut state, 0.0025).unwrap();
        }
        let statistics = *engine.statistics();
        eprintln!("e = {restitution}: {statistics:?}");
        assert!(statistics.impacts > 50);
        let after = state.momentum(&network);
        assert!((after[0] - momentum[0]).abs() < 1e-11 && (after[1] - momentum[1]).abs() < 1e-11);
        if restitution == 1.0 {
            assert!(statistics.largest_relative_energy_change < 1e-12);
        } else {
            assert!(statistics.impact_energy < 0.0);
            assert!(
                state.kinetic_energy(&network)
                    < 0.8 * random_start(&network, seed).kinetic_energy(&network)
            );
        }
        assert!(smallest_height(&network, &state.positions) > -1e-9);
    }
}

#[test]
fn long_runs_keep_squares_apart_and_rods_exact() {
    for (size, steps, step, allowed) in [
        (2, 3000, 0.01, 2e-2),
        (2, 3000, 0.0025, 1e-3),
        (10, 300, 0.0025, 1e-2),
    ] {
        for seed in 1..=3 {
            let network = lattice(size, 3.0 / 22.0);
            let mut state = random_start(&network, seed);
            let mut engine = engine(&network, &state);
            let energy = state.kinetic_energy(&network);
            let mut worst = 0.0_f64;
            for index in 0..steps {
                engine.step(&mut state, step).unwrap();
                worst = worst.max((state.kinetic_energy(&network) / energy - 1.0).abs());
                if index % 10 == 0 {
                    assert!(
                        smallest_height(&network, &state.positions) > -1e-9,
                        "{size} {seed} step {index}"
                    );
                    for rod in &network.rods {
                        let (a, b) = (
                            corner(&state.positions, rod.from),
                            corner(&state.positions, rod.to),
                        );
                        assert!(((a[0] - b[0]).hypot(a[1] - b[1]) - rod.length).abs() < 1e-12);
                    }
                }
            }
            let statistics = engine.statistics();
            eprintln!(
                "{size} x {size}, dt {step}, seed {seed}: energy within {worst:.1e}, {statistics:?}"
            );
            assert_eq!(statistics.steps, steps);
            assert!(statistics.impacts > 0 && statistics.capped_steps == 0);
            assert!(statistics.largest_relative_energy_change < 1e-12);
            assert!(
                statistics.largest_rod_violation < 1e-12 && statistics.largest_rod_rate < 1e-12
            );
            assert!(worst < allowed, "{size} {seed}: {worst:e}");
        }
    }
}

/// The angle at which the coherent motion ends (errata: eq. 29c of the paper is wrong).
#[test]
fn coherent_motion_ends_at_the_angle_of_contact() {
    for r0 in [0.05, 3.0 / 22.0, 0.5, 1.0, 2.0, 2.7, 3.0, 3.5, 3.9] {
        let network = lattice(2, r0);
        let mut state = State::coherent(&network, FRAC_PI_4);
        for (p, omega) in state.velocities.iter_mut().skip(2).step_by(3).enumerate() {
            *omega = -network.sign(p);
        }
        let mut dynamics = Dynamics::new(network.clone(), Vec::new(), &state).unwrap();
        let found = first_contact(&mut dynamics, &mut state, 1e-3, 10.0, false)
            .unwrap()
            .unwrap();
        let expected = if r0 <= 2.0 * SQRT_2 {
            -(r0 / (2.0 * SQRT_2)).asin()
        } else {
            FRAC_PI_4 - (-r0 / 4.0).acos()
        };
        let angle = state.positions[2];
        eprintln!(
            "r0 = {r0}: contact at {angle}, expected {expected}, {:?}",
            found.listed()
        );
        assert!((angle - expected).abs() < 1e-6, "{r0}: {angle} {expected}");
    }
}

/// Results are a function of the state alone: neither the list of near pairs nor anything else from
/// the past affects them.
#[test]
fn a_run_taken_up_again_goes_on_as_if_nothing_had_been() {
    for r0 in [3.0 / 22.0, 2.0] {
        let network = lattice(4, r0);
        let mut whole = random_start(&network, 9);
        let start = |state: &State| engine(&network, state);
        let mut engine = start(&whole);
        for _ in 0..700 {
            engine.step(&mut whole, 0.005).unwrap();
        }
        let mut parted = whole.clone();
        let mut fresh = start(&parted);
        for _ in 0..700 {
            engine.step(&mut whole, 0.005).unwrap();
            fresh.step(&mut parted, 0.005).unwrap();
        }
        assert!(fresh.statistics().impacts > 0);
        assert_eq!(whole, parted);
    }
}

#[test]
fn a_periodic_lattice_collides_across_its_edges() {
    // With all its rods the straight rows and columns would hold each other: one rod is missing
    // from each.
    let mut network =
        Network::lattice(4, 4, 0.15, Square::default(), Edges::Periodic, 0.5).unwrap();
    let mut index = 0;
    network.rods.retain(|_| {
        let (i, j) = (index / 8, index / 2 % 4);
        index += 1;
        i != j
    });
    let network = Arc::new(network);
    let mut state = State::coherent(&network, 0.5);
    let mut rng = CounterRng::new(11, 0, 0);
    for omega in state.velocities.iter_mut().skip(2).step_by(3) {
        *omega = rng.uniform_in(-1.0, 1.0);
    }
    let mut dynamics = Dynamics::new(network.clone(), Vec::new(), &state).unwrap();
    dynamics.project_velocities(&mut state.velocities);
    let mut engine = engine(&network, &state);
    let energy = state.kinetic_energy(&network);
    let cell = network.cell.unwrap();
    for step in 0..4000 {
        engine.step(&mut state, 0.0025).unwrap();
        if step % 20 == 0 {
            let mut everything = Vec::new();
            for (i, j) in (-1..=1).flat_map(|i| (-1..=1).map(move |j| (i, j))) {
                for s in state.positions.chunks_exact(3) {
                    everything.extend([
                        s[0] + f64::from(i) * cell[0],
                        s[1] + f64::from(j) * cell[1],
                        s[2],
                    ]);
                }
            }
            assert!(
                smallest_height(&loose(144, None), &everything) > -1e-9,
                "step {step}"
            );
        }
    }
    eprintln!(
        "{:?} {:e}",
        engine.statistics(),
        state.kinetic_energy(&network) / energy - 1.0
    );
    assert!(engine.statistics().impacts > 5);
    assert!((state.kinetic_energy(&network) / energy - 1.0).abs() < 1e-2);
}

/// Collisions do not spoil the order of the integrator: impacts happen at their own times, not at
/// steps.
#[test]
fn trajectories_through_collisions_converge_to_second_order() {
    for (r0, until, seed) in [(1.0, 4.0, 1), (3.0 / 22.0, 1.5, 1), (2.0, 12.0, 1)] {
        let network = lattice(2, r0);
        let ends: Vec<(Vec<f64>, u64)> = [1, 2, 4]
            .iter()
            .map(|finer| {
                let mut state = random_start(&network, seed);
                let mut engine = engine(&network, &state);
                let steps = 2000 * finer;
                for _ in 0..steps {
                    engine.step(&mut state, until / f64::from(steps)).unwrap();
                }
                (state.positions, engine.statistics().impacts)
            })
            .collect();
        let difference = |a: &[f64], b: &[f64]| {
            a.iter()
                .zip(b)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max)
        };
        let coarse = difference(&ends[0].0, &ends[1].0);
        let fine = difference(&ends[1].0, &ends[2].0);
        eprintln!(
            "r0 = {r0}: {} impacts, {coarse:.1e}, {fine:.1e}, ratio {}",
            ends[0].1,
            coarse / fine
        );
        assert!(ends[0].1 >= 2 && ends.iter().all(|(_, impacts)| *impacts == ends[0].1));
        assert!(
            (3.6..4.4).contains(&(coarse / fine)),
            "{r0}: {coarse:e} {fine:e}"
        );
    }
}

#[test]
fn long_rods_cut_no_square() {
    for (r0, steps) in [(1.0, 4000), (2.0, 4000)] {
        for seed in 1..=2 {
            let network = lattice(4, r0);
            let mut state = random_start(&network, seed);
            let settings = CollisionSettings {
                rods_block: Some(true),
                ..CollisionSettings::default()
            };
            let mut engine = Engine::new(network.clone(), Vec::new(), &state, settings).unwrap();
            let energy = state.kinetic_energy(&network);
            for step in 0..steps {
                engine.step(&mut state, 0.01).unwrap();
                if step % 10 == 0 {
                    assert!(
                        smallest_height(&network, &state.positions) > -1e-9,
                        "{r0} {seed} step {step}"
                    );
                    let cuts = cut_squares(&network, &state.positions);
                    assert!(cuts.is_empty(), "{r0} {seed} step {step}: {cuts:?}");
                }
            }
            let change = state.kinetic_energy(&network) / energy - 1.0;
            eprintln!(
                "r0 = {r0}, seed {seed}: energy {change:+.1e}, {:?}",
                engine.statistics()
            );
            assert!(change.abs() < 5e-3);
            assert_eq!(engine.statistics().capped_steps, 0);
            if r0 > SQRT_2 {
                assert!(engine.statistics().rod_contacts > 10);
            }
        }
    }
}

/// The same run without rods as obstacles does go through squares: the test above can fail.
#[test]
fn rods_that_do_not_block_cut_squares() {
    let network = lattice(4, 2.0);
    let mut state = random_start(&network, 1);
    let settings = CollisionSettings {
        rods_block: Some(false),
        ..CollisionSettings::default()
    };
    let mut engine = Engine::new(network.clone(), Vec::new(), &state, settings).unwrap();
    let mut cut = false;
    for _ in 0..4000 {
        engine.step(&mut state, 0.01).unwrap();
        cut = cut || !cut_squares(&network, &state.positions).is_empty();
    }
    assert!(cut);
}

#[test]
fn overlaps_and_bad_settings_are_named() {
    let network = Arc::new(loose(2, None));
    let state = State {
        time: 0.0,
        positions: vec![0.0, 0.0, 0.0, 1.3, 0.0, 0.0],
        velocities: vec![0.0; 6],
    };
    let settings = CollisionSettings::default();
    match Engine::new(network.clone(), Vec::new(), &state, settings).err() {
        Some(CrystalError::Overlap {
            first,
            second,
            depth,
            ..
        }) => {
            assert_eq!((first.as_str(), second.as_str()), ("square 0", "square 1"));
            assert!((depth - (SQRT_2 - 1.3)).abs() < 1e-12);
        }
        other => panic!("{other:?}"),
    }
    let settings = CollisionSettings {
        restitution: 1.5,
        ..settings
    };
    let apart = State {
        positions: vec![0.0, 0.0, 0.0, 3.0, 0.0, 0.0],
        ..state
    };
    assert!(matches!(
        Engine::new(network, Vec::new(), &apart, settings).err(),
        Some(CrystalError::BadSetting {
            setting: "restitution",
            ..
        })
    ));
}
