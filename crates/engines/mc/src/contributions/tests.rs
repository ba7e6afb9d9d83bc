//! Contributions against slow, obvious twins and known cases.

use super::*;
use crate::energy::terms::Terms;
use crate::energy::{ContactPotential, DirectSum, EnergyModel, TermsByType, WithTerms};
use crate::pair::Contacts;
use crate::test_support::tetrahedron;
use crate::{BodyType, Interaction, Settings, Simulation, System};
use protomer_body::residue_contacts::ContactScale;
use protomer_body::{Body, Residue, Site};
use protomer_kernel::potential::Yukawa;
use protomer_kernel::random::CounterRng;
use protomer_kernel::{Boundary, Pose, Vec3};
use std::ops::ControlFlow;
use std::sync::Arc;

/// A body of residues, each one atom with a charge, along x (Å).
pub fn body_of(residues: &[(&str, f64, f64)]) -> Body {
    let mut body = Body::of_mesh("body", tetrahedron(1.0), Vec::new()).unwrap();
    for (number, (name, x, charge_e)) in residues.iter().enumerate() {
        body.residues.push(Residue {
            chain: "A".into(),
            number: number as i32 + 1,
            insertion_code: String::new(),
            name: (*name).into(),
            charge_e: *charge_e,
            hydropathy: None,
        });
        body.sites.push(Site {
            position: Vec3::new(*x, 0.0, 0.0),
            charge_e: *charge_e,
            radius_angstrom: 2.0,
            atom_name: "CA".into(),
            residue: Some(number as u32),
        });
    }
    body
}

/// A body of random residues of three atoms.
fn random_body(rng: &mut CounterRng, residues: usize) -> Body {
    let names = ["LYS", "GLU", "TRP", "SER"];
    let mut body = body_of(&[]);
    for number in 0..residues {
        let name = names[rng.index(names.len())];
        body.residues.extend(body_of(&[(name, 0.0, 0.0)]).residues);
        let centre = rng.vector_in_ball(9.0);
        for atom_name in ["CA", "CB", "CG"] {
            body.sites.push(Site {
                position: centre + rng.vector_in_ball(1.5),
                charge_e: rng.uniform_in(-1.0, 1.0),
                radius_angstrom: 1.7,
                atom_name: atom_name.into(),
                residue: Some(number as u32),
            });
        }
    }
    body
}

struct Case {
    bodies: Vec<Body>,
    system: System,
    yukawa: Yukawa,
    terms: TermsByType,
}

/// Two copies of one body and two of another in a box of this edge that holds them.
fn case(seed: u64, edge: f64) -> Case {
    let mut rng = CounterRng::new(seed, 0, 0);
    let bodies = vec![random_body(&mut rng, 7), random_body(&mut rng, 5)];
    let kind = |body: &Body| Arc::new(BodyType::from_body(body).unwrap());
    let types: Vec<Arc<BodyType>> = bodies.iter().map(kind).collect();
    let mut pose = |x: f64, y: f64| Pose {
        position: Vec3::new(x, y, 0.0),
        rotation: rng.rotation(),
    };
    let placed = [
        (1, pose(0.0, 0.0)),
        (0, pose(16.0, 0.0)),
        (0, pose(0.0, 17.0)),
        (1, pose(18.0, 19.0)),
    ];
    let boundary = Boundary::periodic(Vec3::repeat(edge)).unwrap();
    let system = System::new(types.clone(), &placed, boundary).unwrap();
    let contacts = ContactPotential::new(ContactScale::Calvados3, 1.3, 298.15).unwrap();
    let terms = TermsByType::new(2, |first, second| {
        let (a, b): (&BodyType, &BodyType) = (&types[first], &types[second]);
        let contacts = Contacts::new(contacts.clone(), &a.beads, &b.beads);
        Ok::<_, ()>(Terms(vec![Arc::new(contacts)]))
    });
    Case {
        bodies,
        system,
        yukawa: Yukawa::uncut(7.0, 1.0 / 6.0).unwrap(),
        terms: terms.unwrap(),
    }
}

