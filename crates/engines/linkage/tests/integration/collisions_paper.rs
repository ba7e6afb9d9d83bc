//! The paper's collision protocol: what it does, and what it leaves behind.

use crate::common::{engine, lattice, random_start};
use protomer_linkage::lattice::paper::ansatz::Ansatz;
use protomer_linkage::lattice::paper::{PaperEngine, PaperSettings, printed_normal};
use protomer_linkage::lattice::{Corner, Dynamics};

#[test]
fn the_ansatz_is_singular_from_four_on_and_misses_rods_at_third_order() {
    for (size, equations, rank) in [(2, 8, 8), (3, 24, 24), (4, 48, 46), (10, 360, 298)] {
        let network = lattice(size, 3.0 / 22.0);
        let mut state = random_start(&network, 3);
        let mut dynamics = Dynamics::new(network.clone(), Vec::new(), &state).unwrap();
        for _ in 0..20 {
            dynamics.step(&mut state, 0.0025).unwrap();
        }
        let mut free = vec![0.0; state.positions.len()];
        let mut total = free.clone();
        dynamics.accelerations_into(&mut free, &mut total);
        let mut ansatz =
            Ansatz::new(&network, &state.positions, &state.velocities, &free, &total).unwrap();
        let errors: Vec<f64> = [2e-3, 1e-3]
            .iter()
            .map(|time| {
                let mut sigma = vec![0.0; network.rods.len()];
                dynamics
                    .rods()
                    .violations(&ansatz.land(*time).positions, &mut sigma)
                    .1
                    .abs()
            })
            .collect();
        eprintln!(
            "{size}: {equations} equations of rank {}, rods off by {errors:?}",
            ansatz.rank()
        );
        assert_eq!(2 * network.rods.len(), equations);
        assert_eq!(ansatz.rank(), rank);
        assert!(
            errors[0] > 1e-10 && (6.5..9.0).contains(&(errors[0] / errors[1])),
            "{errors:?}"
        );
    }
}

#[test]
fn the_printed_corner_normal_depends_on_the_observer() {
    let network = lattice(2, 0.5);
    let mut state = random_start(&network, 1);
    for (index, angle) in state.positions.iter_mut().skip(2).step_by(3).enumerate() {
        *angle += 0.1 * index as f64;
    }
    let corners = [
        Corner {
            square: 0,
            vertex: 2,
        },
        Corner {
            square: 1,
            vertex: 1,
        },
    ];
    let normal = printed_normal(&network, &state, corners[0], corners[1]).unwrap();
    for velocity in state.velocities.chunks_exact_mut(3) {
        velocity[0] += 1.0;
    }
    let seen_moving = printed_normal(&network, &state, corners[0], corners[1]).unwrap();
    let along = normal[0] * seen_moving[0] + normal[1] * seen_moving[1];
    assert!(along < 0.999, "{normal:?} {seen_moving:?}");
}

#[test]
fn the_protocol_leaves_overlaps_and_the_engine_does_not() {
    let network = lattice(10, 3.0 / 22.0);
    for ansatz in [false, true] {
        let mut state = random_start(&network, 1);
        let mut paper = PaperEngine::new(
            network.clone(),
            Vec::new(),
            &state,
            PaperSettings { ansatz },
        )
        .unwrap();
        let mut completed = 0;
        for step in 0..if ansatz { 120 } else { 300 } {
            if let Err(error) = paper.step(&mut state, 0.01) {
                eprintln!("the protocol ends at step {step}: {error}");
                break;
            }
            completed += 1;
        }
        let statistics = paper.statistics();
        eprintln!("ansatz {ansatz}, {completed} steps: {statistics:?}");
        assert!(statistics.collisions > 3);
        assert!(statistics.largest_relative_energy_change < 1e-9);
        if ansatz {
            assert!(statistics.largest_ansatz_rod_error > 1e-9);
        } else {
            assert!(statistics.deepest_overlap > 1e-4 && statistics.steps_with_overlap > 0);
        }
    }
    let mut state = random_start(&network, 1);
    let mut engine = engine(&network, &state);
    for _ in 0..300 {
        engine.step(&mut state, 0.01).unwrap();
    }
    assert!(engine.statistics().smallest_gap.unwrap() > -1e-10);
}

/// One contact at a time: the equality and the inequality agree, and so do the trajectories, to the
/// tolerance of the times.
#[test]
fn single_contacts_agree_with_the_engine() {
    let network = lattice(2, 1.0);
    let start = random_start(&network, 1);
    let (mut a, mut b) = (start.clone(), start.clone());
    let mut paper = PaperEngine::new(
        network.clone(),
        Vec::new(),
        &a,
        PaperSettings { ansatz: false },
    )
    .unwrap();
    let mut engine = engine(&network, &b);
    while engine.statistics().impacts < 3 {
        paper.step(&mut a, 0.01).unwrap();
        engine.step(&mut b, 0.01).unwrap();
        let difference = a
            .positions
            .iter()
            .zip(&b.positions)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(difference < 1e-7, "{difference:e} at t = {}", a.time);
    }
    assert!(paper.statistics().collisions >= 3);
}
