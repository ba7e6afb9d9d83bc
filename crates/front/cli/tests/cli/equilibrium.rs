//! Equilibria of assemblies: the answer for scripts, continuation, and what is refused.

use crate::common::{TemporaryFolder, contents, is_ok, message};
use serde_json::{Value, json};
use std::fmt::Write;
use std::fs;

/// A cube of 10 Å.
const CUBE: &str = "OFF\n8 12 0\n-5 -5 -5\n5 -5 -5\n5 5 -5\n-5 5 -5\n-5 -5 5\n5 -5 5\n5 5 5\n-5 5 5\n\
    3 0 2 1\n3 0 3 2\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 2 3 7\n3 2 7 6\n3 1 2 6\n3 1 6 5\n3 0 4 7\n3 0 7 3\n";
const QUICK: &str = "--model thesis --live-states 24 --runs 2 -q --json";

/// Cubes with a positive patch on one face and a negative one on the next, and assemblies of them: `ring.json` has four
/// around an axis, `pair.json` two, `apart.json` two far from each other, `single.json` one.
fn patchy() -> TemporaryFolder {
    let place = TemporaryFolder::new();
    fs::write(place.path("cube.off"), CUBE).unwrap();
    let mut charges = String::new();
    for a in [-3, 3] {
        for b in [-3, 3] {
            writeln!(charges, "4.2 {a} {b} 1.6\n{a} 4.2 {b} -1.6").unwrap();
        }
    }
    fs::write(place.path("patchy.xyzq"), charges).unwrap();
    is_ok(&place.run("body -q --mesh cube.off --charges patchy.xyzq -o patchy.body"));
    let corners = [[0.0, 0.0], [10.4, 0.0], [10.4, 10.4], [0.0, 10.4]];
    let placed: Vec<Value> = (0..4)
        .map(|number| {
            let half = std::f64::consts::FRAC_PI_4 * f64::from(number);
            let [x, y] = corners[number as usize];
            json!({"body": "patchy", "position_angstrom": [x, y, 0.0],
                   "orientation_wxyz": [half.cos(), 0.0, 0.0, half.sin()]})
        })
        .collect();
    let mut far = placed[..2].to_vec();
    far[1]["position_angstrom"] = json!([80.0, 0.0, 0.0]);
    let assemblies = [
        ("ring", placed.clone()),
        ("pair", placed[..2].to_vec()),
        ("single", placed[..1].to_vec()),
        ("apart", far),
    ];
    for (name, placements) in assemblies {
        let assembly = json!({"bodies": [{"name": "patchy", "file": "patchy.body"}], "placements": placements});
        fs::write(place.path(&format!("{name}.json")), assembly.to_string()).unwrap();
    }
    place
}

#[test]
fn a_ring_falls_apart_with_salt_and_says_where() {
    let place = patchy();
    let found = place.answer(&format!(
        "stability ring.json --salt 500mM,700mM,1M --concentration 10mM,1mM -o out {QUICK}"
    ));
    assert_eq!(found["way"], "mass action");
    assert_eq!(found["model"], "thesis");
    let yields: Vec<f64> = found["yield"]
        .as_array()
        .unwrap()
        .iter()
        .map(|value| value.as_f64().unwrap())
        .collect();
    assert!(yields[0] > 0.6 && yields[2] < 0.1, "{yields:?}");
    let half = found["half_salt_molar"].as_f64().unwrap();
    let interval = found["half_salt_interval_molar"].as_array().unwrap();
    assert!(interval[0].as_f64().unwrap() < half && half < interval[1].as_f64().unwrap());
    half_of_the_bodies_are_bound_where_the_shares_cross(&found);
    // Single body, neighbours, opposite corners, three, and the ring with its four rotations.
    let symmetries: Vec<u64> = found["parts"]
        .as_array()
        .unwrap()
        .iter()
        .map(|part| part["symmetry_number"].as_u64().unwrap())
        .collect();
    assert_eq!(symmetries.last(), Some(&4));
    for condition in found["conditions"].as_array().unwrap() {
        for mixture in condition["mixtures"].as_array().unwrap() {
            let shares = mixture["shares"].as_array().unwrap();
            let sum: f64 = shares.iter().map(|share| share.as_f64().unwrap()).sum();
            assert!((sum - 1.0).abs() < 1e-9, "{mixture}");
        }
    }
    for name in [
        "stability.csv",
        "parts.csv",
        "stability.json",
        "stability.svg",
    ] {
        assert!(place.path("out").join(name).is_file(), "{name}");
    }
    is_ok(&place.run("report out -q"));
    let page = fs::read_to_string(place.path("out/report.html")).unwrap();
    let (verdict, assembly, results) = (
        page.find("Equilibrated"),
        page.find("<h2>Assembly"),
        page.find("<h2>Results"),
    );
    assert!(
        verdict < assembly && assembly < results,
        "{verdict:?} {assembly:?} {results:?}"
    );
    // Concentrations weigh what was sampled, so another one needs no sampling.
    let checkpoint = fs::read(place.path("out/condition/checkpoint.bin")).unwrap();
    let more = place.answer(&format!(
        "stability ring.json --salt 500mM,700mM,1M --concentration 100uM -o out {QUICK}"
    ));
    assert!(more["yield"][0].as_f64().unwrap() < yields[0]);
    assert_eq!(
        fs::read(place.path("out/condition/checkpoint.bin")).unwrap(),
        checkpoint
    );
}