impl Case {
    fn contributions(&self, touching_angstrom: f64) -> Contributions {
        let types = self.system.types().iter();
        let kinds = self.bodies.iter().zip(types);
        let kinds = kinds.map(|(body, kind)| ResiduesOfKind::new(body, kind).unwrap());
        Contributions::new(
            &self.system,
            kinds.collect(),
            self.yukawa,
            Some(self.terms.clone()),
            touching_angstrom,
        )
    }
}

#[test]
fn contributions_add_up_to_the_energy_of_the_engine() {
    for (seed, edge) in [(1, 60.0), (2, 90.0), (3, 60.0)] {
        let case = case(seed, edge);
        let state = case.contributions(5.0).evaluate(&case.system);
        let charges = Box::new(DirectSum::new(case.yukawa));
        let mut model = WithTerms::new(charges, case.terms.clone());
        model.reset(&case.system).unwrap();
        let energy_kt = model.total_kt(&case.system);
        assert!(energy_kt.abs() > 0.1);
        assert!((state.parts.total_kt() - energy_kt).abs() < 1e-10);
        let of_residues: f64 = state
            .residues
            .iter()
            .flatten()
            .map(|residue| residue.parts.total_kt())
            .sum();
        assert!((0.5 * of_residues - energy_kt).abs() < 1e-10);
        let pairs = state.pairs.iter().flat_map(|pairs| &pairs.pairs);
        let of_pairs: f64 = pairs.map(PairContribution::total_kt).sum();
        assert!((of_pairs - energy_kt).abs() < 1e-10);
    }
}

#[test]
fn pairs_of_residues_are_those_of_the_double_loop() {
    const TOUCH: f64 = 7.0;
    // A box so large that one image of each body counts.
    let case = case(4, 400.0);
    let state = case.contributions(TOUCH).evaluate(&case.system);
    let atoms_at = |copy: usize| {
        let (body, pose) = (
            &case.bodies[case.system.type_index(copy)],
            case.system.pose(copy),
        );
        let atom = |site: &Site| {
            let residue = site.residue.unwrap() as usize;
            (residue, pose.transform_point(&site.position), site.charge_e)
        };
        body.sites.iter().map(atom).collect::<Vec<_>>()
    };
    let mut touches = vec![vec![false; 7]; 4];
    let mut apart = 0.0;
    for pairs in &state.pairs {
        for a in 0..case.bodies[pairs.kinds.0].residues.len() {
            for b in 0..pairs.columns {
                let (mut energy, mut touching) = (0.0, 0.0);
                for first in 0..4 {
                    for second in 0..4 {
                        let kinds = (
                            case.system.type_index(first),
                            case.system.type_index(second),
                        );
                        let is_once = kinds.0 != kinds.1 || a != b || first < second;
                        if first == second || kinds != pairs.kinds || !is_once {
                            continue;
                        }
                        let (mut of_bodies, mut nearest) = (0.0, f64::INFINITY);
                        for (residue, place, charge) in atoms_at(first) {
                            for (other, other_place, other_charge) in atoms_at(second) {
                                if (residue, other) == (a, b) {
                                    let r = (place - other_place).norm();
                                    nearest = nearest.min(r);
                                    of_bodies += charge * other_charge * case.yukawa.energy_kt(r);
                                }
                            }
                        }
                        energy += of_bodies;
                        if nearest < TOUCH {
                            touching += 1.0;
                            touches[first][a] = true;
                            touches[second][b] = true;
                        } else if pairs.kinds.0 != pairs.kinds.1 || a <= b {
                            apart += of_bodies;
                        }
                    }
                }
                let is_one_kind = pairs.kinds.0 == pairs.kinds.1;
                let pair = pairs.pair(a, b);
                assert!((pair.parts.charges_kt - energy).abs() < 1e-11, "{a} {b}");
                assert_eq!(pair.touching, touching, "{:?} {a} {b}", pairs.kinds);
                if is_one_kind {
                    assert_eq!(pair, pairs.pair(b, a));
                }
            }
        }
    }
    let mut outside = 0.0;
    for (copy, residues) in state.residues.iter().enumerate() {
        for (residue, contribution) in residues.iter().enumerate() {
            assert_eq!(contribution.touches, touches[copy][residue]);
            if !contribution.touches {
                outside += 0.5 * contribution.parts.charges_kt;
            }
        }
    }
    let touching = touches.iter().flatten().filter(|touches| **touches).count();
    assert!((1..20).contains(&touching), "{touching}");
    assert!((state.outside_kt - outside).abs() < 1e-11);
    assert!((state.apart_kt - apart).abs() < 1e-11);
}

