//! Plain moves, and plain moves with cluster moves, sample the same distribution; caches stay true;
//! nothing overlaps.

use crate::common::*;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::{Boundary, Pose, Rotation, Vec3};
use protomer_mc::energy::{DirectSum, EnergyModel};
use protomer_mc::hard::overlapping_pairs;
use protomer_mc::{BodyType, Interaction, Simulation, System};
use std::ops::ControlFlow;
use std::sync::Arc;

/// Six chiral bodies of two kinds and opposite charge on a lattice in a space that holds them.
fn mixture(boundary: Boundary, yukawa: &Yukawa) -> System {
    let sites = [
        (1.5, -0.7, 0.0, 1.6),
        (-1.5, 1.0, -0.7, -0.5),
        (0.0, -1.5, -1.0, 0.9),
    ];
    let charges = |sign: f64| sites.map(|(x, y, z, charge)| (Vec3::new(x, y, z), sign * charge));
    let kinds = vec![
        Arc::new(BodyType::new("plus", &chiral_tetrahedron(), &charges(1.0)).unwrap()),
        Arc::new(BodyType::new("minus", &chiral_bump(6.0), &charges(-1.0)).unwrap()),
    ];
    let pose = |x: f64, y: f64| Pose {
        position: Vec3::new(x, y, 0.0),
        rotation: Rotation::identity(),
    };
    let bodies: Vec<(usize, Pose)> = (0..6)
        .map(|k| {
            (
                k % 2,
                pose(19.0 * (k % 3) as f64 - 19.0, 20.0 * (k / 3) as f64 - 10.0),
            )
        })
        .collect();
    let system = System::new(kinds, &bodies, boundary).unwrap();
    assert!(DirectSum::new(*yukawa).range_angstrom(&system) > 0.0);
    system
}

fn yukawa() -> Yukawa {
    Yukawa::new(7.0, 0.08, 18.0).unwrap()
}

fn boxes() -> [Boundary; 2] {
    [
        Boundary::periodic(Vec3::new(58.0, 50.0, 76.0)).unwrap(),
        Boundary::SphereWall {
            radius_angstrom: 30.0,
        },
    ]
}

#[test]
fn plain_and_cluster_moves_give_the_same_averages() {
    for boundary in boxes() {
        let system = mixture(boundary, &yukawa());
        let sample = |interaction: Interaction, cluster_moves: u32, sweeps: u64| {
            simulate(
                &system,
                settings(interaction, cluster_moves),
                10,
                sweeps,
                |state| {
                    let contacts =
                        protomer_mc::observables::contacts(state.system(), 3.0).len() as f64;
                    let energy: f64 = state
                        .pair_energies()
                        .iter()
                        .map(|pair| pair.energy_kt)
                        .sum();
                    [
                        energy,
                        protomer_mc::observables::r_g_angstrom(state.system(), |_| 1.0),
                        contacts,
                    ]
                },
            )
        };
        let charged = Interaction::YukawaDirect(yukawa());
        let (plain, mixed) = (sample(charged, 0, 12_000), sample(charged, 6, 6_000));
        for (name, largest_error, k) in
            [("energy", 0.12, 0), ("R_g", 0.12, 1), ("contacts", 0.06, 2)]
        {
            assert_agree(
                &format!("{name}, {boundary:?}"),
                mixed[k],
                plain[k],
                largest_error,
            );
        }
    }
}

#[test]
fn caches_stay_true_and_nothing_overlaps() {
    for boundary in boxes() {
        let system = mixture(boundary, &yukawa());
        let mut simulation = Simulation::new(
            system,
            settings(Interaction::YukawaDirect(yukawa()), 2),
            3,
            0,
        )
        .unwrap();
        simulation
            .run_until(2_000, &mut |_| ControlFlow::Continue(()))
            .unwrap();
        let mut fresh = DirectSum::new(yukawa());
        fresh.reset(simulation.system()).unwrap();
        let kept = simulation.pair_energies();
        let scale: f64 = kept.iter().map(|pair| pair.energy_kt.abs()).sum();
        assert!(
            (simulation.observables().energy_kt - fresh.total_kt(simulation.system())).abs()
                <= 1e-10 * scale
        );
        for pair in fresh.pairs(simulation.system()) {
            let same = kept
                .iter()
                .find(|other| (other.first, other.second) == (pair.first, pair.second))
                .unwrap();
            assert!(
                (same.energy_kt - pair.energy_kt).abs() <= 1e-10 * scale,
                "{same:?} {pair:?}"
            );
        }
        assert_eq!(overlapping_pairs(simulation.system()), []);
        for first in 0..6 {
            for second in first + 1..6 {
                let pair = simulation.system().pair(first, second);
                let (a, b) = pair.types();
                assert!(
                    protomer_kernel::overlap::distance(&a.shape, &b.shape, &pair.relative()) > 0.0
                );
            }
        }
    }
}

