//! Effective charges in every verb that computes energies of an assembly, and their cache.

use crate::common::{TemporaryFolder, contents, is_ok, message};
use protomer_protein_verbs::assemblies::assembly_file::Assembly;
use protomer_protein_verbs::stability::disk_cache::DiskCache;
use protomer_protein_verbs::stability::effective::{EffectiveStore, SoluteModel};
use protomer_protein_verbs::stability::run::{EnergyMode, Engine, RunSettings};
use protomer_protein_verbs::stability::sweep::run_sweep;
use protomer_results::{End, Execution};
use serde_json::Value;
use std::process::Output;
use std::sync::Arc;

/// Two spheres of 6 Å with charges of ±6 e, nearly touching.
const PAIR: &str = r#"{"box_angstrom": [120, 120, 120],
 "bodies": [{"name": "plus", "file": "plus.body"}, {"name": "minus", "file": "minus.body"}],
 "placements": [
  {"body": "plus", "position_angstrom": [0, 0, 0], "orientation_wxyz": [1, 0, 0, 0]},
  {"body": "minus", "position_angstrom": [12.1, 0, 0], "orientation_wxyz": [1, 0, 0, 0]}]}"#;

const EFFECTIVE: &str = "--salt 100mM --interaction effective --ion-radius 0";

fn spheres() -> TemporaryFolder {
    let place = TemporaryFolder::new();
    for (name, charge) in [("plus", 6.0), ("minus", -6.0)] {
        let line = format!("ATOM 1 Q ION 1 0.0 0.0 0.0 {charge} 6.0\n");
        std::fs::write(place.path(&format!("{name}.pqr")), line).unwrap();
        is_ok(&place.run(&format!("ingest {name}.pqr --density 0.4 -o .")));
    }
    std::fs::write(place.path("pair.json"), PAIR).unwrap();
    place
}

fn run(place: &TemporaryFolder, arguments: &str) -> Output {
    let mut command = place.command(arguments);
    command.env("PROTOMER_CACHE_DIR", place.path("cache"));
    command.stdout(std::process::Stdio::piped());
    command.stderr(std::process::Stdio::piped());
    command.output().unwrap()
}

fn json(output: &Output) -> Value {
    is_ok(output);
    serde_json::from_slice(&output.stdout).unwrap()
}

fn same(found: f64, expected: f64) -> bool {
    (found - expected).abs() < 1e-9 * expected.abs()
}

