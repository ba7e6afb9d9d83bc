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

/// The energy of the run's log is that of the shares; files and report are there.
#[test]
fn a_run_is_shared_out_and_shown() {
    let place = place();
    ingest(&place, "plus", "A:D3K,A:E49K");
    ingest(&place, "minus", MINUS);
    is_ok(&place.run("assemble ring -q plus.body minus.body --members 4 --box 200 -o four.json"));
    is_ok(&place.run(
        "sweep four.json --salt 30mM,300mM --replicas 2 --energy direct --equilibration 20 --sweeps 60 \
         --log-every 10 --trajectory-every 10 -q -o run --contacts calvados3",
    ));
    let output = place.run("residues run --salt 30mM --script chimerax --json -q");
    is_ok(&output);
    let result = json(&output.stdout);
    assert_eq!(
        (&result["frames"], &result["blocks"]),
        (&12.into(), &6.into())
    );
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
    let changed = place.run("residues run --mutations --salt 30mM --json -q -o elsewhere");
    is_ok(&changed);
    let changed = json(&changed.stdout);
    let of_minus = |row: &&Value| row["body"] == "minus" && row["mutation"] == "A:D50K";
    let row = changed["mutations"]
        .as_array()
        .unwrap()
        .iter()
        .find(of_minus)
        .unwrap();
    assert!(
        row["energy_change_kt"]["mean"].as_f64().unwrap() > 1.0,
        "{row}"
    );
    assert!(
        row["first_order_half_salt_molar"].as_f64().unwrap()
            < sweep["half_salt_molar"].as_f64().unwrap()
    );
    // All start alike, so nothing is known of an equilibrium.
    assert!(row["half_salt_molar"].is_null());
    assert!(
        changed["mutations_note"]
            .as_str()
            .unwrap()
            .contains("not known to be in equilibrium")
    );
    let script = std::fs::read_to_string(place.path("run/residues/residues.cxc")).unwrap();
    assert!(script.contains("color byattribute bfactor"), "{script}");
    let again = place.run("residues run --salt 30mM -q");
    assert!(message(&again).contains("--force"));
    is_ok(&place.run("report run"));
    let page = std::fs::read_to_string(place.path("run/report.html")).unwrap();
    assert!(page.contains("What holds it") && page.contains("energy of residues at 30 mM"));
    // A run that is begun anew takes its residues with it.
    is_ok(&place.run(
        "sweep four.json --salt 30mM --replicas 1 --energy direct --equilibration 20 --sweeps 60 \
         --log-every 10 -q -o run --force",
    ));
    assert!(!place.path("run/residues").exists());
}