/// Two charges of +2 and -3 e, 10 Å apart, and two neutral residues that touch.
#[test]
fn two_point_charges_have_the_energy_of_the_formula() {
    let first = body_of(&[("LYS", 0.0, 2.0), ("SER", 4.0, 0.0)]);
    let second = body_of(&[("GLU", 0.0, -3.0), ("SER", -2.0, 0.0)]);
    let types: Vec<Arc<BodyType>> = [&first, &second]
        .map(|body| Arc::new(BodyType::from_body(body).unwrap()))
        .to_vec();
    let second_pose = Pose {
        position: Vec3::new(10.0, 0.0, 0.0),
        ..Pose::identity()
    };
    let placed = [(0, Pose::identity()), (1, second_pose)];
    let system = System::new(types.clone(), &placed, Boundary::Open).unwrap();
    let yukawa = Yukawa::uncut(7.0, 0.1).unwrap();
    let kinds = [&first, &second].into_iter().zip(&types);
    let kinds: Vec<ResiduesOfKind> = kinds
        .map(|(body, kind)| ResiduesOfKind::new(body, kind).unwrap())
        .collect();
    let contributions = Contributions::new(&system, kinds, yukawa, None, 5.0);
    let state = contributions.evaluate(&system);
    let expected = -6.0 * 7.0 * (-1.0_f64).exp() / 10.0;
    assert!((state.parts.charges_kt - expected).abs() < 1e-14);
    // 4 Å and 8 Å: the uncharged residues touch, the charged ones do not.
    assert_eq!(state.pairs[1].pair(1, 1).touching, 1.0);
    assert_eq!(state.pairs[1].pair(0, 0).touching, 0.0);
    assert!((state.outside_kt - expected).abs() < 1e-14);
    assert!((state.residues[1][0].parts.charges_kt - expected).abs() < 1e-14);
    // One charge more on the first residue: the potential of the other body.
    let sites = [ChargeSites {
        kind: 0,
        places: vec![Vec3::zeros()],
    }];
    let responses = contributions.responses(&system, &sites).unwrap();
    assert!((responses[0].energy_change_kt(-2.0) + expected).abs() < 1e-14);
    let mut averages = Averages::new(&contributions, &system);
    averages.push(&state, &system);
    averages.end_block();
    assert_eq!(averages.total_kt().error, None);
    assert!((averages.outside_share().unwrap().mean - 1.0).abs() < 1e-14);
    assert_eq!(averages.untouched_share().mean, 0.5);
}

