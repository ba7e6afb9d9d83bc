//! Long runs, for what must hold at any length. Run by name with `-- --ignored --nocapture`.

use crate::common::brute_force::{cut_squares, smallest_height};
use crate::common::{drawn_start, engine, lattice};
use protomer_linkage::analysis::grima::{CoherentOrbit, smallest_angle};
use protomer_linkage::analysis::modes::Modes;
use protomer_linkage::lattice::collision::replay::first_contact;
use protomer_linkage::lattice::paper::{PaperEngine, PaperSettings};
use protomer_linkage::lattice::{
    CollisionSettings, Dynamics, Engine, Square, Start, StartVelocities,
};
use std::f64::consts::FRAC_PI_4;

/// Processor time of this thread in seconds, where the system tells.
fn thread_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split_whitespace()
        .next()
        .and_then(|word| word.parse::<f64>().ok())
        .map_or(f64::NAN, |count| 1e-9 * count)
}

const STEPS: usize = 100_000;
const STEP: f64 = 0.0025;

#[test]
#[ignore = "10^5 steps"]
fn a_hundred_thousand_steps_without_collisions() {
    let network = lattice(10, 3.0 / 22.0);
    let mut state = drawn_start(&network, 1, None);
    let mut dynamics = Dynamics::new(network.clone(), Vec::new(), &state).unwrap();
    let (energy, spin) = (
        state.kinetic_energy(&network),
        state.angular_momentum(&network),
    );
    let mut sigma = vec![0.0; network.rods.len()];
    // Rods, J v, energy from and to, momentum, angular momentum.
    let mut worst = [0.0, 0.0, f64::INFINITY, f64::NEG_INFINITY, 0.0, 0.0_f64];
    let mut seconds = 0.0;
    for _ in 0..STEPS {
        let begin = thread_seconds();
        dynamics.step(&mut state, STEP).unwrap();
        seconds += thread_seconds() - begin;
        let (_, violation) = dynamics.rods().violations(&state.positions, &mut sigma);
        worst[0] = worst[0].max(violation.abs());
        dynamics.rods().apply(&state.velocities, &mut sigma);
        worst[1] = sigma
            .iter()
            .fold(worst[1], |worst, rate| worst.max(rate.abs()));
        let change = state.kinetic_energy(&network) / energy - 1.0;
        worst[2] = worst[2].min(change);
        worst[3] = worst[3].max(change);
        let [x, y] = state.momentum(&network);
        worst[4] = worst[4].max(x.hypot(y));
        worst[5] = worst[5].max((state.angular_momentum(&network) - spin).abs());
    }
    eprintln!(
        "{STEPS} steps of {STEP}, no collisions: rods {:.1e}, J v {:.1e}, energy {:+.1e} to {:+.1e}, at the end {:+.1e}, \
         momentum {:.1e}, angular momentum {:.1e} of {spin:.2}; {:.0} steps per CPU-second",
        worst[0],
        worst[1],
        worst[2],
        worst[3],
        state.kinetic_energy(&network) / energy - 1.0,
        worst[4],
        worst[5],
        STEPS as f64 / seconds
    );
    assert!(worst[0] < 1e-12 && worst[1] < 1e-12);
    assert!(worst[2] > -2e-2 && worst[3] < 2e-2);
    assert!(worst[4] < 1e-10 && worst[5] < 1e-10);
}

