//! The dynamics against the coherent orbit, which is known exactly.

use crate::common::lattice;
use protomer_linkage::analysis::grima::{CoherentOrbit, smallest_angle};
use protomer_linkage::analysis::modes::{Modes, orientational_spread};
use protomer_linkage::lattice::{
    Coherence, Dynamics, Force, Network, Square, Start, StartVelocities, State,
};
use std::sync::Arc;

fn start(size: usize, rod_length: f64, angle: f64, rate: f64) -> (Arc<Network>, State) {
    let network = lattice(size, rod_length);
    let start = Start {
        angle,
        velocities: StartVelocities::Checkerboard { rate },
        ..Start::default()
    };
    let state = start.build(&network, 0).unwrap().state;
    (network, state)
}

/// The largest distance of θ_c from the orbit in a time, and the largest spread about the coherent
/// state.
fn depart(size: usize, rod_length: f64, kappa: f64, angle: f64, time: f64, step: f64) -> [f64; 2] {
    let (network, mut state) = start(size, rod_length, angle, 1.0);
    let orbit = CoherentOrbit::new(size, size, Square::default(), rod_length, angle, 1.0).unwrap();
    assert!(
        orbit.first_contact().unwrap() > time,
        "the squares would meet"
    );
    let forces: Vec<Box<dyn Force>> = vec![Box::new(Coherence { kappa })];
    let mut dynamics = Dynamics::new(network.clone(), forces, &state).unwrap();
    let mut worst = [0.0_f64; 2];
    for _ in 0..(time / step).round() as u64 {
        dynamics.step(&mut state, step).unwrap();
        let away = Modes::from_coordinates(&network, &state.positions).checkerboard
            - orbit.state(state.time)[0];
        worst[0] = worst[0].max(away.abs());
        worst[1] = worst[1].max(orientational_spread(&network, &state.positions));
    }
    worst
}

#[test]
fn two_by_two_keeps_the_orbit_to_second_order_whatever_the_rods() {
    for rod_length in [0.05, 3.0 / 22.0, 1.0, 2.0] {
        let [coarse, middle, fine] =
            [4e-3, 2e-3, 1e-3].map(|step| depart(2, rod_length, 0.0, 0.2, 1.0, step)[0]);
        eprintln!("r0 = {rod_length}: {coarse:e} {middle:e} {fine:e}");
        assert!(fine < 2e-6, "{rod_length}: {fine}");
        assert!(
            (3.9..4.1).contains(&(coarse / middle)) && (3.9..4.1).contains(&(middle / fine)),
            "{rod_length}"
        );
    }
}

/// With r0 > 0 larger lattices leave the orbit. The shorter the rods, the less other motion there is;
/// in the limit r0 = 0, where the constraints are singular, only the orbit is left.
#[test]
fn four_by_four_approaches_the_orbit_as_the_rods_shrink() {
    let [long, middle, short] = [0.1, 0.025, 0.00625]
        .map(|rod_length| depart(4, rod_length, 0.0, 0.3, 0.9, 2e-3 * rod_length));
    eprintln!("spread and departure: {long:?} {middle:?} {short:?}");
    for which in [0, 1] {
        assert!(long[which] > 1.5 * middle[which] && middle[which] > 1.5 * short[which]);
    }
}

#[test]
fn four_by_four_approaches_the_orbit_as_coherence_is_enforced() {
    let [weak, middle, strong] =
        [100.0, 1000.0, 10000.0].map(|kappa| depart(4, 0.2, kappa, 0.3, 0.9, 2e-4));
    eprintln!("spread and departure: {weak:?} {middle:?} {strong:?}");
    for which in [0, 1] {
        assert!(weak[which] > 2.0 * middle[which] && middle[which] > 2.0 * strong[which]);
    }
}

use crate::common::references::numbers;
use crate::test_data;

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: reference/lattice"]
fn contact_times_and_velocities_are_those_computed_elsewhere() {
    let folder = test_data::test_data("reference/lattice");
    for name in ["grima2_r0.05", "grima2_r0.1364", "grima2_r1"] {
        let text = std::fs::read(folder.join(format!("{name}.json"))).unwrap();
        let reference: serde_json::Value = serde_json::from_slice(&text).unwrap();
        let rod_length = reference["r0"].as_f64().unwrap();
        let (angles, rates) = (numbers(&reference["s0"]), numbers(&reference["v0"]));
        let orbit =
            CoherentOrbit::new(2, 2, Square::default(), rod_length, angles[2], rates[2]).unwrap();
        let contact = &reference["first_collision"];
        assert!(
            (orbit.first_contact().unwrap() - contact["t"].as_f64().unwrap()).abs() < 1e-10,
            "{name}"
        );
        let [angle, rate] = orbit.state(contact["t"].as_f64().unwrap() + 1e-9);
        assert!((angle - numbers(&contact["s"])[2]).abs() < 2e-9, "{name}");
        assert!(
            (angle - smallest_angle(rod_length, 1.0).unwrap()).abs() < 2e-9,
            "{name}"
        );
        assert!(
            (rate - numbers(&contact["v_after"])[2]).abs() < 1e-7,
            "{name}"
        );
        // The whole trajectory, to the accuracy of the reference.
        for (time, (s, v)) in numbers(&reference["times"])
            .iter()
            .zip(
                reference["s"]
                    .as_array()
                    .unwrap()
                    .iter()
                    .zip(reference["v"].as_array().unwrap()),
            )
            .filter(|(time, _)| **time < contact["t"].as_f64().unwrap())
        {
            let [angle, rate] = orbit.state(*time);
            assert!(
                (angle - numbers(s)[2]).abs() < 1e-10 && (rate - numbers(v)[2]).abs() < 1e-10,
                "{name} {time}"
            );
        }
    }
}
