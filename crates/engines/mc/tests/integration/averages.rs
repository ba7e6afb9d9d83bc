//! Averages with direct, calibrated and approximate energies agree, from independent random numbers.

use crate::common::*;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Boundary, Pose, Vec3};
use protomer_mc::energy::levels::{Levels, Table};
use protomer_mc::energy::{DirectSum, EnergyModel, NoCharges};
use protomer_mc::observables::{contacts, r_g_angstrom};
use protomer_mc::{BodyType, Interaction, Settings, Simulation, System};
use std::ops::ControlFlow;
use std::sync::Arc;

const RADIUS_ANGSTROM: f64 = 10.0;
const CHARGES: usize = 40;
const TOLERANCE_KT: f64 = 1e-3;
const REPLICAS: u32 = 16;
const SWEEPS: u64 = 450;

/// Little salt: a Debye length of three body radii.
fn yukawa() -> Yukawa {
    Yukawa::uncut(7.0, 1.0 / 30.0).unwrap()
}

/// Four bodies of each of two kinds with opposite net charge, some ±3 e, behind a spherical wall.
fn system() -> System {
    let mut rng = CounterRng::new(51, 0, 0);
    let mesh = icosphere(RADIUS_ANGSTROM, 1);
    let kinds: Vec<Arc<BodyType>> = [1.0, -1.0]
        .iter()
        .map(|sign| {
            let mut charge = || {
                (
                    rng.vector_in_ball(RADIUS_ANGSTROM - 1.5),
                    sign * 0.07 + rng.uniform_in(-0.6, 0.6),
                )
            };
            let charges: Vec<(Vec3, f64)> = (0..CHARGES).map(|_| charge()).collect();
            Arc::new(BodyType::new("ball", &mesh, &charges).unwrap())
        })
        .collect();
    let bodies: Vec<(usize, Pose)> = (0..8)
        .map(|i| {
            let corner = |bit: usize| 24.0 * f64::from(u8::from(i >> bit & 1 == 1)) - 12.0;
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
        Boundary::SphereWall {
            radius_angstrom: 34.0,
        },
    )
    .unwrap()
}

/// Translations, rotations and cluster moves.
fn moves() -> Settings {
    // The model is given along with the settings, which only travel with it.
    Settings {
        equilibration_sweeps: 150,
        ..settings(Interaction::HardOnly, 1)
    }
}

/// Energy (kT), radius of gyration (Å) and contacts, from independent replicas.
fn sample(system: &System, model: &dyn Fn() -> Box<dyn EnergyModel>, seed: u64) -> [Estimate; 3] {
    let mut samples: [Vec<f64>; 3] = Default::default();
    for replica in 0..REPLICAS {
        let mut simulation =
            Simulation::with_model(system.clone(), moves(), model(), seed, replica).unwrap();
        let equilibration = moves().equilibration_sweeps;
        simulation
            .run_until(equilibration, &mut |_| ControlFlow::Continue(()))
            .unwrap();
        let mut sums = [0.0; 3];
        let mut measure = |state: &Simulation| {
            let touching = contacts(state.system(), 4.0).len() as f64;
            let energy: f64 = state
                .pair_energies()
                .iter()
                .map(|pair| pair.energy_kt)
                .sum();
            let values = [energy, r_g_angstrom(state.system(), |_| 1.0), touching];
            sums.iter_mut()
                .zip(values)
                .for_each(|(sum, value)| *sum += value);
            ControlFlow::Continue(())
        };
        simulation
            .run_until(equilibration + SWEEPS, &mut measure)
            .unwrap();
        samples
            .iter_mut()
            .zip(sums)
            .for_each(|(samples, sum)| samples.push(sum / SWEEPS as f64));
    }
    samples.map(|samples| Estimate::from_samples(&samples))
}

fn tables(system: &System) -> Vec<Arc<Table>> {
    let table = |kind: &Arc<BodyType>| Arc::new(Table::new(&kind.charges, &yukawa(), 500.0));
    system.types().iter().map(table).collect()
}

#[test]
fn averages_do_not_depend_on_how_energies_are_computed() {
    let system = system();
    let tables = tables(&system);
    let levels = || Levels::with_tables(yukawa(), &system, tables.clone());
    let direct = sample(&system, &|| Box::new(DirectSum::new(yukawa())), 61);
    let hard = sample(&system, &|| Box::new(NoCharges), 62);
    let near = sample(
        &system,
        &|| Box::new(levels().with_tolerance(TOLERANCE_KT)),
        63,
    );
    let calibrated = sample(&system, &|| Box::new(levels()), 64);
    for (name, k, largest_error) in [
        ("energy, kT", 0, 0.5),
        ("R_g, Å", 1, 0.3),
        ("contacts", 2, 0.15),
    ] {
        assert_agree(
            &format!("approximate {name}"),
            near[k],
            direct[k],
            largest_error,
        );
        assert_agree(
            &format!("calibrated {name}"),
            calibrated[k],
            direct[k],
            largest_error,
        );
        let sigmas = hard[k].sigmas_from(&direct[k]);
        assert!(
            sigmas > 4.0,
            "{name} of hard bodies is {sigmas} sigma away: charges matter to what is compared"
        );
    }
}

/// What a run leaves behind but the energies, of which calibrated ones are approximate.
fn trace(mut simulation: Simulation, sweeps: u64) -> (String, u64) {
    simulation
        .run_until(sweeps, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    let steps = simulation.step_sizes();
    let cluster_bodies = simulation.statistics().cluster_bodies;
    (
        format!(
            "{:?} {:?} {steps:?}",
            simulation.system().poses(),
            simulation.statistics()
        ),
        cluster_bodies,
    )
}

#[test]
fn calibrated_runs_are_the_direct_runs_of_the_same_seed() {
    let system = system();
    let tables = tables(&system);
    let run = |model: Box<dyn EnergyModel>, seed| {
        trace(
            Simulation::with_model(system.clone(), moves(), model, seed, 0).unwrap(),
            250,
        )
    };
    for seed in [64, 65] {
        let (direct, cluster_bodies) = run(Box::new(DirectSum::new(yukawa())), seed);
        let (calibrated, _) = run(
            Box::new(Levels::with_tables(yukawa(), &system, tables.clone())),
            seed,
        );
        assert_eq!(
            direct, calibrated,
            "every pose and every count to the last bit"
        );
        assert!(cluster_bodies > 200, "rigid groups moved: {cluster_bodies}");
    }
}