#[test]
#[ignore = "10^5 steps"]
fn a_hundred_thousand_steps_with_collisions() {
    let network = lattice(10, 3.0 / 22.0);
    let mut state = drawn_start(&network, 1, None);
    let settings = CollisionSettings::default();
    let mut engine = Engine::new(network.clone(), Vec::new(), &state, settings).unwrap();
    let (energy, spin) = (
        state.kinetic_energy(&network),
        state.angular_momentum(&network),
    );
    let mut worst = [f64::INFINITY, f64::NEG_INFINITY, 0.0, 0.0_f64];
    let mut seconds = 0.0;
    for _ in 0..STEPS {
        let begin = thread_seconds();
        engine.step(&mut state, STEP).unwrap();
        seconds += thread_seconds() - begin;
        let change = state.kinetic_energy(&network) / energy - 1.0;
        worst[0] = worst[0].min(change);
        worst[1] = worst[1].max(change);
        let [x, y] = state.momentum(&network);
        worst[2] = worst[2].max(x.hypot(y));
        worst[3] = worst[3].max((state.angular_momentum(&network) - spin).abs());
    }
    let statistics = engine.statistics();
    eprintln!(
        "{STEPS} steps of {STEP} with collisions: energy {:+.1e} to {:+.1e}, at the end {:+.1e}, momentum {:.1e}, angular \
         momentum {:.1e} of {spin:.2}; {:.0} steps per CPU-second, {statistics:?}",
        worst[0],
        worst[1],
        state.kinetic_energy(&network) / energy - 1.0,
        worst[2],
        worst[3],
        STEPS as f64 / seconds
    );
    assert!(statistics.impacts > 1000);
    assert!(statistics.largest_rod_violation < 1e-12 && statistics.largest_rod_rate < 1e-12);
    assert!(
        statistics.smallest_gap.unwrap() > -1e-9
            && statistics.largest_relative_energy_change < 1e-10
    );
    assert!(worst[2] < 1e-9 && worst[3] < 1e-9);
}

#[test]
#[ignore = "2 x 10^4 steps of 10 x 10 with rods as obstacles"]
fn ten_times_longer_than_the_papers_no_rod_runs_through_a_square() {
    for r0 in [1.0, 2.0] {
        let network = lattice(10, r0);
        let mut state = drawn_start(&network, 1, None);
        let settings = CollisionSettings {
            rods_block: Some(true),
            ..CollisionSettings::default()
        };
        let mut engine = Engine::new(network.clone(), Vec::new(), &state, settings).unwrap();
        let energy = state.kinetic_energy(&network);
        for step in 1..=10_000 {
            engine.step(&mut state, 0.01).unwrap();
            if step % 10 == 0 {
                let height = smallest_height(&network, &state.positions);
                assert!(
                    height > -1e-9,
                    "r0 = {r0}, step {step}: a corner is {height} inside a square"
                );
                let cuts = cut_squares(&network, &state.positions);
                assert!(cuts.is_empty(), "r0 = {r0}, step {step}: {cuts:?}");
            }
        }
        let change = state.kinetic_energy(&network) / energy - 1.0;
        eprintln!("r0 = {r0}: energy {change:+.1e}, {:?}", engine.statistics());
        assert!(engine.statistics().rod_contacts > 0);
    }
}

/// How far rods that nothing stops, as in the papers, get in the same time: the test above can fail.
#[test]
#[ignore = "10^4 steps of 10 x 10"]
fn without_rods_as_obstacles_they_run_through_squares() {
    for r0 in [1.0, 2.0] {
        let network = lattice(10, r0);
        let mut state = drawn_start(&network, 1, None);
        let settings = CollisionSettings {
            rods_block: Some(false),
            ..CollisionSettings::default()
        };
        let mut engine = Engine::new(network.clone(), Vec::new(), &state, settings).unwrap();
        let first = (1..=10_000).find(|_| {
            engine.step(&mut state, 0.01).unwrap();
            !cut_squares(&network, &state.positions).is_empty()
        });
        eprintln!("r0 = {r0}: the first rod is in a square at step {first:?}");
        assert!(first.is_some());
    }
}

