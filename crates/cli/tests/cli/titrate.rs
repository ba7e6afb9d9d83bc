//! Titration of a structure: the answer for scripts, the files, and what is refused.

use crate::common::{TemporaryFolder, is_ok, message};
use serde_json::Value;
use std::path::Path;

const STRUCTURE: &str = "data/structures/5pti.cif.gz";

/// A folder with the bundled structures.
fn place() -> TemporaryFolder {
    let place = TemporaryFolder::new();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data");
    std::os::unix::fs::symlink(data, place.path("data")).unwrap();
    place
}

#[test]
fn a_titration_says_what_shifts_each_pka_and_writes_its_tables() {
    let place = place();
    let output = place.run(&format!(
        "titrate -q {STRUCTURE} --ph 2..12/21 --salt 100mM --json -o titration"
    ));
    is_ok(&output);
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let groups = answer["groups"].as_array().unwrap();
    assert_eq!(groups.len(), 20);
    let mut net_charge_e = 0.0;
    for group in groups {
        net_charge_e += group["charge_e"].as_f64().unwrap();
        let [pka, model_pka, desolvation, background, neighbours] = [
            "pka",
            "model_pka",
            "shift_desolvation",
            "shift_background",
            "shift_neighbours",
        ]
        .map(|key| group[key].as_f64().unwrap());
        let sum = model_pka + desolvation + background + neighbours;
        assert!((pka - sum).abs() < 1e-9, "{group}");
    }
    assert!((net_charge_e - answer["net_charge_e"].as_f64().unwrap()).abs() < 1e-9);
    assert_eq!(answer["curve"].as_array().unwrap().len(), 21);
    // Tyrosine 23, in the protein's core: 11.7 is measured.
    let buried = groups
        .iter()
        .find(|group| group["residue"] == "TYR" && group["residue_number"] == 23)
        .unwrap();
    assert!(buried["pka"].as_f64().unwrap() > 11.0, "{buried}");
    for name in [
        "titration.csv",
        "curve.csv",
        "titration.json",
        "titration.svg",
        "run.json",
    ] {
        assert!(place.path("titration").join(name).is_file(), "{name}");
    }
    is_ok(&place.run("report titration"));
    let page = std::fs::read_to_string(place.path("titration/report.html")).unwrap();
    for words in ["A TYR 23", "isoelectric point", "desolvation"] {
        assert!(page.contains(words), "{words}");
    }
    // The second run is refused before it computes anything.
    let again = place.run(&format!("titrate {STRUCTURE} --salt 0.1M -o titration"));
    assert!(message(&again).contains("already exists"));
}

#[test]
fn conditions_outside_the_fit_are_named() {
    let place = place();
    let output = place.run(&format!(
        "titrate {STRUCTURE} --salt 0.1M --temperature 350 --inner-permittivity 4 --json"
    ));
    is_ok(&output);
    let told = message(&output);
    assert!(
        told.contains("permittivity of 20") && told.contains("25 °C"),
        "{told}"
    );
}

/// Salt weakens what groups do to each other: of this positive protein, aspartate 50 moves towards its
/// pKa in water.
#[test]
fn salt_screens_the_shifts_by_neighbours() {
    let place = place();
    let pka = |salt: &str| {
        let output = place.run(&format!("titrate -q {STRUCTURE} --salt {salt} --json"));
        is_ok(&output);
        let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
        let groups = answer["groups"].as_array().unwrap().clone();
        let group = groups
            .into_iter()
            .find(|group| group["residue_number"] == 50)
            .unwrap();
        group["pka"].as_f64().unwrap()
    };
    assert!(pka("1M") > pka("10mM") + 0.2);
}

#[test]
fn what_cannot_be_titrated_is_refused_with_a_remedy() {
    let place = place();
    std::fs::write(
        place.path("glycine.pdb"),
        "ATOM      1  N   GLY A   2       0.000   0.000   0.000  1.00  0.00           N\n\
         ATOM      2  CA  GLY A   2       1.460   0.000   0.000  1.00  0.00           C\n\
         HETATM    3 ZN    ZN B   3       9.000   0.000   0.000  1.00  0.00          ZN\n",
    )
    .unwrap();
    std::fs::write(
        place.path("point.pqr"),
        "ATOM 1 N LYS 1 0.0 0.0 0.0 1.0 2.0\n",
    )
    .unwrap();
    for (words, told) in [
        (
            "glycine.pdb --chain B --keep-ligands --salt 0.1M",
            "no titratable group",
        ),
        ("point.pqr --salt 0.1M", "give PDB or mmCIF"),
        ("glycine.pdb --salt 0.1M --ph 20", "0 to 14"),
        ("glycine.pdb --salt 0.1M --ph 12..2", "lower pH first"),
        ("glycine.pdb", "--salt"),
    ] {
        let output = place.run(&format!("titrate {words}"));
        assert!(!output.status.success(), "{words}");
        assert!(
            message(&output).contains(told),
            "{words}: {}",
            message(&output)
        );
    }
}