#[test]
fn a_response_is_the_energy_of_the_changed_bodies() {
    let case = case(5, 60.0);
    let contributions = case.contributions(5.0);
    for kind in 0..2 {
        for residue in 0..case.bodies[kind].residues.len() {
            let places = charge_sites(&case.bodies[kind], residue);
            // The outermost of CA, CB, CG.
            assert_eq!(places, [case.bodies[kind].sites[3 * residue + 2].position]);
            let site = ChargeSites { kind, places };
            let responses = contributions.responses(&case.system, &[site]).unwrap();
            let mut bodies = case.bodies.clone();
            bodies[kind].sites[3 * residue + 2].charge_e += 1.5;
            let types = bodies.iter();
            let types = types.map(|body| Arc::new(BodyType::from_body(body).unwrap()));
            let placed: Vec<(usize, Pose)> = (0..4)
                .map(|copy| (case.system.type_index(copy), *case.system.pose(copy)))
                .collect();
            let boundary = *case.system.boundary();
            let changed = System::new(types.collect(), &placed, boundary).unwrap();
            let energy = |system: &System| {
                let mut model = DirectSum::new(case.yukawa);
                model.reset(system).unwrap();
                model.total_kt(system)
            };
            let expected = energy(&changed) - energy(&case.system);
            let change = responses[0].energy_change_kt(1.5);
            // Images beyond the reach of either system are left out, 1e-8 kT each.
            assert!((change - expected).abs() < 1e-6, "{change} {expected}");
        }
    }
}

#[test]
fn means_are_those_of_the_frames_and_errors_those_of_blocks() {
    let case = case(6, 60.0);
    let contributions = case.contributions(6.0);
    let mut averages = Averages::new(&contributions, &case.system);
    let mut energies = Vec::new();
    let mut rng = CounterRng::new(8, 0, 0);
    for block in 0..4 {
        for _ in 0..3 {
            let mut poses = case.system.poses().to_vec();
            for pose in &mut poses {
                pose.position += rng.vector_in_ball(2.0) + Vec3::x() * f64::from(block);
            }
            let displaced_system = case.system.with_poses(&poses);
            let state = contributions.evaluate(&displaced_system);
            energies.push(state.parts.total_kt());
            averages.push(&state, &displaced_system);
        }
        averages.end_block();
    }
    assert_eq!((averages.frames(), averages.blocks()), (12, 4));
    let of_blocks: Vec<f64> = energies
        .chunks(3)
        .map(|block| block.iter().sum::<f64>() / 3.0)
        .collect();
    let mean = of_blocks.iter().sum::<f64>() / 4.0;
    let squares: f64 = of_blocks.iter().map(|block| (block - mean).powi(2)).sum();
    let total = averages.total_kt();
    assert!((total.mean - mean).abs() < 1e-12);
    assert!((total.error.unwrap() - (squares / 12.0).sqrt()).abs() < 1e-12);
    // Per copy, two of each kind; a pair with both of its residues.
    let (mut of_residues, mut of_pairs) = (0.0, 0.0);
    for kind in 0..2 {
        for residue in 0..averages.residues(kind) {
            of_residues += averages.residue(kind, residue).energy_kt.mean;
        }
    }
    for (index, (first, second)) in averages.pairs_of_kinds().into_iter().enumerate() {
        for a in 0..averages.residues(first) {
            for b in 0..averages.residues(second) {
                of_pairs += averages.pair(index, a, b).energy_kt.mean;
            }
        }
    }
    assert!((of_residues - mean).abs() < 1e-11, "{of_residues} {mean}");
    assert!((of_pairs - mean).abs() < 1e-11);
}

/// Takes the number of a replica, whether its bodies touch, and its state.
type Take<'a> = Box<dyn FnMut(u32, f64, &System) + 'a>;