#[test]
#[ignore = "several lengths and steps"]
fn coherent_two_by_two_follows_the_exact_orbit_through_contacts() {
    for r0 in [0.05, 3.0 / 22.0, 1.0, 2.0] {
        let network = lattice(2, r0);
        let velocities = StartVelocities::Checkerboard { rate: -1.0 };
        let start = Start {
            velocities,
            ..Start::default()
        }
        .build(&network, 0)
        .unwrap()
        .state;
        let orbit = CoherentOrbit::new(2, 2, Square::default(), r0, FRAC_PI_4, -1.0).unwrap();
        let errors = [0.01, 0.005, 0.0025].map(|step| {
            let mut state = start.clone();
            let mut engine = engine(&network, &state);
            let mut worst = [0.0_f64; 2];
            for _ in 0..(10.0 / step) as usize {
                engine.step(&mut state, step).unwrap();
                let angle = Modes::from_coordinates(&network, &state.positions).checkerboard;
                let rate = Modes::from_coordinates(&network, &state.velocities).checkerboard;
                worst[0] = worst[0].max((angle - orbit.state(state.time)[0]).abs());
                worst[1] = worst[1].max((rate.abs() - orbit.rate_at(angle)).abs());
            }
            assert!(engine.statistics().impacts >= 2);
            worst
        });
        let mut dynamics = Dynamics::new(network.clone(), Vec::new(), &start).unwrap();
        let mut state = start.clone();
        first_contact(&mut dynamics, &mut state, 1e-3, 10.0, false)
            .unwrap()
            .unwrap();
        let contact = Modes::from_coordinates(&network, &state.positions).checkerboard
            - smallest_angle(r0, 1.0).unwrap();
        for (step, [angle, rate]) in [0.01, 0.005, 0.0025].iter().zip(errors) {
            eprintln!(
                "r0 = {r0}, step {step}, a time of 10: eq. 29a missed by {angle:.2e}, eq. 29b by {rate:.2e}"
            );
        }
        eprintln!("r0 = {r0}: angle of contact missed by {contact:.1e}");
        for which in [0, 1] {
            assert!(errors[0][which] < 1e-2);
            assert!(
                errors[1][which] < 0.3 * errors[0][which]
                    && errors[2][which] < 0.3 * errors[1][which]
            );
        }
        assert!(contact.abs() < 1e-6);
    }
}

#[test]
#[ignore = "1000 steps of 10 x 10, twice, for several lattices"]
fn the_papers_protocol_leaves_overlaps_and_events_do_not() {
    for (r0, step) in [
        (0.05, 0.01),
        (0.05, 0.001),
        (3.0 / 22.0, 0.01),
        (3.0 / 22.0, 0.0025),
        (1.0, 0.01),
    ] {
        let network = lattice(10, r0);
        let steps = (10.0_f64 / step).round() as usize;
        let start = drawn_start(&network, 1, None);
        let energy = start.kinetic_energy(&network);
        let mut state = start.clone();
        let mut paper = PaperEngine::new(
            network.clone(),
            Vec::new(),
            &state,
            PaperSettings { ansatz: false },
        )
        .unwrap();
        let mut end = String::from("to the end");
        for _ in 0..steps {
            if let Err(error) = paper.step(&mut state, step) {
                end = format!("until {error}");
                break;
            }
        }
        let left = *paper.statistics();
        let paper_energy = state.kinetic_energy(&network) / energy - 1.0;
        let mut state = start.clone();
        let settings = CollisionSettings {
            rods_block: Some(false),
            ..CollisionSettings::default()
        };
        let mut engine = Engine::new(network.clone(), Vec::new(), &state, settings).unwrap();
        let mut event_end = String::from("to the end");
        for _ in 0..steps {
            if let Err(error) = engine.step(&mut state, step) {
                event_end = format!("until {error}");
                break;
            }
        }
        let kept = engine.statistics();
        eprintln!(
            "r0 = {r0}, steps of {step}: the protocol {} steps, {end}, {} steps with overlaps, deepest {:.1e}, {} of {} impulses \
             pull, energy {paper_energy:+.1e}; events {} steps, {event_end}, smallest gap {:.1e}, {} impacts, energy {:+.1e}",
            left.steps,
            left.steps_with_overlap,
            left.deepest_overlap,
            left.pulling_impulses,
            left.contacts,
            kept.steps,
            kept.smallest_gap.unwrap_or(0.0),
            kept.impacts,
            state.kinetic_energy(&network) / energy - 1.0
        );
        assert!(kept.smallest_gap.unwrap_or(0.0) > -1e-9);
        assert!(
            left.deepest_overlap > 1e3 * (-kept.smallest_gap.unwrap_or(0.0)).max(1e-9)
                || left.collisions == 0
        );
    }
}