/// The first part is the single body, and salts rise.
fn half_of_the_bodies_are_bound_where_the_shares_cross(found: &Value) {
    let conditions = found["conditions"].as_array().unwrap();
    let mut crossings = 0;
    for (number, half) in found["half_salts"].as_array().unwrap().iter().enumerate() {
        let bound = |row: &Value| 1.0 - row["mixtures"][number]["shares"][0].as_f64().unwrap();
        let between = conditions
            .windows(2)
            .find(|rows| bound(&rows[0]) > 0.5 && bound(&rows[1]) < 0.5);
        match (between, half["half_bound_salt_molar"].as_f64()) {
            (Some(rows), Some(salt_molar)) => {
                let [low, high] = [&rows[0], &rows[1]].map(|row| row["salt_M"].as_f64().unwrap());
                assert!(low < salt_molar && salt_molar < high, "{half}");
                assert!(
                    half["half_salt_molar"]
                        .as_f64()
                        .is_none_or(|whole| whole < salt_molar)
                );
                crossings += 1;
            }
            (None, None) => {}
            _ => panic!("{half}"),
        }
    }
    assert!(crossings > 0, "{found}");
}

/// Windows and nested sampling are two ways to one number.
#[test]
fn a_biased_simulation_has_the_free_energy_of_mass_action() {
    let place = patchy();
    let common = "--salt 500mM --concentration 10mM --model thesis -q --json";
    let grown = place.answer(&format!(
        "stability pair.json --live-states 60 --runs 4 {common}"
    ));
    let pulled = place.answer(&format!(
        "stability pair.json --way biased --sweeps 5000 --runs 4 -o pulled {common}"
    ));
    assert_eq!(pulled["way"], "biased simulation");
    assert_eq!(pulled["equilibrated"], "yes", "{}", pulled["equilibration"]);
    let whole = |found: &Value| found["conditions"][0]["parts"][1].clone();
    let (a, b) = (whole(&grown), whole(&pulled));
    let number = |part: &Value, key: &str| part[key].as_f64().unwrap();
    let error = number(&a, "free_energy_error_kt").hypot(number(&b, "free_energy_error_kt"));
    let apart = number(&a, "free_energy_kt") - number(&b, "free_energy_kt");
    assert!(error < 0.6 && apart.abs() < 3.0 * error, "{a} {b}");
    assert!(b["windows"]["round_trips"].as_u64().unwrap() > 0, "{b}");
    assert!(a["windows"].is_null(), "{a}");
    // Other settings are other work.
    let other = place.run(&format!("stability pair.json -o pulled {common}"));
    assert!(
        message(&other).contains("other settings"),
        "{}",
        message(&other)
    );
    let few = place.run(&format!(
        "stability pair.json --way biased --windows 4 --sweeps 100 {common}"
    ));
    assert!(
        message(&few).contains("--windows")
            || String::from_utf8_lossy(&few.stdout).contains("--windows"),
        "{}",
        message(&few)
    );
    let stray = place.run(&format!("stability pair.json --windows 30 {common}"));
    assert!(
        message(&stray).contains("add --way biased"),
        "{}",
        message(&stray)
    );
}

#[test]
fn equal_seeds_give_equal_bytes_with_any_threads_and_after_a_stop() {
    let place = patchy();
    let command =
        "stability ring.json --salt 500mM,1M --model thesis --live-states 20 --runs 2 -q --json";
    is_ok(&place.run(&format!("{command} -o whole -j 2")));
    // Stopped again and again, until it is done: a stop loses the part that was begun, so each try has more time.
    let (mut minutes, mut stops) = (0.003, 0);
    loop {
        let output = place.run(&format!(
            "{command} -o parts -j 1 --time-limit {minutes} --checkpoint-every 0"
        ));
        if output.status.code() != Some(3) {
            is_ok(&output);
            break;
        }
        stops += 1;
        minutes *= 1.6;
    }
    assert!(stops > 0);
    let files = |name: &str| {
        let mut files = contents(&place.path(name));
        files.retain(|file, _| file.starts_with("stability") || file.starts_with("parts"));
        files
    };
    assert_eq!(files("whole"), files("parts"));
}

#[test]
fn what_has_no_equilibrium_is_refused_with_what_to_do() {
    let place = patchy();
    for (arguments, named) in [
        ("single.json", "holds one body"),
        ("apart.json", "do not touch"),
        (
            "pair.json --concentration 0",
            "without bodies there is no equilibrium",
        ),
        ("pair.json --concentration 1", "1 what? write 1uM"),
        ("pair.json --salt 0", "--salt above zero"),
        ("pair.json --ph 7", "charges are fixed"),
        ("pair.json --model natural-1", "patchy"),
        ("pair.json --live-states 3", "live-states"),
    ] {
        let output = place.run(&format!("stability --model thesis -q {arguments}").replace(
            "--model thesis -q pair.json --model natural-1",
            "--model natural-1 -q pair.json",
        ));
        assert_ne!(output.status.code(), Some(0), "{arguments}");
        assert!(
            message(&output).contains(named),
            "{arguments}: {}",
            message(&output)
        );
    }
}