#[test]
fn all_verbs_use_the_same_charges_from_the_cache() {
    let place = spheres();
    let inspect = format!("inspect pair.json {EFFECTIVE} --json");
    let cold = run(&place, &inspect);
    let inspected = json(&cold);
    let energy_kt = inspected["energy_kT"].as_f64().unwrap();
    let bodies = &inspected["effective_bodies"];
    let kappa_a = 6.0 / inspected["debye_length_angstrom"].as_f64().unwrap();
    for (body, charge) in bodies.as_array().unwrap().iter().zip([6.0, -6.0]) {
        let expected = charge * kappa_a.exp() / (1.0 + kappa_a);
        let found = body["net_effective_charge_e"].as_f64().unwrap();
        assert!((found / expected - 1.0).abs() < 0.01, "{body}");
        assert_eq!(body["net_charge_e"], charge);
        assert!(body["relative_residual"].as_f64().unwrap() < 0.05);
        assert!(body.get("warning").is_none(), "{body}");
    }
    let plain = run(&place, "inspect pair.json --salt 100mM --json");
    assert_eq!(message(&plain), "");
    let bare = json(&plain);
    assert!(bare.get("warnings").is_none());
    // Charges at the centres: the energy goes as the product of what both look like.
    let factor = kappa_a.exp() / (1.0 + kappa_a);
    let ratio = energy_kt / bare["energy_kT"].as_f64().unwrap();
    assert!((ratio / factor.powi(2) - 1.0).abs() < 0.02, "{ratio}");
    assert!(bare.get("effective_bodies").is_none());

    // The cache holds one entry for each kind of body, and what comes from it is the same.
    let kept = contents(&place.path("cache"));
    assert_eq!(kept.len(), 2);
    let warm = run(&place, &inspect);
    assert_eq!(warm.stdout, cold.stdout);
    // The surfaces are 0.1 Å apart, nearer than the charges were fitted.
    let warned = "the surfaces of bodies 0 and 1 are nearer than 3 Å";
    assert!(message(&warm).contains(warned), "{}", message(&warm));
    assert_eq!(inspected["warnings"].as_array().map(Vec::len), Some(1));
    assert!(contents(&place.path("cache")) == kept);

    // A simulation that rejects its only moves stays at its start.
    let direct =
        "--energy direct --equilibration 0 --sweeps 1 --log-every 1 --cluster-moves 0 --force";
    let still = (1..200).find_map(|seed| {
        let found = json(&run(
            &place,
            &format!("simulate pair.json {EFFECTIVE} {direct} --seed {seed} -o run --json"),
        ));
        let moved = ["translation_acceptance", "rotation_acceptance"]
            .iter()
            .any(|kind| found[kind].as_f64().unwrap() > 0.0);
        (!moved).then_some(found)
    });
    let still = still.expect("some seed rejects both moves");
    assert!(same(
        still["energy_kT"]["mean"].as_f64().unwrap(),
        energy_kt
    ));
    assert_eq!(&still["effective_bodies"], bodies);

    // The benchmark and a pair find the charges, too.
    let bench = format!("bench pair.json {EFFECTIVE} --energy direct --moves 20 --json");
    assert_eq!(&json(&run(&place, &bench))["effective_bodies"], bodies);
    let pair = format!(
        "pair plus.body minus.body {EFFECTIVE} --relative-error 0.5 --most-directions 2048 --json"
    );
    let pair = run(&place, &pair);
    let nearer = message(&pair).contains("bound poses are nearer than 3 Å");
    assert!(nearer, "{}", message(&pair));
    let of_pair = json(&pair);
    for number in 0..2 {
        assert_eq!(
            of_pair["conditions"][0]["net_effective_charge_e"][number],
            bodies[number]["net_effective_charge_e"]
        );
    }
    assert!(contents(&place.path("cache")) == kept);

    // A damaged entry is said and replaced by the same.
    let name = kept.keys().next().unwrap();
    let mut changed = kept[name].clone();
    let middle = changed.len() / 2;
    changed[middle] ^= 1;
    std::fs::write(place.path("cache").join(name), &changed).unwrap();
    let mended = run(&place, &inspect);
    assert!(
        message(&mended).contains(name) && message(&mended).contains("checksum"),
        "{}",
        message(&mended)
    );
    assert_eq!(mended.stdout, cold.stdout);
    assert!(contents(&place.path("cache")) == kept);
}

#[test]
fn the_replicas_of_a_salt_share_a_fit_and_the_settings_say_it() {
    let place = spheres();
    let store = || {
        let cache = DiskCache::new(place.path("cache"));
        Arc::new(EffectiveStore::default().with_cache(cache, |line| panic!("{line}")))
    };
    let solute = SoluteModel {
        ion_radius_angstrom: 0.0,
        ..SoluteModel::default()
    };
    let settings = RunSettings {
        salt_molar: vec![0.1],
        replicas: 4,
        sweeps: 20,
        equilibration_sweeps: 10,
        energy: Some(EnergyMode::Direct),
        effective_charges: Some(solute),
        ..RunSettings::default()
    };
    let sweep = |store: &Arc<EffectiveStore>, directory: &str| {
        let assembly = Assembly::read(&place.path("pair.json")).unwrap();
        let engine = Engine::new(assembly)
            .unwrap()
            .with_effective_store(Arc::clone(store));
        let directory = place.path(directory);
        // More simulations than threads, so that some wait for the fit of others.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2);
        let end = pool
            .build()
            .unwrap()
            .install(|| run_sweep(&engine, &settings, &directory, &Execution::default()));
        match end.unwrap() {
            End::Finished(result) => result,
            End::Stopped => panic!("nobody stops it"),
        }
    };
    let (cold, warm) = (store(), store());
    let first = sweep(&cold, "first");
    let second = sweep(&warm, "second");
    assert_eq!((cold.fitted(), warm.fitted()), (2, 0));
    assert_eq!(first, second);
    let bodies = first.salts[0].effective_bodies.as_ref().unwrap();
    assert_eq!(bodies.len(), 2);

    let stored = std::fs::read_to_string(place.path("first/run.toml")).unwrap();
    assert!(
        stored.contains("[effective_charges]\ninner_permittivity = 4.0\nion_radius_angstrom = 0.0"),
        "{stored}"
    );
    // The same command continues it; bare charges make another run.
    let again = |more: &str| {
        run(
            &place,
            &format!("sweep pair.json --config first/run.toml -o first {more}"),
        )
    };
    is_ok(&again(""));
    let other = again("--interaction bare");
    assert_eq!(other.status.code(), Some(1));
    assert!(
        message(&other).contains("effective_charges"),
        "{}",
        message(&other)
    );
}

