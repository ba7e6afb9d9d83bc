//! A run cut anywhere and continued equals the uninterrupted run, bit for bit; replicas do not know
//! of each other.

use crate::common::*;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::{Boundary, Pose, Rotation, Vec3};
use protomer_mc::energy::EnergyModel;
use protomer_mc::energy::levels::{Levels, Table};
use protomer_mc::{BodyType, Checkpoint, Interaction, McError, Outcome, Simulation, System};
use std::ops::ControlFlow;
use std::sync::Arc;

fn system(bodies_per_edge: usize) -> System {
    let charges = |sign: f64| {
        [
            (Vec3::new(2.0, 1.0, -1.0), sign * 1.5),
            (Vec3::new(-2.0, 0.0, 1.0), sign * 0.5),
        ]
    };
    let kinds = vec![
        Arc::new(BodyType::new("plus", &chiral_bump(5.0), &charges(1.0)).unwrap()),
        Arc::new(BodyType::new("minus", &chiral_bump(6.0), &charges(-1.0)).unwrap()),
    ];
    let spacing = 17.0;
    let coordinate = |k: usize| spacing * (k as f64 - 0.5 * (bodies_per_edge as f64 - 1.0));
    let bodies: Vec<(usize, Pose)> = (0..bodies_per_edge.pow(3))
        .map(|k| {
            let [x, y, z] = [k, k / bodies_per_edge, k / bodies_per_edge.pow(2)]
                .map(|k| coordinate(k % bodies_per_edge));
            (
                k % 2,
                Pose {
                    position: Vec3::new(x, y, z),
                    rotation: Rotation::identity(),
                },
            )
        })
        .collect();
    let length = (spacing * bodies_per_edge as f64).max(60.0);
    System::new(
        kinds,
        &bodies,
        Boundary::periodic(Vec3::new(length, length + 5.0, length + 9.0)).unwrap(),
    )
    .unwrap()
}

fn start(system: System, replica: u32) -> Simulation {
    start_with(
        system,
        Interaction::YukawaDirect(Yukawa::new(7.0, 0.1, 15.0).unwrap()),
        replica,
    )
}

fn start_with(system: System, interaction: Interaction, replica: u32) -> Simulation {
    let settings = protomer_mc::Settings {
        equilibration_sweeps: 60,
        binding_moves_per_sweep: 2,
        ..settings(interaction, 2)
    };
    Simulation::new(system, settings, 99, replica).unwrap()
}

fn run(simulation: &mut Simulation, sweep: u64) {
    assert_eq!(
        simulation.run_until(sweep, &mut |_| ControlFlow::Continue(())),
        Ok(Outcome::Finished)
    );
}

/// Everything a run leaves behind, to the last bit.
fn trace(simulation: &Simulation) -> String {
    format!(
        "{:?} {:?}",
        serde_json::to_string(&simulation.checkpoint()).unwrap(),
        simulation.observables()
    )
}

#[test]
fn a_continued_run_equals_the_uninterrupted_one() {
    // Few bodies are searched by pairs, many through cells; the cuts lie in and after
    // equilibration.
    for (edge, sweeps) in [(2, 150), (6, 70)] {
        let system = system(edge);
        let mut whole = start(system.clone(), 0);
        run(&mut whole, sweeps);
        let mut parts = start(system.clone(), 0);
        for cut in [1, sweeps / 4, sweeps / 2, sweeps - 1, sweeps] {
            run(&mut parts, cut);
            let text = serde_json::to_string(&parts.checkpoint()).unwrap();
            let checkpoint: Checkpoint = serde_json::from_str(&text).unwrap();
            assert_eq!(checkpoint.sweep(), cut);
            parts = Simulation::resume(system.clone(), checkpoint).unwrap();
        }
        assert_eq!(trace(&parts), trace(&whole));
        assert_eq!(protomer_mc::hard::overlapping_pairs(whole.system()), []);
        assert_energies_are_those_of_all_pairs(&whole);
        let moved = whole.statistics().translation[0].accepted;
        assert!(moved > 0 && whole.statistics().cluster_moves > 0);
    }
}

