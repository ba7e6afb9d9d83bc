//! Contact terms in addition to charges: the energies that a simulation keeps, and the law of
//! mass action.

use crate::common::*;
use protomer_body::chemistry::AminoAcid::{self, Leu, Lys, Phe, Trp};
use protomer_body::residue_contacts::{Bead, ContactScale};
use protomer_kernel::potential::Yukawa;
use protomer_kernel::{Boundary, Pose, Rotation, Vec3};
use protomer_mc::beads::BeadCloud;
use protomer_mc::desolvation::{Desolvation, DesolvationBody, Solute};
use protomer_mc::energy::{ContactPotential, DirectSum, EnergyModel, TermsByType, WithTerms};
use protomer_mc::pair::{
    BodyPair, Charged, Contacts, Core, Estimator, PairSettings, PairThermodynamics, Terms,
};
use protomer_mc::{BodyType, Interaction, Settings, Simulation, System};
use std::ops::ControlFlow;
use std::sync::Arc;

/// A body with three charges and three residues below its faces.
fn kind(charges: [f64; 3], residues: [AminoAcid; 3]) -> Arc<BodyType> {
    let places = [[4.0, -0.6, -1.4], [-2.6, 3.6, -1.4], [0.2, 0.5, 2.6]].map(Vec3::from);
    let sites: Vec<(Vec3, f64)> = places.into_iter().zip(charges).collect();
    let mut beads = Vec::new();
    for (residue, (position, amino_acid)) in places.into_iter().zip(residues).enumerate() {
        beads.push(Bead {
            position,
            amino_acid,
            residue,
        });
    }
    let mut kind = BodyType::new("body", &chiral_tetrahedron(), &sites).unwrap();
    kind.beads = BeadCloud::new(&beads);
    Arc::new(kind)
}

fn kinds() -> Vec<Arc<BodyType>> {
    vec![
        kind([2.0, -1.2, 1.2], [Trp, Leu, Phe]),
        kind([-2.0, 1.2, -1.2], [Phe, Trp, Lys]),
    ]
}

fn yukawa() -> Yukawa {
    Yukawa::uncut(7.0, 1.0 / 5.0).unwrap()
}

fn contacts() -> ContactPotential {
    ContactPotential::new(ContactScale::Calvados3, 1.5, 298.15).unwrap()
}

fn model(kinds: &[Arc<BodyType>]) -> Box<dyn EnergyModel> {
    let terms_of_pair = |first: usize, second: usize| {
        let beads = (&kinds[first].beads, &kinds[second].beads);
        let term = Contacts::new(contacts(), beads.0, beads.1);
        Ok::<_, ()>(Terms(vec![Arc::new(term)]))
    };
    let terms = TermsByType::new(kinds.len(), terms_of_pair).unwrap();
    Box::new(WithTerms::new(Box::new(DirectSum::new(yukawa())), terms))
}

fn settings() -> Settings {
    Settings {
        equilibration_sweeps: 200,
        contact_gap_angstrom: 4.0,
        cluster_moves_per_sweep: 2,
        ..Settings::new(Interaction::YukawaDirect(yukawa()))
    }
}

/// The slow, obvious twin: every pair of bodies over all images nearby.
fn plain_sum(system: &System, edge: f64) -> f64 {
    let (contacts, mut energy) = (contacts(), 0.0);
    for first in 0..system.len() {
        for second in 0..first {
            let (a, b) = (system.body_type(first), system.body_type(second));
            for cell in 0..27 {
                let cell = [cell % 3, cell / 3 % 3, cell / 9].map(|n| f64::from(n - 1) * edge);
                let (one, mut other) = (*system.pose(first), *system.pose(second));
                other.position += Vec3::from(cell);
                let displacement = other.position - one.position;
                let relative = protomer_kernel::RelativePose::new(&one, &other, &displacement);
                energy += contacts.energy_kt(&a.beads, &b.beads, &relative);
                for (site, charge) in a.charges.iter() {
                    for (place, other) in b.charges.iter() {
                        let apart = (relative.transform_point(&place) - site).norm();
                        energy += charge * other * yukawa().energy_kt(apart);
                    }
                }
            }
        }
    }
    energy
}

