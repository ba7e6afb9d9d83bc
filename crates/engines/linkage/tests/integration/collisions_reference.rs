//! First contacts and elastic impacts computed elsewhere.

use protomer_linkage::lattice::collision::replay::{first_contact, respond};
use protomer_linkage::lattice::{Coherence, Dynamics, Edges, Network, Square, State};
use serde_json::Value;
use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

use crate::common::references::{numbers, references};

fn contacts(value: &Value) -> Vec<[usize; 3]> {
    let triple = |x: &Value| [0, 1, 2].map(|place| x[place].as_u64().unwrap() as usize);
    value.as_array().unwrap().iter().map(triple).collect()
}

fn network(reference: &Value) -> Network {
    let size = reference["ns"].as_u64().unwrap() as usize;
    let r0 = reference["r0"].as_f64().unwrap();
    Network::lattice(size, size, r0, Square::default(), Edges::Open, FRAC_PI_4).unwrap()
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: reference/lattice"]
fn impacts_give_the_reference_velocities() {
    for (name, reference) in references() {
        let network = network(&reference);
        let contact = &reference["first_collision"];
        let (positions, velocities) = (numbers(&contact["s"]), numbers(&contact["v"]));
        let listed = contacts(&contact["contacts"]);
        let response = respond(&network, &positions, &velocities, &listed, 1.0).unwrap();
        let error = largest_difference(&response.velocities_after, &numbers(&contact["v_after"]));
        eprintln!(
            "{name}: {} listed, {} touches, v_after off by {error:.1e}",
            listed.len(),
            response.contacts.len()
        );
        assert!(error < 1e-10, "{name}: {error:e}");
        assert!(response.impulses.iter().all(|impulse| *impulse >= 0.0));
    }
}

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: reference/lattice"]
fn first_contacts_are_those_of_the_reference() {
    for (name, reference) in references() {
        let network = Arc::new(network(&reference));
        let kappa = reference["kappa"].as_f64().unwrap();
        let contact = &reference["first_collision"];
        let time = contact["t"].as_f64().unwrap();
        let errors = [1e-3, 5e-4].map(|step| {
            let mut state =
                State { time: 0.0, positions: numbers(&reference["s0"]), velocities: numbers(&reference["v0"]) };
            let mut dynamics = Dynamics::new(network.clone(), vec![Box::new(Coherence { kappa })], &state).unwrap();
            let found = first_contact(&mut dynamics, &mut state, step, 2.0 * time, false).unwrap().unwrap();
            assert_eq!(found.listed(), contacts(&contact["contacts"]), "{name}");
            let reached = [found.state.positions.as_slice(), &found.state.velocities].concat();
            let expected = [numbers(&contact["s"]), numbers(&contact["v"])].concat();
            let state_error = largest_difference(&reached, &expected);
            let after =
                respond(&network, &found.state.positions, &found.state.velocities, &found.listed(), 1.0).unwrap();
            let after_error = largest_difference(&after.velocities_after, &numbers(&contact["v_after"]));
            eprintln!(
                "{name} at {step}: time off by {:.2e}, state by {state_error:.2e}, v_after by {after_error:.2e}",
                found.time - time
            );
            (found.time - time).abs()
        });
        assert!(errors[0] < 1e-4, "{name}: {errors:?}");
        assert!(
            (3.7..4.3).contains(&(errors[0] / errors[1])),
            "{name}: {errors:?}"
        );
    }
}