/// 125 spheres are searched through cells. At low density g(r) = 1 + ρ V(r), with V(r) the volume
/// common to two spheres of radius σ at the distance r: 4π/3 σ³ (1 - 3r/4σ + r³/16σ³) (Hansen and
/// McDonald, Theory of Simple Liquids, ch. 3); the next order is below 0.003 here.
#[test]
fn dilute_hard_spheres_have_the_pair_distribution_of_the_virial_expansion() {
    use std::f64::consts::PI;
    let (bodies, length) = (125_usize, 130.0);
    let mesh = icosphere(5.0, 2);
    // The diameter of the sphere of the same mean of inner and outer radius; the mesh is within 1 %
    // of it.
    let sigma = 2.0 * (0.75 * mesh.volume_angstrom3() / PI).cbrt();
    let kind = Arc::new(BodyType::new("sphere", &mesh, &[]).unwrap());
    let place =
        |k: usize| Vec3::new((k % 5) as f64, (k / 5 % 5) as f64, (k / 25) as f64) * (length / 5.0);
    let poses: Vec<(usize, Pose)> = (0..bodies)
        .map(|k| {
            (
                0,
                Pose {
                    position: place(k),
                    rotation: Rotation::identity(),
                },
            )
        })
        .collect();
    let system = System::new(
        vec![kind],
        &poses,
        Boundary::periodic(Vec3::repeat(length)).unwrap(),
    )
    .unwrap();
    let (near, far) = (1.05 * sigma, 1.4 * sigma);
    let density = bodies as f64 / length.powi(3);
    let common = |r: f64| {
        4.0 / 3.0 * PI * sigma.powi(3) * (1.0 - 0.75 * r / sigma + (r / sigma).powi(3) / 16.0)
    };
    let shell = |g: &dyn Fn(f64) -> f64| -> f64 {
        let width = (far - near) / 1000.0;
        (0..1000)
            .map(|k| near + (k as f64 + 0.5) * width)
            .map(|r| 4.0 * PI * r * r * g(r) * width)
            .sum()
    };
    let pairs_per_volume = 0.5 * (bodies - 1) as f64 * density;
    let expected = pairs_per_volume * shell(&|r| 1.0 + density * common(r));
    let ideal = pairs_per_volume * shell(&|_| 1.0);
    let [measured] = simulate(
        &system,
        settings(Interaction::HardOnly, 5),
        6,
        600,
        |state| {
            let system = state.system();
            let distance = |i: usize, j: usize| system.pair(i, j).displacement.norm();
            let pairs = (0..bodies).flat_map(|j| (0..j).map(move |i| (i, j)));
            [pairs
                .filter(|&(i, j)| (near..far).contains(&distance(i, j)))
                .count() as f64]
        },
    );
    assert!(
        (expected - ideal) / measured.error > 5.0,
        "the statistics cannot tell {expected} from {ideal}"
    );
    assert_agree(
        "pairs in the first shell",
        measured,
        Estimate {
            mean: expected,
            error: 0.003 * expected,
        },
        0.01 * expected,
    );
}

/// The memory of gaps saves time and may not change an answer.
#[test]
fn remembered_gaps_never_hide_an_overlap() {
    use protomer_kernel::random::CounterRng;
    use protomer_mc::hard::HardBodies;
    let mesh = chiral_bump(6.0);
    let kind = Arc::new(BodyType::new("bump", &mesh, &[]).unwrap());
    let mut rng = CounterRng::new(8, 0, 0);
    let mut hard = HardBodies::new(2);
    let mut poses = [
        Pose::identity(),
        Pose {
            position: Vec3::new(13.0, 0.0, 0.0),
            rotation: Rotation::identity(),
        },
    ];
    let (mut overlapping, mut free) = (0, 0);
    for _ in 0..20_000 {
        let step = rng.uniform();
        let body = rng.index(2);
        let mut trial = poses;
        trial[body].position += rng.vector_in_ball(step);
        trial[body].rotation = rng.small_rotation(0.2 * step) * trial[body].rotation;
        let system = System::new(
            vec![kind.clone()],
            &trial.map(|pose| (0, pose)),
            Boundary::Open,
        )
        .unwrap();
        let truth = !overlapping_pairs(&system).is_empty();
        assert_eq!(hard.overlap(&system.pair(0, 1)), truth);
        if truth {
            overlapping += 1;
        } else {
            free += 1;
            // Stay near, so that the question stays hard.
            if distance(&system) < 12.5 {
                poses = trial;
            }
        }
    }
    assert!(overlapping > 1000 && free > 1000, "{overlapping} {free}");
}

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: bench/data"]
fn the_benchmark_state_has_its_published_energy() {
    let folder = bench_folder();
    let system = bench_system(&folder, "bumpy_1620.off");
    assert_eq!(overlapping_pairs(&system), []);
    let mut model = DirectSum::new(Yukawa::new(7.0, 1.0 / 9.6, 48.0).unwrap());
    model.reset(&system).unwrap();
    let total = model.total_kt(&system);
    assert!((total / -26.303340096741 - 1.0).abs() < 1e-10, "{total}");
    let pairs = model.pairs(&system);
    let first = pairs
        .iter()
        .find(|pair| (pair.first, pair.second) == (0, 1))
        .unwrap();
    assert!(
        (first.energy_kt / 0.589221080102 - 1.0).abs() < 1e-10,
        "{first:?}"
    );
}
