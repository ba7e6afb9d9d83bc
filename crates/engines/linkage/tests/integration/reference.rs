//! Converged trajectories computed elsewhere.

use protomer_linkage::lattice::{Coherence, Dynamics, Edges, Network, Square, State};
use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

use crate::common::references::{numbers, references};

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: reference/lattice"]
fn trajectories_are_followed_to_second_order() {
    for (name, reference) in references() {
        let size = reference["ns"].as_u64().unwrap() as usize;
        let r0 = reference["r0"].as_f64().unwrap();
        let network = Arc::new(
            Network::lattice(size, size, r0, Square::default(), Edges::Open, FRAC_PI_4).unwrap(),
        );
        let kappa = reference["kappa"].as_f64().unwrap();
        let times = numbers(&reference["times"]);
        let contact = reference["first_collision"]["t"].as_f64().unwrap();
        let errors: Vec<f64> = [1e-3, 5e-4]
            .iter()
            .map(|step| {
                let mut state = State {
                    time: 0.0,
                    positions: numbers(&reference["s0"]),
                    velocities: numbers(&reference["v0"]),
                };
                let mut dynamics =
                    Dynamics::new(network.clone(), vec![Box::new(Coherence { kappa })], &state)
                        .unwrap();
                let mut worst = 0.0_f64;
                for (time, expected) in times.iter().zip(reference["s"].as_array().unwrap()) {
                    if *time > contact.min(1.0) {
                        break;
                    }
                    while state.time < time - 0.5 * step {
                        dynamics.step(&mut state, *step).unwrap();
                    }
                    let expected = numbers(expected);
                    let error = state
                        .positions
                        .iter()
                        .zip(&expected)
                        .map(|(a, b)| (a - b).abs())
                        .fold(0.0, f64::max);
                    worst = worst.max(error);
                }
                worst
            })
            .collect();
        let allowed = match name.split('_').next().unwrap() {
            "grima2" => 7e-7,
            "rand2" => 2e-5,
            "rand4" => 5e-5,
            _ => 3e-5,
        };
        eprintln!("{name}: {errors:?} ratio {}", errors[0] / errors[1]);
        assert!(errors[0] < 3.0 * allowed, "{name}: {errors:?}");
        assert!(
            (3.8..4.2).contains(&(errors[0] / errors[1])),
            "{name}: {errors:?}"
        );
    }
}
