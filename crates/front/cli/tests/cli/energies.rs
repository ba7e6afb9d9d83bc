//! Energies from the command line against sums written out here, and against the shared benchmark
//! state.

use crate::common::{CHARGES, TemporaryFolder, is_ok, message};

#[test]
fn calibrated_energies_hold_the_sum() {
    let place = TemporaryFolder::new();
    let inspect = |energy: &str| -> (f64, f64) {
        let output = place.run(&format!(
            "inspect ring.json --debye 9.6A --json --energy {energy}"
        ));
        is_ok(&output);
        let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (
            found["energy_kT"].as_f64().unwrap(),
            found["error_bound_kt_per_pair"].as_f64().unwrap(),
        )
    };
    let (direct, none) = (inspect("direct"), inspect("none"));
    assert!(
        direct.0.abs() > 1e-3 && direct.1 == 0.0 && none == (0.0, 0.0),
        "{direct:?} {none:?}"
    );
    for (energy, tolerance) in [
        ("calibrated", 0.05),
        ("approximate", 1e-3),
        ("approximate --tolerance 1e-7", 1e-7),
    ] {
        let (found, bound) = inspect(energy);
        // Six pairs.
        assert!(
            (found - direct.0).abs() <= 6.0 * bound + 1e-12 && bound <= tolerance,
            "{energy}: {found} {bound}"
        );
        assert!(
            bound > 0.0 || tolerance < 1e-6,
            "{energy}: intervals were used"
        );
    }
}

#[test]
fn a_tolerance_without_approximate_energies_is_refused() {
    let place = TemporaryFolder::new();
    for verb in ["inspect", "bench"] {
        for energy in ["direct", "calibrated", "none"] {
            let output = place.run(&format!(
                "{verb} ring.json --debye 3A --tolerance 1e-3 --energy {energy}"
            ));
            assert_eq!(output.status.code(), Some(1));
            assert!(
                message(&output).contains("--energy approximate"),
                "{}",
                message(&output)
            );
        }
        let output = place.run(&format!(
            "{verb} ring.json --debye 3A --tolerance -1e-3 --energy approximate"
        ));
        assert!(
            message(&output).contains("--tolerance") && message(&output).contains("give 1e-12 to"),
            "{}",
            message(&output)
        );
    }
}

fn inspect(place: &TemporaryFolder, assembly: &str) -> serde_json::Value {
    let output = place.run(&format!(
        "inspect {assembly} --bjerrum 7.0A --debye 9.6A --json"
    ));
    is_ok(&output);
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn the_energy_of_two_bodies_is_the_sum_over_their_charges() {
    let place = TemporaryFolder::new();
    // The second body stands a quarter turn about z from the first one: (x, y, z) becomes (-y, x,
    // z).
    let half = std::f64::consts::FRAC_1_SQRT_2;
    std::fs::write(
        place.path("pair.json"),
        format!(
            r#"{{"bodies": [{{"name": "a", "file": "a.body"}}, {{"name": "b", "file": "b.body"}}], "placements": [
            {{"body": "a", "position_angstrom": [1, 2, 3], "orientation_wxyz": [1, 0, 0, 0]}},
            {{"body": "b", "position_angstrom": [14, 2, 3], "orientation_wxyz": [{half}, 0, 0, {half}]}}]}}"#
        ),
    )
    .unwrap();
    let mut expected = 0.0;
    for [x1, y1, z1, q1] in CHARGES[0] {
        for [x2, y2, z2, q2] in CHARGES[1] {
            let (dx, dy, dz) = (13.0 - y2 - x1, x2 - y1, z2 - z1);
            let r = f64::sqrt(dx * dx + dy * dy + dz * dz);
            expected += 7.0 * q1 * q2 * (-r / 9.6).exp() / r;
        }
    }
    let found = inspect(&place, "pair.json");
    let energy = found["energy_kT"].as_f64().unwrap();
    assert!((energy - expected).abs() < 1e-12, "{energy} {expected}");
    assert!((found["pair_energies"][0][2].as_f64().unwrap() - expected).abs() < 1e-12);
    assert!((found["r_g_angstrom"].as_f64().unwrap() - 6.5).abs() < 1e-12);
    assert_eq!(found["overlaps"].as_array().unwrap().len(), 0);
}

#[path = "../../../../../tests/test_data.rs"]
mod test_data;

#[test]
#[ignore = "needs PROTOMER_TEST_DATA: bench/data"]
fn the_benchmark_state_has_its_stated_energy() {
    let states = test_data::test_data("bench/data");
    let place = TemporaryFolder::new();
    std::fs::copy(states.join("cluster16.json"), place.path("cluster16.json")).unwrap();
    for name in ["a", "b"] {
        let (mesh, charges) = (
            states.join("bumpy_1620.off"),
            states.join(format!("charges_{name}.xyzq")),
        );
        let mut command = place.command("body");
        command
            .arg("--mesh")
            .arg(mesh)
            .arg("--charges")
            .arg(charges)
            .args(["-o", &format!("{name}.body"), "--force"]);
        is_ok(&command.output().unwrap());
    }
    let reference = std::fs::read(states.join("energies.json")).unwrap();
    let reference: serde_json::Value = serde_json::from_slice(&reference).unwrap();
    for (cutoff, definition, total) in [
        ("", "a", -27.093464773453),
        (" --cutoff 48A", "sharp_cut", -26.303340096741),
    ] {
        let found = inspect(&place, &format!("cluster16.json{cutoff}"));
        let energy = found["energy_kT"].as_f64().unwrap();
        assert!((energy - total).abs() < 1e-8, "{energy}");
        let pairs = reference["pairs"].as_array().unwrap();
        let pair_energies = found["pair_energies"].as_array().unwrap();
        assert_eq!(pairs.len(), pair_energies.len());
        for (pair, found) in pairs.iter().zip(pair_energies) {
            assert!(pair["i"] == found[0] && pair["j"] == found[1]);
            let expected = pair[definition].as_f64().unwrap();
            let difference = found[2].as_f64().unwrap() - expected;
            assert!(difference.abs() < 1e-10, "{pair} {difference:e}");
        }
        assert_eq!(found["overlaps"].as_array().unwrap().len(), 0);
    }
}
