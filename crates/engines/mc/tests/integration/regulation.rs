//! Bodies whose groups take up and lose protons, against sums over all states.

use crate::common::*;
use protomer_kernel::potential::Yukawa;
use protomer_kernel::statistics::RunningMoments;
use protomer_kernel::{Boundary, Pose, Vec3};
use protomer_mc::energy::{DirectSum, Effort, EnergyModel};
use protomer_mc::titratable::{Tautomers, TitratableCharges, TitratableGroup};
use protomer_mc::{BodyType, Checkpoint, Interaction, Settings, Simulation, System};
use std::f64::consts::LN_10;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Groups at the sites of a body: a charge, the free energy of the charged form, half the difference of tautomers.
struct Kind {
    sites: Vec<(Vec3, f64)>,
    groups: Vec<(usize, f64, f64, Option<f64>)>,
    pair_kt: Vec<f64>,
    tautomer_pair_kt: Vec<f64>,
}

const FIRST_SHARE: f64 = 0.2;

impl Kind {
    fn charges(&self) -> Arc<TitratableCharges> {
        let group = |group: &(usize, f64, f64, Option<f64>)| TitratableGroup {
            change_e: vec![(group.0, group.1)],
            free_energy_kt: group.2,
            tautomers: group.3.map(|half_difference_kt| Tautomers {
                first_share: FIRST_SHARE,
                half_difference_kt,
            }),
        };
        let groups = self.groups.iter().map(group).collect();
        let (pairs, tautomers) = (self.pair_kt.clone(), self.tautomer_pair_kt.clone());
        Arc::new(TitratableCharges::new(&self.sites, groups, pairs, tautomers).unwrap())
    }

    fn is_charged(state: usize, group: usize) -> bool {
        state >> group & 1 == 1
    }

    /// Free energy of a state, its bits the charged groups: the equation, term by term.
    fn own_kt(&self, state: usize) -> f64 {
        let count = self.groups.len();
        let mut energy_kt = 0.0;
        for (index, group) in self.groups.iter().enumerate() {
            let mut half_kt = group.3.unwrap_or(0.0);
            for other in (0..count).filter(|other| Self::is_charged(state, *other)) {
                if Self::is_charged(state, index) && other < index {
                    energy_kt += self.pair_kt[index * count + other];
                }
                half_kt += self.tautomer_pair_kt[index * count + other];
            }
            if Self::is_charged(state, index) {
                energy_kt += group.2;
            } else if group.3.is_some() {
                let weight = FIRST_SHARE * (-half_kt).exp() + (1.0 - FIRST_SHARE) * half_kt.exp();
                energy_kt -= weight.ln();
            }
        }
        energy_kt
    }

    /// The charges of a state.
    fn sites_in(&self, state: usize) -> Vec<(Vec3, f64)> {
        let mut sites = self.sites.clone();
        for (index, group) in self.groups.iter().enumerate() {
            if Self::is_charged(state, index) {
                sites[group.0].1 += group.1;
            }
        }
        sites
    }

    fn net_charge_e(&self, state: usize) -> f64 {
        self.sites_in(state).iter().map(|site| site.1).sum()
    }

    fn states(&self) -> usize {
        1 << self.groups.len()
    }
}

/// Two acids, a base with tautomers and a base, coupled, around a fixed charge.
fn coupled(scale_angstrom: f64) -> Kind {
    let count = 4;
    let mut pair_kt = vec![0.0; count * count];
    for (first, second, energy_kt) in [(0, 1, 1.5), (0, 2, -0.9), (1, 3, -1.2), (2, 3, 0.6)] {
        pair_kt[first * count + second] = energy_kt;
        pair_kt[second * count + first] = energy_kt;
    }
    let mut tautomer_pair_kt = vec![0.0; count * count];
    tautomer_pair_kt[2 * count] = 0.8;
    tautomer_pair_kt[2 * count + 3] = -0.5;
    let place = |x: f64, y: f64, z: f64| scale_angstrom * Vec3::new(x, y, z);
    Kind {
        sites: vec![
            (place(0.9, 0.1, 0.0), 0.0),
            (place(-0.2, 0.8, 0.1), 0.1),
            (place(0.1, -0.7, 0.5), 0.0),
            (place(-0.5, -0.1, -0.8), 0.0),
            (place(0.0, 0.2, 0.3), -0.6),
        ],
        groups: vec![
            (0, -1.0, -0.4, None),
            (1, -1.0, -1.0, None),
            (2, 1.0, 0.2, Some(0.7)),
            (3, 1.0, -0.7, None),
        ],
        pair_kt,
        tautomer_pair_kt,
    }
}

