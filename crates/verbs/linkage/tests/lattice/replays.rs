//! Files of squares are replayed.

use crate::support::small;
use crate::test_data;
use protomer_linkage_verbs::lattice::replay::{LatticeFile, replay, respond};
use protomer_linkage_verbs::lattice::settings::LatticeSettings;
use protomer_linkage_verbs::lattice::start::begin;

/// The error of a replay of 10 x 10 squares with random velocities is of second order, and the
/// answer says how large it is.
#[test]
fn replays_state_their_error() {
    let settings = LatticeSettings {
        rows: 10,
        columns: 10,
        r0: 0.5,
        ..small()
    };
    let start = begin(&settings).unwrap().state;
    let file = LatticeFile {
        squares_along_edge: 10,
        r0: 0.5,
        kappa: 0.0,
        l: 1.0,
        inertia: None,
        s0: start.positions,
        v0: start.velocities,
        times: vec![0.3, 0.6],
        first_collision: None,
    };
    let [coarse, fine, finest] = [4e-3, 2e-3, 5e-4].map(|step| replay(&file, step, 0.01).unwrap());
    let ratio = coarse.estimated_error / fine.estimated_error;
    assert!((3.7..4.3).contains(&ratio), "{ratio}");
    let mut error = 0.0_f64;
    for (a, b) in coarse.s.iter().flatten().zip(finest.s.iter().flatten()) {
        error = error.max((a - b).abs());
    }
    assert!(
        (0.9..1.1).contains(&(error / coarse.estimated_error)),
        "{error}"
    );
}

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: reference/lattice"]
fn files_are_replayed_to_their_contacts() {
    let entries = std::fs::read_dir(test_data::test_data("reference/lattice")).unwrap();
    for path in entries
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "json"))
    {
        let file = LatticeFile::read(&path).unwrap();
        let reference: serde_json::Value =
            serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        let numbers = |value: &serde_json::Value| -> Vec<f64> {
            value
                .as_array()
                .unwrap()
                .iter()
                .map(|x| x.as_f64().unwrap())
                .collect()
        };
        let apart = |a: &[f64], b: &[f64]| {
            a.iter()
                .zip(b)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max)
        };
        let found = replay(&file, 1e-3, 20.0).unwrap();
        for (s, expected) in found.s.iter().zip(reference["s"].as_array().unwrap()) {
            assert!(apart(s, &numbers(expected)) < 1e-4, "{}", path.display());
        }
        let energies = numbers(&reference["energy"]);
        assert!(
            apart(&found.energy, &energies) < 2e-3 * energies[0],
            "{}",
            path.display()
        );
        let contact = &reference["first_collision"];
        let first = found.first_collision.unwrap();
        assert!((first.t - contact["t"].as_f64().unwrap()).abs() < 1e-4);
        assert_eq!(
            serde_json::json!(first.contacts),
            contact["contacts"],
            "{}",
            path.display()
        );
        let response = respond(&file).unwrap();
        assert!(apart(&response.v_after, &numbers(&contact["v_after"])) < 1e-9);
        assert!(
            response.energy_change.abs() < 1e-12
                && response.impulses.iter().all(|impulse| *impulse >= 0.0)
        );
    }
}