#[test]
fn kept_energies_are_those_of_the_poses_and_runs_continue() {
    let kinds = kinds();
    let edge = 66.0;
    let mut bodies = Vec::new();
    for number in 0..12_usize {
        let corner = [number % 3, number / 3 % 2, number / 6].map(|n| 22.0 * n as f64);
        let pose = Pose {
            position: Vec3::from(corner),
            rotation: Rotation::identity(),
        };
        bodies.push((number % 2, pose));
    }
    let boundary = Boundary::periodic(Vec3::repeat(edge)).unwrap();
    let system = System::new(kinds.clone(), &bodies, boundary).unwrap();
    let mut whole =
        Simulation::with_model(system.clone(), settings(), model(&kinds), 5, 0).unwrap();
    whole
        .run_until(150, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    let saved = whole.checkpoint();
    let text = serde_json::to_string(&saved).unwrap();
    let saved = serde_json::from_str(&text).unwrap();
    whole
        .run_until(300, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    let mut half = Simulation::resume_with_model(system, saved, model(&kinds)).unwrap();
    half.run_until(300, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    assert_eq!(whole.observables(), half.observables());
    let kept = whole.observables().energy_kt;
    let expected = plain_sum(whole.system(), edge);
    // Images beyond the nearest shell hold less than this.
    assert!((kept - expected).abs() < 1e-4, "{kept} {expected}");
    let moved: u64 = whole.pair_energies().len() as u64;
    assert!(moved > 5 && kept.abs() > 0.1, "{moved} {kept}");
}

fn thermodynamics(kinds: &[Arc<BodyType>]) -> PairThermodynamics {
    let (first, second) = (Arc::clone(&kinds[0]), Arc::clone(&kinds[1]));
    let charged = Charged::new(yukawa(), &first.charges, &second.charges).unwrap();
    let contacts = Contacts::new(contacts(), &first.beads, &second.beads);
    let pair = BodyPair {
        first,
        second,
        potential: Terms(vec![Arc::new(charged), Arc::new(contacts)]),
        core: Core::Surfaces,
        contact_gap_angstrom: settings().contact_gap_angstrom,
    };
    let settings = PairSettings::default();
    let mut estimator = Estimator::new(settings).unwrap();
    while estimator.done() < Estimator::steps(&settings) {
        estimator.advance(&pair);
    }
    estimator.thermodynamics(&pair)
}

/// The law of mass action for two bodies in a box: they are in contact for A/Z of the time, where
/// A = ∫ exp(-U) over contacts and Z = V - 2 B₁₂ is the whole integral.
#[test]
fn two_bodies_in_a_box_are_in_contact_as_the_association_constant_says() {
    let kinds = kinds();
    let found = thermodynamics(&kinds);
    let edge: f64 = 44.0;
    let whole = edge.powi(3) - 2.0 * found.b2_angstrom3;
    let expected = found.association_volume_angstrom3 / whole;
    assert!((0.1..0.9).contains(&expected), "{expected}");
    let pose = |x: f64| Pose {
        position: Vec3::new(x, 0.0, 0.0),
        rotation: Rotation::identity(),
    };
    let boundary = Boundary::periodic(Vec3::repeat(edge)).unwrap();
    let system = System::new(
        kinds.clone(),
        &[(0, pose(-12.0)), (1, pose(12.0))],
        boundary,
    );
    let settings = settings();
    let mut simulation =
        Simulation::with_model(system.unwrap(), settings, model(&kinds), 9, 0).unwrap();
    simulation
        .run_until(2000, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    let (blocks, samples, between) = (32, 300, 20);
    let mut shares = Vec::new();
    let mut sweep = simulation.sweep();
    for _ in 0..blocks {
        let mut bound = 0;
        for _ in 0..samples {
            sweep += between;
            simulation
                .run_until(sweep, &mut |_| ControlFlow::Continue(()))
                .unwrap();
            bound += usize::from(simulation.observables().contacts > 0);
        }
        shares.push(bound as f64 / f64::from(samples));
    }
    let Estimate { mean, error } = Estimate::from_samples(&shares);
    let of_pair =
        expected * found.association_volume_error_angstrom3 / found.association_volume_angstrom3;
    let allowed = 3.0 * error.hypot(of_pair);
    println!("{mean} ± {error} in the box, {expected} ± {of_pair} of the pair");
    assert!(error < 0.02, "{error}");
    assert!(
        (mean - expected).abs() < allowed,
        "{mean} ± {error} but {expected}"
    );
}

/// Each body's places hold the energy of the pose; displaced solvent is divided between the bodies.
#[test]
fn shares_of_places_add_up_to_the_energy() {
    let kinds = kinds();
    let (first, second) = (&kinds[0], &kinds[1]);
    let charged = Charged::new(yukawa(), &first.charges, &second.charges).unwrap();
    let solute = Solute {
        permittivity_ratio: 0.05,
        ion_radius_angstrom: 2.0,
    };
    let solvated = |kind: &BodyType| {
        let body = DesolvationBody::new(kind, &kind.charges, &yukawa(), &solute).unwrap();
        Arc::new(body)
    };
    let terms = Terms(vec![
        Arc::new(charged),
        Arc::new(Contacts::new(contacts(), &first.beads, &second.beads)),
        Arc::new(Desolvation::new(solvated(first), solvated(second))),
    ]);
    let pose = Pose {
        position: Vec3::new(9.0, -7.0, 6.0),
        rotation: Rotation::from_euler_angles(0.3, 1.1, -2.0),
    };
    let relative = protomer_kernel::RelativePose::from(&pose);
    for term in &terms.0 {
        let mut sums = [0.0; 2];
        term.shares(&relative, &mut |body, place, energy_kt| {
            assert!(place.norm() < 14.0, "{place}");
            sums[body] += energy_kt;
        });
        let energy = term.energy_kt(&relative);
        assert!(energy.abs() > 1e-3, "{energy}");
        let allowed = 1e-9 * energy.abs();
        if term.term().is_sum_over_pairs() {
            assert!((sums[0] - energy).abs() < allowed, "{sums:?} {energy}");
            assert!((sums[1] - energy).abs() < allowed, "{sums:?} {energy}");
        } else {
            assert!((sums[0] + sums[1] - energy).abs() < allowed);
        }
    }
    let parts = terms.parts_kt(&relative);
    assert!((parts.total_kt() - terms.energy_kt(&relative)).abs() < 1e-12);
    assert!(parts.desolvation_kt > 0.0);
}