fn pose_at(x: f64) -> Pose {
    Pose {
        position: Vec3::new(x, 0.0, 0.0),
        ..Pose::identity()
    }
}

/// A simulation that makes mostly moves of protons, with a body of each kind at these places.
fn simulation(
    kinds: &[&Kind],
    poses: &[Pose],
    yukawa: Yukawa,
    step_angstrom: f64,
    boundary: Boundary,
) -> Simulation {
    let mesh = icosphere(1e-3, 0);
    let bodies: Vec<_> = poses.iter().copied().enumerate().collect();
    let types = kinds
        .iter()
        .map(|kind| Arc::new(BodyType::new("ball", &mesh, &kind.sites).unwrap()))
        .collect();
    let system = System::new(types, &bodies, boundary).unwrap();
    let groups = kinds.iter().map(|kind| Some(kind.charges())).collect();
    let settings = Settings {
        equilibration_sweeps: 0,
        translation_step_angstrom: step_angstrom,
        rotation_step_rad: step_angstrom.min(1.0),
        cluster_moves_per_sweep: 0,
        proton_moves_per_sweep: 12,
        ..Settings::new(Interaction::YukawaDirect(yukawa))
    };
    Simulation::with_model(
        system,
        settings,
        Box::new(DirectSum::regulated(yukawa, groups)),
        5,
        0,
    )
    .unwrap()
}

