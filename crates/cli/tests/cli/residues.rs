//! Residues of a run: the files, the report, and mutants simulated anew.

use crate::common::{TemporaryFolder, is_ok, message};
use serde_json::Value;
use std::path::Path;

const STRUCTURE: &str = "data/structures/5pti.cif.gz";
/// Exchanges that make BPTI negative.
const MINUS: &str = "A:R17E,A:K26E,A:R39E,A:K41E,A:R42E,A:K46E,A:R53E";

/// A folder with the bundled structures.
fn place() -> TemporaryFolder {
    let place = TemporaryFolder::new();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data");
    std::os::unix::fs::symlink(data, place.path("data")).unwrap();
    place
}

fn ingest(place: &TemporaryFolder, name: &str, mutations: &str) {
    is_ok(&place.run(&format!(
        "ingest -q {STRUCTURE} -o . --name {name} --charges formal --density 0.5 --mutate {mutations}"
    )));
}

fn json(text: &[u8]) -> Value {
    serde_json::from_slice(text).unwrap()
}

fn read(path: &Path) -> Value {
    json(&std::fs::read(path).unwrap())
}

/// The frames of two bodies, weighted for three mutants, give what the mutants give when they are
/// simulated themselves. `tests/validation/mutation_scan.sh` is the same at length.
#[test]
fn weighted_frames_are_those_of_the_mutants() {
    const SALTS: &str = "50mM,150mM";
    let place = place();
    ingest(&place, "plus", "A:D3K,A:E49K");
    let mutants = [
        ("A:E17Q", MINUS.replace("A:R17E", "A:R17Q")),
        ("A:D50N", format!("{MINUS},A:D50N")),
        ("A:K15E", format!("{MINUS},A:K15E")),
    ];
    let sweep = |name: &str, mutations: &str, seed: usize| -> Value {
        ingest(&place, name, mutations);
        is_ok(&place.run(&format!(
            "assemble ring -q plus.body {name}.body --members 2 --box 80 -o {name}.json"
        )));
        let output = place.run(&format!(
            "sweep {name}.json --salt {SALTS} --replicas 4 --starts both --exchange-every 10 --energy \
             direct --equilibration 200 --sweeps 4000 --trajectory-every 20 --seed {seed} --json -q -o \
             run_{name}"
        ));
        is_ok(&output);
        json(&output.stdout)
    };
    sweep("unchanged", MINUS, 1);
    let output = place.run("residues run_unchanged --salt 50mM --mutations --frames 10000 --json -q");
    is_ok(&output);
    let scan = json(&output.stdout);
    let mut largest_change: f64 = 0.0;
    for (number, (mutation, mutations)) in mutants.iter().enumerate() {
        let simulated = sweep(&mutation.replace("A:", ""), mutations, number + 2);
        let rows = scan["mutations"].as_array().unwrap().iter();
        let of_minus = |row: &&Value| row["mutation"] == *mutation && row["body"] == "unchanged";
        let row = rows.clone().find(of_minus).unwrap();
        for (at, salt) in row["at_salts"].as_array().unwrap().iter().zip(
            simulated["salts"].as_array().unwrap(),
        ) {
            assert!(at["effective_frames"].as_f64().unwrap() > 20.0);
            let weighted = at["contacts_left"]["mean"].as_f64().unwrap();
            let error = at["contacts_left"]["error"].as_f64().unwrap();
            let bound = salt["bound_fraction_mean"].as_f64().unwrap();
            let spread = salt["bound_fraction_sd"].as_f64().unwrap() / 2.0;
            let tolerance = 4.0 * error.hypot(spread).max(0.01);
            assert!(
                (weighted - bound).abs() < tolerance,
                "{mutation}: {weighted} ± {error}, {bound} ± {spread}"
            );
        }
        let change = row["energy_change_kt"]["mean"].as_f64().unwrap();
        largest_change = largest_change.max(change.abs());
    }
    assert!(largest_change > 0.3, "{largest_change}");
}

/// The energy of the run's log is that of the shares; files and report are there.
#[test]
fn a_run_is_shared_out_and_shown() {
    let place = place();
    ingest(&place, "plus", "A:D3K,A:E49K");
    ingest(&place, "minus", MINUS);
    is_ok(&place.run("assemble ring -q plus.body minus.body --members 4 --box 200 -o ring.json"));
    is_ok(&place.run(
        "sweep ring.json --salt 30mM,300mM --replicas 2 --energy direct --equilibration 20 --sweeps 60 \
         --log-every 10 --trajectory-every 10 -q -o run --contacts calvados3",
    ));
    let output = place.run("residues run --salt 30mM --script chimerax --json -q");
    is_ok(&output);
    let result = json(&output.stdout);
    assert_eq!((&result["frames"], &result["blocks"]), (&12.into(), &6.into()));
    let sweep = read(&place.path("run/sweep.json"));
    let expected = sweep["salts"][0]["energy_mean_kT"].as_f64().unwrap();
    let found = result["energy"]["total_kt"]["mean"].as_f64().unwrap();
    // The rows of the log are those of the frames, whose poses have single precision.
    assert!((found - expected).abs() < 0.01, "{found} {expected}");
    for name in [
        "residues.csv",
        "residue_pairs.csv",
        "residues.png",
        "contact_map.svg",
        "energy_map.png",
        "residues.cif",
        "residues.cxc",
        "residues.json",
    ] {
        assert!(place.path("run/residues").join(name).is_file(), "{name}");
    }
    let script = std::fs::read_to_string(place.path("run/residues/residues.cxc")).unwrap();
    assert!(script.contains("color byattribute bfactor"), "{script}");
    let again = place.run("residues run --salt 30mM -q");
    assert!(message(&again).contains("--force"));
    is_ok(&place.run("report run"));
    let page = std::fs::read_to_string(place.path("run/report.html")).unwrap();
    assert!(page.contains("What holds it") && page.contains("energy of residues at 30 mM"));
    // A run that is begun anew takes its residues with it.
    is_ok(&place.run(
        "sweep ring.json --salt 30mM --replicas 1 --energy direct --equilibration 20 --sweeps 60 \
         --log-every 10 -q -o run --force",
    ));
    assert!(!place.path("run/residues").exists());
}