/// Energies by levels: a continued run finds the same ones, although groups that moved rigidly have
/// kept energies of relative poses that are no longer theirs to the last bit.
#[test]
fn continued_runs_with_energies_by_levels_equal_the_uninterrupted_ones() {
    // So short that few images count in this small box.
    let yukawa = Yukawa::uncut(7.0, 0.3).unwrap();
    let (system, sweeps) = (system(2), 80);
    let approximate = |tolerance_kt| Interaction::YukawaApproximate {
        yukawa,
        tolerance_kt,
    };
    let mut direct = start_with(system.clone(), Interaction::YukawaDirect(yukawa), 0);
    run(&mut direct, sweeps);
    let table = |kind: &Arc<BodyType>| Arc::new(Table::new(&kind.charges, &yukawa, 150.0));
    let tables: Vec<_> = system.types().iter().map(table).collect();
    for interaction in [
        Interaction::YukawaCertified(yukawa),
        Interaction::YukawaCalibrated(yukawa),
        approximate(1e-3),
        approximate(1e-9),
    ] {
        let model = || -> Box<dyn EnergyModel> {
            let levels = Levels::with_tables(yukawa, &system, tables.clone());
            match interaction {
                Interaction::YukawaApproximate { tolerance_kt, .. } => {
                    Box::new(levels.with_tolerance(tolerance_kt))
                }
                Interaction::YukawaCertified(_) => interaction.model(&system),
                _ => Box::new(levels),
            }
        };
        let start = || {
            let settings = *direct.settings();
            Simulation::with_model(system.clone(), settings, model(), 99, 0).unwrap()
        };
        let mut whole = start();
        run(&mut whole, sweeps);
        let mut parts = start();
        for cut in [1, sweeps / 4, sweeps / 2, sweeps - 1, sweeps] {
            run(&mut parts, cut);
            let text = serde_json::to_string(&parts.checkpoint()).unwrap();
            let checkpoint = serde_json::from_str(&text).unwrap();
            parts = Simulation::resume_with_model(system.clone(), checkpoint, model()).unwrap();
        }
        assert_eq!(trace(&parts), trace(&whole));
        assert!(
            whole.statistics().cluster_bodies > whole.statistics().cluster_moves,
            "groups moved rigidly"
        );
        let bound = whole.energy_error_bound_kt();
        match interaction {
            Interaction::YukawaApproximate { tolerance_kt, .. } => {
                assert!(bound <= tolerance_kt, "{bound}")
            }
            _ => {
                assert!(bound > 0.0, "tables were used");
                assert_eq!(
                    parts.system().poses(),
                    direct.system().poses(),
                    "the decisions of the direct sum"
                );
            }
        }
        for (sum, kept) in direct.pair_energies().iter().zip(whole.pair_energies()) {
            if !matches!(interaction, Interaction::YukawaApproximate { .. }) {
                let difference = (sum.energy_kt - kept.energy_kt).abs();
                assert!(difference < 1e-3, "{sum:?} {kept:?}");
            }
        }
    }
}

/// Cells may miss no partner.
fn assert_energies_are_those_of_all_pairs(simulation: &Simulation) {
    let mut model = simulation.settings().interaction.model(simulation.system());
    model.reset(simulation.system()).unwrap();
    let (fresh, kept) = (model.pairs(simulation.system()), simulation.pair_energies());
    assert_eq!(fresh.len(), kept.len());
    for (fresh, kept) in fresh.iter().zip(&kept) {
        assert_eq!((fresh.first, fresh.second), (kept.first, kept.second));
        assert!((fresh.energy_kt - kept.energy_kt).abs() < 1e-11);
    }
}

#[test]
fn replicas_are_independent_of_threads_and_differ() {
    let system = system(2);
    let one_after_the_other: Vec<String> =
        (0..4).map(|replica| finished(&system, replica)).collect();
    let side_by_side: Vec<String> = std::thread::scope(|scope| {
        let runs: Vec<_> = (0..4)
            .map(|replica| {
                scope.spawn({
                    let system = &system;
                    move || finished(system, replica)
                })
            })
            .collect();
        runs.into_iter().map(|run| run.join().unwrap()).collect()
    });
    assert_eq!(one_after_the_other, side_by_side);
    assert_ne!(one_after_the_other[0], one_after_the_other[1]);
}

fn finished(system: &System, replica: u32) -> String {
    let mut simulation = start(system.clone(), replica);
    run(&mut simulation, 50);
    trace(&simulation)
}

#[test]
fn an_observer_stops_a_run_that_can_go_on() {
    let system = system(2);
    let mut stopped = start(system.clone(), 0);
    let stop_at_7 = &mut |state: &Simulation| {
        if state.sweep() == 7 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    assert_eq!(stopped.run_until(20, stop_at_7), Ok(Outcome::Stopped));
    run(&mut stopped, 20);
    let mut whole = start(system, 0);
    run(&mut whole, 20);
    assert_eq!(trace(&stopped), trace(&whole));
}

#[test]
fn steps_are_tuned_in_equilibration_and_frozen_after_it() {
    let mut simulation = start(system(2), 0);
    run(&mut simulation, 60);
    let frozen = simulation.step_sizes();
    assert_ne!(
        frozen[0].translation_angstrom,
        simulation.settings().translation_step_angstrom
    );
    assert_eq!(
        simulation.statistics().cluster_moves,
        0,
        "counted anew after equilibration"
    );
    run(&mut simulation, 90);
    assert_eq!(simulation.step_sizes(), frozen);
}

#[test]
fn a_checkpoint_of_another_system_is_refused() {
    let checkpoint = start(system(2), 0).checkpoint();
    assert!(matches!(
        Simulation::resume(system(3), checkpoint),
        Err(McError::ForeignCheckpoint(_))
    ));
}