#[test]
fn what_has_no_effective_charges_is_told_what_to_do() {
    let place = TemporaryFolder::new();
    let run_of = |verb: &str| match verb {
        "simulate" | "sweep" => "--sweeps 10 -o run",
        _ => "",
    };
    let refused = |verb: &str, flags: &str, named: &str| {
        let output = place.run(&format!("{verb} ring.json {flags} {}", run_of(verb)));
        assert_eq!(output.status.code(), Some(1), "{verb} {flags}");
        let said = message(&output);
        assert!(said.contains(named), "{verb} {flags}: {said}");
        assert!(!place.path("run").exists(), "{verb} {flags}");
    };
    for verb in ["inspect", "simulate", "sweep", "bench"] {
        for (flags, named) in [
            ("--salt 0 --interaction effective", "--salt above zero"),
            (
                "--salt 100mM --debye 9.6A --interaction effective",
                "give --salt 100mM",
            ),
            (
                "--salt 100mM --bjerrum 7A --interaction effective",
                "give --salt 100mM",
            ),
            (
                "--salt 100mM --cutoff 30A --interaction effective",
                "--cutoff",
            ),
            (
                "--salt 100mM --energy none --interaction effective",
                "another --energy",
            ),
            ("--salt 100mM --ion-radius 0", "--interaction effective"),
            (
                "--salt 100mM --inner-permittivity 2 --interaction bare",
                "--interaction effective",
            ),
            // Bodies from a mesh have no atoms.
            ("--salt 100mM --interaction effective", "body 'a'"),
        ] {
            refused(verb, flags, named);
        }
    }
    let output = place.run("bench --interaction effective --part charges");
    assert!(
        message(&output).contains("give an assembly"),
        "{}",
        message(&output)
    );
}

/// The same term in every verb, on top of the bare charges, and refused where it has no meaning.
#[test]
fn the_response_of_the_solvent_is_added_to_the_bare_charges() {
    const RESPONSE: &str = "--salt 100mM --interaction response --ion-radius 2";
    let place = spheres();
    let energy_kt = |choice: &str| {
        let found = json(&run(&place, &format!("inspect pair.json {choice} --json")));
        found["energy_kT"].as_f64().unwrap()
    };
    let (bare, response) = (energy_kt("--salt 100mM"), energy_kt(RESPONSE));
    assert!((response - bare).abs() > 0.1, "{bare} {response}");
    // 1 M is where the response counts as zero.
    let strong = ["--salt 1M", "--salt 1M --interaction response"].map(energy_kt);
    assert!((strong[0] - strong[1]).abs() < 1e-4, "{strong:?}");
    let bench = format!("bench pair.json {RESPONSE} --energy direct --moves 20 --json");
    json(&run(&place, &bench));
    let of_pair = json(&run(
        &place,
        &format!(
            "pair plus.body minus.body {RESPONSE} --relative-error 0.5 --most-directions 2048 --json"
        ),
    ));
    let pose = &of_pair["conditions"][0]["poses"][0];
    assert!(
        pose["solvent_response_kt"].as_f64().unwrap() < 0.0,
        "{of_pair}"
    );
    for (arguments, words) in [
        ("--debye 9A", "needs the salt and the permittivity"),
        ("--salt 100mM --cutoff 40", "leave out --cutoff"),
        (
            "--salt 100mM --desolvation",
            "desolvation is that of effective charges",
        ),
        ("--salt 100mM --energy none", "hard bodies feel no charges"),
    ] {
        let refused = run(
            &place,
            &format!("inspect pair.json --interaction response {arguments}"),
        );
        assert_eq!(refused.status.code(), Some(1), "{arguments}");
        assert!(message(&refused).contains(words), "{}", message(&refused));
    }
}
