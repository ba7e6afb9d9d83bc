//! The search of tilts and spins from the command line.

use crate::common::{TemporaryFolder, message};
use serde_json::Value;

const SEARCH: &str = "candidates a.body b.body --ring 4 --stack 2 --salt 100mM --refine 2";

#[test]
fn refined_arrangements_are_assemblies_of_the_stated_energy() {
    let place = TemporaryFolder::new();
    let found = place.answer(&format!(
        "{SEARCH} --tilt 0..90/3 --spin 0,50 -o found --json -q"
    ));
    let arrangements = found["arrangements"].as_array().unwrap();
    let energy = |arrangement: &Value| arrangement["energy_kt"].as_f64().unwrap();
    assert!(arrangements.is_sorted_by(|a, b| energy(a) <= energy(b)));
    // A tilt and a spin for each kind of body.
    assert_eq!(arrangements[0]["tilt_degrees"].as_array().unwrap().len(), 2);
    let refined: Vec<&Value> = arrangements
        .iter()
        .filter(|arrangement| arrangement["is_refined"] == true)
        .collect();
    let assemblies = found["assemblies"].as_array().unwrap();
    assert!(!refined.is_empty() && refined.len() == assemblies.len());
    for (arrangement, assembly) in refined.into_iter().zip(assemblies) {
        let assembly = assembly.as_str().unwrap();
        let state = place.answer(&format!("inspect {assembly} --salt 100mM --json -q"));
        assert_eq!(state["overlaps"].as_array().unwrap().len(), 0);
        let direct = state["energy_kT"].as_f64().unwrap();
        assert!((energy(arrangement) - direct).abs() < 1e-6 * (1.0 + direct.abs()));
        // The provenance says which arrangement it is, and the recipe makes it again.
        let text = std::fs::read_to_string(place.path(assembly)).unwrap();
        let file: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(
            file["provenance"]["arrangement"]["energy_kt"],
            arrangement["energy_kt"]
        );
    }
}

#[test]
fn cages_are_assemblies_of_the_stated_energy() {
    let place = TemporaryFolder::new();
    let command =
        "candidates a.body b.body --group tetrahedral --samples 30 --refine 2 --salt 100mM";
    let found = place.answer(&format!("{command} -o found --json -q"));
    let cage = &found["cages"][0];
    assert_eq!(
        (&cage["is_refined"], &cage["bodies"]),
        (&true.into(), &24.into())
    );
    let assembly = found["assemblies"][0].as_str().unwrap();
    let state = place.answer(&format!("inspect {assembly} --salt 100mM --json -q"));
    assert_eq!(state["overlaps"].as_array().unwrap().len(), 0);
    let [energy, direct] = [&cage["energy_kt"], &state["energy_kT"]].map(|e| e.as_f64().unwrap());
    assert!(
        (energy - direct).abs() < 1e-6 * (1.0 + direct.abs()),
        "{energy} {direct}"
    );
    let output = place.run("candidates a.body --group tetrahedral --ring 4");
    assert_eq!(output.status.code(), Some(2));
}

/// A search does not depend on the number of threads, and without a salt it says which one it takes.
#[test]
fn a_search_is_the_same_on_every_number_of_threads() {
    let place = TemporaryFolder::new();
    let search = |threads: usize| {
        let command = "candidates a.body b.body --ring 4 --stack 2 --tilt 0,45 --refine 1";
        let mut found = place.answer(&format!("{command} -j {threads} --json -q"));
        found["arrangements_per_cpu_second"] = Value::Null;
        found
    };
    let alone = search(1);
    assert_eq!(alone, search(2));
    assert_eq!(alone["salt_M"], 0.15);
}

#[test]
fn searches_that_make_no_sense_are_refused() {
    let place = TemporaryFolder::new();
    for (flags, reason) in [
        ("--tilt 0..90", "write it as 0..90/7"),
        ("--tilt 0..90/1", "give a number from 2 to 361"),
        ("--tilt upright", "'upright' is not an angle"),
        (
            "--spin 0,1e9",
            "angle is 1000000000; give -360 to 360 degrees",
        ),
        ("--tilt 0..90/300 --spin 0..90/300", "are too many"),
        (
            "--refine 3",
            "without --tilt or --spin no energies are computed",
        ),
        ("--tilt 0 --salt 0M", "give a --salt above zero"),
    ] {
        let output = place.run(&format!(
            "candidates a.body b.body --ring 4 --stack 2 {flags}"
        ));
        assert_eq!(output.status.code(), Some(1), "{flags}");
        assert!(
            message(&output).contains(reason),
            "{flags}: {}",
            message(&output)
        );
    }
    let output = place.run("candidates a.body b.body --ring 2 --tilt 0");
    assert!(
        message(&output).contains("try --symmetry cyclic"),
        "{}",
        message(&output)
    );
}