/// The frames of two bodies, weighted for three mutants, against separate simulations of them:
/// `tests/validation/mutation_scan.sh` does the same with proteins.
#[test]
fn weighted_frames_are_those_of_the_mutants() {
    const REPLICAS: u32 = 5;
    const FRAMES: u64 = 3000;
    let first = body_of(&[("LYS", 0.3, 1.5), ("LYS", -0.3, 1.0)]);
    let second = body_of(&[("GLU", 0.3, -1.5), ("SER", -0.3, 0.0)]);
    let yukawa = Yukawa::uncut(2.5, 1.0 / 4.0).unwrap();
    let system_of = |first: &Body, second: &Body| {
        let types = [first, second].map(|body| Arc::new(BodyType::from_body(body).unwrap()));
        let second_pose = Pose {
            position: Vec3::new(4.0, 0.0, 0.0),
            ..Pose::identity()
        };
        let boundary = Boundary::SphereWall {
            radius_angstrom: 7.0,
        };
        let placed = [(0, Pose::identity()), (1, second_pose)];
        System::new(types.to_vec(), &placed, boundary).unwrap()
    };
    // Each frame of each replica: whether the bodies touch, and the state.
    let simulated = |system: &System, seed: u64, mut take: Take<'_>| {
        for replica in 0..REPLICAS {
            let mut settings = Settings::new(Interaction::YukawaDirect(yukawa));
            settings.contact_gap_angstrom = 2.0;
            settings.cluster_moves_per_sweep = 0;
            let mut simulation = Simulation::new(system.clone(), settings, seed, replica).unwrap();
            for frame in 0..FRAMES {
                let stop = simulation.settings().equilibration_sweeps + 4 * frame + 4;
                simulation
                    .run_until(stop, &mut |_| ControlFlow::Continue(()))
                    .unwrap();
                take(
                    replica,
                    simulation.observables().bound_fraction,
                    simulation.system(),
                );
            }
        }
    };
    let mean_of = |values: &[Vec<f64>]| -> Mean {
        let block_mean = |values: &Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
        mean_of_blocks(&values.iter().map(block_mean).collect::<Vec<f64>>())
    };
    let system = system_of(&first, &second);
    let kinds = [&first, &second].into_iter().zip(system.types());
    let kinds = kinds.map(|(body, kind)| ResiduesOfKind::new(body, kind).unwrap());
    let contributions = Contributions::new(&system, kinds.collect(), yukawa, None, 5.0);
    let mutants = [(0, 1, -1.0), (1, 0, -1.0), (1, 1, 1.0)];
    let sites = mutants.map(|(kind, residue, _)| ChargeSites {
        kind,
        places: charge_sites([&first, &second][kind], residue),
    });
    let mut frames: Vec<Vec<(f64, Vec<Response>)>> = vec![Vec::new(); REPLICAS as usize];
    simulated(
        &system,
        1,
        Box::new(|replica, bound, state| {
            let responses = contributions.responses(state, &sites).unwrap();
            frames[replica as usize].push((bound, responses));
        }),
    );
    let mut largest: f64 = 0.0;
    for (index, (kind, residue, charge_e)) in mutants.into_iter().enumerate() {
        let weighted: Vec<f64> = frames
            .iter()
            .map(|frames| {
                let frames = frames.iter().map(|(bound, responses)| {
                    (*bound, responses[index].energy_change_kt(charge_e))
                });
                let estimate = reweighted(frames);
                assert!(
                    estimate.effective_frames > 300.0,
                    "{}",
                    estimate.effective_frames
                );
                estimate.mean
            })
            .collect();
        let weighted = mean_of_blocks(&weighted);
        let (mut ours, mut theirs) = (first.clone(), second.clone());
        [&mut ours, &mut theirs][kind].sites[residue].charge_e += charge_e;
        let mut bound = vec![Vec::new(); REPLICAS as usize];
        simulated(
            &system_of(&ours, &theirs),
            2 + index as u64,
            Box::new(|replica, of_frame, _| bound[replica as usize].push(of_frame)),
        );
        let anew = mean_of(&bound);
        let error = weighted.error.unwrap().hypot(anew.error.unwrap());
        let apart = (weighted.mean - anew.mean).abs();
        assert!(error < 0.03 && apart < 4.0 * error, "{weighted:?} {anew:?}");
        let unchanged: Vec<Vec<f64>> = frames
            .iter()
            .map(|frames| frames.iter().map(|(bound, _)| *bound).collect())
            .collect();
        largest = largest.max((mean_of(&unchanged).mean - anew.mean).abs() / error);
    }
    // One mutant at least is told from the unchanged bodies.
    assert!(largest > 6.0, "{largest}");
}