/// Means of values over a run, with their standard errors from blocks.
fn means<const N: usize>(
    simulation: &mut Simulation,
    sweeps: u64,
    values: impl Fn(&Simulation) -> [f64; N],
) -> [(f64, f64); N] {
    let mut blocks = [RunningMoments::default(); N];
    let (count, skipped) = (50, sweeps / 50);
    simulation
        .run_until(skipped, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    for block in 0..count {
        let mut sums = [0.0; N];
        let until = skipped + (block + 1) * sweeps / count;
        let mut visits = 0.0;
        simulation
            .run_until(until, &mut |simulation| {
                for (sum, value) in sums.iter_mut().zip(values(simulation)) {
                    *sum += value;
                }
                visits += 1.0;
                ControlFlow::Continue(())
            })
            .unwrap();
        for (block, sum) in blocks.iter_mut().zip(sums) {
            block.push(sum / visits);
        }
    }
    blocks.map(|block| (block.mean(), block.independent_standard_error()))
}

fn assert_near(name: &str, (mean, error): (f64, f64), exact: f64) {
    println!("{name}: {mean:.5} ± {error:.5}, exact {exact:.5}");
    assert!(
        (mean - exact).abs() < 4.0 * error && error < 0.01,
        "{name}: {mean} ± {error}, exact {exact}"
    );
}

fn short() -> Yukawa {
    Yukawa::uncut(7.0, 1.0 / 9.6).unwrap()
}

#[test]
fn a_body_alone_follows_henderson_and_hasselbalch() {
    for ph_less_pka in [-1.0, 0.0, 0.7] {
        let acid = Kind {
            sites: vec![(Vec3::zeros(), 0.0)],
            groups: vec![(0, -1.0, -LN_10 * ph_less_pka, None)],
            pair_kt: vec![0.0],
            tautomer_pair_kt: vec![0.0],
        };
        let mut alone = simulation(&[&acid], &[pose_at(0.0)], short(), 1e-9, Boundary::Open);
        let [charge] = means(&mut alone, 20_000, |run| [run.net_charges_e().unwrap()[0]]);
        let exact = -1.0 / (1.0 + 10_f64.powf(-ph_less_pka));
        assert_near("charge of an acid (e)", charge, exact);
    }
}

#[test]
fn coupled_groups_have_the_shares_of_the_sum_over_all_states() {
    let kind = coupled(3.0);
    let mut alone = simulation(&[&kind], &[pose_at(0.0)], short(), 1e-9, Boundary::Open);
    let found = means(&mut alone, 20_000, |run| {
        let states = &run.protonation()[0];
        [0, 1, 2, 3].map(|group| f64::from(u8::from(states[group])))
    });
    let weights: Vec<f64> = (0..kind.states())
        .map(|state| (-kind.own_kt(state)).exp())
        .collect();
    let sum: f64 = weights.iter().sum();
    for (group, found) in found.into_iter().enumerate() {
        let charged = (0..kind.states()).filter(|state| Kind::is_charged(*state, group));
        let exact = charged.map(|state| weights[state]).sum::<f64>() / sum;
        assert_near(&format!("share of group {group}"), found, exact);
    }
}

/// Mean charges, and the mean product of both, by all states of two bodies at fixed poses.
#[test]
fn two_bodies_at_a_distance_have_the_charges_of_the_exact_partition_sum() {
    let (first, second) = (coupled(3.0), coupled(-2.5));
    let (yukawa, distance) = (short(), 9.0);
    let mut exact = [0.0; 3];
    let (mut sum, mut alone, mut alone_sum) = (0.0, 0.0, 0.0);
    for one in 0..first.states() {
        alone += (-first.own_kt(one)).exp() * first.net_charge_e(one);
        alone_sum += (-first.own_kt(one)).exp();
        for other in 0..second.states() {
            let mut energy_kt = first.own_kt(one) + second.own_kt(other);
            for (site, charge_e) in first.sites_in(one) {
                for (partner, other_e) in second.sites_in(other) {
                    let apart = (partner + distance * Vec3::x() - site).norm();
                    energy_kt += charge_e * other_e * yukawa.energy_kt(apart);
                }
            }
            let weight = (-energy_kt).exp();
            let charges = [first.net_charge_e(one), second.net_charge_e(other)];
            sum += weight;
            for (value, term) in
                exact
                    .iter_mut()
                    .zip([charges[0], charges[1], charges[0] * charges[1]])
            {
                *value += weight * term;
            }
        }
    }
    let poses = [pose_at(0.0), pose_at(distance)];
    let mut both = simulation(&[&first, &second], &poses, yukawa, 1e-9, Boundary::Open);
    let found = means(&mut both, 40_000, |run| {
        let charges = run.net_charges_e().unwrap();
        [charges[0], charges[1], charges[0] * charges[1]]
    });
    for (name, (found, exact)) in ["first charge (e)", "second charge (e)", "product (e²)"]
        .iter()
        .zip(found.into_iter().zip(exact))
    {
        assert_near(name, found, exact / sum);
    }
    // The neighbour is felt: the charge alone is another by many errors.
    assert!((alone / alone_sum - exact[0] / sum).abs() > 20.0 * found[0].1);
    // Energies follow the charges without drift.
    let kept: f64 = both.pair_energies().iter().map(|pair| pair.energy_kt).sum();
    let anew = both
        .energy_at_kt(both.system().poses(), Effort::Full)
        .unwrap();
    assert!((kept - anew).abs() < 1e-9, "{kept} {anew}");
}

/// Two bodies with three acids each in a sphere: the sum over all states times the integral over the distance.
#[test]
fn two_bodies_that_move_have_the_exact_partition_sum() {
    let acids = Kind {
        sites: vec![(Vec3::zeros(), 0.0)],
        groups: vec![
            (0, -1.0, -0.5, None),
            (0, -1.0, -1.5, None),
            (0, -1.0, 0.3, None),
        ],
        pair_kt: vec![0.0, 0.7, 0.2, 0.7, 0.0, 0.4, 0.2, 0.4, 0.0],
        tautomer_pair_kt: vec![0.0; 9],
    };
    let (yukawa, radius) = (short(), 12.0);
    // Distances of two random points in a ball.
    let points = 4000;
    let (mut sum, mut charge, mut distance) = (0.0, 0.0, 0.0);
    for point in 0..points {
        let r = 2.0 * radius * (point as f64 + 0.5) / points as f64;
        let x = r / radius;
        let density = r * r * (1.0 - 0.75 * x + x * x * x / 16.0);
        for one in 0..acids.states() {
            for other in 0..acids.states() {
                let charges = [one, other].map(|state| acids.net_charge_e(state));
                let energy_kt = acids.own_kt(one)
                    + acids.own_kt(other)
                    + charges[0] * charges[1] * yukawa.energy_kt(r);
                let weight = density * (-energy_kt).exp();
                sum += weight;
                charge += weight * 0.5 * (charges[0] + charges[1]);
                distance += weight * r;
            }
        }
    }
    let boundary = Boundary::SphereWall {
        radius_angstrom: radius,
    };
    let poses = [pose_at(-4.0), pose_at(4.0)];
    let mut run = simulation(&[&acids, &acids], &poses, yukawa, 8.0, boundary);
    let found = means(&mut run, 100_000, |run| {
        let charges = run.net_charges_e().unwrap();
        let poses = run.system().poses();
        let apart = (poses[1].position - poses[0].position).norm();
        [0.5 * (charges[0] + charges[1]), apart / radius]
    });
    assert_near("charge (e)", found[0], charge / sum);
    assert_near("distance over radius", found[1], distance / sum / radius);
}

/// Many bodies in a box, cut and continued: protons, energies and random numbers go on.
#[test]
fn a_continued_run_equals_the_uninterrupted_one() {
    let kind = coupled(2.0);
    let mesh = icosphere(4.0, 1);
    let types = vec![
        Arc::new(BodyType::new("acid", &mesh, &kind.sites).unwrap()),
        Arc::new(BodyType::new("fixed", &mesh, &[(Vec3::zeros(), 2.0)]).unwrap()),
    ];
    let bodies: Vec<_> = (0..27)
        .map(|place| {
            let [x, y, z] = [place % 3, place / 3 % 3, place / 9].map(|k| 20.0 * k as f64 - 20.0);
            let pose = Pose {
                position: Vec3::new(x, y, z),
                ..Pose::identity()
            };
            (usize::from(place % 4 == 0), pose)
        })
        .collect();
    let boundary = Boundary::periodic(Vec3::repeat(60.0)).unwrap();
    let system = System::new(types, &bodies, boundary).unwrap();
    let yukawa = Yukawa::uncut(7.0, 0.3).unwrap();
    let model = || {
        Box::new(DirectSum::regulated(
            yukawa,
            vec![Some(kind.charges()), None],
        ))
    };
    let settings = Settings {
        equilibration_sweeps: 20,
        cluster_moves_per_sweep: 1,
        binding_moves_per_sweep: 2,
        proton_moves_per_sweep: 30,
        ..Settings::new(Interaction::YukawaDirect(yukawa))
    };
    let start = || Simulation::with_model(system.clone(), settings, model(), 99, 0).unwrap();
    let advance = |simulation: &mut Simulation, sweep| {
        simulation
            .run_until(sweep, &mut |_| ControlFlow::Continue(()))
            .unwrap()
    };
    let mut whole = start();
    advance(&mut whole, 60);
    let mut parts = start();
    for cut in [1, 15, 30, 59, 60] {
        advance(&mut parts, cut);
        let text = serde_json::to_string(&parts.checkpoint()).unwrap();
        let checkpoint: Checkpoint = serde_json::from_str(&text).unwrap();
        parts = Simulation::resume_with_model(system.clone(), checkpoint, model()).unwrap();
    }
    let trace = |simulation: &Simulation| {
        let checkpoint = serde_json::to_string(&simulation.checkpoint()).unwrap();
        format!("{checkpoint} {:?}", simulation.net_charges_e())
    };
    assert_eq!(trace(&parts), trace(&whole));
    let counts = whole.statistics().protons;
    assert!(counts.accepted > 0 && counts.accepted < counts.trials);
    let charges = whole.net_charges_e().unwrap();
    assert!(
        charges.iter().any(|charge| *charge != charges[1]),
        "{charges:?}"
    );
    let kept: f64 = whole
        .pair_energies()
        .iter()
        .map(|pair| pair.energy_kt)
        .sum();
    let anew = whole
        .energy_at_kt(whole.system().poses(), Effort::Full)
        .unwrap();
    assert!((kept - anew).abs() < 1e-9, "{kept} {anew}");

    // A run with fixed charges cannot go on from it, nor bodies with other groups.
    let fixed = Box::new(DirectSum::new(yukawa)) as Box<dyn EnergyModel>;
    let other = Box::new(DirectSum::regulated(
        yukawa,
        vec![None, Some(kind.charges())],
    ));
    for model in [fixed, other] {
        let refused = Simulation::resume_with_model(system.clone(), whole.checkpoint(), model);
        assert!(refused.is_err_and(|error| error.to_string().contains("titratable groups")));
    }
}

/// Without moves of protons the model makes the decisions of the direct sum of the same charges, bit for bit.
#[test]
fn without_moves_of_protons_the_run_is_that_of_the_direct_sum() {
    let kind = coupled(2.0);
    let charges = kind.charges();
    let present: Vec<_> = charges.charges(&charges.start()).iter().collect();
    let mesh = icosphere(4.0, 1);
    let body = Arc::new(BodyType::new("body", &mesh, &present).unwrap());
    let bodies: Vec<_> = (0..3)
        .map(|place| (0, pose_at(12.0 * place as f64)))
        .collect();
    let boundary = Boundary::periodic(Vec3::repeat(80.0)).unwrap();
    let system = System::new(vec![body], &bodies, boundary).unwrap();
    let yukawa = Yukawa::uncut(7.0, 0.2).unwrap();
    let settings = Settings::new(Interaction::YukawaDirect(yukawa));
    let run = |model: Box<dyn EnergyModel>| {
        let mut simulation = Simulation::with_model(system.clone(), settings, model, 3, 0).unwrap();
        simulation
            .run_until(100, &mut |_| ControlFlow::Continue(()))
            .unwrap();
        simulation.system().poses().to_vec()
    };
    let regulated = run(Box::new(DirectSum::regulated(yukawa, vec![Some(charges)])));
    assert_eq!(regulated, run(Box::new(DirectSum::new(yukawa))));
}
